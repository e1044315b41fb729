//! Scenes in serde formats. Reading performs the same checks as the setters.

use std::borrow::Cow;

use glam::{DVec3, Vec2, Vec3, Vec4};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};

use super::{
    Ellipsoid, Light, Material, MaterialId, Mesh, Plane, Scene, Sky, SkyMap, Sphere, Texture, TextureKind, Triangle,
    Wrap, beside::Beside,
};
use crate::Error;

/// Serialised form of a scene.
#[derive(Serialize, Deserialize)]
struct GivenScene<'a> {
    lights: Cow<'a, [Light]>,
    shadows: bool,
    ambient: Option<Vec3>,
    sky: Cow<'a, Sky>,
    origin: DVec3,
    materials: Cow<'a, [Material]>,
    textures: Cow<'a, [Texture]>,
    meshes: Vec<GivenMesh<'a>>,
    spheres: Cow<'a, [Sphere]>,
    ellipsoids: Cow<'a, [Ellipsoid]>,
    planes: Cow<'a, [Plane]>,
}

/// Serialised form of a mesh: its part of the scene's triangles and attributes.
#[derive(Serialize, Deserialize)]
struct GivenMesh<'a> {
    name: Cow<'a, str>,
    triangles: Cow<'a, [Triangle]>,
    uv: Cow<'a, [[Vec2; 3]]>,
    colors: Cow<'a, [[Vec3; 3]]>,
    #[serde(default)]
    tangents: Cow<'a, [[Vec4; 3]]>,
}

impl Serialize for Scene {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // All fields are named, so that a new field gives a compile error here. Omitted fields follow from others.
        let Self { lights, shadows, ambient, sky, origin, materials, textures, triangles, .. } = self;
        let Self { spheres, ellipsoids, planes, mesh_objects, beside: Beside { uv, colors, tangents, .. }, .. } = self;
        let Self { smooth: _, dropped: _, dropping_meshes: _, .. } = self;
        let Self { triangles_stamp: _, spheres_stamp: _, .. } = self;
        let ends = mesh_objects.iter().skip(1).map(|next| next.first_primitive as usize).chain([triangles.len()]);
        let meshes = mesh_objects.iter().zip(ends).map(|(object, end)| {
            let range = object.first_primitive as usize..end;
            GivenMesh {
                name: Cow::Borrowed(&object.name),
                triangles: triangles[range.clone()].into(),
                uv: if object.has_uv { &uv[range.clone()] } else { &[] }.into(),
                colors: if object.has_colors { &colors[range.clone()] } else { &[] }.into(),
                tangents: if object.has_tangents { &tangents[range] } else { &[] }.into(),
            }
        });
        let given = GivenScene {
            lights: lights.into(),
            shadows: *shadows,
            ambient: *ambient,
            sky: Cow::Borrowed(sky),
            origin: *origin,
            materials: materials.into(),
            textures: textures.into(),
            meshes: meshes.collect(),
            spheres: spheres.into(),
            ellipsoids: ellipsoids.into(),
            planes: planes.into(),
        };
        given.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Scene {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let given = GivenScene::deserialize(deserializer)?;
        scene(given).map_err(D::Error::custom)
    }
}

/// Builds the scene by its setters.
fn scene(given: GivenScene<'_>) -> Result<Scene, Error> {
    let mut scene = Scene::new();
    scene.lights = given.lights.into_owned();
    scene.set_origin(given.origin)?;
    (scene.shadows, scene.ambient, scene.sky) = (given.shadows, given.ambient, given.sky.into_owned());
    scene.materials = given.materials.into_owned();
    scene.textures = given.textures.into_owned();
    for mesh in given.meshes {
        let corners = mesh.triangles.iter().flat_map(|triangle| triangle.corners).collect();
        let count = u32::try_from(mesh.triangles.len()).unwrap_or(u32::MAX);
        let triangles = (0..count).map(|index| [0, 1, 2].map(|corner| 3 * index + corner)).collect();
        let materials: Vec<MaterialId> = mesh.triangles.iter().map(|triangle| triangle.material).collect();
        let materials = if materials.is_empty() { vec![MaterialId::default()] } else { materials };
        let normals = mesh.triangles.iter().map(|triangle| triangle.normals).collect();
        let added = Mesh::new(corners, triangles).name(mesh.name).materials(materials).normals(normals);
        // Dropped triangles were logged when the mesh was first added.
        let added = added.uv(mesh.uv.into_owned()).colors(mesh.colors.into_owned());
        // A mesh that had no tangents gets none.
        let added = added.tangents(mesh.tangents.into_owned());
        let triangles = scene.checked_triangles(&added)?;
        scene.push_checked(&added, triangles, &added.tangents);
    }
    given.spheres.iter().try_for_each(|sphere| scene.add_sphere(*sphere))?;
    given.ellipsoids.iter().try_for_each(|ellipsoid| scene.add_ellipsoid(*ellipsoid))?;
    given.planes.iter().try_for_each(|plane| scene.add_plane(*plane))?;
    Ok(scene)
}

/// Serialised form of a texture.
#[derive(Deserialize)]
pub(super) struct GivenTexture {
    kind: TextureKind,
    wrap: Wrap,
    #[serde(default)]
    data: bool,
}

impl TryFrom<GivenTexture> for Texture {
    type Error = Error;

    fn try_from(given: GivenTexture) -> Result<Self, Error> {
        let texture = match given.kind {
            TextureKind::Image { size: [width, height], pixels } => {
                Self::image(width, height, std::sync::Arc::unwrap_or_clone(pixels))
            }
            TextureKind::Checkerboard { colors: [first, second], squares } => {
                Self::checkerboard(first, second, squares)
            }
        };
        Ok(texture?.wrap(given.wrap).data(given.data))
    }
}

/// Serialised form of a sky map.
#[derive(Deserialize)]
pub(super) struct GivenSkyMap {
    width: u32,
    height: u32,
    pixels: Vec<Vec3>,
}

impl TryFrom<GivenSkyMap> for SkyMap {
    type Error = Error;

    fn try_from(GivenSkyMap { width, height, pixels }: GivenSkyMap) -> Result<Self, Error> {
        Self::new(width, height, pixels)
    }
}
