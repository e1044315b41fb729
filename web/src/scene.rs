//! Scenes.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
    rc::Rc,
    sync::Arc,
};

use js_sys::{ArrayBuffer, Float32Array, Object, Uint8Array, Uint16Array, Uint32Array};
use serde::{Deserialize, Serialize};
use stereotrace::{
    Builtin, Error, Finish, Light, Limits, Material, MaterialId, Mesh, MissingTextures, Plane, Principled, SceneFile,
    SceneOptions, Sky, Sphere, StereoCamera, Texture, TextureId, Wrap,
    glam::{DVec3, Vec3},
};
use wasm_bindgen::{JsCast, prelude::*};
use web_sys::ImageData;

use crate::{
    camera,
    errors::{raised, refused},
    messages,
    renderer::Uploaded,
    values::{array, corners, named, pairs, points, read, written},
};

/// Maximum size of scene files. A page has 4 GiB of memory for everything that is made from them.
const MOST_BYTES: u64 = 512 << 20;
/// Maximum number of triangles of a scene file.
const MOST_TRIANGLES: u64 = 4 << 20;
/// Alternative that messages about these limits name.
const ELSEWHERE: &str = "reading it with the library outside a browser";

/// A scene to render: shapes, materials, lights and a sky. World coordinates are right-handed with y up. Colours are
/// linear RGB.
#[wasm_bindgen]
pub struct Scene {
    pub(crate) shared: Rc<Shared>,
    /// Names and cameras of the scene's file.
    cameras: Vec<(Arc<str>, StereoCamera)>,
    builtin: Option<Builtin>,
    warnings: Vec<String>,
}

/// Scene data that a renderer reads while JavaScript may change it.
pub(crate) struct Shared {
    scene: RefCell<Rc<stereotrace::Scene>>,
    pub(crate) changes: Cell<Changes>,
    /// The scene on the device that rendered it last.
    pub(crate) uploaded: RefCell<Option<Uploaded>>,
}

/// Counters of a scene's changes.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Changes {
    /// Changes of shapes.
    pub(crate) shapes: u32,
    /// Changes of lights, materials and sky.
    rest: u32,
}

impl Shared {
    pub(crate) fn scene(&self) -> Rc<stereotrace::Scene> {
        self.scene.borrow().clone()
    }

    /// Changes lights, materials or sky. While the scene is being uploaded, a copy is changed.
    fn change<T>(&self, change: impl FnOnce(&mut stereotrace::Scene) -> T) -> T {
        let changes = self.changes.get();
        self.changes.set(Changes { rest: changes.rest + 1, ..changes });
        change(Rc::make_mut(&mut self.scene.borrow_mut()))
    }

    /// Adds shapes.
    fn add<T>(&self, add: impl FnOnce(&mut stereotrace::Scene) -> T) -> T {
        let changes = self.changes.get();
        self.changes.set(Changes { shapes: changes.shapes + 1, ..changes });
        add(Rc::make_mut(&mut self.scene.borrow_mut()))
    }
}

#[wasm_bindgen]
impl Scene {
    /// Makes an empty scene: black sky, no lights, and one grey material with id 0.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::of(stereotrace::Scene::new(), Vec::new(), None)
    }

    /// Makes a built-in scene with lights, sky and a camera. `name` is one of `builtins()`.
    pub async fn builtin(name: String) -> Result<Self, JsValue> {
        let builtin: Builtin = named(&name)?;
        Ok(Self::of(builtin.scene(), Vec::new(), Some(builtin)))
    }

    /// Reads a scene from files: OBJ with its MTL files and textures, glTF 2.0 (.gltf with its buffers and textures, or
    /// .glb) or PLY. `files` is an object of file contents by path. `main` is the path of the scene's own file. It may
    /// be omitted if only one file ends in .obj, .gltf, .glb or .ply. Files that it names are found by path, or by name
    /// if `files` has no folders. `creaseAngle` in degrees gives smooth normals to objects without any.
    ///
    /// Only glTF files bring lights and cameras. For other files see `placeLights`. A missing texture is left out, with
    /// a message in `warnings`. Rejects with an error that names the file, and if possible the line, for other faults.
    #[wasm_bindgen(js_name = fromFiles)]
    pub async fn from_files(
        #[wasm_bindgen(unchecked_param_type = "Record<string, Uint8Array | ArrayBuffer>")] files: JsValue,
        main: Option<String>,
        #[wasm_bindgen(js_name = creaseAngle)] crease_angle: Option<f32>,
    ) -> Result<Self, JsValue> {
        let files = contents(&files)?;
        let main = main.map_or_else(|| main_file(&files), Ok)?;
        let limits = Limits::default().file_bytes(MOST_BYTES).triangles(MOST_TRIANGLES);
        let limits = limits.option_names(ELSEWHERE, ELSEWHERE);
        let limits = limits.texture_option_name(ELSEWHERE).triangle_option_name(ELSEWHERE);
        let options = SceneOptions::default().limits(limits).missing_textures(MissingTextures::Warn);
        let options = options.crease_angle(crease_angle);
        drop(messages::taken());
        let SceneFile { scene, cameras, .. } = SceneFile::from_memory(&main, &files, &options).map_err(raised)?;
        let mut read = Self::of(scene, cameras, None);
        read.warnings = messages::taken();
        Ok(read)
    }

    /// Warnings of reading the files: parts that were left out or are not shown.
    #[wasm_bindgen(getter)]
    pub fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Contents of the scene.
    #[wasm_bindgen(getter, unchecked_return_type = "SceneInfo")]
    pub fn info(&self) -> Result<JsValue, JsValue> {
        let scene = self.shared.scene();
        written(&Info {
            triangles: scene.triangles().len(),
            primitives: scene.primitive_count(),
            objects: scene.object_count(),
            materials: scene.materials().len(),
            textures: scene.textures().len(),
            lights: scene.lights.len(),
            physically_based: scene.materials().iter().any(|material| material.principled.is_some()),
            emits: scene.materials().iter().any(|material| material.emission != Vec3::ZERO),
            bounds: scene.bounds().map(|(low, high)| [low.to_array(), high.to_array()]),
        })
    }

    /// Returns the scene's camera for pictures of this size in pixels. It is the camera of a built-in scene, or the
    /// first camera of a file. Otherwise it shows the whole scene.
    #[wasm_bindgen(unchecked_return_type = "Camera")]
    pub fn camera(&self, width: u32, height: u32) -> Result<JsValue, JsValue> {
        camera::written(&self.own_camera(width, height)?)
    }

    /// Adds a material and returns its id.
    #[wasm_bindgen(js_name = addMaterial)]
    pub fn add_material(
        &self,
        #[wasm_bindgen(unchecked_param_type = "Material")] material: JsValue,
    ) -> Result<u32, JsValue> {
        let material = material_of(read("material", material)?)?;
        Ok(self.shared.change(|scene| scene.add_material(material)).0)
    }

    /// Adds a texture for materials and projectors, and returns its id. `wrap` is for texture coordinates outside 0 to
    /// 1. `data` says that the image holds linear numbers, such as roughness or normals, and not colours.
    #[wasm_bindgen(js_name = addTexture)]
    pub fn add_texture(
        &self,
        image: &ImageData,
        #[wasm_bindgen(unchecked_optional_param_type = "\"repeat\" | \"mirror\" | \"clamp\"")] wrap: Option<String>,
        #[wasm_bindgen(unchecked_optional_param_type = "boolean")] data: Option<bool>,
    ) -> Result<u32, JsValue> {
        let wrap = match wrap.as_deref() {
            None | Some("repeat") => Wrap::Repeat,
            Some("mirror") => Wrap::Mirror,
            Some("clamp") => Wrap::Clamp,
            Some(_) => return Err(refused("wrap: it must be repeat, mirror or clamp")),
        };
        let pixels = image.data().as_chunks::<4>().0.to_vec();
        let texture = Texture::image(image.width(), image.height(), pixels).map_err(raised)?;
        let texture = texture.wrap(wrap).data(data.unwrap_or(false));
        Ok(self.shared.change(|scene| scene.add_texture(texture)).0)
    }

    /// Adds triangles as one object.
    #[wasm_bindgen(js_name = addMesh)]
    pub fn add_mesh(&self, #[wasm_bindgen(unchecked_param_type = "Mesh")] mesh: &JsValue) -> Result<(), JsValue> {
        let mesh = mesh_of(mesh)?;
        self.shared.add(|scene| scene.add_mesh(&mesh)).map_err(raised)
    }

    /// Adds a sphere as an object. Lengths are in world units.
    #[wasm_bindgen(js_name = addSphere)]
    pub fn add_sphere(
        &self,
        #[wasm_bindgen(unchecked_param_type = "Vector")] center: JsValue,
        radius: f32,
        material: Option<u32>,
    ) -> Result<(), JsValue> {
        let center = Vec3::from_array(read("center", center)?);
        let sphere = Sphere::new(center, radius, MaterialId(material.unwrap_or(0)));
        self.shared.add(|scene| scene.add_sphere(sphere)).map_err(raised)
    }

    /// Adds an infinite plane through a point, as an object.
    #[wasm_bindgen(js_name = addPlane)]
    pub fn add_plane(
        &self,
        #[wasm_bindgen(unchecked_param_type = "Vector")] point: JsValue,
        #[wasm_bindgen(unchecked_param_type = "Vector")] normal: JsValue,
        material: Option<u32>,
    ) -> Result<(), JsValue> {
        let (point, normal) = (Vec3::from_array(read("point", point)?), Vec3::from_array(read("normal", normal)?));
        let plane = Plane::new(point, normal, MaterialId(material.unwrap_or(0)));
        self.shared.add(|scene| scene.add_plane(plane)).map_err(raised)
    }

    /// Replaces the scene's lights.
    #[wasm_bindgen(js_name = setLights)]
    pub fn set_lights(&self, #[wasm_bindgen(unchecked_param_type = "Light[]")] lights: JsValue) -> Result<(), JsValue> {
        let given: &js_sys::Array = lights.dyn_ref().ok_or_else(|| refused("lights: they must be an array"))?;
        let one = |(index, light)| Ok(light_of(&read(&format!("lights[{index}]"), light)?));
        let lights = given.iter().enumerate().map(one).collect::<Result<_, JsValue>>()?;
        self.shared.change(|scene| scene.lights = lights);
        Ok(())
    }

    /// Replaces the scene's lights by `count` point lights beside and above a camera's eyes.
    #[wasm_bindgen(js_name = placeLights)]
    pub fn place_lights(
        &self,
        count: u32,
        #[wasm_bindgen(unchecked_param_type = "Camera")] camera: JsValue,
    ) -> Result<(), JsValue> {
        let camera = camera::read(camera)?;
        self.shared.change(|scene| scene.place_lights(count as usize, &camera)).map_err(raised)
    }

    /// Sets the ambient light. Without a colour it gets its default: 0.15 with lights, 1 without.
    #[wasm_bindgen(js_name = setAmbient)]
    pub fn set_ambient(
        &self,
        #[wasm_bindgen(unchecked_optional_param_type = "Vector")] ambient: JsValue,
    ) -> Result<(), JsValue> {
        let ambient: Option<[f32; 3]> = read("ambient", ambient)?;
        self.shared.change(|scene| scene.ambient = ambient.map(Vec3::from_array));
        Ok(())
    }

    /// Sets the sky: a blend between the colours straight down and straight up.
    #[wasm_bindgen(js_name = setSky)]
    pub fn set_sky(
        &self,
        #[wasm_bindgen(unchecked_param_type = "Vector")] nadir: JsValue,
        #[wasm_bindgen(unchecked_param_type = "Vector")] zenith: JsValue,
    ) -> Result<(), JsValue> {
        let (nadir, zenith) = (Vec3::from_array(read("nadir", nadir)?), Vec3::from_array(read("zenith", zenith)?));
        self.shared.change(|scene| scene.sky = Sky::Gradient { nadir, zenith });
        Ok(())
    }
}

impl Scene {
    fn of(scene: stereotrace::Scene, cameras: Vec<(Arc<str>, StereoCamera)>, builtin: Option<Builtin>) -> Self {
        let shared =
            Shared { scene: RefCell::new(Rc::new(scene)), changes: Cell::default(), uploaded: RefCell::default() };
        Self { shared: Rc::new(shared), cameras, builtin, warnings: Vec::new() }
    }

    pub(crate) fn own_camera(&self, width: u32, height: u32) -> Result<StereoCamera, JsValue> {
        let camera = match (self.builtin, self.cameras.first(), self.shared.scene().bounds()) {
            (Some(builtin), ..) => builtin.camera(width, height),
            (None, Some((_, camera)), _) => camera.size(width, height),
            (None, None, Some(bounds)) => StereoCamera::fitting(bounds, width, height),
            (None, None, None) => {
                return Err(refused(
                    "camera: the scene has nothing to look at: it is empty, or has only infinite planes",
                ));
            }
        };
        camera.pose().map_err(raised)?;
        Ok(camera)
    }
}

/// Reads the bytes of files by path.
fn contents(files: &JsValue) -> Result<BTreeMap<String, Vec<u8>>, JsValue> {
    let object: &Object =
        files.dyn_ref().ok_or_else(|| refused("files: it must be an object of Uint8Arrays by path"))?;
    let entries = Object::entries(object).into_iter().map(|entry| {
        let entry: js_sys::Array = entry.unchecked_into();
        let path = entry.get(0).as_string().unwrap_or_default();
        let content = entry.get(1);
        let bytes = match content.dyn_ref::<ArrayBuffer>() {
            Some(buffer) => Some(Uint8Array::new(buffer)),
            None => content.dyn_into().ok(),
        };
        let bytes = bytes.ok_or_else(|| refused(&format!("files: {path}: it must be a Uint8Array or an ArrayBuffer")));
        Ok((path, bytes?.to_vec()))
    });
    entries.collect()
}

/// Returns the path of the only scene file.
fn main_file(files: &BTreeMap<String, Vec<u8>>) -> Result<String, JsValue> {
    let is_scene = |path: &&String| {
        let path = path.to_lowercase();
        [".obj", ".gltf", ".glb", ".ply"].iter().any(|ending| path.ends_with(ending))
    };
    let scenes: Vec<&String> = files.keys().filter(is_scene).collect();
    match scenes[..] {
        [one] => Ok(one.clone()),
        [] => Err(refused("files: none is a scene, whose name must end in .obj, .gltf, .glb or .ply")),
        _ => {
            let names: Vec<&str> = scenes.iter().map(|path| path.as_str()).collect();
            Err(refused(&format!("files: {} are scenes; give one of them", names.join(", "))))
        }
    }
}

/// `SceneInfo` of `types.d.ts`.
#[derive(Serialize)]
struct Info {
    triangles: usize,
    primitives: usize,
    objects: usize,
    materials: usize,
    textures: usize,
    lights: usize,
    #[serde(rename = "physicallyBased")]
    physically_based: bool,
    emits: bool,
    bounds: Option<[[f64; 3]; 2]>,
}

/// `Material` of `types.d.ts`.
#[derive(Deserialize)]
struct GivenMaterial {
    albedo: Option<[f32; 3]>,
    specular: Option<[f32; 3]>,
    exponent: Option<f32>,
    emission: Option<[f32; 3]>,
    opacity: Option<f32>,
    #[serde(rename = "alphaBlend")]
    alpha_blend: Option<bool>,
    texture: Option<u32>,
    cutout: Option<u32>,
    finish: Option<String>,
    index: Option<f32>,
    surface: Option<GivenSurface>,
}

/// `Surface` of `types.d.ts`.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
struct GivenSurface {
    base: Option<[f32; 3]>,
    metallic: Option<f32>,
    roughness: Option<f32>,
    index: Option<f32>,
    specular: Option<f32>,
    specular_color: Option<[f32; 3]>,
    transmission: Option<f32>,
    thin: Option<bool>,
    absorption: Option<[f32; 3]>,
    clearcoat: Option<f32>,
    clearcoat_roughness: Option<f32>,
    normal_scale: Option<f32>,
    roughness_texture: Option<u32>,
    metallic_texture: Option<u32>,
    normal_texture: Option<u32>,
    emission_texture: Option<u32>,
    transmission_texture: Option<u32>,
    clearcoat_texture: Option<u32>,
    clearcoat_roughness_texture: Option<u32>,
}

fn surface_of(given: &GivenSurface, emission: Vec3) -> Principled {
    let base = given.base.map_or(Vec3::splat(0.8), Vec3::from_array);
    let mut surface = Principled::new(base, given.metallic.unwrap_or(0.0), given.roughness.unwrap_or(0.5))
        .index(given.index.unwrap_or(1.5))
        .transmission(given.transmission.unwrap_or(0.0))
        .thin(given.thin.unwrap_or(false))
        .clearcoat(given.clearcoat.unwrap_or(0.0), given.clearcoat_roughness.unwrap_or(0.0))
        .emission(emission);
    surface.grazing = given.specular.unwrap_or(1.0);
    surface.specular = surface.grazing * given.specular_color.map_or(Vec3::ONE, Vec3::from_array);
    surface.absorption = given.absorption.map_or(Vec3::ZERO, Vec3::from_array);
    surface.normal_scale = given.normal_scale.unwrap_or(1.0);
    surface.roughness_texture = given.roughness_texture.map(TextureId);
    surface.metallic_texture = given.metallic_texture.map(TextureId);
    surface.normal_texture = given.normal_texture.map(TextureId);
    surface.emission_texture = given.emission_texture.map(TextureId);
    surface.transmission_texture = given.transmission_texture.map(TextureId);
    surface.clearcoat_texture = given.clearcoat_texture.map(TextureId);
    surface.clearcoat_roughness_texture = given.clearcoat_roughness_texture.map(TextureId);
    surface
}

fn material_of(given: GivenMaterial) -> Result<Material, JsValue> {
    let GivenMaterial { albedo, specular, exponent, emission, texture, cutout, finish, index, surface, .. } = given;
    let mut material = Material::new(albedo.map_or(Vec3::splat(0.7), Vec3::from_array));
    material.specular = specular.map_or(material.specular, Vec3::from_array);
    material.exponent = exponent.unwrap_or(material.exponent);
    material.emission = emission.map_or(material.emission, Vec3::from_array);
    material.opacity = given.opacity.unwrap_or(material.opacity);
    material.alpha_blend = given.alpha_blend.unwrap_or(false);
    (material.texture, material.cutout) = (texture.map(TextureId), cutout.map(TextureId));
    material.finish = match finish.as_deref() {
        None | Some("matte") => Finish::Matte,
        Some("mirror") => Finish::Mirror { fresnel: false },
        Some("glass") => Finish::Glass { index: index.unwrap_or(1.5), transmission: Vec3::ONE, fresnel: true },
        Some(_) => return Err(refused("material.finish: it must be matte, mirror or glass")),
    };
    if index.is_some() && !matches!(material.finish, Finish::Glass { .. }) {
        return Err(refused("material.index: it applies to glass; set finish to glass"));
    }
    if let Some(surface) = surface {
        if albedo.is_some() || specular.is_some() || exponent.is_some() || finish.is_some() {
            let reason = "material.surface: it replaces albedo, specular, exponent and finish; leave them out";
            return Err(refused(reason));
        }
        let surface = surface_of(&surface, material.emission);
        material = material.principled(surface);
    }
    Ok(material)
}

/// `Light` of `types.d.ts`.
#[derive(Deserialize)]
struct GivenLight {
    position: [f64; 3],
    intensity: [f32; 3],
    radius: Option<f32>,
    falloff: Option<GivenFalloff>,
    cone: Option<GivenCone>,
    projector: Option<GivenProjector>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum GivenFalloff {
    None,
    Quadratic,
}

#[derive(Deserialize)]
struct GivenCone {
    direction: [f32; 3],
    inner: f32,
    outer: f32,
}

#[derive(Deserialize)]
struct GivenProjector {
    texture: u32,
    direction: [f32; 3],
    up: [f32; 3],
    fov: f32,
}

fn light_of(given: &GivenLight) -> Light {
    let (position, intensity) = (DVec3::from_array(given.position), Vec3::from_array(given.intensity));
    let mut light =
        given.radius.map_or(Light::point(position, intensity), |radius| Light::sphere(position, radius, intensity));
    if let Some(GivenFalloff::Quadratic) = given.falloff {
        light = light.with_quadratic_falloff();
    }
    if let Some(GivenCone { direction, inner, outer }) = given.cone {
        light = light.with_cone(Vec3::from_array(direction), inner, outer);
    }
    if let Some(GivenProjector { texture, direction, up, fov }) = given.projector {
        light = light.with_projector(TextureId(texture), Vec3::from_array(direction), Vec3::from_array(up), fov);
    }
    light
}

/// Reads `Mesh` of `types.d.ts`, whose lists are typed arrays.
fn mesh_of(given: &JsValue) -> Result<Mesh, JsValue> {
    let floats = |field: &str| array::<Float32Array>("mesh", given, field, "Float32Array");
    let missing = |field: &str| refused(&format!("mesh.{field}: it is missing"));
    let positions = points("mesh.positions", &floats("positions")?.ok_or_else(|| missing("positions"))?)?;
    let triangles = match array::<Object>("mesh", given, "indices", "Uint32Array or a Uint16Array")? {
        Some(indices) => corners("mesh.indices", &wide(&indices)?)?,
        None => (0..positions.len() as u32 / 3).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect(),
    };
    let rest: MeshOptions = read("mesh", rest_of(given)?)?;
    let mut mesh = Mesh::new(positions, triangles).name(rest.name.unwrap_or_default());
    mesh = mesh.materials(vec![MaterialId(rest.material.unwrap_or(0))]);
    let unfit = |error: Error| refused(&error.to_string());
    if let Some(normals) = floats("normals")? {
        if rest.crease_angle.is_some() {
            return Err(refused("mesh: normals are given, but creaseAngle would replace them; give one of them"));
        }
        mesh = mesh.vertex_normals(&points("mesh.normals", &normals)?).map_err(unfit)?;
    }
    if let Some(uvs) = floats("uvs")? {
        mesh = mesh.vertex_uv(&pairs("mesh.uvs", &uvs)?).map_err(unfit)?;
    }
    if let Some(colors) = floats("colors")? {
        mesh = mesh.vertex_colors(&points("mesh.colors", &colors)?).map_err(unfit)?;
    }
    match rest.crease_angle {
        Some(degrees) => mesh.smooth(degrees).map_err(raised),
        None => Ok(mesh),
    }
}

/// Returns indices of 16 or 32 bits as those of 32 bits.
fn wide(indices: &Object) -> Result<Uint32Array, JsValue> {
    match (indices.dyn_ref::<Uint32Array>(), indices.dyn_ref::<Uint16Array>()) {
        (Some(wide), _) => Ok(wide.clone()),
        (_, Some(narrow)) => Ok(Uint32Array::new(narrow)),
        _ => Err(refused("mesh.indices: it must be a Uint32Array or a Uint16Array")),
    }
}

/// Fields of a mesh that are not lists.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct MeshOptions {
    name: Option<String>,
    material: Option<u32>,
    crease_angle: Option<f32>,
}

/// Returns a copy of a mesh without its lists, so that fields with unknown names are found.
fn rest_of(mesh: &JsValue) -> Result<JsValue, JsValue> {
    let object: &Object = mesh.dyn_ref().ok_or_else(|| refused("mesh: it must be an object"))?;
    let copy = Object::assign(&Object::new(), object);
    for field in ["positions", "indices", "normals", "uvs", "colors"] {
        js_sys::Reflect::delete_property(&copy, &field.into())?;
    }
    Ok(copy.into())
}
