//! Where a scene's files come from: the disk or memory.

#[cfg(any(feature = "obj", feature = "gltf"))]
use std::path::PathBuf;
use std::{
    borrow::Cow,
    collections::HashMap,
    io::{self, ErrorKind, Read},
    path::Path,
};

use super::{check_size, open};
use crate::{Error, Limits};

/// Where a scene file is read from, and what it names.
#[derive(Clone, Copy)]
pub(crate) enum Files<'a> {
    Disk,
    Memory(&'a Given<'a>),
}

/// Files in memory, by their paths as [`normalised`] makes them.
pub(crate) struct Given<'a> {
    content: HashMap<String, &'a [u8]>,
    /// The path to a file by its last component in lower case; `None` where several end in it.
    #[cfg_attr(not(any(feature = "obj", feature = "gltf")), allow(dead_code, reason = "PLY files name no others"))]
    paths: HashMap<String, Option<String>>,
}

impl<'a> Given<'a> {
    /// Of two names that mean the same path the first one counts.
    pub(crate) fn new(files: impl Iterator<Item = (&'a str, &'a [u8])>) -> Self {
        let mut given = Self { content: HashMap::new(), paths: HashMap::new() };
        for (name, bytes) in files {
            let path = normalised(name);
            if given.content.contains_key(&path) {
                continue;
            }
            let known = given.paths.entry(last_component(&path));
            known.and_modify(|known| *known = None).or_insert_with(|| Some(path.clone()));
            given.content.insert(path, bytes);
        }
        given
    }

    fn bytes(&self, path: &Path) -> Option<&'a [u8]> {
        self.content.get(&normalised(&path.to_string_lossy())).copied()
    }
}

impl<'a> Files<'a> {
    /// A file's bytes.
    ///
    /// # Errors
    /// Those of [`open`]; [`Error::Io`] for what is not in memory.
    pub(crate) fn read_bytes(self, path: &Path, limit: u64, raised_by: &str) -> Result<Cow<'a, [u8]>, Error> {
        match self.given(path)? {
            Some(bytes) => {
                check_size(path, bytes.len() as u64, limit, raised_by)?;
                Ok(Cow::Borrowed(bytes))
            }
            None => super::read_bytes(path, limit, raised_by).map(Cow::Owned),
        }
    }

    /// A text's bytes. UTF-16 is an error.
    #[cfg(feature = "obj")]
    pub(crate) fn read(self, path: &Path, limit: u64, raised_by: &str) -> Result<Cow<'a, [u8]>, Error> {
        let content = self.read_bytes(path, limit, raised_by)?;
        super::check_text(path, &content)?;
        Ok(content)
    }

    /// The first bytes of a file that is within the limits, at most so many.
    pub(crate) fn start(self, path: &Path, count: u64, limits: &Limits) -> Result<Vec<u8>, Error> {
        let (limit, raised_by) = (limits.file_bytes, limits.option_names[0]);
        let mut start = Vec::new();
        let read = match self {
            Self::Disk => open(path, limit, raised_by)?.0.take(count).read_to_end(&mut start),
            Self::Memory(_) => self.read_bytes(path, limit, raised_by)?.take(count).read_to_end(&mut start),
        };
        read.map_err(|source| Error::io(path, source))?;
        Ok(start)
    }

    /// The bytes of a file in memory, however many; `None` where files lie on the disk.
    pub(crate) fn given(self, path: &Path) -> Result<Option<&'a [u8]>, Error> {
        let Self::Memory(given) = self else { return Ok(None) };
        let missing = || Error::io(path, io::Error::new(ErrorKind::NotFound, "no such file among those in memory"));
        given.bytes(path).map(Some).ok_or_else(missing)
    }
}

#[cfg(any(feature = "obj", feature = "gltf"))]
impl Files<'_> {
    /// Where a file lies that another one in `folder` names. In memory, which may be without folders, one that is not at its path is found by its
    /// last component, if no other has the same but for upper and lower case.
    pub(crate) fn locate(self, folder: &Path, name: &str) -> PathBuf {
        let path = self.join(folder, name);
        match self {
            Self::Memory(given) if !self.is_file(&path) => {
                let found = given.paths.get(&last_component(&normalised(&path.to_string_lossy())));
                found.cloned().flatten().map_or(path, PathBuf::from)
            }
            _ => path,
        }
    }

    /// The path that a name means. Some names come with the separators of another system.
    pub(crate) fn join(self, folder: &Path, name: &str) -> PathBuf {
        let path = folder.join(name);
        match self {
            Self::Disk if path.is_file() => path,
            _ => folder.join(name.replace('\\', "/")),
        }
    }

    pub(crate) fn is_file(self, path: &Path) -> bool {
        match self {
            Self::Disk => path.is_file(),
            Self::Memory(given) => given.bytes(path).is_some(),
        }
    }

    /// One path for all that lead to a file.
    pub(crate) fn real(self, path: &Path) -> PathBuf {
        match self {
            Self::Disk => path.canonicalize().unwrap_or_else(|_| path.into()),
            Self::Memory(_) => normalised(&path.to_string_lossy()).into(),
        }
    }
}

/// A path with `/` alone, without `.` and without folders that `..` leaves. What begins with a separator, as paths of a drop in a browser do, is the
/// same without it.
fn normalised(path: &str) -> String {
    let mut components: Vec<&str> = Vec::new();
    for component in path.split(['/', '\\']) {
        match component {
            "" | "." => {}
            ".." if components.last().is_some_and(|last| *last != "..") => drop(components.pop()),
            _ => components.push(component),
        }
    }
    components.join("/")
}

/// What stands behind a path's last separator, in lower case.
fn last_component(path: &str) -> String {
    path.rsplit('/').next().unwrap_or(path).to_lowercase()
}

#[cfg(all(test, any(feature = "obj", feature = "gltf")))]
mod tests {
    use super::*;

    #[test]
    fn what_makes_no_difference_to_a_path_goes() {
        for (path, expected) in [
            ("a.obj", "a.obj"),
            ("/house//a.obj", "house/a.obj"),
            ("./house/./a.obj", "house/a.obj"),
            ("house\\tex\\..\\a b.png", "house/a b.png"),
            ("a/../../b/../../c.png", "../../c.png"),
            ("../a/..", ".."),
            ("C:\\tex\\a.png", "C:/tex/a.png"),
            ("", ""),
        ] {
            assert_eq!(normalised(path), expected, "{path}");
            assert_eq!(normalised(expected), expected);
        }
    }

    /// The bytes of each file are its key.
    fn find(keys: &[&str], folder: &str, name: &str) -> Option<String> {
        let given = Given::new(keys.iter().map(|key| (*key, key.as_bytes())));
        let files = Files::Memory(&given);
        let path = files.locate(Path::new(folder), name);
        let found = files.given(&path).ok()?.expect("files in memory");
        assert!(files.is_file(&path));
        Some(String::from_utf8(found.to_vec()).unwrap())
    }

    #[test]
    fn files_are_found_by_their_path_first_and_by_a_last_component_that_one_has() {
        let drop =
            ["/house/House.obj", "/house/tex/Wood.PNG", "/house/old/wood.png", "/house/tex/\u{c9}mail.png", "roof.png"];
        for (folder, name, expected) in [
            ("house", "tex/Wood.PNG", Some("/house/tex/Wood.PNG")),
            ("/house/tex", "Wood.PNG", Some("/house/tex/Wood.PNG")),
            ("house/tex", "..\\old\\wood.png", Some("/house/old/wood.png")),
            ("house", "./tex/../old//wood.png", Some("/house/old/wood.png")),
            ("", "/house/old/wood.png", Some("/house/old/wood.png")),
            // Two have the name.
            ("house", "wood.png", None),
            ("house", "tex/wood.png", None),
            ("house", "maps/\u{e9}mail.PNG", Some("/house/tex/\u{c9}mail.png")),
            ("house", "C:\\house\\Roof.png", Some("roof.png")),
            ("house", "../../../roof.png", Some("roof.png")),
            ("house", "tiles/roof.jpg", None),
            // Folders are no files.
            ("house", "tex", None),
            ("house", "", None),
            ("", "..", None),
        ] {
            assert_eq!(find(&drop, folder, name).as_deref(), expected, "{folder} {name}");
        }
        assert_eq!(find(&[], "", "a.png"), None);
        // One path twice is one file, the first.
        assert_eq!(find(&["./a.png", "a.png"], "sub", "a.png").as_deref(), Some("./a.png"));
    }

    #[test]
    fn what_is_not_found_keeps_the_path_that_the_disk_would_be_asked_for() {
        let given = Given::new([("a.obj", &b""[..])].into_iter());
        for files in [Files::Disk, Files::Memory(&given)] {
            assert_eq!(files.locate(Path::new("none"), "./tex\\a.png"), Path::new("none/./tex/a.png"));
        }
        let error = Files::Memory(&given).read_bytes(Path::new("tex/a.obj"), 9, "Limits").unwrap_err();
        assert!(matches!(&error, Error::Io { source, .. } if source.kind() == ErrorKind::NotFound), "{error}");
    }
}
