//! A floor that is seen from above, and whose light has a closed form.

use stereotrace::{
    GBuffer, Material, Mesh, Method, Options, Renderer, Scene, Sky, StereoCamera, blocking::Wait, glam::Vec3,
};

use super::gpu;

/// Returns a white floor at y = 0 under a black sky, without ambient light.
pub(crate) fn floor() -> Scene {
    let mut scene = Scene::new();
    let white = scene.add_material(Material::new(Vec3::ONE));
    let corner = |x: f32, z: f32| Vec3::new(40.0 * x, 0.0, 40.0 * z);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    scene.add_mesh(&Mesh::new(corners, vec![[0, 2, 1], [0, 3, 2]]).materials(vec![white; 2])).unwrap();
    scene.sky = Sky::Constant(Vec3::ZERO);
    scene.ambient = Some(Vec3::ZERO);
    scene
}

/// Returns `[x, z, light]` for each pixel of a view from straight above: a position on the floor and the light there.
/// The light is the mean over `seeds` seeds. The position follows from the pixel's row and column.
pub(crate) fn light_on_floor(scene: &Scene, options: &Options, half: f32, seeds: u32) -> Vec<[f64; 3]> {
    let mut renderer = Renderer::new(gpu());
    let uploaded = renderer.upload(scene).wait().unwrap();
    let size = 48;
    let up = 30.0;
    let camera = StereoCamera::look_at(Vec3::new(0.0, up, 0.0), Vec3::ZERO)
        .up(Vec3::NEG_Z)
        .size(size, size)
        .screen_width(2.0 * half)
        .interaxial(0.0);
    let mut sum = vec![0.0; (size * size) as usize];
    for seed in 0..seeds {
        let options = options.clone().linear(true).g_buffer(GBuffer::None).seed(seed);
        let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
        sum.iter_mut().zip(&pair.left.linear).for_each(|(sum, color)| *sum += f64::from(color[0]) / f64::from(seeds));
    }
    let place = |index: usize| (2.0 * (index as f64 + 0.5) / f64::from(size) - 1.0) * f64::from(half);
    let pixel = |(index, &light): (usize, &f64)| [place(index % size as usize), place(index / size as usize), light];
    sum.iter().enumerate().map(pixel).collect()
}

pub(crate) fn naive() -> Options {
    Options::new(Method::Naive)
}

/// Returns the largest and the root mean square difference from a closed form.
pub(crate) fn errors(pixels: &[[f64; 3]], form: impl Fn(f64, f64) -> f64) -> (f64, f64) {
    let off = pixels.iter().map(|&[x, z, light]| (light - form(x, z)).abs());
    let (largest, squares) =
        off.fold((0.0_f64, 0.0), |(largest, squares), off| (largest.max(off), squares + off * off));
    (largest, (squares / pixels.len() as f64).sqrt())
}
