//! Tests signals to `stereotrace render`, `sequence` and `dataset`. A sequence or data set ends between two pairs, and
//! the next run continues from there.
#![cfg(unix)]

mod common;

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Child, Command, Output, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

use common::{folder::Folder, printed};
use serde_json::Value;

/// Maximum time to wait for an event, so that a hang becomes a failure. All events here need much less time.
const DEADLINE: Duration = Duration::from_secs(60);

/// A running command. It is killed if its test fails.
struct Run(Option<Child>);

impl Drop for Run {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn start(arguments: &[&str]) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stereotrace"));
    command.args(arguments).env("NODEVICE_SELECT", "1").stdout(Stdio::piped()).stderr(Stdio::piped());
    Run(Some(command.spawn().expect("the command runs")))
}

fn send(signal: &str, to: &Run) {
    let id = to.0.as_ref().unwrap().id().to_string();
    let sent = Command::new("kill").args([&format!("-{signal}"), &id]).status().unwrap();
    assert!(sent.success(), "{signal}");
}

#[track_caller]
fn wait_for(what: &str, mut is_there: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !is_there() {
        assert!(begin.elapsed() < DEADLINE, "{what} did not come");
        sleep(Duration::from_millis(10));
    }
}

fn end_of(mut run: Run) -> Output {
    wait_for("the end", || run.0.as_mut().unwrap().try_wait().unwrap().is_some());
    run.0.take().unwrap().wait_with_output().unwrap()
}

/// Returns the paths of all files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Checks that a signal ended the run and that the message says so. Returns the number of finished pairs or
/// pictures in the message.
#[track_caller]
fn interrupted(output: &Output, of: u32, many: &str) -> usize {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(output.stdout.is_empty());
    let said = said.lines().last().unwrap_or_default();
    let count = said.strip_prefix("error: interrupted after ").and_then(|said| said.split_once(" of "));
    let (count, rest) = count.unwrap_or_else(|| panic!("{said}"));
    assert_eq!(rest, format!("{of} {many}; run the same command again to make the rest"));
    count.parse().unwrap()
}

#[test]
fn an_interrupted_picture_leaves_nothing() {
    let folder = Folder::new("interrupted_picture");
    let out = folder.file("out");
    let child = start(&["render", "builtin:hall", "--size", "8192x8192", "--out", out.to_str().unwrap()]);
    let has_rows = |path: &PathBuf| path.metadata().is_ok_and(|metadata| metadata.len() > 100_000);
    wait_for("the first rows", || out.is_dir() && files(&out).iter().any(has_rows));
    send("INT", &child);
    let output = end_of(child);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.ends_with("error: interrupted\n"), "{said}");
    assert_eq!(files(&out), Vec::<PathBuf>::new());
}

#[test]
fn a_sequence_ends_after_the_picture_at_hand_and_goes_on_later() {
    let folder = Folder::new("interrupted");
    let out = folder.file("film");
    let command = ["sequence", "builtin:spheres", "--size", "64x48", "--orbit", "9999", "--out", out.to_str().unwrap()];
    let child = start(&command);
    wait_for("a picture", || out.join("left_0001.png").is_file());
    send("INT", &child);
    let done = interrupted(&end_of(child), 9999, "pairs");
    // The folder has three pictures per pair and the record, but no temporary files.
    assert!(done >= 2);
    let found = files(&out);
    assert_eq!(found.len(), 3 * done + 1, "{found:?}");
    let rest = format!("0..{}", done + 1);
    let said = printed(&[&command[..], &["--frames", &rest]].concat());
    assert!(said.starts_with("1 pair in ") && said.contains(&format!("; {done} already existed")), "{said}");
}

#[test]
fn a_film_of_quilts_is_counted_in_pictures() {
    let folder = Folder::new("interrupted_quilts");
    let out = folder.file("film");
    let small = ["builtin:spheres", "--size", "16x12", "--quilt", "2x1", "--orbit", "9999"];
    let child = start(&[&["sequence"][..], &small, &["--out", out.to_str().unwrap()]].concat());
    wait_for("a quilt", || out.join("quilt_0000.png").is_file());
    send("INT", &child);
    assert!(interrupted(&end_of(child), 9999, "pictures") >= 1);
}

#[test]
fn a_data_set_ends_after_the_pair_at_hand_and_goes_on_later() {
    let folder = Folder::new("interrupted_data");
    let out = folder.file("data");
    let size = ["dataset", "builtin:hall", "--size", "48x36", "--lights", "1"];
    let command = [&size[..], &["--pairs", "9999", "--out", out.to_str().unwrap()]].concat();
    let manifest = out.join("manifest.jsonl");
    let lines = || fs::read_to_string(&manifest).map_or(0, |text| text.lines().count());
    let child = start(&command);
    wait_for("a pair", || lines() > 2);
    send("TERM", &child);
    let done = interrupted(&end_of(child), 9999, "pairs");
    assert!(done >= 2 && lines() == done + 1, "{done} {}", lines());
    let text = fs::read_to_string(&manifest).unwrap();
    let mut expected = 1;
    for line in text.lines().skip(1) {
        let line: Value = serde_json::from_str(line).unwrap();
        let of_pair = line["files"].as_object().unwrap();
        expected += of_pair.len();
        assert!(of_pair.keys().all(|name| out.join(name).is_file()), "{line}");
    }
    let found = files(&out);
    assert_eq!(found.len(), expected, "{found:?}");
    let rest = format!("0..{}", done + 1);
    let said = printed(&[&command[..], &["--items", &rest]].concat());
    assert!(said.starts_with("1 pair in ") && said.contains(&format!("; {done} already existed")), "{said}");
}

#[test]
fn a_second_signal_does_not_wait_for_the_picture() {
    let folder = Folder::new("interrupted_twice");
    let out = folder.file("film");
    // In software, one picture of this size takes minutes.
    let large = ["--size", "4096x4096", "--lights", "50", "--samples", "64"];
    let command = [&["sequence", "builtin:hall", "--orbit", "9", "--out", out.to_str().unwrap()], &large[..]].concat();
    let child = start(&command);
    wait_for("the record", || out.join("sequence.json").is_file());
    send("INT", &child);
    sleep(Duration::from_millis(200));
    send("TERM", &child);
    assert_eq!(end_of(child).status.code(), Some(130));
}
