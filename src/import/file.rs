//! Opens scene files of any format.

use std::{collections::BTreeMap, ffi::OsStr, path::Path, sync::Arc};

use super::SceneOptions;
use crate::scene::Scene;
use crate::{
    Animation, Error, StereoCamera,
    import::input::{Files, Given},
};

/// Format of a scene file.
#[derive(Clone, Copy, PartialEq)]
enum Format {
    Obj,
    Gltf,
    Ply,
}

/// Known file name extensions.
const ENDINGS: [(&str, Format); 4] =
    [("obj", Format::Obj), ("gltf", Format::Gltf), ("glb", Format::Gltf), ("ply", Format::Ply)];

/// Content of a scene file: OBJ, glTF 2.0 (.gltf and .glb) or PLY. The cargo features `obj`, `gltf` and `ply` enable
/// the formats.
///
/// ```no_run
/// use stereotrace::{SceneFile, SceneOptions, StereoCamera};
///
/// let SceneFile { mut scene, cameras, .. } = SceneFile::open("house.glb", &SceneOptions::default())?;
/// let camera = match (cameras.first(), scene.bounds()) {
///     (Some((_, camera)), _) => camera.size(1280, 720),
///     (None, Some(bounds)) => StereoCamera::fitting(bounds, 1280, 720),
///     (None, None) => panic!("nothing to see"),
/// };
/// if scene.lights.is_empty() {
///     scene.place_lights(3, &camera)?;
/// }
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SceneFile {
    /// The scene, with the file's own lights. Only glTF files may have lights.
    pub scene: Scene,
    /// The file's cameras with their names, in the file's order: glTF's perspective cameras. Their pictures are 480
    /// pixels high. The screen stands at the depth of the centre of the scene's bounds, but at least a quarter of these
    /// bounds' diagonal away. The interaxial is a thirtieth of that distance.
    pub cameras: Vec<(Arc<str>, StereoCamera)>,
    /// The file's animations, in the file's order. Only glTF files may have any.
    pub animations: Vec<Animation>,
}

impl SceneFile {
    /// Reads a scene file. Its content determines the format. If it does not, the extension of the file's name does.
    ///
    /// # Errors
    /// - [`Error::UnknownName`] for a file of another format.
    /// - The errors of [`Scene::from_obj_with`], [`Scene::from_gltf_with`] and [`Scene::from_ply_with`].
    /// - [`Error::Parse`] if the feature for the format is disabled.
    pub fn open(path: impl AsRef<Path>, options: &SceneOptions) -> Result<Self, Error> {
        let path = path.as_ref();
        Self::read(Files::Disk(&options.folder_of(path)), path, options)
    }

    /// Reads a scene file from memory, as [`SceneFile::open`] does from the disk, for example files dropped on a web
    /// page. `files` has the bytes of the file `name` and of all files that it names (MTL files, pictures, buffers).
    /// Its keys are paths from one folder, with `/` or `\` as separators. Files without folders have their names alone.
    ///
    /// Names in a file are relative to that file's folder. If no file is at that path, the file with the same last
    /// component is taken, in any folder. Upper and lower case count as equal, and only one file may match. So
    /// files may come without their folders.
    ///
    /// ```no_run
    /// use std::collections::BTreeMap;
    ///
    /// use stereotrace::{SceneFile, SceneOptions};
    ///
    /// # let (obj, mtl, png) = (vec![], vec![], vec![]);
    /// let files = BTreeMap::from([
    ///     ("spot/spot.obj".into(), obj),
    ///     ("spot/spot.mtl".into(), mtl),
    ///     ("spot/textures/spot.png".into(), png),
    /// ]);
    /// let SceneFile { scene, .. } = SceneFile::from_memory("spot/spot.obj", &files, &SceneOptions::default())?;
    /// # let _ = scene;
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns the errors of [`SceneFile::open`]. Returns [`Error::Io`] of the kind
    /// [`NotFound`](std::io::ErrorKind::NotFound) if `name` is not among the files. Missing files that it names give
    /// the same errors as on the disk.
    pub fn from_memory(name: &str, files: &BTreeMap<String, Vec<u8>>, options: &SceneOptions) -> Result<Self, Error> {
        let given = Given::new(files.iter().map(|(name, bytes)| (&**name, &**bytes)));
        // Other names are relative to this path's folder, and most systems only know `/`.
        Self::read(Files::Memory(&given), Path::new(&name.replace('\\', "/")), options)
    }

    #[cfg(any(feature = "obj", feature = "ply"))]
    fn of(scene: Scene) -> Self {
        Self { scene, cameras: Vec::new(), animations: Vec::new() }
    }

    fn read(files: Files, path: &Path, options: &SceneOptions) -> Result<Self, Error> {
        match format_of(files, path, options)? {
            #[cfg(feature = "obj")]
            Format::Obj => super::obj::read(files, path, options).map(Self::of),
            #[cfg(feature = "gltf")]
            Format::Gltf => super::gltf::read(files, path, options),
            #[cfg(feature = "ply")]
            Format::Ply => super::ply::read(files, path, options).map(Self::of),
            #[allow(unreachable_patterns, reason = "with all features there are no others")]
            format => {
                let (name, _) = ENDINGS.into_iter().find(|(_, known)| *known == format).unwrap_or(ENDINGS[0]);
                Err(Error::parse(path, None, format!("stereotrace is built without its feature `{name}`")))
            }
        }
    }
}

fn format_of(files: Files, path: &Path, options: &SceneOptions) -> Result<Format, Error> {
    let start = files.start(path, 64, &options.limits)?;
    let text = start.strip_prefix("\u{feff}".as_bytes()).unwrap_or(&start).trim_ascii_start();
    if start.starts_with(b"glTF") || text.starts_with(b"{") {
        return Ok(Format::Gltf);
    }
    if start.starts_with(b"ply\n") || start.starts_with(b"ply\r") {
        return Ok(Format::Ply);
    }
    let ending = path.extension().unwrap_or(OsStr::new("")).to_string_lossy().to_lowercase();
    match ENDINGS.iter().find(|(known, _)| *known == ending) {
        Some((_, format)) => Ok(*format),
        None => Err(Error::unknown_name("ending of a scene file", &ending, &ENDINGS.map(|(known, _)| known))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::Folder;

    #[test]
    fn content_tells_the_format_and_the_ending_where_it_does_not() {
        let folder = Folder::new("scene_file");
        let options = SceneOptions::default();
        let disk = options.folder_of(&folder.file("a.obj"));
        let format = |name: &str, content: &str| format_of(Files::Disk(&disk), &folder.write(name, content), &options);
        for (name, content, expected) in [
            ("a.obj", "v 0 0 0", Format::Obj),
            ("A.OBJ", "", Format::Obj),
            ("b.gltf", " \n{}", Format::Gltf),
            ("b.json", "\u{feff}{", Format::Gltf),
            ("b.obj", "glTF\u{2}", Format::Gltf),
            ("b.glb", "", Format::Gltf),
            ("c", "ply\r\n", Format::Ply),
            ("c.ply", "plywood", Format::Ply),
        ] {
            assert!(format(name, content).unwrap() == expected, "{name}");
        }
        for (name, ending) in [("house.stl", "stl"), ("house", ""), ("house.obj.gz", "gz")] {
            let message = format(name, "solid ply").err().map(|error| error.to_string()).unwrap_or_default();
            let expected = format!("unknown ending of a scene file '{ending}'; use one of obj, gltf, glb, ply");
            assert_eq!(message, expected);
        }
        assert!(matches!(format_of(Files::Disk(&disk), &folder.file("none.obj"), &options), Err(Error::Io { .. })));
    }
}
