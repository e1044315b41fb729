//! Tests textures, vertex colours, highlights and emission on the adapter against formulas in double precision.

use crate::common;
mod degenerate;
mod filter;
mod round;
mod sampling;
mod shine;
mod twins;
mod updates;

use common::renderer;
use stereotrace::{
    Material, Mesh, Method, Options, Scene, StereoCamera, StereoPair, Texture, TextureKind, Wrap,
    blocking::Wait,
    glam::{DVec2, DVec3, Vec2, Vec3},
};

/// Returns a square of two units across the z axis. Its texture coordinates go from `low` in the lower left corner to
/// `high`.
fn square(low: Vec2, high: Vec2) -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
    let uv = [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)];
    Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).uv(vec![[uv[0], uv[1], uv[2]], [uv[0], uv[2], uv[3]]])
}

/// Returns a camera on the z axis whose picture is exactly the square.
fn before(size: u32) -> StereoCamera {
    StereoCamera::look_at(4.0 * Vec3::Z, Vec3::ZERO)
        .screen_distance(4.0)
        .screen_width(2.0)
        .size(size, size)
        .interaxial(0.0)
}

/// Returns a scene of one mesh, white except for its texture.
fn textured(mesh: Mesh, texture: Texture) -> Scene {
    let mut scene = Scene::new();
    let texture = scene.add_texture(texture);
    let material = scene.add_material(Material::new(Vec3::ONE).texture(texture));
    let count = mesh.triangles.len();
    scene.add_mesh(&mesh.materials(vec![material; count])).unwrap();
    scene
}

fn render(scene: &Scene, camera: &StereoCamera, method: Method) -> StereoPair {
    let mut renderer = renderer();
    let uploaded = renderer.upload(scene).wait().unwrap();
    renderer.pair(&uploaded, camera).options(&Options::new(method).linear(true)).read().wait().unwrap()
}

/// Returns the linear colours of the left view.
fn left(scene: &Scene, camera: &StereoCamera) -> Vec<DVec3> {
    colors(&render(scene, camera, Method::Naive).left.linear)
}

fn colors(linear: &[[f32; 4]]) -> Vec<DVec3> {
    linear.iter().map(|&[r, g, b, _]| Vec3::new(r, g, b).as_dvec3()).collect()
}

/// Decodes a byte by sRGB's formula (IEC 61966-2-1).
fn decoded(byte: u8) -> f64 {
    let encoded = f64::from(byte) / 255.0;
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Returns a texture's colour without a filter, except for the interpolation between its pixels.
fn sampled(texture: &Texture, uv: DVec2) -> DVec3 {
    sampled_as(texture, [texture.wrap; 2], uv)
}

/// Does the same with separate wrap modes along u and along v.
fn sampled_as(texture: &Texture, [along_u, along_v]: [Wrap; 2], uv: DVec2) -> DVec3 {
    let wrapped = |wrap: Wrap, at: i64, size: i64| match wrap {
        Wrap::Repeat => at.rem_euclid(size),
        Wrap::Mirror => {
            let turn = at.rem_euclid(2 * size);
            if turn < size { turn } else { 2 * size - 1 - turn }
        }
        Wrap::Clamp => at.clamp(0, size - 1),
        other => panic!("{other:?}"),
    };
    match texture.kind() {
        TextureKind::Image { size, pixels } => {
            let [width, height] = size.map(i64::from);
            // The weight of each pixel is a tent around its centre.
            let place = DVec2::new(uv.x * width as f64 - 0.5, (1.0 - uv.y) * height as f64 - 0.5);
            let (x, y) = (place.x.floor() as i64, place.y.floor() as i64);
            let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
            let colors = corners.map(|(x, y)| {
                let weight = (1.0 - (place.x - x as f64).abs()) * (1.0 - (place.y - y as f64).abs());
                let [r, g, b, _] = pixels[(wrapped(along_v, y, height) * width + wrapped(along_u, x, width)) as usize];
                DVec3::new(decoded(r), decoded(g), decoded(b)) * weight
            });
            colors.into_iter().sum()
        }
        TextureKind::Checkerboard { colors, squares } => {
            let place = uv * f64::from(*squares);
            let column = wrapped(along_u, place.x.floor() as i64, i64::from(*squares));
            let row = wrapped(along_v, place.y.floor() as i64, i64::from(*squares));
            colors[((column + row) % 2) as usize].as_dvec3()
        }
        other => panic!("{other:?}"),
    }
}

/// Returns a texture with red and green above, blue and yellow below.
fn four_colors() -> Texture {
    let pixels = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 0, 255]];
    Texture::image(2, 2, pixels).unwrap()
}

/// Returns a picture of random bytes.
fn noise(width: u32, height: u32, seed: u32) -> Texture {
    let mut random = common::random::Random::new(seed);
    let mut byte = || (random.unit() * 256.0) as u8;
    Texture::image(width, height, (0..width * height).map(|_| [byte(), byte(), byte(), 255]).collect()).unwrap()
}

fn worst(found: &[DVec3], expected: impl Fn(usize) -> Option<DVec3>) -> f64 {
    let error =
        |(index, found): (usize, &DVec3)| expected(index).map(|expected| (*found - expected).abs().max_element());
    found.iter().enumerate().filter_map(error).fold(0.0, f64::max)
}
