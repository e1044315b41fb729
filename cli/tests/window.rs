//! Tests the window of `stereotrace view` on a virtual display: `sh scripts/check_view.sh`.
#![cfg(feature = "view")]

mod common;

use std::{
    env, fs,
    io::{BufRead, BufReader},
    path::Path,
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use common::{folder::Folder, printed};
use image::RgbaImage;

const SIZE: &str = "200x120";
/// Maximum time that a test waits for the window.
const PATIENCE: Duration = Duration::from_secs(100);

/// A process with a window. It is killed when its test ends.
struct Window(Child);

impl Drop for Window {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Returns the largest difference of any channel between two pictures of the same size.
fn difference(a: &RgbaImage, b: &RgbaImage) -> u8 {
    assert_eq!(a.dimensions(), b.dimensions());
    a.as_raw().iter().zip(b.as_raw()).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

fn open(path: &Path) -> RgbaImage {
    image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).into_rgba8()
}

/// Runs a command line that `view` printed, with another output file.
fn made_again(command: &str, file: &Path) -> RgbaImage {
    let words = Vec::from_iter(command.split_whitespace());
    let [program, words @ .., "--out", _] = &words[..] else { panic!("{command}") };
    assert_eq!(*program, "stereotrace");
    printed(&[words, &["--quiet", "--out", text(file)]].concat());
    open(file)
}

#[test]
#[ignore = "needs a display: scripts/check_view.sh"]
fn a_window_shows_what_render_makes() {
    let folder = Folder::new("window");
    let [shown, made] = ["shown.png", "made.png"].map(|name| folder.file(name));
    let looks: [(&[&str], u8); 3] =
        [(&[], 1), (&["--anaglyph", "amber-blue", "--swap", "--samples", "4"], 1), (&["--packing", "cross-eyed"], 0)];
    for (look, most) in looks {
        let both = [&["builtin:hall", "--size", SIZE], look].concat();
        printed(&[&["view", "--no-text", "--frames", "1", "--screenshot", text(&shown)], &both[..]].concat());
        printed(&[&["render", "--quiet", "--out", text(&made)], &both[..]].concat());
        let found = difference(&open(&shown), &open(&made));
        assert!(found <= most, "{look:?}: {found}");
    }
}

#[test]
#[ignore = "needs a display: scripts/check_view.sh"]
fn what_is_done_shows_and_what_is_written_is_made_again() {
    let folder = Folder::new("window");
    let [shot, out, again] = ["shot.png", "out", "again.png"].map(|name| folder.file(name));
    let shots = ["0", "1", "2", "3"].map(|name| folder.file(&format!("{name}.png")));
    let [begin, dragged, flown, keyed] = shots.each_ref().map(|path| text(path));
    let steps = format!(
        "wait\nshot {begin}\ndrag left 40 -9\nwait\nshot {dragged}\nfly w 0.4\nwheel 1\nwait\nshot {flown}\n\
         key right\nkey shift+up\nkey m\nwait\nshot {keyed}\n\
         size 160x90\nwait\nlose window\nwait\nlose device\nwait\nkey p\n"
    );
    let steps = folder.write("steps", steps);
    let said = printed(&[
        "view",
        "builtin:hall",
        "--size",
        SIZE,
        "--no-text",
        "--frames",
        "1",
        "--replay",
        text(&steps),
        "--screenshot",
        text(&shot),
        "--out",
        text(&out),
    ]);
    let [begin, dragged, flown, keyed] = shots.each_ref().map(|path| open(path));
    assert!(difference(&begin, &dragged) > 60 && difference(&dragged, &flown) > 60 && difference(&flown, &keyed) > 60);
    let written = open(&out.join("hall-001.png"));
    assert_eq!(written.dimensions(), (160, 90));
    assert!(difference(&open(&shot), &written) <= 1);
    let command = said.lines().find(|line| line.starts_with("stereotrace render")).unwrap();
    assert!(command.contains("--eye") && command.ends_with("hall-001.png"), "{command}");
    assert_eq!(difference(&made_again(command, &again), &written), 0);
}

#[test]
#[ignore = "needs a display: scripts/check_view.sh"]
fn a_head_turns_inside_an_equirectangular_pair_without_another_frame() {
    let folder = Folder::new("window");
    let shots = ["ahead", "turned", "near"].map(|name| folder.file(&format!("{name}.png")));
    let [ahead, turned, near] = shots.each_ref().map(|path| text(path));
    let (out, again) = (folder.file("out"), folder.file("again.png"));
    let steps = format!(
        "size 200x120\nwait\nshot {ahead}\ndrag left 70 9\nshot {turned}\nwheel 3\n\
         shot {near}\ndrag right -70 -9\nkey p\n"
    );
    let steps = folder.write("steps", steps);
    let around = ["view", "builtin:hall", "--projection", "360", "--size", "128x64", "--no-text", "--frames", "1"];
    let said = printed(&[&around[..], &["--replay", text(&steps), "--out", text(&out)]].concat());
    assert!(said.contains("1 whole pictures"), "{said}");
    let [ahead, turned, near] = shots.each_ref().map(|path| open(path));
    assert_eq!(ahead.dimensions(), (200, 120));
    assert!(difference(&ahead, &turned) > 60 && difference(&turned, &near) > 60);
    let written = open(&out.join("hall-001_360_TB.png"));
    assert_eq!(written.dimensions(), (128, 128));
    let command = said.lines().find(|line| line.starts_with("stereotrace render")).unwrap();
    assert_eq!(difference(&made_again(command, &again), &written), 0);
}

#[test]
#[ignore = "needs a display: scripts/check_view.sh"]
fn a_frame_that_cant_be_rendered_ends_with_its_reason() {
    let options = ["--adaptive", "8", "--method", "atomic", "--frames", "1"];
    let message = common::error_of(&[&["view", "builtin:hall", "--size", SIZE], &options[..]].concat());
    assert!(message.contains("adaptive: it does not support the method atomic"), "{message}");
}

#[test]
#[ignore = "needs a display: scripts/check_view.sh"]
fn mouse_and_keys_of_a_display_do_what_they_say() {
    let folder = Folder::new("window");
    let (out, again) = (folder.file("out"), folder.file("again.png"));
    let child = Command::new(env!("CARGO_BIN_EXE_stereotrace"))
        .args(["view", "builtin:hall", "--size", SIZE, "--no-text", "--out", text(&out)])
        .env("NODEVICE_SELECT", "1")
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut window = Window(child);
    let mut lines = BufReader::new(window.0.stdout.take().unwrap()).lines();
    let mut command_of = |write: &str| {
        xdotool(&["key", write]);
        lines.next().expect("a line").unwrap()
    };
    xdotool(&["search", "--sync", "--onlyvisible", "--name", "hall - stereotrace", "windowfocus", "--sync"]);
    // The key also works before anything is rendered. The picture is then written as soon as it is ready.
    let begin = command_of("p");
    assert!(!begin.contains("--eye") && begin.ends_with("hall-001.png"), "{begin}");
    xdotool(&["mousemove", "90", "60", "mousedown", "1", "mousemove", "120", "55", "mouseup", "1"]);
    let dragged = command_of("ctrl+s");
    assert!(dragged.contains("--eye") && dragged.ends_with("hall-002.png"), "{dragged}");
    xdotool(&["click", "4", "keydown", "w", "sleep", "0.3", "keyup", "w", "key", "Right", "key", "x"]);
    let flown = command_of("p");
    assert!(flown.contains("--swap"), "{flown}");
    let written = open(&out.join("hall-003.png"));
    assert_eq!(difference(&made_again(&flown, &again), &written), 0);
    // The display must show the same picture once the window is drawn.
    let begun = Instant::now();
    while difference(&framebuffer(written.dimensions()), &written) > 1 {
        assert!(begun.elapsed() < PATIENCE, "{}", difference(&framebuffer(written.dimensions()), &written));
        thread::sleep(Duration::from_millis(100));
    }
    xdotool(&["key", "Escape"]);
    let begun = Instant::now();
    let status = loop {
        match window.0.try_wait().unwrap() {
            Some(status) => break status,
            None => assert!(begun.elapsed() < PATIENCE, "Esc does not end it"),
        }
        thread::sleep(Duration::from_millis(50));
    };
    assert!(status.success());
    let names = ["hall-001.png", "hall-002.png", "hall-003.png"];
    assert_eq!(fs::read_dir(&out).unwrap().count(), names.len());
    assert_ne!(open(&out.join(names[0])), open(&out.join(names[1])));
}

fn xdotool(arguments: &[&str]) {
    let output = Command::new("xdotool").args(arguments).output().expect("xdotool runs");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Returns the top left part of the picture that Xvfb shows. Xvfb keeps it in a file in the X Window Dump format. The
/// file has a header of big-endian 4-byte words, a table of colours of 12 bytes each, and rows of 4-byte pixels. The
/// bytes of a pixel are blue, green, red and an unused byte.
fn framebuffer((width, height): (u32, u32)) -> RgbaImage {
    let file = env::var_os("STEREOTRACE_FRAMEBUFFER").expect("the file that Xvfb shows");
    let bytes = fs::read(&file).expect("Xvfb's file");
    let word = |index: usize| u32::from_be_bytes(bytes[4 * index..4 * index + 4].try_into().unwrap()) as usize;
    let (header, bytes_per_line, colors) = (word(0), word(12), word(19));
    let pixels = &bytes[header + 12 * colors..];
    RgbaImage::from_fn(width, height, |x, y| {
        let at = y as usize * bytes_per_line + 4 * x as usize;
        image::Rgba([pixels[at + 2], pixels[at + 1], pixels[at], 255])
    })
}
