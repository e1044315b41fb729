//! A scene built in code: a mesh with a texture, a mirror, a glass sphere, an infinite ground, and soft light.
//!
//! ```sh
//! cargo run --release --example custom_scene -- custom_scene.png
//! ```

use std::error::Error;

use stereotrace::{
    Finish, Gpu, Light, Material, Mesh, Options, Plane, Renderer, Scene, Sky, Sphere, StereoCamera, Texture,
    blocking::Wait,
    glam::{Vec2, Vec3},
    output::Anaglyph,
};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or("custom_scene.png".into());
    let scene = scene()?;
    // The screen is at the target. Nearer objects appear in front of it, and farther ones behind it.
    let camera = StereoCamera::look_at(Vec3::new(0.3, 1.7, 6.0), Vec3::new(0.0, 0.8, 0.0)).size(640, 400);

    let mut renderer = Renderer::new(Gpu::new().wait()?);
    let uploaded = renderer.upload(&scene).wait()?;
    let pair =
        renderer.pair(&uploaded, &camera).options(&Options::default().samples(4).shadow_rays(8)).read().wait()?;
    pair.anaglyph(Anaglyph::Dubois).save_png(&path)?;
    let comfort = pair.pose.comfort(pair.left.depth_range().0, f32::INFINITY, 0.6);
    println!("{path}: {:.1}% of the right eye traced again", 100.0 * pair.statistics.retraced_share());
    for warning in comfort.warnings() {
        println!("on a display 0.6 m wide: {warning}");
    }
    Ok(())
}

fn scene() -> Result<Scene, stereotrace::Error> {
    let mut scene = Scene::new();
    scene.sky = Sky::Gradient { nadir: Vec3::new(0.5, 0.5, 0.52), zenith: Vec3::new(0.25, 0.4, 0.7) };
    scene.lights = vec![Light::sphere(Vec3::new(-3.0, 5.0, 4.0), 0.6, Vec3::splat(0.9))];

    let squares = scene.add_texture(Texture::checkerboard(Vec3::splat(0.75), Vec3::splat(0.3), 2)?);
    let ground = scene.add_material(Material::new(Vec3::ONE).name("ground").texture(squares));
    scene.add_plane(Plane::new(Vec3::ZERO, Vec3::Y, ground).tile(1.0))?;

    let glass = Finish::Glass { index: 1.5, transmission: Vec3::new(0.95, 1.0, 0.97), fresnel: true };
    let glass = scene.add_material(Material::new(Vec3::ZERO).specular(Vec3::splat(0.04)).finish(glass));
    scene.add_sphere(Sphere::new(Vec3::new(1.1, 0.7, 1.2), 0.7, glass))?;
    let chrome = Material::new(Vec3::ZERO).specular(Vec3::splat(0.9)).finish(Finish::Mirror { fresnel: false });
    let chrome = scene.add_material(chrome);
    scene.add_sphere(Sphere::new(Vec3::new(-1.4, 1.0, -0.8), 1.0, chrome))?;

    let stripes = Texture::image(2, 1, vec![[214, 69, 65, 255], [240, 236, 224, 255]])?;
    let stripes = scene.add_texture(stripes);
    let painted = scene.add_material(Material::new(Vec3::ONE).name("painted").texture(stripes));
    scene.add_mesh(&pyramid().materials(vec![painted; 4]))?;
    Ok(scene)
}

/// Builds four sides, each with the whole texture.
fn pyramid() -> Mesh {
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z - 0.2);
    let corners = [corner(-0.8, 0.8), corner(0.8, 0.8), corner(0.8, -0.8), corner(-0.8, -0.8)];
    let positions = corners.into_iter().chain([Vec3::new(0.0, 1.6, -0.2)]).collect();
    let sides = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
    let uv = [Vec2::ZERO, Vec2::new(4.0, 0.0), Vec2::new(2.0, 1.0)];
    Mesh::new(positions, sides.to_vec()).name("pyramid").uv(vec![uv; 4])
}
