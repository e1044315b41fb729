//! Builds scenes in which each feature is off, unused or on.

use stereotrace::{
    AmbientOcclusion, Ellipsoid, Finish, GBuffer, Light, Material, MaterialId, Mesh, Method, Options, Plane, Scene,
    ShadowBuffer, ShadowRule, Sky, Sphere, StereoCamera, Texture, Visibility,
    glam::{Mat3, Vec3, Vec3Swizzles},
};

/// Number of the terrain's quads per side.
const TERRAIN: u32 = 300;

/// One state of a feature.
pub(crate) struct Variant {
    pub(crate) name: &'static str,
    pub(crate) scene: Scene,
    pub(crate) camera: StereoCamera,
    pub(crate) options: Options,
}

fn of(name: &'static str, scene: Scene, camera: &StereoCamera, options: &Options) -> Variant {
    Variant { name, scene, camera: *camera, options: options.clone() }
}

/// Builds a terrain of 180,000 triangles that all face upwards, so a light below it reaches none. The first `smooth`
/// triangles have vertex normals.
pub(crate) fn terrain(smooth: u32) -> Scene {
    let side = TERRAIN + 1;
    let height = |x: f32, z: f32| 0.3 * (3.1 * x).sin() * (2.3 * z).cos() + 0.05 * (17.0 * x + 11.0 * z).sin();
    let place = |i: u32| {
        let (x, z) = ((i % side) as f32 / TERRAIN as f32 * 8.0 - 4.0, (i / side) as f32 / TERRAIN as f32 * 8.0 - 4.0);
        Vec3::new(x, height(x, z), z)
    };
    let quads = (0..TERRAIN * TERRAIN).map(|i| i / TERRAIN * side + i % TERRAIN);
    let triangles: Vec<[u32; 3]> =
        quads.flat_map(|i| [[i, i + side, i + 1], [i + 1, i + side, i + side + 1]]).collect();
    let normals = (0..triangles.len() as u32).map(|t| if t < smooth { [Vec3::Y; 3] } else { [Vec3::ZERO; 3] });
    let normals = if smooth > 0 { normals.collect() } else { Vec::new() };
    let mesh = Mesh::new((0..side * side).map(place).collect(), triangles).normals(normals);
    let mut scene = Scene::new();
    scene.add_mesh(&mesh).expect("a terrain of finite points");
    scene
}

/// Builds the terrain with a separate material on the first `count` triangles. The terrain has texture coordinates if a
/// texture is given.
fn with_material(count: usize, texture: Option<Texture>, change: impl Fn(Material) -> Material) -> Scene {
    let plain = terrain(0);
    let mut scene = Scene::new();
    let mut material = change(Material::new(plain.materials()[0].albedo));
    let textured = texture.is_some();
    if let Some(texture) = texture {
        material = material.texture(scene.add_texture(texture));
    }
    let material = scene.add_material(material);
    let corners = plain.triangles().iter().flat_map(|triangle| triangle.corners).collect();
    let triangles: Vec<[u32; 3]> = (0..plain.triangles().len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let materials = (0..triangles.len()).map(|t| if t < count { material } else { MaterialId(0) }).collect();
    let uv = plain.triangles().iter().map(|triangle| triangle.corners.map(|corner| corner.xz() * 0.125 + 0.5));
    let uv = if textured { uv.collect() } else { Vec::new() };
    scene.add_mesh(&Mesh::new(corners, triangles).materials(materials).uv(uv)).expect("a terrain of finite points");
    scene
}

/// Returns a picture of 1024x1024 pixels of pseudo-random bytes.
fn picture() -> Texture {
    let byte = |index: u32| (index.wrapping_mul(747_796_405) >> 22) as u8;
    let pixels = (0..1 << 20).map(|index| [byte(index), byte(index + 1), byte(index + 2), 255]).collect();
    Texture::image(1024, 1024, pixels).expect("as many pixels as it has")
}

fn board() -> Texture {
    Texture::checkerboard(Vec3::splat(0.9), Vec3::splat(0.1), 64).expect("colours within 0 to 1")
}

fn shiny(material: Material) -> Material {
    material.specular(Vec3::splat(0.3)).exponent(20.0)
}

fn with_spheres(mut scene: Scene, count: u32, height: f32) -> Scene {
    for i in 0..count {
        let center = Vec3::new((i % 10) as f32 * 0.7 - 3.2, height, (i / 10) as f32 * 0.7 - 3.2);
        let radius = if height > 0.0 { 0.2 } else { 0.01 };
        scene.add_sphere(Sphere::new(center, radius, MaterialId(0))).expect("a sphere of finite size");
    }
    scene
}

fn with_lights(mut scene: Scene, height: f32, shadows: bool) -> Scene {
    scene.shadows = shadows;
    for i in 0..5 {
        let position = Vec3::new(2.0 * i as f32 - 4.0, height, 3.0 - i as f32);
        scene.lights.push(Light::point(position, Vec3::splat(0.3)));
    }
    scene
}

fn with_sky(mut scene: Scene) -> Scene {
    scene.sky = Sky::Gradient { nadir: Vec3::splat(0.2), zenith: Vec3::new(0.2, 0.4, 0.9) };
    scene
}

/// Returns all features with their states. In the first state of each feature, it is off.
pub(crate) fn states(size: [u32; 2]) -> Vec<(&'static str, Vec<Variant>)> {
    let rest = surfaces(size).into_iter().chain(many_rays(size)).chain([("planes", planes(size))]).chain(buffers(size));
    geometry_and_light(size).into_iter().chain(rest).collect()
}

/// Returns a camera whose picture is one third sky.
fn ahead([width, height]: [u32; 2]) -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.0, 1.6, 5.0), Vec3::new(0.0, 0.4, 0.0)).size(width, height)
}

fn plain() -> Options {
    Options::new(Method::Naive).g_buffer(GBuffer::None)
}

/// Returns the features that trace more than one ray per pixel and light, and ellipsoids.
fn many_rays(size: [u32; 2]) -> [(&'static str, Vec<Variant>); 4] {
    let plainly = |name, scene| of(name, scene, &ahead(size), &plain());
    let mirrors = |count: u32, height| {
        let mut scene = with_spheres(terrain(0), 100 - count, 0.6);
        if count == 0 {
            return scene;
        }
        let mirror = Material::new(Vec3::ZERO).specular(Vec3::splat(0.9)).finish(Finish::Mirror { fresnel: false });
        let mirror = scene.add_material(mirror);
        for i in 100 - count..100 {
            let center = Vec3::new((i % 10) as f32 * 0.7 - 3.2, height, (i / 10) as f32 * 0.7 - 3.2);
            scene.add_sphere(Sphere::new(center, 0.2, mirror)).expect("a sphere of finite size");
        }
        scene
    };
    let ellipsoids = || {
        let mut scene = terrain(0);
        for i in 0..100 {
            let center = Vec3::new((i % 10) as f32 * 0.7 - 3.2, 0.6, (i / 10) as f32 * 0.7 - 3.2);
            let axes = Mat3::from_diagonal(Vec3::new(0.2, 0.19, 0.21));
            scene.add_ellipsoid(Ellipsoid::new(center, axes, MaterialId(0))).expect("an ellipsoid of finite size");
        }
        scene
    };
    let lit = |light| {
        let mut scene = terrain(0);
        scene.lights.push(light);
        scene
    };
    let (above, below, white) = (Vec3::new(2.0, 4.0, 1.0), Vec3::new(2.0, -9.0, 1.0), Vec3::splat(0.8));
    let occluded = plain().ambient_occlusion(AmbientOcclusion::new(16, 1.0));
    [
        (
            "ellipsoids",
            vec![
                plainly("off: 100 spheres", with_spheres(terrain(0), 100, 0.6)),
                plainly("on: 100 of them", ellipsoids()),
            ],
        ),
        (
            "mirrors",
            vec![
                plainly("off: 100 spheres", mirrors(0, 0.6)),
                plainly("unused: one of them, below the ground", mirrors(1, -3.0)),
                plainly("on: all", mirrors(100, 0.6)),
            ],
        ),
        (
            "soft light",
            vec![
                plainly("off: a point", lit(Light::point(above, white))),
                plainly("unused: a ball below the ground, 16 rays", lit(Light::sphere(below, 0.2, white))),
                plainly("on: a ball, 16 rays", lit(Light::sphere(above, 0.2, white))),
            ],
        ),
        ("occlusion", vec![plainly("off", terrain(0)), of("on: 16 rays", terrain(0), &ahead(size), &occluded)]),
    ]
}

/// Returns the states of planes: none, one behind the eye, and one or eight below the terrain.
fn planes(size: [u32; 2]) -> Vec<Variant> {
    let with = |name, planes: &[Plane]| {
        let mut scene = terrain(0);
        planes.iter().for_each(|&plane| scene.add_plane(plane).expect("a plane with a normal"));
        of(name, scene, &ahead(size), &plain())
    };
    let ground = |below: u8| Plane::new(-f32::from(below) * Vec3::Y, Vec3::Y, MaterialId(0));
    vec![
        with("off", &[]),
        with("unused: one behind the eye", &[Plane::new(9.0 * Vec3::Z, Vec3::Z, MaterialId(0))]),
        with("on: a ground below the terrain", &[ground(1)]),
        with("on: eight of them", &Vec::from_iter((1..9).map(ground))),
    ]
}

/// Returns the features that replace rays: T-buffers and shadow-buffers.
fn buffers(size: [u32; 2]) -> [(&'static str, Vec<Variant>); 2] {
    let with = |name, lights: bool, options: &Options| {
        let scene = if lights { with_lights(terrain(0), 4.0, true) } else { terrain(0) };
        of(name, scene, &ahead(size), options)
    };
    let tables = |rule| plain().shadow_buffer(ShadowBuffer::new(400).rule(rule));
    [
        ("T-buffer", vec![with("off", false, &plain()), with("on", false, &plain().visibility(Visibility::TBuffer))]),
        (
            "shadow-buffers",
            vec![
                with("off: 5 lights with shadows", true, &plain()),
                with("on: 400 rows, filled before, hybrid", true, &tables(ShadowRule::HYBRID)),
                with("on: 400 rows, filled before, object", true, &tables(ShadowRule::Object)),
            ],
        ),
    ]
}

/// Builds the terrain with a checkerboard of holes cut out of its first `count` triangles.
fn cut_out(count: usize) -> Scene {
    let holes = Texture::checkerboard(Vec3::ONE, Vec3::ZERO, 128).expect("colours within 0 to 1");
    let mut scene = with_material(count, Some(holes), |material| material);
    let mut material = scene.materials()[1].clone();
    material.cutout = material.texture.take();
    scene.set_material(MaterialId(1), material).expect("a material that is there");
    scene
}

/// Returns the features of surface materials.
fn surfaces(size: [u32; 2]) -> [(&'static str, Vec<Variant>); 3] {
    const ALL: usize = usize::MAX;
    let plainly = |name, scene| of(name, scene, &ahead(size), &plain());
    let textured = |count, texture| with_material(count, Some(texture), |material| material);
    let lit = |count| with_lights(with_material(count, None, shiny), 4.0, false);
    [
        (
            "textures",
            vec![
                plainly("off", terrain(0)),
                plainly("unused: on one triangle", textured(1, picture())),
                plainly("on: a picture of 1024x1024 on all", textured(ALL, picture())),
                plainly("on: a checkerboard on all", textured(ALL, board())),
            ],
        ),
        (
            "highlights",
            vec![
                plainly("off: 5 lights without shadows", with_lights(terrain(0), 4.0, false)),
                plainly("unused: on one triangle", lit(1)),
                plainly("on: on all", lit(ALL)),
            ],
        ),
        (
            "cut-outs",
            vec![
                plainly("off", terrain(0)),
                plainly("unused: on one triangle", cut_out(1)),
                plainly("on: half of all", cut_out(ALL)),
            ],
        ),
    ]
}

fn geometry_and_light(size: [u32; 2]) -> [(&'static str, Vec<Variant>); 7] {
    let ([width, height], ahead, plain) = (size, ahead(size), plain());
    // This camera looks down and sees no sky.
    let down = StereoCamera::look_at(Vec3::new(0.0, 3.0, 0.1), Vec3::ZERO).size(width, height);
    let plainly = |name, scene| of(name, scene, &ahead, &plain);
    let keeping = |name, kept| of(name, terrain(0), &ahead, &plain.clone().g_buffer(kept));
    [
        (
            "spheres",
            vec![
                plainly("off", terrain(0)),
                plainly("unused: one below the ground", with_spheres(terrain(0), 1, -0.3)),
                plainly("on: 100 in view", with_spheres(terrain(0), 100, 0.6)),
            ],
        ),
        (
            "vertex normals",
            vec![
                plainly("off", terrain(0)),
                plainly("unused: on one triangle", terrain(1)),
                plainly("on: on all", terrain(u32::MAX)),
            ],
        ),
        (
            "lights and shadows",
            vec![
                plainly("off", terrain(0)),
                plainly("unused: 5 lights below the ground", with_lights(terrain(0), -9.0, true)),
                plainly("5 lights without shadows", with_lights(terrain(0), 4.0, false)),
                plainly("on: 5 lights with shadows", with_lights(terrain(0), 4.0, true)),
            ],
        ),
        ("sky gradient", vec![plainly("off", terrain(0)), plainly("on", with_sky(terrain(0)))]),
        (
            "sky gradient, looking down",
            vec![
                of("off", terrain(0), &down, &plain),
                of("unused: no sky in view", with_sky(terrain(0)), &down, &plain),
            ],
        ),
        (
            "G-buffer",
            vec![
                keeping("off", GBuffer::None),
                keeping("depth", GBuffer::Depth),
                keeping("depth and ids", GBuffer::Ids),
            ],
        ),
        (
            "counters",
            vec![plainly("off", terrain(0)), of("on: one ray a lane", terrain(0), &ahead, &plain.clone().count(true))],
        ),
    ]
}
