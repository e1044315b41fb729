//! Packs primitives for shaders/shared/primitives.wgsl, ellipsoid.wgsl and planes.wgsl.

use glam::{Vec3, Vec4};

use super::Texel;
use crate::{
    Scene, Triangle,
    accel::large::longest_edge,
    kernel::variant::TexelPlaces,
    scene::{Primitive, ToSphere},
};

/// Flags in `w` of a primitive's second texel. The lowest bit marks spheres, ellipsoids and planes
/// (shaders/shared/primitive.wgsl). The highest bit marks cut-out triangles (cutouts.wgsl). The other bits hold the
/// connected component.
const IS_SPHERE: u32 = 1;
const IS_CUT_OUT: u32 = 1 << 31;

/// Data that determine the holes of a cut-out triangle: its material, and the bits of its texture coordinates.
type Holes = Option<(u32, [[u32; 2]; 3])>;

/// Returns the bits that determine a primitive's hits: its kind, its geometry and its holes. The geometry is a
/// triangle's corners, a sphere's centre and radius, an ellipsoid's centre and axes, or a plane's point, normal and u
/// axis.
pub(super) fn geometry(scene: &Scene, id: u32) -> (u8, [[u32; 3]; 4], Holes) {
    match scene.primitive(id) {
        Primitive::Triangle(triangle) => {
            let [a, b, c] = triangle.corners.map(words);
            let uv = || scene.uv().get(id as usize).map(|uv| uv.map(|corner| corner.to_array().map(f32::to_bits)));
            let holes = scene.cutout_of(triangle).map(|_| (triangle.material.0, uv().unwrap_or_default()));
            (0, [a, b, c, [0; 3]], holes)
        }
        Primitive::Sphere(sphere) => (1, [words(sphere.center), [sphere.radius.to_bits(), 0, 0], [0; 3], [0; 3]], None),
        Primitive::Ellipsoid(one) => {
            let [x, y, z] = [one.axes.x_axis, one.axes.y_axis, one.axes.z_axis].map(words);
            (2, [words(one.center), x, y, z], None)
        }
        Primitive::Plane(one) => {
            (3, [words(one.point), words(one.unit_normal()), words(one.u_per_unit()), [0; 3]], None)
        }
    }
}

fn words(v: Vec3) -> [u32; 3] {
    v.to_array().map(f32::to_bits)
}

fn texel([x, y, z]: [u32; 3], w: u32) -> Texel {
    [x, y, z, w]
}

/// Returns the number of texels per primitive of a scene.
pub(super) fn texels_of_each(scene: &Scene) -> usize {
    places(scene).count
}

fn places(scene: &Scene) -> TexelPlaces {
    let fourth = scene.has_normals() || !scene.ellipsoids().is_empty();
    TexelPlaces::of(fourth, !scene.uv().is_empty(), !scene.colors().is_empty())
}

/// Appends a primitive's texels. If the scene has ellipsoids, spheres are packed as ellipsoids.
pub(super) fn push_primitive(primitives: &mut Vec<Texel>, scene: &Scene, components: &[u32], id: u32) {
    let component = components[id as usize] << 1;
    let has_ellipsoids = !scene.ellipsoids().is_empty();
    let ellipsoid = |center: Vec3, map: ToSphere, material: u32| {
        let [a, b, c] = map.rows.map(words);
        let [center, radius] = [texel(words(center), id), texel(c, map.radius.to_bits())];
        [center, texel(a, component | IS_SPHERE), texel(b, material), radius]
    };
    let all = match scene.primitive(id) {
        Primitive::Triangle(triangle) => {
            let cut_out = if scene.cutout_of(triangle).is_some() { IS_CUT_OUT } else { 0 };
            triangle_texels(triangle, id, component | cut_out)
        }
        Primitive::Sphere(one) if has_ellipsoids => {
            ellipsoid(one.center, ToSphere::identity(one.radius), one.material.0)
        }
        Primitive::Sphere(one) => {
            let radius = texel([one.radius.to_bits(), 0, 0], component | IS_SPHERE);
            [texel(words(one.center), id), radius, [0, 0, 0, one.material.0], [0; 4]]
        }
        Primitive::Ellipsoid(one) => ellipsoid(one.center, one.to_sphere(), one.material.0),
        Primitive::Plane(one) => {
            let normal = texel(words(one.unit_normal()), component | IS_SPHERE);
            [texel(words(one.point), id), normal, texel(words(one.u_per_unit()), one.material.0), [0; 4]]
        }
    };
    let TexelPlaces { uv, colors, count } = places(scene);
    primitives.extend_from_slice(&all[..uv]);
    let beside = primitives.len();
    primitives.resize(beside + count - uv, [0; 4]);
    let Some(triangle) = scene.triangles().get(id as usize) else { return };
    let first = shortest_edge(triangle.corners);
    if let Some(&(mut corners)) = scene.uv().get(id as usize) {
        corners.rotate_left(first);
        let [a, b, c] = corners.map(|corner| corner.to_array().map(f32::to_bits));
        primitives[beside] = [a[0], a[1], b[0], b[1]];
        let [tangents, more] = scene.tangents().get(id as usize).map_or([0; 2], |&(mut corners)| {
            corners.rotate_left(first);
            pack_tangents(corners)
        });
        primitives[beside + 1] = [c[0], c[1], tangents, more];
    }
    if let Some(&(mut corners)) = scene.colors().get(id as usize) {
        corners.rotate_left(first);
        primitives[beside + colors - uv] = texel(corners.map(pack_color), 0);
    }
}

/// Packs a colour as 10 bits of red, 12 of green and 10 of blue; `shaders/shared/textures.wgsl` unpacks it.
fn pack_color(color: Vec3) -> u32 {
    let parts = (color.clamp(Vec3::ZERO, Vec3::ONE) * Vec3::new(1023.0, 4095.0, 1023.0)).round();
    parts.x as u32 | (parts.y as u32) << 10 | (parts.z as u32) << 22
}

/// Packs a triangle's corners, and its vertex normals if it has any.
fn triangle_texels(triangle: &Triangle, id: u32, component: u32) -> [Texel; 4] {
    let [a, b, c] = shortest_edge_first(triangle.corners).map(words);
    let material = triangle.material.0 | reach_bits(triangle.corners);
    let mut normals = [0; 4];
    if triangle.is_smooth() {
        let mut packed = triangle.normals.map(pack_normal);
        packed.rotate_left(shortest_edge(triangle.corners));
        normals = texel(packed, 1);
    }
    [texel(a, id), texel(b, component), texel(c, material), normals]
}

/// Returns the index of the first corner of a triangle's shortest edge.
pub(crate) fn shortest_edge(corners: [Vec3; 3]) -> usize {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let lengths = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
    (0..3).min_by(|&i, &j| lengths[i].total_cmp(&lengths[j])).unwrap_or(0)
}

/// Rotates a triangle's corners so that its shortest edge comes first. The cross product of that edge with another edge
/// is the normal with the least rounding error.
pub(crate) fn shortest_edge_first(mut corners: [Vec3; 3]) -> [Vec3; 3] {
    let first = shortest_edge(corners);
    corners.rotate_left(first);
    corners
}

/// Returns an upper bound of a triangle's longest edge, in the upper 16 bits of an f32. The lower 16 bits are free for
/// the material.
pub(crate) fn reach_bits(corners: [Vec3; 3]) -> u32 {
    let longest = longest_edge(corners.map(Vec3::as_dvec3)) as f32;
    longest.next_up().max(f32::MIN_POSITIVE).to_bits().next_multiple_of(1 << 16)
}

/// Packs three tangents as 10-bit numbers of their octahedral maps, three per word. Bit 30 of the first word is 1 if v
/// grows against `cross(normal, tangent)`, and that of the second word if there are tangents. `looks.wgsl` unpacks
/// them.
fn pack_tangents(corners: [Vec4; 3]) -> [u32; 2] {
    if corners.iter().any(|tangent| tangent.truncate() == Vec3::ZERO) {
        return [0; 2];
    }
    let place = |tangent: Vec4| octahedral(tangent.truncate()).map(|value| ((value + 1.0) * 511.0).round() as u32);
    let [[a, b], [c, d], [e, f]] = corners.map(place);
    let is_against = corners.iter().map(|tangent| tangent.w).sum::<f32>() < 0.0;
    [a | b << 10 | c << 20 | u32::from(is_against) << 30, d | e << 10 | f << 20 | 1 << 30]
}

/// Packs a unit vector as two 16-bit snorms (octahedral mapping); `shaders/shared/triangle.wgsl` unpacks it.
pub(crate) fn pack_normal(normal: Vec3) -> u32 {
    let [x, y] = octahedral(normal).map(|value| (value * 32767.0).round() as i16 as u16);
    u32::from(x) | u32::from(y) << 16
}

/// Maps a direction to the square from -1 to 1 (octahedral mapping).
fn octahedral(direction: Vec3) -> [f32; 2] {
    let n = direction / (direction.x.abs() + direction.y.abs() + direction.z.abs());
    let sign = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
    let (x, y) = if n.z >= 0.0 { (n.x, n.y) } else { ((1.0 - n.y.abs()) * sign(n.x), (1.0 - n.x.abs()) * sign(n.y)) };
    [x, y].map(|value| value.clamp(-1.0, 1.0))
}
