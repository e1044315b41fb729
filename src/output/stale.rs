//! Names temporary files, and removes temporary files that killed processes left.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime};

/// Age at which a temporary file counts as abandoned, even if its process can't be checked.
const OLD: Duration = Duration::from_secs(24 * 3600);

/// End of the names of temporary files.
pub(super) const SUFFIX: &str = ".tmp";

/// Returns the start of this process's temporary file names: the process id and the boot and container where the id is
/// valid.
pub(super) fn prefix() -> String {
    // wasm32 has neither processes nor files. Opening a file later gives the error to report.
    let process = if cfg!(target_arch = "wasm32") { 0 } else { std::process::id() };
    format!(".stereotrace-{}-{process}-", place())
}

/// Removes temporary files of dead processes from a folder, at this process's first call for that folder.
pub(super) fn remove_once(folder: &Path) {
    static SEEN: Mutex<Option<HashSet<PathBuf>>> = Mutex::new(None);
    let mut seen = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    if seen.get_or_insert_default().insert(folder.into()) {
        remove(folder);
    }
}

fn remove(folder: &Path) {
    // A folder that can't be listed may still be writable, so errors are ignored.
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_name().to_str().is_some_and(|name| is_stale(name, &entry)) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Returns whether the file is a temporary file whose process has ended. If that can't be checked, its age decides.
fn is_stale(name: &str, entry: &fs::DirEntry) -> bool {
    let Some(parts) = name.strip_prefix(".stereotrace-").and_then(|rest| rest.strip_suffix(SUFFIX)) else {
        return false;
    };
    let process: Option<u32> = match parts.split('-').collect::<Vec<_>>()[..] {
        [named, process, _] if named == place() => process.parse().ok(),
        _ => None,
    };
    // If /proc shows any process, it shows process 1.
    if let Some(process) = process.filter(|_| Path::new("/proc/1").exists()) {
        return !Path::new(&format!("/proc/{process}")).exists();
    }
    let modified = entry.metadata().and_then(|metadata| metadata.modified());
    let age = modified.ok().and_then(|modified| SystemTime::now().duration_since(modified).ok());
    age.is_some_and(|age| age > OLD)
}

/// Identifies the boot and the container within which a process id is unique, since other machines may share a folder.
/// The text is empty if they are unknown.
fn place() -> String {
    let boot = fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    let container = fs::read_link("/proc/self/ns/pid").unwrap_or_default();
    let digits = container.to_string_lossy().chars().filter(char::is_ascii_digit).collect::<String>();
    boot.chars().take(8).filter(char::is_ascii_hexdigit).chain(digits.chars()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::write_whole;
    use super::*;
    use crate::folder::Folder;

    #[cfg(target_os = "linux")]
    #[test]
    fn what_a_dead_process_left_goes_and_what_may_be_in_use_stays() {
        let folder = Folder::new("stale");
        let mut child = std::process::Command::new("true").spawn().unwrap();
        let dead = child.id();
        child.wait().unwrap();
        let (place, own) = (place(), std::process::id());
        assert!(place.len() > 8, "{place}");
        let old = SystemTime::now() - OLD - Duration::from_secs(60);
        let files = [
            (format!(".stereotrace-{place}-{dead}-0.tmp"), None, false),
            (format!(".stereotrace-{place}-{own}-99999.tmp"), Some(old), true),
            (format!(".stereotrace-{place}-1-0.tmp"), None, true),
            (format!(".stereotrace-0123abcd456-{dead}-0.tmp"), None, true),
            (format!(".stereotrace-0123abcd456-{dead}-1.tmp"), Some(old), false),
            (".stereotrace-7-0.tmp".into(), Some(old), false),
            (format!("stereotrace-{place}-{dead}-0.tmp"), Some(old), true),
            (format!(".stereotrace-{place}-{dead}-0.png"), Some(old), true),
        ];
        for (name, modified, _) in &files {
            let file = fs::File::create(folder.file(name)).unwrap();
            modified.iter().for_each(|&time| file.set_modified(time).unwrap());
        }
        write_whole(folder.file("a"), b"x").unwrap();
        let mut expected: Vec<String> = files.into_iter().filter(|file| file.2).map(|file| file.0).collect();
        expected.push("a".into());
        expected.sort();
        assert_eq!(folder.names(), expected);
    }
}
