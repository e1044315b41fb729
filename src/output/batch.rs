//! Files that are written completely or not at all, alone or together.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, TempPath};

use super::stale;
use crate::Error;

/// Time to wait for a pipe's reader.
#[cfg(unix)]
const PATIENCE: std::time::Duration = std::time::Duration::from_secs(5);

/// Maximum number of links to links that are followed, as in Linux.
const MOST_LINKS: u32 = 40;

/// Writes a file completely or not at all: under a temporary name in the same folder, which then replaces `path`.
///
/// An existing file keeps its permissions, and a read-only file is not replaced. A link keeps pointing to its file,
/// which need not exist yet. Pipes and devices can't be replaced and are written to directly. The first write of a
/// process to a folder removes temporary files that killed processes left there.
///
/// # Errors
/// [`Error::Io`], naming `path`, also for a named pipe without a reader for five seconds. The old file is unchanged,
/// and the temporary one is removed.
pub fn write_whole(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), Error> {
    let mut batch = Batch::new();
    batch.add(path, bytes)?;
    batch.commit().map(drop)
}

/// Files that appear together or not at all. Each is written as by [`write_whole`], but keeps its temporary name until
/// [`Batch::commit`]. A batch that is dropped before leaves nothing.
///
/// ```
/// use stereotrace::output::Batch;
///
/// let folder = std::env::temp_dir();
/// let mut batch = Batch::new();
/// batch.add(folder.join("left.txt"), b"left")?;
/// batch.add(folder.join("right.txt"), b"right")?;
/// assert_eq!(batch.commit()?.len(), 2);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct Batch {
    staged: Vec<Staged>,
}

#[derive(Debug)]
struct Staged {
    /// Path as given by the caller.
    path: PathBuf,
    content: Content,
}

#[derive(Debug)]
enum Content {
    /// A written file, to be renamed. It is removed when dropped.
    Temporary { temporary: TempPath, target: PathBuf, replaces: bool },
    /// Content for a target that can't be replaced, in a file without a name.
    Direct(File),
}

/// A file that is being written under its temporary name. It is removed when dropped.
#[derive(Debug)]
pub(super) struct OpenFile {
    pub(super) file: File,
    /// Path as given by the caller.
    pub(super) path: PathBuf,
    /// The temporary file, its target, and the old file that it replaces. `None` if the target can't be replaced.
    temporary: Option<(TempPath, PathBuf, Option<fs::Metadata>)>,
}

impl Batch {
    /// Creates a batch without files.
    pub fn new() -> Self {
        Self::default()
    }

    /// Writes a file under its temporary name.
    ///
    /// # Errors
    /// [`Error::Io`], naming `path`, if it can't be written, is read-only, or is a folder.
    pub fn add(&mut self, path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), Error> {
        self.add_with(path.as_ref(), |file| file.write_all(bytes))
    }

    fn add_with(&mut self, path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), Error> {
        let mut open = OpenFile::create(path)?;
        write(&mut open.file).map_err(|source| Error::io(path, source))?;
        self.close(open)
    }

    /// Syncs a written file to disk, and closes it, since Windows does not rename open files.
    pub(super) fn close(&mut self, open: OpenFile) -> Result<(), Error> {
        let OpenFile { file, path, temporary } = open;
        let content = match temporary {
            None => Content::Direct(file),
            Some((temporary, target, old)) => {
                let permitted = old.as_ref().map_or(Ok(()), |old| file.set_permissions(old.permissions()));
                permitted.and_then(|()| file.sync_all()).map_err(|source| Error::io(&path, source))?;
                Content::Temporary { temporary, target, replaces: old.is_some() }
            }
        };
        self.staged.push(Staged { path, content });
        Ok(())
    }

    /// Renames all files to their final names and returns the paths in the order of addition. Everything that may fail
    /// was tried before. Renames are done one after the other, so only a process that ends in between leaves a part of
    /// the files.
    ///
    /// # Errors
    /// [`Error::Io`], naming the file that could not be renamed. Files that were new are removed again.
    pub fn commit(mut self) -> Result<Vec<PathBuf>, Error> {
        for Staged { path, content } in &mut self.staged {
            if let Content::Direct(content) = content {
                let rewound = content.rewind().and_then(|()| open_direct(path));
                let written = rewound.and_then(|mut file| io::copy(content, &mut file));
                written.map_err(|source| Error::io(&*path, source))?;
            }
        }
        let mut new = Vec::new();
        let mut paths = Vec::with_capacity(self.staged.len());
        for Staged { path, content } in self.staged {
            if let Content::Temporary { temporary, target, replaces } = content {
                if let Err(error) = temporary.persist(&target) {
                    for target in new {
                        let _ = fs::remove_file(target); // report the first error only
                    }
                    return Err(Error::io(path, error.error));
                }
                if !replaces {
                    new.push(target);
                }
            }
            paths.push(path);
        }
        Ok(paths)
    }
}

impl OpenFile {
    /// Creates a temporary file beside the target, or a file without a name for a target that can't be replaced.
    ///
    /// # Errors
    /// [`Error::Io`], naming `path`, if it can't be written, is read-only, or is a folder.
    pub(super) fn create(path: &Path) -> Result<Self, Error> {
        Self::create_for(path).map_err(|source| Error::io(path, source))
    }

    fn create_for(path: &Path) -> io::Result<Self> {
        let old = fs::metadata(path).ok();
        if old.as_ref().is_some_and(|old| !old.is_file() && !old.is_dir()) {
            return Ok(Self { file: tempfile::tempfile()?, path: path.into(), temporary: None });
        }
        let target = follow(path)?;
        if let Some(old) = &old {
            check_replaceable(&target, old)?;
        }
        let (file, temporary) = create_beside(&target)?.into_parts();
        Ok(Self { file, path: path.into(), temporary: Some((temporary, target, old)) })
    }
}

/// Opens a target that can't be replaced.
fn open_direct(path: &Path) -> io::Result<File> {
    #[cfg(unix)]
    if std::os::unix::fs::FileTypeExt::is_fifo(&fs::metadata(path)?.file_type()) {
        return open_pipe(path, PATIENCE);
    }
    OpenOptions::new().write(true).open(path)
}

/// Opens a named pipe once it has a reader; without one, an ordinary open blocks for ever.
#[cfg(unix)]
fn open_pipe(path: &Path, patience: std::time::Duration) -> io::Result<File> {
    use std::{os::unix::fs::OpenOptionsExt, thread::sleep, time::Duration, time::Instant};

    use rustix::{
        fs::{OFlags, fcntl_setfl},
        io::Errno,
    };

    let begin = Instant::now();
    loop {
        match OpenOptions::new().write(true).custom_flags(OFlags::NONBLOCK.bits() as i32).open(path) {
            Ok(file) => {
                // Writes must block again.
                fcntl_setfl(&file, OFlags::empty())?;
                return Ok(file);
            }
            Err(error) if error.raw_os_error() != Some(Errno::NXIO.raw_os_error()) => return Err(error),
            Err(_) if begin.elapsed() >= patience => {
                let reason = format!("the pipe had no reader for {patience:?}");
                return Err(io::Error::new(ErrorKind::TimedOut, reason));
            }
            Err(_) => sleep(Duration::from_millis(20)),
        }
    }
}

/// Returns the final target of a link, whether the file exists or not.
fn follow(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&target) else { return Ok(target) };
        target = target.parent().unwrap_or(Path::new("")).join(next);
    }
    Err(io::Error::other("too many symbolic links in a chain"))
}

/// Returns an error for a folder or a read-only file. A rename would replace read-only files, and an administrator may
/// open them.
fn check_replaceable(target: &Path, old: &fs::Metadata) -> io::Result<()> {
    if old.is_dir() {
        return Err(io::Error::new(ErrorKind::IsADirectory, "it is a folder"));
    }
    if old.permissions().readonly() {
        return Err(io::Error::new(ErrorKind::PermissionDenied, "the file is read-only; it is not replaced"));
    }
    OpenOptions::new().write(true).open(target).map(drop)
}

/// Creates a file in the folder of `target`. Its name does not contain the target's, which may have the maximum length.
fn create_beside(target: &Path) -> io::Result<NamedTempFile> {
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    stale::remove_once(folder);
    let prefix = stale::prefix();
    let mut fault = None;
    let created = tempfile::Builder::new().prefix(&prefix).suffix(stale::SUFFIX).make_in(folder, |path| {
        let opened = OpenOptions::new().read(true).write(true).create_new(true).open(path);
        opened.map_err(|error| {
            let kind = error.kind();
            fault = Some(error);
            kind.into()
        })
    });
    // The system's own error is returned: tempfile's error names the temporary file, but callers name the target.
    created.map_err(|error| fault.unwrap_or(error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::Folder;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_temporary() {
        let folder = Folder::new("failed");
        let path = folder.file("a.bin");
        write_whole(&path, b"old").unwrap();
        let result = Batch::new().add_with(&path, |file| {
            file.write_all(b"half of the n")?;
            Err(io::Error::other("disk full"))
        });
        let message = result.unwrap_err().to_string();
        assert!(message.ends_with("a.bin: disk full"), "{message}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(folder.names(), ["a.bin"]);
        write_whole(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(folder.names(), ["a.bin"]);
    }

    #[test]
    fn a_folder_is_not_replaced_and_a_missing_one_is_named() {
        let folder = Folder::new("folder");
        let inner = folder.file("inner");
        fs::create_dir(&inner).unwrap();
        assert!(write_whole(&inner, b"x").unwrap_err().to_string().ends_with("inner: it is a folder"));
        let message = write_whole(folder.file("none").join("a.bin"), b"x").unwrap_err().to_string();
        assert!(message.contains("a.bin: ") && message.ends_with("(os error 2)"), "{message}");
        assert!(write_whole("", b"x").is_err());
        assert_eq!(folder.names(), ["inner"]);
    }

    #[test]
    fn a_read_only_file_is_not_replaced() {
        let folder = Folder::new("read_only");
        let path = folder.file("a.bin");
        fs::write(&path, b"old").unwrap();
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        let message = write_whole(&path, b"new").unwrap_err().to_string();
        assert!(message.ends_with("a.bin: the file is read-only; it is not replaced"), "{message}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(folder.names(), ["a.bin"]);
    }

    #[test]
    fn files_of_a_batch_appear_together_or_not_at_all() {
        let folder = Folder::new("batch");
        fs::write(folder.file("b"), b"old").unwrap();
        fs::create_dir(folder.file("folder")).unwrap();
        let mut batch = Batch::new();
        batch.add(folder.file("a"), b"new a").unwrap();
        batch.add(folder.file("b"), b"new b").unwrap();
        let seen = folder.names();
        assert!(!seen.contains(&"a".into()) && fs::read(folder.file("b")).unwrap() == b"old", "{seen:?}");
        assert!(batch.add(folder.file("folder"), b"x").is_err());
        drop(batch);
        assert_eq!(folder.names(), ["b", "folder"]);

        let mut batch = Batch::new();
        batch.add(folder.file("a"), b"new a").unwrap();
        batch.add(folder.file("b"), b"new b").unwrap();
        assert_eq!(batch.commit().unwrap(), [folder.file("a"), folder.file("b")]);
        assert_eq!(folder.names(), ["a", "b", "folder"]);
        assert_eq!(fs::read(folder.file("b")).unwrap(), b"new b");

        // A failure during commit must leave no new file.
        let mut batch = Batch::new();
        batch.add(folder.file("c"), b"c").unwrap();
        batch.add(folder.file("d"), b"d").unwrap();
        fs::create_dir(folder.file("d")).unwrap();
        let message = batch.commit().unwrap_err().to_string();
        assert!(message.contains("d: "), "{message}");
        assert_eq!(folder.names(), ["a", "b", "d", "folder"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_permissions_and_sockets_survive() {
        use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
        use std::os::unix::net::UnixListener;

        let folder = Folder::new("unix");
        let (file, link) = (folder.file("file"), folder.file("link"));
        fs::write(&file, b"old").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
        symlink(&file, &link).unwrap();
        write_whole(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
        let long = "n".repeat(255);
        write_whole(folder.file(&long), b"x").unwrap();
        let socket = folder.file("socket");
        let _listener = UnixListener::bind(&socket).unwrap();
        assert!(write_whole(&socket, b"x").is_err());
        assert!(fs::metadata(&socket).unwrap().file_type().is_socket());
        assert_eq!(folder.names(), ["file", "link", &long, "socket"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_is_written_to_as_it_is_read_and_given_up_without_a_reader() {
        use std::{io::Read, process::Command, thread, time::Duration};

        let folder = Folder::new("pipe");
        let pipe = folder.file("pipe");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let error = open_pipe(&pipe, Duration::from_millis(50)).unwrap_err();
        assert_eq!((error.kind(), error.to_string()), (ErrorKind::TimedOut, "the pipe had no reader for 50ms".into()));
        // The content exceeds the buffer of a pipe.
        let bytes = vec![7; 1 << 20];
        let reader = thread::spawn({
            let pipe = pipe.clone();
            move || {
                let mut found = Vec::new();
                File::open(pipe).unwrap().read_to_end(&mut found).unwrap();
                found
            }
        });
        write_whole(&pipe, &bytes).unwrap();
        assert!(reader.join().unwrap() == bytes);
        assert_eq!(folder.names(), ["pipe"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_whose_file_is_not_there_yet_still_leads_to_it() {
        use std::os::unix::fs::symlink;

        let folder = Folder::new("dangling");
        fs::create_dir(folder.file("inner")).unwrap();
        symlink("second", folder.file("first")).unwrap();
        symlink("inner/file", folder.file("second")).unwrap();
        write_whole(folder.file("first"), b"new").unwrap();
        assert_eq!(fs::read(folder.file("inner/file")).unwrap(), b"new");
        assert!(fs::symlink_metadata(folder.file("first")).unwrap().is_symlink());
        symlink("round", folder.file("round")).unwrap();
        assert!(write_whole(folder.file("round"), b"x").unwrap_err().to_string().contains("too many symbolic links"));
        assert_eq!(folder.names(), ["first", "inner", "round", "second"]);
    }
}
