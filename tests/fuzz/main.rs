//! Scene files with bytes, numbers and pieces exchanged: whatever a file holds, reading it ends soon, in a scene or in
//! an error that names the file. The test takes some seconds. To look for longer, at one format or all:
//!
//! ```text
//! MALLOC_MMAP_THRESHOLD_=65536 MALLOC_TRIM_THRESHOLD_=65536 STEREOTRACE_FUZZ_SECONDS=1200 \
//!     cargo test --test fuzz gltf -- --nocapture
//! ```
//!
//! Then each case's memory is measured too (Linux): glibc must give back what was freed, or the next case's is not
//! seen. `STEREOTRACE_FUZZ_CASE=NUMBER` repeats one case, the one that a failure names.
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

/// Without the environment's word for it.
const SECONDS: u64 = 2;
/// A case may take so long: files have a few thousand bytes.
const LONGEST: Duration = Duration::from_secs(10);
/// Triangles and pixels of textures that a case may ask for. What they take is not the files' own.
const MOST_TRIANGLES: u64 = 20_000;
const MOST_PIXELS: u64 = 1 << 16;
/// What a case may take beside 20 times its files: so many triangles, pixels while they are decoded, and what the
/// allocator keeps.
const MOST_MEMORY: u64 = 24 << 20;

/// The files of a case, the first one to be opened.
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
            // Its lengths stay right.
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
            Ok(_) => scenes += 1,
            Err(error) => {
                errors += 1;
                // Where nothing else does, its own path begins it.
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

fn options() -> SceneOptions {
    let limits = Limits::default().triangles(MOST_TRIANGLES).texture_pixels(MOST_PIXELS).file_bytes(1 << 20);
    SceneOptions::default().limits(limits).missing_textures(MissingTextures::Warn).crease_angle(Some(30.0))
}

/// Writes files and returns where the first one lies, and how large all are.
fn write(folder: &Folder, files: &Files) -> (PathBuf, u64) {
    files.iter().for_each(|(name, content)| drop(folder.write(name, content)));
    (folder.file(&files[0].0), files.iter().map(|(_, content)| content.len() as u64).sum())
}

/// Says which case it was, unless it is forgotten.
struct OnPanic<'a>(&'a str, u64);

impl Drop for OnPanic<'_> {
    fn drop(&mut self) {
        eprintln!("{}: case {}; STEREOTRACE_FUZZ_CASE={} repeats it", self.0, self.1, self.1);
    }
}

fn below(random: &mut Random, count: usize) -> usize {
    ((random.unit() * count as f32) as usize).min(count.saturating_sub(1))
}

/// Numbers at which readers stumble.
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
        // Numbers as often as all else: what is not read as text or JSON says little.
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
                // A word of a binary file.
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

/// Where the next number written in digits stands.
fn number_from(bytes: &[u8], at: usize) -> Option<std::ops::Range<usize>> {
    let start = at + bytes[at..].iter().position(u8::is_ascii_digit)?;
    let length = bytes[start..].iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(bytes.len() - start);
    Some(start..start + length)
}

/// Makes the process's peak what is in use, in bytes.
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
