//! Reads a scene's files from the disk or from memory.

use std::{
    borrow::Cow,
    cell::Cell,
    collections::HashMap,
    io::{self, ErrorKind, Read},
    path::{Path, PathBuf},
};

use super::{check_size, open};
#[cfg(any(feature = "obj", feature = "gltf"))]
use crate::error::located;
use crate::{Error, Limits};

/// The source of a scene file and of the files that it names.
#[derive(Clone, Copy)]
pub(crate) enum Files<'a> {
    #[cfg_attr(not(any(feature = "obj", feature = "gltf")), allow(dead_code, reason = "PLY files name no others"))]
    Disk(&'a SceneFolder),
    Memory(&'a Given<'a>),
}

/// Folder of a scene file on the disk. By default, names in the file must not lead out of it.
#[cfg_attr(not(any(feature = "obj", feature = "gltf")), allow(dead_code, reason = "PLY files name no others"))]
pub(crate) struct SceneFolder {
    /// Path of the scene file, as given.
    scene: PathBuf,
    /// Canonical path of its folder; `None` if the system can't determine it.
    real: Option<PathBuf>,
    /// Option that allows files outside, for messages; `None` if they are allowed.
    opened_by: Option<&'static str>,
    /// Whether a warning about a path from another machine was logged.
    is_warned: Cell<bool>,
}

impl SceneFolder {
    /// Returns the folder of `scene`. If the file is a link, it is the link's folder.
    pub(crate) fn of(scene: &Path, opened_by: Option<&'static str>) -> Self {
        let real = parent(scene).canonicalize().ok();
        Self { scene: scene.into(), real, opened_by, is_warned: Cell::new(false) }
    }
}

/// Returns the folder of a file, or the current one for a bare name.
fn parent(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Files in memory, by their paths as [`normalised`] returns them.
pub(crate) struct Given<'a> {
    content: HashMap<String, &'a [u8]>,
    /// Paths of files by their last component in lower case; `None` if several share it.
    #[cfg_attr(not(any(feature = "obj", feature = "gltf")), allow(dead_code, reason = "PLY files name no others"))]
    paths: HashMap<String, Option<String>>,
}

impl<'a> Given<'a> {
    /// Indexes the files. If two names mean the same path, the first one counts.
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
    /// Returns a file's bytes.
    ///
    /// # Errors
    /// Returns the errors of [`open`], and [`Error::Io`] for a file that is not in memory.
    pub(crate) fn read_bytes(self, path: &Path, limit: u64, raised_by: &str) -> Result<Cow<'a, [u8]>, Error> {
        match self.given(path)? {
            Some(bytes) => {
                check_size(path, bytes.len() as u64, limit, raised_by)?;
                Ok(Cow::Borrowed(bytes))
            }
            None => super::read_bytes(path, limit, raised_by).map(Cow::Owned),
        }
    }

    /// Returns a text file's bytes. UTF-16 is an error.
    #[cfg(feature = "obj")]
    pub(crate) fn read(self, path: &Path, limit: u64, raised_by: &str) -> Result<Cow<'a, [u8]>, Error> {
        let content = self.read_bytes(path, limit, raised_by)?;
        super::check_text(path, &content)?;
        Ok(content)
    }

    /// Returns up to `count` bytes from the start of a file that is within the limits.
    pub(crate) fn start(self, path: &Path, count: u64, limits: &Limits) -> Result<Vec<u8>, Error> {
        let (limit, raised_by) = (limits.file_bytes, limits.option_names[0]);
        let mut start = Vec::new();
        let read = match self {
            Self::Disk(_) => open(path, limit, raised_by)?.0.take(count).read_to_end(&mut start),
            Self::Memory(_) => self.read_bytes(path, limit, raised_by)?.take(count).read_to_end(&mut start),
        };
        read.map_err(|source| Error::io(path, source))?;
        Ok(start)
    }

    /// Returns the bytes of a file in memory, without a limit; `None` if files are on the disk.
    pub(crate) fn given(self, path: &Path) -> Result<Option<&'a [u8]>, Error> {
        let Self::Memory(given) = self else { return Ok(None) };
        let missing = || Error::io(path, io::Error::new(ErrorKind::NotFound, "no such file among those in memory"));
        given.bytes(path).map(Some).ok_or_else(missing)
    }
}

#[cfg(any(feature = "obj", feature = "gltf"))]
impl Files<'_> {
    /// Returns the path of a file that another one in `folder` names.
    ///
    /// In memory, where folders may be missing, a file that is not at its path is found by its last component. Upper
    /// and lower case count as equal, and no other file may match.
    ///
    /// On the disk, an absolute path may come from another machine. If no readable file is there, a file with its last
    /// component is taken, from `folder` or from the scene's folder.
    ///
    /// # Errors
    /// [`Error::Io`] for a file on the disk outside the scene's folder, unless the options allow it.
    pub(crate) fn locate(self, folder: &Path, name: &str) -> Result<PathBuf, Error> {
        let path = self.join(folder, name);
        match self {
            Self::Memory(given) if !self.is_file(&path) => {
                let found = given.paths.get(&last_component(&normalised(&path.to_string_lossy())));
                Ok(found.cloned().flatten().map_or(path, PathBuf::from))
            }
            Self::Memory(_) => Ok(path),
            Self::Disk(scene) => {
                let checked = scene.check(&path);
                if checked.is_ok() && path.is_file() {
                    return Ok(path);
                }
                match scene.beside(folder, name) {
                    Some(beside) => Ok(beside),
                    None => checked.map(|()| path),
                }
            }
        }
    }

    /// Returns the path that a name means. Names may use another system's separators.
    pub(crate) fn join(self, folder: &Path, name: &str) -> PathBuf {
        let path = folder.join(name);
        match self {
            Self::Disk(_) if path.is_file() => path,
            _ => folder.join(name.replace('\\', "/")),
        }
    }

    pub(crate) fn is_file(self, path: &Path) -> bool {
        match self {
            Self::Disk(_) => path.is_file(),
            Self::Memory(given) => given.bytes(path).is_some(),
        }
    }

    /// Returns one path for all paths that lead to a file.
    pub(crate) fn real(self, path: &Path) -> PathBuf {
        match self {
            Self::Disk(_) => path.canonicalize().unwrap_or_else(|_| path.into()),
            Self::Memory(_) => normalised(&path.to_string_lossy()).into(),
        }
    }
}

#[cfg(any(feature = "obj", feature = "gltf"))]
impl SceneFolder {
    /// Refuses a file outside the folder, also if a link leads to it. If it is no file, [`open`] refuses it later.
    fn check(&self, path: &Path) -> Result<(), Error> {
        let Some(option) = self.opened_by.filter(|_| path.is_file()) else { return Ok(()) };
        let real = path.canonicalize().map_err(|source| Error::io(path, source))?;
        if self.real.as_ref().is_some_and(|folder| real.starts_with(folder)) {
            return Ok(());
        }
        let folder = self.real.as_deref().unwrap_or(parent(&self.scene)).display();
        let reason = format!("it is {}, outside the scene's folder {folder}; to read it, use {option}", real.display());
        Err(Error::io(path, io::Error::new(ErrorKind::PermissionDenied, reason)))
    }

    /// Returns the local file to use for an absolute path from another machine. Only the first one gives a warning.
    fn beside(&self, folder: &Path, name: &str) -> Option<PathBuf> {
        let last = last_of_absolute(name)?;
        let places = [folder, parent(&self.scene)].map(|folder| folder.join(last));
        let found = places.into_iter().find(|path| path.is_file() && self.check(path).is_ok())?;
        if !self.is_warned.replace(true) {
            let text = format!(
                "it names '{name}', a path of another machine; {} is read instead, and similar paths likewise",
                found.display()
            );
            log::warn!("{}", located(&self.scene, None, &text));
        }
        Some(found)
    }
}

/// Returns the last component of an absolute path, of this system or another; `None` for other paths.
#[cfg(any(feature = "obj", feature = "gltf"))]
fn last_of_absolute(name: &str) -> Option<&str> {
    let behind_drive = match name.as_bytes() {
        [letter, b':', ..] if letter.is_ascii_alphabetic() => Some(&name[2..]),
        _ => None,
    };
    let path = behind_drive.or_else(|| name.starts_with(['/', '\\']).then_some(name))?;
    path.rsplit(['/', '\\']).next().filter(|last| !last.is_empty())
}

/// Returns a path with `/` as the only separator, without `.` and without folders that `..` leaves. A leading
/// separator, as in paths dropped into a browser, is removed.
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

/// Returns a path's last component, in lower case.
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

    /// Locates a file among these keys; the bytes of each file are its key.
    fn find(keys: &[&str], folder: &str, name: &str) -> Option<String> {
        let given = Given::new(keys.iter().map(|key| (*key, key.as_bytes())));
        let files = Files::Memory(&given);
        let path = files.locate(Path::new(folder), name).ok()?;
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
            // Two files have this name.
            ("house", "wood.png", None),
            ("house", "tex/wood.png", None),
            ("house", "maps/\u{e9}mail.PNG", Some("/house/tex/\u{c9}mail.png")),
            ("house", "C:\\house\\Roof.png", Some("roof.png")),
            ("house", "../../../roof.png", Some("roof.png")),
            ("house", "tiles/roof.jpg", None),
            // Folders are not files.
            ("house", "tex", None),
            ("house", "", None),
            ("", "..", None),
        ] {
            assert_eq!(find(&drop, folder, name).as_deref(), expected, "{folder} {name}");
        }
        assert_eq!(find(&[], "", "a.png"), None);
        // If a path is given twice, the first file counts.
        assert_eq!(find(&["./a.png", "a.png"], "sub", "a.png").as_deref(), Some("./a.png"));
    }

    #[test]
    fn absolute_paths_of_any_system_have_a_last_component() {
        for (name, expected) in [
            ("C:\\textures\\a b.png", Some("a b.png")),
            ("d:/tex/a.png", Some("a.png")),
            ("C:a.png", Some("a.png")),
            ("\\\\server\\share\\a.png", Some("a.png")),
            ("/home/me/a.png", Some("a.png")),
            ("/", None),
            ("C:", None),
            ("tex\\a.png", None),
            ("../a.png", None),
            ("", None),
            ("\u{e9}:a.png", None),
        ] {
            assert_eq!(last_of_absolute(name), expected, "{name}");
        }
    }

    #[test]
    fn what_is_not_found_keeps_the_path_that_the_disk_would_be_asked_for() {
        let given = Given::new([("a.obj", &b""[..])].into_iter());
        let disk = SceneFolder::of(Path::new("none/a.obj"), Some("an option"));
        for files in [Files::Disk(&disk), Files::Memory(&given)] {
            let located = files.locate(Path::new("none"), "./tex\\a.png").unwrap();
            assert_eq!(located, Path::new("none/./tex/a.png"));
        }
        let error = Files::Memory(&given).read_bytes(Path::new("tex/a.obj"), 9, "Limits").unwrap_err();
        assert!(matches!(&error, Error::Io { source, .. } if source.kind() == ErrorKind::NotFound), "{error}");
    }
}
