//! The manifest of a data set, which lists its pairs.

use std::{
    collections::BTreeSet,
    error::Error,
    fmt::Display,
    fs::{File, OpenOptions},
    io::{Read as _, Seek as _, SeekFrom, Write as _},
    path::{Path, PathBuf},
};

use serde_json::Value;

use crate::shown;

/// Name of the file.
pub(crate) const MANIFEST: &str = "manifest.jsonl";

/// The manifest has one line with settings and input hashes, then one line for each pair. Several commands may write it
/// at the same time. Each command locks the file, reads the lines that others have added, and then adds its own lines.
pub(crate) struct Manifest {
    folder: PathBuf,
    path: PathBuf,
    /// Pairs whose files exist.
    pub(crate) done: BTreeSet<u32>,
    /// Number of bytes and lines read so far.
    read: u64,
    lines: usize,
}

impl Manifest {
    /// Begins a manifest, or continues one whose first line is `record`.
    ///
    /// # Errors
    /// Fails if the folder's manifest has another first line.
    pub(crate) fn open(folder: &Path, record: &Value) -> Result<Self, Box<dyn Error>> {
        let path = folder.join(MANIFEST);
        let mut manifest = Self { folder: folder.to_owned(), path, done: BTreeSet::new(), read: 0, lines: 0 };
        let mut file = manifest.locked()?;
        manifest.catch_up(&mut file, Some(record))?;
        if manifest.lines == 0 {
            manifest.write(&mut file, record)?;
        }
        Ok(manifest)
    }

    /// Returns whether any command has finished this pair.
    pub(crate) fn has(&mut self, item: u32) -> Result<bool, Box<dyn Error>> {
        let mut file = self.locked()?;
        self.catch_up(&mut file, None)?;
        Ok(self.done.contains(&item))
    }

    /// Adds a pair's line and syncs it to disk. Returns false if another command has meanwhile rendered the pair and
    /// added its line.
    pub(crate) fn add(&mut self, item: u32, line: &Value) -> Result<bool, Box<dyn Error>> {
        let mut file = self.locked()?;
        self.catch_up(&mut file, None)?;
        if self.done.contains(&item) {
            return Ok(false);
        }
        self.write(&mut file, line)?;
        if line.get("files").is_some() {
            self.done.insert(item);
        }
        Ok(true)
    }

    /// Opens and locks the file. Dropping the returned file releases the lock.
    fn locked(&self) -> Result<File, Box<dyn Error>> {
        let opened = OpenOptions::new().create(true).read(true).write(true).truncate(false).open(&self.path);
        let file = opened.map_err(|error| self.fault(&error))?;
        if let Err(error) = fs4::FileExt::lock(&file) {
            // Some network file systems do not support locks. A single command does not need one.
            log::warn!("{}: it can't be locked ({error}); do not let another command write there", shown(&self.path));
        }
        Ok(file)
    }

    fn fault(&self, error: &impl Display) -> Box<dyn Error> {
        format!("{}: {error}", shown(&self.path)).into()
    }

    /// Reads the lines added since the last call. If `head` is given, it must be the file's first line.
    fn catch_up(&mut self, file: &mut File, head: Option<&Value>) -> Result<(), Box<dyn Error>> {
        let mut bytes = Vec::new();
        let found = file.seek(SeekFrom::Start(self.read)).and_then(|_| file.read_to_end(&mut bytes));
        found.map_err(|error| self.fault(&error))?;
        // A killed process may leave an incomplete line, which is removed.
        let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
        if whole < bytes.len() {
            file.set_len(self.read + whole as u64).map_err(|error| self.fault(&error))?;
        }
        for line in bytes[..whole].split(|&byte| byte == b'\n').filter(|line| !line.is_empty()) {
            let line: Result<Value, _> = serde_json::from_slice(line);
            if let (0, Some(head)) = (self.lines, head)
                && !line.as_ref().is_ok_and(|line| line == head)
            {
                let advice = "was made with different files, settings or version; use another folder";
                return Err(format!("{}: the data set there {advice}", shown(&self.path)).into());
            }
            self.lines += 1;
            let line = line.map_err(|error| format!("{}:{}: {error}", shown(&self.path), self.lines))?;
            if let (Some(item), Some(files)) = (line["item"].as_u64(), line["files"].as_object())
                && !files.is_empty()
                && files.keys().all(|name| self.folder.join(name).is_file())
            {
                self.done.insert(item as u32);
            }
        }
        self.read += whole as u64;
        Ok(())
    }

    /// Writes a line after those that were read.
    fn write(&mut self, file: &mut File, line: &Value) -> Result<(), Box<dyn Error>> {
        let text = format!("{line}\n");
        let written = file.seek(SeekFrom::Start(self.read)).and_then(|_| {
            file.write_all(text.as_bytes())?;
            file.sync_all()
        });
        written.map_err(|error| self.fault(&error))?;
        self.read += text.len() as u64;
        self.lines += 1;
        Ok(())
    }
}
