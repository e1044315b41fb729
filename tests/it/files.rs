//! Tests files that would take much more memory than their size, or make a reader wait for ever.
#![cfg(target_os = "linux")]

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use stereotrace::{Error, Limits, Scene, blocking::Wait};

/// A folder for one test, removed when the test is over.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("stereotrace_files_{}_{test}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        fs::write(self.file(name), content).unwrap();
        self.file(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Returns the largest growth of the process's memory while `work` ran, in MiB.
fn peak_growth(work: impl FnOnce()) -> u64 {
    let status = |field: &str| -> u64 {
        let status = fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find(|line| line.starts_with(field)).unwrap();
        line.split_whitespace().nth(1).unwrap().parse().unwrap()
    };
    fs::write("/proc/self/clear_refs", "5").unwrap(); // resets the peak to the current memory
    let before = status("VmRSS:");
    work();
    (status("VmHWM:") - before) / 1024
}

/// Runs a test of this file in a process of its own, since other tests change the memory of this one. Returns whether
/// this is that process.
fn is_alone(test: &str) -> bool {
    const ALONE: &str = "STEREOTRACE_TEST_ALONE";
    if std::env::var_os(ALONE).is_some() {
        return true;
    }
    let name = format!("files::{test}");
    let child = Command::new(std::env::current_exe().unwrap()).args([&name, "--exact"]).env(ALONE, "1").output();
    let output = child.unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.contains("1 passed"), "{said}");
    false
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\n";

#[test]
fn a_long_name_over_many_changes_of_normals_takes_no_memory_of_its_own() {
    if !is_alone("a_long_name_over_many_changes_of_normals_takes_no_memory_of_its_own") {
        return;
    }
    let folder = Folder::new("sections");
    let faces = "f 1 2 3\nf 1//1 2//1 3//1\n".repeat(4000);
    let obj = folder.write("scene.obj", format!("o {}\n{TRIANGLE}{faces}", "n".repeat(100_000)));
    let mib = peak_growth(|| assert_eq!(Scene::from_obj(obj).unwrap().primitive_count(), 8000));
    // The measured memory is 6 MiB. It would be 769 MiB if each section stored the name.
    assert!(mib < 40, "{mib} MiB for a file of 204 kB");
}

#[test]
fn a_library_that_is_named_often_is_read_once() {
    if !is_alone("a_library_that_is_named_often_is_read_once") {
        return;
    }
    let folder = Folder::new("libraries");
    let materials: String = (0..10_000).map(|index| format!("newmtl m{index}\nKd 0.5 0.5 0.5\n")).collect();
    let mtl = folder.write("m.mtl", materials);
    std::os::unix::fs::symlink(mtl, folder.file("link.mtl")).unwrap();
    let names = "mtllib m.mtl\nmtllib link.mtl\nmtllib ./m.mtl m.mtl\n".repeat(50);
    let obj = folder.write("scene.obj", format!("{names}{TRIANGLE}usemtl m7\nf 1 2 3\n"));
    let mib = peak_growth(|| {
        let scene = Scene::from_obj(&obj).unwrap();
        assert_eq!((scene.materials().len(), scene.triangles()[0].material.0), (10_001, 8));
    });
    // The measured memory is 3 MiB. It would be 810 MiB if the library were read for each mention.
    assert!(mib < 40, "{mib} MiB");
}

/// Returns the message of the error, which must name the file. The error must occur without delay.
fn refused<T>(path: &Path, result: Result<T, Error>) -> String {
    let Err(error) = result else { panic!("{}: not refused", path.display()) };
    assert!(matches!(error, Error::Io { .. } | Error::TooLarge { .. } | Error::Parse { .. }), "{error:?}");
    let message = error.to_string();
    assert!(message.starts_with(path.to_str().unwrap()), "{message}");
    message
}

fn pipe(folder: &Folder) -> PathBuf {
    let pipe = folder.file("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    pipe
}

#[test]
fn what_is_no_regular_file_is_refused_and_not_waited_for() {
    let folder = Folder::new("regular");
    for path in [&pipe(&folder), Path::new("/dev/zero"), Path::new("/dev/tty")] {
        let message = refused(path, Scene::from_obj(path));
        assert!(message.ends_with("it is a pipe, a socket or a device; only regular files are read"), "{message}");
    }
    assert!(refused(&folder.0, Scene::from_obj(&folder.0)).contains("it is a folder"));
    // This is a regular file by its type. But its size is 0, and a read blocks until the kernel writes a line.
    let kernel = Path::new("/proc/kmsg");
    assert!(Scene::from_obj(kernel).is_err());
    let obj = folder.write("scene.obj", format!("mtllib pipe\nmtllib /dev/zero\n{TRIANGLE}f 1 2 3\n"));
    assert_eq!(Scene::from_obj(obj).unwrap().materials().len(), 1);
}

#[test]
fn a_file_over_the_limit_is_refused_unread_and_the_limit_can_be_raised() {
    let folder = Folder::new("limit");
    let text = format!("mtllib a.mtl b.mtl\n{TRIANGLE}f 1 2 3\n");
    let obj = folder.write("scene.obj", &text);
    let limit = text.len() as u64;
    let message = refused(&obj, Scene::from_obj_within(&obj, &Limits::default().file_bytes(limit - 1)));
    assert!(message.contains(&format!("the file has {limit} bytes, over the limit of {}", limit - 1)), "{message}");
    assert!(message.ends_with("raise it with Limits if the size is intended"), "{message}");
    let limits = Limits::default().file_bytes(limit - 1).option_names("--max-file", "--max-sky");
    let message = refused(&obj, Scene::from_obj_within(&obj, &limits));
    assert!(message.ends_with("raise it with --max-file if the size is intended"), "{message}");
    // The MTL files share one limit.
    let material = |name: &str| format!("newmtl {name}\n{}\n", "#".repeat(40));
    folder.write("a.mtl", material("a"));
    folder.write("b.mtl", material("b"));
    for (limit, materials) in [(limit, 2), (2 * limit, 3)] {
        let scene = Scene::from_obj_within(&obj, &Limits::default().file_bytes(limit)).unwrap();
        assert_eq!(scene.materials().len(), materials, "{limit}");
    }
    // A sparse file of a terabyte takes no disk space.
    fs::File::options().write(true).open(&obj).unwrap().set_len(1 << 40).unwrap();
    assert!(refused(&obj, Scene::from_obj(&obj)).contains("over the limit of 1073741824"));
}

/// Writes an empty picture, as a file of few bytes.
#[cfg(feature = "sky")]
fn picture(folder: &Folder, width: u32, height: u32) -> PathBuf {
    let path = folder.file("sky.png");
    image::GrayImage::new(width, height).save(&path).unwrap();
    path
}

#[cfg(feature = "sky")]
#[test]
fn a_sky_takes_at_most_16_bytes_a_pixel_and_one_over_the_limit_none() {
    use stereotrace::SkyMap;

    if !is_alone("a_sky_takes_at_most_16_bytes_a_pixel_and_one_over_the_limit_none") {
        return;
    }
    let folder = Folder::new("sky");
    let path = picture(&folder, 4096, 2048);
    let mib = peak_growth(|| assert_eq!(SkyMap::open(&path).unwrap().size(), [4096, 2048]));
    // The measured memory is 96 MiB, which is 12 bytes per pixel for the colours. With 36 bytes per pixel it was 288
    // MiB.
    assert!(mib < 128, "{mib} MiB for 8 million pixels");
    let path = picture(&folder, 8192, 4096);
    let mib = peak_growth(|| {
        let message = refused(&path, SkyMap::open(&path));
        assert!(message.contains("8192x4096 pixels, 33554432 in all, over the limit of 8388608"), "{message}");
    });
    assert!(mib < 8, "{mib} MiB for what is refused");
    let message =
        refused(&path, SkyMap::open_within(&path, &Limits::default().option_names("--max-file", "--max-sky")));
    assert!(message.ends_with("raise it with --max-sky, up to the adapter's limit"), "{message}");
    let pipe = pipe(&folder);
    assert!(refused(&pipe, SkyMap::open(&pipe)).contains("only regular files"));
    let message = refused(&path, SkyMap::open_within(&path, &Limits::default().file_bytes(100)));
    assert!(message.contains("over the limit of 100"), "{message}");
}

#[test]
fn a_sky_s_upload_takes_at_most_24_bytes_a_pixel_with_what_it_takes_on_a_software_adapter() {
    use stereotrace::{Gpu, Renderer, Sky, SkyMap, glam::Vec3};

    if !is_alone("a_sky_s_upload_takes_at_most_24_bytes_a_pixel_with_what_it_takes_on_a_software_adapter") {
        return;
    }
    let gpu = Gpu::open(std::env::var("STEREOTRACE_ADAPTER").unwrap_or("software".into())).wait().unwrap();
    let renderer = Renderer::new(gpu);
    let mut scene = Scene::new();
    renderer.upload(&scene).wait().unwrap();
    scene.sky = Sky::Map(SkyMap::new(4096, 2047, vec![Vec3::ONE; 4096 * 2047]).unwrap());
    let mib = peak_growth(|| drop(renderer.upload(&scene).wait().unwrap()));
    // The measured memory is 160 MiB: 128 MiB of the texture, and a piece of 16 MiB twice. If the whole texture was
    // converted at once, it took 255 MiB in addition to the texture.
    assert!(mib < 192, "{mib} MiB for 8 million pixels");
}

#[cfg(feature = "json")]
#[test]
fn cameras_and_lights_are_read_within_limits_too() {
    use stereotrace::StereoCamera;

    let folder = Folder::new("json");
    let pipe = pipe(&folder);
    assert!(refused(&pipe, StereoCamera::from_json(&pipe, "a", 1, 1)).contains("only regular files"));
    assert!(refused(&pipe, Scene::new().light_from_json(&pipe, "a")).contains("only regular files"));
    let path = folder.write("cameras.json", "{} ");
    let limits = Limits::default().json_bytes(2);
    let message = refused(&path, StereoCamera::from_json_within(&path, "a", 1, 1, &limits));
    assert!(message.contains("the file has 3 bytes, over the limit of 2"), "{message}");
    let message = refused(&path, Scene::new().light_from_json_within(&path, "a", &limits));
    assert!(message.contains("over the limit of 2"), "{message}");
    folder.write("cameras.json", b"\xff\xfe{\0}\0");
    let message = refused(&path, StereoCamera::from_json(&path, "a", 1, 1));
    assert!(message.ends_with("it is UTF-16 text, judging by its byte order mark; save it as UTF-8"), "{message}");
    // A name from the file must not send control sequences to the terminal through an error message.
    folder.write("cameras.json", "{ \"\\u001b[2J\": 1 }");
    let message = refused(&path, StereoCamera::from_json(&path, "a", 1, 1));
    assert!(message.ends_with(r"which has: \u{1b}[2J"), "{message}");
}
