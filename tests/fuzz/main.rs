//! Fuzzes the scene readers. Bytes, numbers and pieces of scene files are replaced at random. Reading must end soon,
//! with a scene or with an error that names the file. The test takes some seconds. To search for longer, in one format
//! or in all formats:
//!
//! ```text
//! MALLOC_MMAP_THRESHOLD_=65536 MALLOC_TRIM_THRESHOLD_=65536 STEREOTRACE_FUZZ_SECONDS=1200 \
//!     cargo test --test fuzz gltf -- --nocapture
//! ```
//!
//! With `STEREOTRACE_FUZZ_SECONDS`, the memory of each case is measured too (Linux). The other two settings make glibc
//! return freed memory to the system. Otherwise the memory of the next case could not be measured.
//! `STEREOTRACE_FUZZ_CASE=NUMBER` repeats the case with the number that a failure prints.
#![cfg(all(feature = "obj", feature = "gltf", feature = "ply", feature = "textures"))]

#[allow(dead_code, reason = "the other tests use more of it")]
#[path = "../it/common/folder.rs"]
mod folder;
#[path = "../it/common/gltf.rs"]
mod gltf;
#[allow(dead_code, reason = "the other tests use more of it")]
use stereotrace::testing::random;
mod seeds;
mod structure;

use std::{
    fs,
    path::PathBuf,
    time::{Duration, Instant},
};

use folder::Folder;
use random::{Random, pcg};
use stereotrace::{Limits, MissingTextures, SceneFile, SceneOptions};

/// Default duration per format, if the environment variable is not set.
const SECONDS: u64 = 2;
/// Maximum time to read a case. Files have a few thousand bytes.
const LONGEST: Duration = Duration::from_secs(10);
/// Limits on triangles and texture pixels of a case. The required memory depends on these counts, not on the size of
/// the files.
const MOST_TRIANGLES: u64 = 20_000;
const MOST_PIXELS: u64 = 1 << 16;
/// Maximum memory of a case, in addition to 20 times the size of its files. It covers the maximum number of triangles,
/// the pixels while they are decoded, and memory that the allocator keeps.
const MOST_MEMORY: u64 = 24 << 20;

/// The files of a case. The first one is opened.
type Files = Vec<(String, Vec<u8>)>;

#[test]
fn obj() {
    fuzz("obj", &seeds::obj());
}

#[test]
fn gltf_text_and_binary() {
    fuzz("gltf", &seeds::gltf());
}

#[test]
fn ply() {
    fuzz("ply", &seeds::ply());
}

fn fuzz(name: &str, seeds: &[Files]) {
    let folder = Folder::new(&format!("fuzz_{name}"));
    let set = |name: &str| std::env::var(name).ok().map(|value| value.parse::<u64>().expect("a number"));
    let (seconds, case) = (set("STEREOTRACE_FUZZ_SECONDS"), set("STEREOTRACE_FUZZ_CASE"));
    let end = Instant::now() + Duration::from_secs(seconds.unwrap_or(SECONDS));
    let (mut scenes, mut errors, mut most) = (0u64, 0u64, (0u64, 0));
    if seconds.is_some() {
        for _ in 0..2 {
            let before = reset_peak();
            drop(std::hint::black_box(vec![1u8; 8 << 20]));
            let seen = peak() - before;
            assert!(seen >= 7 << 20, "of 8 MiB {seen} bytes are seen: set the variables that tests/fuzz/main.rs names");
        }
    }
    for (index, seed) in seeds.iter().enumerate() {
        let (path, _) = write(&folder, seed);
        let read = SceneFile::open(path, &options());
        assert!(read.is_ok(), "{name}: seed {index} is no scene: {}", read.unwrap_err());
    }
    for number in case.unwrap_or(0)..=case.unwrap_or(u64::from(u32::MAX)) {
        if Instant::now() > end && case.is_none() {
            break;
        }
        let on_panic = OnPanic(name, number);
        let mut random = Random(pcg(number as u32));
        let mut files = seeds[below(&mut random, seeds.len())].clone();
        let chosen = below(&mut random, files.len());
        let (name, content) = &mut files[chosen];
        if name.ends_with(".glb") && random.unit() < 0.7 {
            // The lengths in the file's header stay correct.
            let (mut json, mut buffer) = seeds::parts(content);
            mutate(if random.unit() < 0.7 { &mut json } else { &mut buffer }, &mut random);
            *content = gltf::binary(json, &buffer);
        } else {
            mutate(content, &mut random);
        }
        let (path, bytes) = write(&folder, &files);
        let before = seconds.map(|_| reset_peak());
        let started = Instant::now();
        match SceneFile::open(&path, &options()) {
            Ok(file) => {
                scenes += 1;
                play(file);
            }
            Err(error) => {
                errors += 1;
                // The message must name a file of the case, unless the file name's extension is unknown.
                let message = error.to_string();
                let is_clear = message.contains("fuzz_") || message.starts_with("unknown ending of a scene file");
                assert!(is_clear && message.len() < 20_000, "{message}");
            }
        }
        assert!(started.elapsed() < LONGEST, "{:?}", started.elapsed());
        if let Some(before) = before {
            let taken = peak().saturating_sub(before);
            most = most.max((taken, number));
            assert!(taken <= 20 * bytes + MOST_MEMORY, "{taken} bytes of memory for {bytes} of files");
        }
        std::mem::forget(on_panic);
    }
    println!("{name}: {scenes} scenes and {errors} errors; most memory {} KiB, by case {}", most.0 >> 10, most.1);
    assert!(case.is_some() || scenes > 0 && errors > 0, "{scenes} scenes, {errors} errors");
}

/// Moves a scene by its first animations. A fault must be an error.
fn play(SceneFile { mut scene, cameras, animations, .. }: SceneFile) {
    for animation in animations.iter().take(3) {
        for share in [0.0, 0.4, 1.0] {
            let seconds = share * animation.duration();
            let _ = animation.pose(&mut scene, seconds);
            assert!(animation.cameras(seconds).is_ok_and(|moved| moved.len() == cameras.len()));
        }
    }
}

fn options() -> SceneOptions {
    let limits = Limits::default().triangles(MOST_TRIANGLES).texture_pixels(MOST_PIXELS).file_bytes(1 << 20);
    SceneOptions::default().limits(limits).missing_textures(MissingTextures::Warn).crease_angle(Some(30.0))
}

/// Writes files. Returns the path of the first one and the size of all of them.
fn write(folder: &Folder, files: &Files) -> (PathBuf, u64) {
    files.iter().for_each(|(name, content)| drop(folder.write(name, content)));
    (folder.file(&files[0].0), files.iter().map(|(_, content)| content.len() as u64).sum())
}

/// Prints the format and the case number if the test panics; `std::mem::forget` disarms it.
struct OnPanic<'a>(&'a str, u64);

impl Drop for OnPanic<'_> {
    fn drop(&mut self) {
        eprintln!("{}: case {}; STEREOTRACE_FUZZ_CASE={} repeats it", self.0, self.1, self.1);
    }
}

fn below(random: &mut Random, count: usize) -> usize {
    ((random.unit() * count as f32) as usize).min(count.saturating_sub(1))
}

/// Numbers that are hard for readers.
const NUMBERS: [&str; 22] = [
    "0",
    "1",
    "-1",
    "2",
    "3",
    "7",
    "127",
    "128",
    "255",
    "256",
    "65535",
    "65536",
    "1000000",
    "2147483647",
    "-2147483648",
    "4294967295",
    "18446744073709551615",
    "1e39",
    "-1e-40",
    "nan",
    "1e400",
    "0.5",
];

fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + below(random, 3) {
        let at = below(random, bytes.len().max(1));
        // Half of the mutations change numbers, since a file that is no longer text or JSON tests little.
        match below(random, 12) {
            _ if bytes.is_empty() => bytes.push(0),
            0 => bytes[at] ^= 1 << below(random, 8),
            1 => bytes[at] = below(random, 256) as u8,
            2 => bytes.truncate(at),
            3 => {
                let end = (at + 1 + below(random, 40)).min(bytes.len());
                bytes.drain(at..end);
            }
            4 => {
                let end = (at + 1 + below(random, 200)).min(bytes.len());
                let piece = bytes[at..end].to_vec();
                let to = below(random, bytes.len());
                bytes.splice(to..to, piece);
            }
            5 => {
                // This writes a 4-byte word, as binary files contain.
                let word = [0u32, 1, 3, 255, 65_536, 0x7fff_ffff, u32::MAX, 0x7f80_0000, 0x7fc0_0000][below(random, 9)];
                for (place, byte) in bytes[at..].iter_mut().zip(word.to_le_bytes()) {
                    *place = byte;
                }
            }
            6..9 => {
                if let Some(number) = number_from(bytes, at) {
                    bytes.splice(number, NUMBERS[below(random, NUMBERS.len())].bytes());
                }
            }
            _ => {
                let other = below(random, bytes.len());
                if let (Some(one), Some(other)) = (number_from(bytes, at), number_from(bytes, other)) {
                    let by = bytes[other].to_vec();
                    bytes.splice(one, by);
                }
            }
        }
    }
}

/// Returns the position of the next number written in digits.
fn number_from(bytes: &[u8], at: usize) -> Option<std::ops::Range<usize>> {
    let start = at + bytes[at..].iter().position(u8::is_ascii_digit)?;
    let length = bytes[start..].iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(bytes.len() - start);
    Some(start..start + length)
}

/// Resets the process's peak memory to its current memory, and returns that in bytes.
fn reset_peak() -> u64 {
    fs::write("/proc/self/clear_refs", "5").unwrap();
    status("VmRSS:")
}

fn peak() -> u64 {
    status("VmHWM:")
}

fn status(field: &str) -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with(field)).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 1024
}
