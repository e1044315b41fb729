//! Textures, skies and meshes of the user's folders.

use std::{
    fs::{self, File},
    io::Read as _,
    path::{Path, PathBuf},
    sync::Arc,
};

use glam::Vec3;
use sha2::{Digest as _, Sha256};

use super::form::{Face, Form};
use crate::{
    Error, Material, SceneFile, SceneOptions, SkyMap, Texture, TextureKind,
    dataset::spec::{Generate, Spec},
    scene::content::hex,
};

/// Maximum number of files in a folder and below.
const MOST_FILES: usize = 10_000;
/// Maximum depth of folders in a folder.
const MOST_LEVELS: usize = 16;
/// Largest side of a texture in pixels. Larger pictures are reduced.
const TEXTURE_SIDE: usize = 512;
/// Largest width of a sky in pixels. Larger ones are reduced.
const SKY_WIDTH: usize = 1024;
/// Maximum number of triangles of a mesh file.
const MOST_TRIANGLES: usize = 100_000;
/// Memory in bytes for the files of a folder. Files beyond it are read again when they are needed.
const MEMORY: usize = 256 << 20;

/// File name extensions of the three kinds of folders.
const PICTURES: &[&str] = &["png", "jpg", "jpeg"];
const SKIES: &[&str] = &["hdr", "exr", "png", "jpg", "jpeg"];
const MESHES: &[&str] = &["glb", "gltf", "obj", "ply"];

/// The files of a spec's folders.
#[derive(Default)]
pub(in crate::dataset) struct Assets {
    textures: Folder<Texture>,
    skies: Folder<SkyMap>,
    meshes: Folder<Arc<Model>>,
}

/// A mesh file as a form with its longest side of 1, and its materials by slot.
pub(super) struct Model {
    pub(super) form: Form,
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
}

/// The files of a folder, in the order of their names.
struct Folder<T> {
    files: Vec<PathBuf>,
    /// The content of the first files, as far as memory allows.
    kept: Vec<T>,
    digest: String,
}

impl<T> Default for Folder<T> {
    fn default() -> Self {
        Self { files: Vec::new(), kept: Vec::new(), digest: String::new() }
    }
}

impl Assets {
    /// Lists and checks the files of the folders.
    pub(in crate::dataset) fn open(spec: &Spec, generate: &Generate) -> Result<Self, Error> {
        let path = |folder: &Option<String>| folder.as_ref().map(|folder| spec.path_of(folder));
        Ok(Self {
            textures: Folder::open("textures", path(&generate.textures), PICTURES, reduced, texture_memory)?,
            skies: Folder::open("skies", path(&generate.skies), SKIES, reduced_sky, sky_memory)?,
            meshes: Folder::open("meshes", path(&generate.meshes), MESHES, model, |model| model.memory())?,
        })
    }

    /// Returns a hash of the folders' contents.
    pub(in crate::dataset) fn digest(&self) -> String {
        [&self.textures.digest, &self.skies.digest, &self.meshes.digest].map(String::as_str).join(" ")
    }

    pub(super) fn has_textures(&self) -> bool {
        !self.textures.files.is_empty()
    }

    pub(super) fn texture_count(&self) -> usize {
        self.textures.files.len()
    }

    pub(super) fn sky_count(&self) -> usize {
        self.skies.files.len()
    }

    pub(super) fn mesh_count(&self) -> usize {
        self.meshes.files.len()
    }

    pub(super) fn texture(&self, index: usize) -> Result<Texture, Error> {
        self.textures.get(index, reduced)
    }

    pub(super) fn sky(&self, index: usize) -> Result<SkyMap, Error> {
        self.skies.get(index, reduced_sky)
    }

    pub(super) fn mesh(&self, index: usize) -> Result<Arc<Model>, Error> {
        self.meshes.get(index, model)
    }
}

impl<T: Clone> Folder<T> {
    fn open(
        key: &str,
        path: Option<PathBuf>,
        endings: &[&str],
        read: impl Fn(&Path) -> Result<T, Error>,
        memory: impl Fn(&T) -> usize,
    ) -> Result<Self, Error> {
        let Some(path) = path else { return Ok(Self::default()) };
        let fault = |reason: String| Error::Spec { key: format!("generate.{key}"), reason };
        let mut all = Vec::new();
        list(&path, 0, &mut all).map_err(&fault)?;
        all.sort();
        let fits = |file: &PathBuf| {
            let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
            endings.contains(&ending.to_ascii_lowercase().as_str())
        };
        let files: Vec<PathBuf> = all.iter().filter(|file| fits(file)).cloned().collect();
        if files.is_empty() {
            let reason = format!("the folder {} has no files of the kinds {}", path.display(), endings.join(", "));
            return Err(fault(reason));
        }
        let digest = digest(&path, &all)?;
        let (mut kept, mut used) = (Vec::new(), 0);
        for file in &files {
            let content = read(file)?;
            used += memory(&content);
            if used <= MEMORY {
                kept.push(content);
            }
        }
        Ok(Self { files, kept, digest })
    }

    fn get(&self, index: usize, read: impl Fn(&Path) -> Result<T, Error>) -> Result<T, Error> {
        self.kept.get(index).map_or_else(|| read(&self.files[index]), |kept| Ok(kept.clone()))
    }
}

/// Lists the regular files of a folder and below. Links that lead out of their folder are refused.
fn list(folder: &Path, level: usize, found: &mut Vec<PathBuf>) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("the folder {} can't be read: {error}", folder.display());
    if level > MOST_LEVELS {
        return Err(format!("{} is over {MOST_LEVELS} folders deep", folder.display()));
    }
    let real = folder.canonicalize().map_err(failed)?;
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let target = path.canonicalize().map_err(failed)?;
        if !target.starts_with(&real) {
            return Err(format!("{} is a link out of its folder", path.display()));
        }
        if target.is_dir() {
            list(&path, level + 1, found)?;
        } else if target.is_file() {
            found.push(path);
        }
        if found.len() > MOST_FILES {
            return Err(format!("the folder {} has over {MOST_FILES} files", folder.display()));
        }
    }
    Ok(())
}

/// Returns a hash of the names and contents of files.
fn digest(folder: &Path, files: &[PathBuf]) -> Result<String, Error> {
    let mut hash = Sha256::new();
    let mut piece = vec![0; 1 << 16];
    for path in files {
        let failed = |source| Error::Io { path: path.clone(), source };
        let name = path.strip_prefix(folder).unwrap_or(path).to_string_lossy().replace('\\', "/");
        let mut file = File::open(path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        hash.update(format!("{} {name} {length} ", name.len()));
        loop {
            match file.read(&mut piece).map_err(failed)? {
                0 => break,
                count => hash.update(&piece[..count]),
            }
        }
    }
    Ok(hex(&hash.finalize()))
}

fn texture_memory(texture: &Texture) -> usize {
    match texture.kind() {
        TextureKind::Image { pixels, .. } => size_of_val(&**pixels),
        TextureKind::Checkerboard { .. } => 0,
    }
}

fn sky_memory(sky: &SkyMap) -> usize {
    size_of_val(sky.pixels())
}

/// Reads a picture, and reduces it by a whole factor if it is large.
fn reduced(path: &Path) -> Result<Texture, Error> {
    let texture = Texture::open(path)?;
    let TextureKind::Image { size, pixels } = texture.kind() else { return Ok(texture) };
    let [width, height] = size.map(|side| side as usize);
    let factor = width.max(height).div_ceil(TEXTURE_SIDE);
    let small = [width, height].map(|side| (side / factor).max(1));
    if factor == 1 {
        return Ok(texture);
    }
    let pixel = |place: usize| {
        let (left, top) = (place % small[0] * factor, place / small[0] * factor);
        let (right, bottom) = ((left + factor).min(width), (top + factor).min(height));
        let mut sums = [0_u32; 4];
        for row in top..bottom {
            for pixel in &pixels[row * width + left..row * width + right] {
                sums.iter_mut().zip(pixel).for_each(|(sum, &channel)| *sum += u32::from(channel));
            }
        }
        let count = ((right - left) * (bottom - top)).max(1) as u32;
        sums.map(|sum| (sum / count) as u8)
    };
    Texture::image(small[0] as u32, small[1] as u32, (0..small[0] * small[1]).map(pixel).collect())
}

/// Reads a sky, and reduces it if it is large.
fn reduced_sky(path: &Path) -> Result<SkyMap, Error> {
    let sky = SkyMap::open(path)?;
    let [width, height] = sky.size().map(|side| side as usize);
    if width <= SKY_WIDTH {
        return Ok(sky);
    }
    let small = [SKY_WIDTH, (height * SKY_WIDTH / width).max(1)];
    let pixel = |place: usize| {
        let (column, row) = (place % small[0], place / small[0]);
        let [left, right] = [column, column + 1].map(|column| column * width / small[0]);
        let [top, bottom] = [row, row + 1].map(|row| row * height / small[1]);
        let rows = (top..bottom.max(top + 1)).map(|row| &sky.pixels()[row * width + left..row * width + right]);
        let (sum, count) = rows.flatten().fold((Vec3::ZERO, 0.0), |(sum, count), pixel| (sum + *pixel, count + 1.0));
        sum / count
    };
    SkyMap::new(small[0] as u32, small[1] as u32, (0..small[0] * small[1]).map(pixel).collect())
}

impl Model {
    fn memory(&self) -> usize {
        let textures: usize = self.textures.iter().map(texture_memory).sum();
        size_of_val(&*self.form.positions) + size_of_val(&*self.form.faces) + textures
    }
}

/// Reads a mesh file. It is scaled to a longest side of 1, and stands on the plane y = 0.
fn model(path: &Path) -> Result<Arc<Model>, Error> {
    let fault = |reason: String| Error::Spec { key: "generate.meshes".into(), reason };
    let SceneFile { scene, .. } = SceneFile::open(path, &SceneOptions::default())?;
    let count = scene.triangles().len();
    if count - scene.degenerate_count() == 0 {
        return Err(fault(format!("{} has no triangles", path.display())));
    }
    if count > MOST_TRIANGLES {
        let reason = format!("{} has {count} triangles; at most {MOST_TRIANGLES} are allowed", path.display());
        return Err(fault(reason));
    }
    let mut form = Form::default();
    for (index, triangle) in scene.triangles().iter().enumerate().filter(|(_, triangle)| !triangle.is_degenerate()) {
        form.colors.extend(scene.colors().get(index));
        let first = form.positions.len() as u32;
        form.positions.extend(triangle.corners);
        let uv = scene.uv().get(index).copied().unwrap_or_default();
        let corners = [first, first + 1, first + 2];
        let normals = if triangle.is_smooth() { triangle.normals } else { [Vec3::ZERO; 3] };
        form.faces.push(Face { corners, normals, uv, slot: triangle.material.0.min(u32::from(u16::MAX)) as u16 });
    }
    let (low, high) = form.bounds();
    let scale = 1.0 / (high - low).max_element();
    let foot = Vec3::new(low.x.midpoint(high.x), low.y, low.z.midpoint(high.z));
    form.positions.iter_mut().for_each(|at| *at = (*at - foot) * scale);
    let materials = scene.materials().iter().map(|own| Material { principled: None, ..own.clone() }).collect();
    Ok(Arc::new(Model { form, materials, textures: scene.textures().to_vec() }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: &str = "v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n";

    fn opened(folder: &Path, options: &str) -> Result<Assets, Error> {
        let text = format!(r#"{{"pairs": 1, "scenes": [{{"generate": {{"kind": "rooms", {options}}}}}]}}"#);
        let spec = Spec::from_json(&text, folder)?;
        Assets::open(&spec, spec.generator(0).unwrap())
    }

    fn said(folder: &Path, options: &str) -> String {
        opened(folder, options).err().map_or_else(|| panic!("{options} is accepted"), |error| error.to_string())
    }

    fn picture(path: &Path, side: u32, value: u8) {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let pixels = vec![value; (side * side * 3) as usize];
        image::save_buffer(path, &pixels, side, side, image::ColorType::Rgb8).unwrap();
    }

    #[test]
    fn files_are_read_in_order_of_their_names_and_large_ones_are_reduced() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        picture(&at("t/b.png"), 1100, 200);
        picture(&at("t/a/z.png"), 8, 50);
        fs::write(at("t/notes.txt"), "no picture").unwrap();
        fs::create_dir_all(at("m")).unwrap();
        fs::write(at("m/one.obj"), TRIANGLE).unwrap();
        let assets = opened(folder.path(), r#""textures": "t", "meshes": "m""#).unwrap();
        assert_eq!((assets.texture_count(), assets.mesh_count(), assets.sky_count()), (2, 1, 0));
        let size = |index| match assets.texture(index).unwrap().kind() {
            TextureKind::Image { size, pixels } => (*size, pixels[0][0]),
            other => panic!("{other:?}"),
        };
        assert_eq!((size(0), size(1)), (([8, 8], 50), ([366, 366], 200)));
        let model = assets.mesh(0).unwrap();
        assert_eq!(model.form.bounds(), (Vec3::new(-0.5, 0.0, 0.0), Vec3::new(0.5, 0.5, 0.0)));
        // Any byte of the folder changes the hash.
        let digest = assets.digest();
        fs::write(at("t/notes.txt"), "no pictures").unwrap();
        assert_ne!(opened(folder.path(), r#""textures": "t", "meshes": "m""#).unwrap().digest(), digest);
    }

    #[test]
    fn bad_folders_and_files_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let missing = said(folder.path(), r#""textures": "nowhere""#);
        assert!(missing.starts_with("generate.textures: the folder ") && missing.contains("nowhere"), "{missing}");
        fs::create_dir_all(at("empty")).unwrap();
        let empty = said(folder.path(), r#""skies": "empty""#);
        assert!(
            empty.starts_with("generate.skies: ") && empty.contains("has no files of the kinds hdr, exr"),
            "{empty}"
        );
        picture(&at("t/good.png"), 4, 9);
        fs::write(at("t/worse.png"), "no picture").unwrap();
        let broken = said(folder.path(), r#""textures": "t""#);
        assert!(broken.contains("worse.png"), "{broken}");
        fs::create_dir_all(at("m")).unwrap();
        fs::write(at("m/points.obj"), "v 0 0 0\nv 1 0 0\n").unwrap();
        let flat = said(folder.path(), r#""meshes": "m""#);
        assert!(flat.contains("points.obj"), "{flat}");
        fs::write(at("m/points.obj"), "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n").unwrap();
        let line = said(folder.path(), r#""meshes": "m""#);
        assert!(line.contains("points.obj has no triangles"), "{line}");
        for (options, message) in [
            (r#""glass": 1.5"#, "scenes[0].generate.glass: 1.5 must be 0 to 1"),
            (r#""mirrors": {"uniform": [0, 2]}"#, "scenes[0].generate.mirrors.uniform[1]: 2 must be 0 to 1"),
            (r#""mesh_size": 1"#, "scenes[0].generate.mesh_size: it needs meshes"),
            (r#""objects": 201"#, "scenes[0].generate.objects: 201 must be a whole number, 0 to 200"),
            (r#""trees": 3"#, "scenes[0].generate: unknown key 'trees'"),
        ] {
            let found = said(folder.path(), options);
            assert!(found.starts_with(message), "{found}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_out_of_a_folder_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        picture(&folder.path().join("other/secret.png"), 4, 9);
        fs::create_dir_all(folder.path().join("t")).unwrap();
        std::os::unix::fs::symlink(folder.path().join("other/secret.png"), folder.path().join("t/link.png")).unwrap();
        let found = said(folder.path(), r#""textures": "t""#);
        assert!(found.contains("link.png is a link out of its folder"), "{found}");
    }
}
