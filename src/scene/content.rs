//! A scene's content as bytes, for hashes.

use std::{collections::HashMap, sync::Arc};

use bytemuck::cast_slice;

use super::{Beside, Scene, Sky, TextureKind, mesh::Object};

/// Returns bytes as hexadecimal digits.
#[cfg(feature = "dataset")]
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Scene {
    /// Passes everything that pictures depend on to `sink`, as bytes in pieces. Equal scenes produce equal bytes, even
    /// if they come from different files. Different scenes produce different bytes. So a hash tells whether two
    /// pictures or data set items show the same scene. The bytes may change between versions of the library.
    ///
    /// ```
    /// use std::hash::{DefaultHasher, Hasher};
    /// use stereotrace::{Builtin, glam::DVec3};
    ///
    /// let hash = |scene: &stereotrace::Scene| {
    ///     let mut hasher = DefaultHasher::new();
    ///     scene.content(|bytes| hasher.write(bytes));
    ///     hasher.finish()
    /// };
    /// let (scene, mut lit) = (Builtin::Near.scene(), Builtin::Near.scene());
    /// assert_eq!(hash(&scene), hash(&lit));
    /// lit.lights[0].position += 1e-3 * DVec3::X;
    /// assert_ne!(hash(&scene), hash(&lit));
    /// ```
    pub fn content(&self, mut sink: impl FnMut(&[u8])) {
        // All fields are named, so that a new field gives a compile error here. Omitted fields follow from others.
        let Self { lights, shadows, ambient, sky, origin, materials, textures, triangles, .. } = self;
        let Self {
            spheres,
            ellipsoids,
            planes,
            mesh_objects,
            beside: Beside { uv, colors, tangents, .. },
            smooth: _,
            dropped: _,
            dropping_meshes: _,
            ..
        } = self;
        let Self { triangles_stamp: _, spheres_stamp: _, .. } = self;
        let (names, objects) = named(mesh_objects);
        // Debug formatting of numbers is lossless, so different numbers give different text.
        let small = format!(
            "{lights:?} {shadows} {ambient:?} {sky:?} {origin:?} {materials:?} {textures:?} \
             {spheres:?} {ellipsoids:?} {planes:?} {names:?} {objects:?} {} {} {} {}",
            triangles.len(),
            uv.len(),
            colors.len(),
            tangents.len(),
        );
        sink(&small.len().to_le_bytes());
        sink(small.as_bytes());
        for triangle in triangles {
            sink(cast_slice(&triangle.corners));
            sink(cast_slice(&triangle.normals));
            sink(&triangle.material.0.to_le_bytes());
        }
        sink(cast_slice(uv));
        sink(cast_slice(colors));
        sink(cast_slice(tangents));
        for texture in textures {
            if let TextureKind::Image { pixels, .. } = texture.kind() {
                sink(cast_slice(pixels));
            }
        }
        if let Sky::Map(map) = sky {
            sink(cast_slice(map.pixels()));
        }
    }

    /// Returns a SHA-256 of [`Scene::content`], as 64 hexadecimal digits.
    #[cfg(feature = "dataset")]
    pub fn sha256(&self) -> String {
        use sha2::Digest as _;
        let mut hash = sha2::Sha256::new();
        self.content(|bytes| hash.update(bytes));
        hex(&hash.finalize())
    }
}

/// Record of an object: the index of its name, its first primitive, and whether it has texture coordinates and colours.
type Written = (usize, u32, [bool; 3]);

/// Returns the distinct names, and the objects by name index. Thousands of objects may share one long name.
fn named(objects: &[Object]) -> (Vec<&str>, Vec<Written>) {
    let (mut names, mut by_place, mut by_text) = (Vec::new(), HashMap::new(), HashMap::new());
    let mut written = Vec::with_capacity(objects.len());
    for Object { name, first_primitive, has_uv, has_colors, has_tangents, stamp: _ } in objects {
        // The bytes of a shared name are hashed only once.
        let number = *by_place.entry(Arc::as_ptr(name)).or_insert_with(|| {
            *by_text.entry(&**name).or_insert_with(|| {
                names.push(&**name);
                names.len() - 1
            })
        });
        written.push((number, *first_primitive, [*has_uv, *has_colors, *has_tangents]));
    }
    (names, written)
}

#[cfg(test)]
mod tests {
    use glam::{Mat3, Vec2, Vec3};

    use crate::{
        Builtin, Ellipsoid, Light, Material, MaterialId, Mesh, Plane, Scene, Sky, SkyMap, Sphere, Texture, Wrap,
    };

    fn bytes(scene: &Scene) -> Vec<u8> {
        let mut all = Vec::new();
        scene.content(|piece| all.extend_from_slice(piece));
        all
    }

    fn quad() -> Mesh {
        Mesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]).uv(vec![[Vec2::ZERO, Vec2::X, Vec2::Y]])
    }

    /// Tests one change of each kind.
    #[test]
    fn what_changes_a_picture_changes_the_bytes() {
        let base = || {
            let mut scene = Scene::new();
            let picture = scene.add_texture(Texture::image(1, 1, vec![[1, 2, 3, 255]]).unwrap());
            let material = scene.add_material(Material::new(Vec3::ONE).texture(picture));
            scene.add_mesh(&quad().materials(vec![material])).unwrap();
            scene.sky = Sky::Map(SkyMap::procedural(8).unwrap());
            scene
        };
        let changes: [fn(&mut Scene); 15] = [
            |scene| scene.set_origin(Vec3::X).unwrap(),
            |scene| scene.lights.push(Light::point(Vec3::Y, Vec3::ONE)),
            |scene| scene.shadows = false,
            |scene| scene.ambient = Some(Vec3::splat(0.15)),
            |scene| scene.sky = Sky::Constant(Vec3::ZERO),
            |scene| scene.sky = Sky::Map(SkyMap::procedural(16).unwrap()),
            |scene| _ = scene.add_material(Material::new(Vec3::ONE)),
            |scene| _ = scene.add_texture(Texture::image(1, 1, vec![[1, 2, 4, 255]]).unwrap()),
            |scene| _ = scene.add_texture(Texture::image(1, 1, vec![[1, 2, 3, 255]]).unwrap().wrap(Wrap::Clamp)),
            |scene| drop(scene.add_sphere(Sphere::new(Vec3::ZERO, 1.0, MaterialId(0)))),
            |scene| drop(scene.add_plane(Plane::new(Vec3::ZERO, Vec3::Y, MaterialId(0)))),
            |scene| drop(scene.add_ellipsoid(Ellipsoid::new(Vec3::ZERO, Mat3::IDENTITY, MaterialId(0)))),
            |scene| {
                drop(scene.set_mesh(0, &Mesh::new(vec![Vec3::ZERO, Vec3::X, 1.000_000_1 * Vec3::Y], vec![[0, 1, 2]])))
            },
            |scene| drop(scene.set_mesh(0, &quad())),
            |scene| drop(scene.set_mesh(0, &quad().colors(vec![[Vec3::X; 3]]))),
        ];
        let mut all = vec![bytes(&base())];
        assert_eq!(all[0], bytes(&base()));
        for change in changes {
            let mut scene = base();
            change(&mut scene);
            all.push(bytes(&scene));
        }
        for (index, one) in all.iter().enumerate() {
            assert!(!all[..index].contains(one), "change {index} is not seen");
        }
        assert_eq!(bytes(&Builtin::Hall.scene()), bytes(&Builtin::Hall.scene()));
    }

    #[test]
    fn a_name_that_objects_share_is_among_the_bytes_once() {
        let with = |names: &[std::sync::Arc<str>]| {
            let mut scene = Scene::new();
            for name in names {
                scene.add_mesh(&quad().name(name.clone())).unwrap();
            }
            scene
        };
        let long: std::sync::Arc<str> = "n".repeat(100_000).into();
        let shared = bytes(&with(&vec![long.clone(); 1000]));
        // Without the name an object takes 291 bytes: triangle, texture coordinates and its record.
        assert!(shared.len() < 100_000 + 1000 * 320, "{}", shared.len());
        // Equal names are equal, shared or not.
        let apart = |last: &str| {
            let names: Vec<_> =
                (0..1000).map(|index| if index < 999 { (&*long).into() } else { last.into() }).collect();
            bytes(&with(&names))
        };
        assert!(apart(&long) == shared && apart("other") != shared);
    }

    #[test]
    fn pixels_of_textures_and_skies_are_among_the_bytes() {
        let with = |pixel: u8| {
            let mut scene = Scene::new();
            scene.add_texture(Texture::image(1, 1, vec![[pixel, 2, 3, 255]]).unwrap());
            scene.sky = Sky::Map(SkyMap::new(2, 1, vec![f32::from(pixel) * Vec3::ONE, Vec3::ZERO]).unwrap());
            scene
        };
        assert_ne!(bytes(&with(1)), bytes(&with(2)));
        assert_eq!(bytes(&with(1)).len(), bytes(&with(2)).len());
    }
}
