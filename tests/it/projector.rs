//! Tests pictures that point lights project, against closed forms in f64.

use std::f64::consts::PI;

use crate::common;

use common::{is_exact, random::Random, renderer};
use stereotrace::{
    Error, Falloff, Finish, Light, Lighting, Material, MaterialId, Mesh, Method, Options, Plane, Projector, Scene, Sky,
    Sphere, StereoCamera, StereoPair, Texture, TextureId, View, Wrap,
    blocking::Wait,
    glam::{DVec2, DVec3, Vec3},
};

const ALBEDO: f64 = 0.8;
/// Sides of the picture, in pixels.
const SIDES: [u32; 2] = [6, 4];
/// Number of squares of the checkerboard, and its colours.
const SQUARES: u32 = 5;
const COLORS: [Vec3; 2] = [Vec3::new(1.0, 0.5, 0.25), Vec3::new(0.0, 0.25, 1.0)];

/// Returns a wall at z = 0 in the dark, which faces +z, with a picture and a checkerboard among its textures.
fn wall() -> (Scene, [TextureId; 2]) {
    let mut scene = Scene::new();
    let grey = scene.add_material(Material::new(Vec3::splat(ALBEDO as f32)));
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(20.0 * x, 20.0 * y, 0.0));
    scene.add_mesh(&Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).materials(vec![grey; 2])).unwrap();
    scene.sky = Sky::Constant(Vec3::ZERO);
    scene.ambient = Some(Vec3::ZERO);
    let picture = Texture::image(SIDES[0], SIDES[1], pixels()).unwrap().data(true).wrap(Wrap::Repeat);
    let board = Texture::checkerboard(COLORS[0], COLORS[1], SQUARES).unwrap();
    let textures = [picture, board].map(|texture| scene.add_texture(texture));
    (scene, textures)
}

/// Returns random colours that f16 holds.
fn pixels() -> Vec<[u8; 4]> {
    let mut random = Random::new(5);
    (0..SIDES[0] * SIDES[1]).map(|_| [0; 4].map(|_| 51 * random.below(6) as u8)).collect()
}

/// Returns the picture's colour at a place in pixels from its upper left corner.
fn picture_at(place: DVec2) -> DVec3 {
    let pixels = pixels();
    let [width, height] = SIDES.map(|side| side as usize);
    let at = |x: f64, y: f64| {
        let (x, y) = (x.clamp(0.0, width as f64 - 1.0) as usize, y.clamp(0.0, height as f64 - 1.0) as usize);
        let [red, green, blue, _] = pixels[y * width + x].map(|value| f64::from(value) / 255.0);
        DVec3::new(red, green, blue)
    };
    let corner = (place - 0.5).floor();
    let share = place - 0.5 - corner;
    let row = |y: f64| at(corner.x, y).lerp(at(corner.x + 1.0, y), share.x);
    row(corner.y).lerp(row(corner.y + 1.0), share.y)
}

/// Returns where a ray meets a projector's picture, from 0 at the upper left to 1 at the lower right. The angles are
/// those of a pinhole camera.
fn place_in(projector: &Projector, aspect: f64, ray: DVec3) -> Option<DVec2> {
    let (ahead, up) = (projector.direction.as_dvec3(), projector.up.as_dvec3());
    let level = ahead.cross(up);
    let upright = level.cross(ahead);
    let angle = |side: DVec3| (ray.dot(side) / side.length()).atan2(ray.dot(ahead) / ahead.length());
    let half_width = (0.5 * f64::from(projector.fov)).tan();
    let place = DVec2::new(angle(level).tan() / half_width, -angle(upright).tan() / (half_width / aspect));
    let is_inside = ray.dot(ahead) > 0.0 && place.abs().max_element() <= 1.0;
    is_inside.then_some(0.5 + 0.5 * place)
}

/// Returns a projector's colour along a ray.
fn color_along(projector: &Projector, ray: DVec3) -> DVec3 {
    let [width, height] = SIDES.map(f64::from);
    if projector.texture.0 == 0 {
        return place_in(projector, width / height, ray)
            .map_or(DVec3::ZERO, |place| picture_at(place * DVec2::new(width, height)));
    }
    // The first square of a checkerboard is at the lower left.
    place_in(projector, 1.0, ray).map_or(DVec3::ZERO, |place| {
        let squares = (DVec2::new(place.x, 1.0 - place.y) * f64::from(SQUARES)).floor();
        COLORS[(squares.x + squares.y) as usize % 2].as_dvec3()
    })
}

/// Returns the light that the wall reflects at a point.
fn reflected(light: &Light, x: f64, y: f64) -> DVec3 {
    let ray = DVec3::new(x, y, 0.0) - light.position;
    let squared = if light.falloff == Falloff::None { 1.0 } else { ray.length_squared() };
    let share = light.cone.map_or(1.0, |cone| {
        let [inner, outer] = [cone.inner, cone.outer].map(|angle| f64::from(angle).cos());
        let along = ray.normalize().dot(cone.direction.as_dvec3().normalize());
        ((along - outer) / (inner - outer)).clamp(0.0, 1.0).powi(2)
    });
    let color = light.projector.map_or(DVec3::ONE, |projector| color_along(&projector, ray));
    color * light.intensity.as_dvec3() * (ALBEDO * -ray.normalize().z * share / squared)
}

#[test]
fn pictures_on_a_wall_have_their_closed_form() {
    let (mut scene, [picture, board]) = wall();
    // Directions are not of length 1, and up is not perpendicular to them. The board's edges cross the view too.
    scene.lights = vec![
        Light::point(Vec3::new(0.6, -0.4, 4.0), Vec3::new(9.0, 12.0, 15.0))
            .with_projector(picture, Vec3::new(-0.3, 0.5, -2.0), Vec3::new(0.5, 2.0, 0.7), 0.8)
            .with_quadratic_falloff()
            .with_cone(Vec3::new(0.1, 0.0, -1.0), 0.3, 0.5),
        Light::point(Vec3::new(-3.0, 1.0, 3.0), Vec3::splat(0.6)),
        Light::point(Vec3::new(2.0, 1.0, 3.0), Vec3::new(0.5, 0.7, 0.9)).with_projector(
            board,
            Vec3::new(-0.9, -0.1, -1.0),
            Vec3::new(1.0, 1.0, 0.0),
            0.9,
        ),
        // It shines away from the wall.
        Light::point(Vec3::new(0.0, 0.0, 3.0), Vec3::ONE).with_projector(board, Vec3::Z, Vec3::Y, 1.5),
    ];
    let off = largest_difference(&scene, 30.0, &Options::new(Method::Naive));
    println!("largest difference {off:.6}");
    assert!(off < 1e-3, "{off}");
}

/// A path finds the light where it meets the wall. A point light is found at the first hit without a path.
#[test]
fn paths_find_the_picture_in_a_mirror() {
    let (mut scene, [picture, _]) = wall();
    scene.lights = vec![
        Light::point(Vec3::new(0.6, -0.4, 4.0), Vec3::new(0.6, 0.8, 1.0))
            .with_projector(picture, Vec3::new(-0.3, 0.5, -2.0), Vec3::new(0.5, 2.0, 0.7), 0.8)
            .with_cone(Vec3::new(0.1, 0.0, -1.0), 0.3, 0.5),
    ];
    let shiny = Material::new(Vec3::ZERO).specular(Vec3::ONE).exponent(10_000.0);
    let mirror = scene.add_material(shiny.finish(Finish::Mirror { fresnel: false }));
    scene.add_plane(Plane::new(Vec3::Z * 10.0, Vec3::NEG_Z, mirror)).unwrap();
    let by_paths = Options::new(Method::BRACKET).lighting(Lighting::Paths { bounces: 1, samples: 1 });
    let off = largest_difference(&scene, 6.0, &by_paths);
    println!("largest difference {off:.6}");
    assert!(off < 1e-3, "{off}");
}

/// Returns the largest difference of light on the wall from its closed form. An eye at `z` looks at the wall straight,
/// or by a mirror at z = 10 if it is near.
fn largest_difference(scene: &Scene, z: f32, options: &Options) -> f64 {
    let (half, size) = (2.5, 96);
    let by_mirror = z < 10.0;
    let (eye, ahead) = (Vec3::Z * z, if by_mirror { Vec3::Z } else { Vec3::NEG_Z });
    let way = if by_mirror { 20.0 - z } else { z };
    let camera =
        StereoCamera::look_at(eye, eye + way * ahead).size(size, size).screen_width(2.0 * half as f32).interaxial(0.0);
    let mut renderer = renderer();
    let uploaded = renderer.upload(scene).wait().unwrap();
    let options = options.clone().linear(true);
    let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
    let form = |x: f64, y: f64| scene.lights.iter().map(|light| reflected(light, x, y)).sum::<DVec3>();
    let (mut at_edges, mut largest) = (0, 0.0_f64);
    for (index, color) in pair.left.linear.iter().enumerate().chain(pair.right.linear.iter().enumerate()) {
        let place = |at: usize| (2.0 * (at as f64 + 0.5) / f64::from(size) - 1.0) * half;
        let [right, y] = [place(index % size as usize), -place(index / size as usize)];
        let x = if by_mirror { -right } else { right };
        let expected = form(x, y);
        let jumps = |(dx, dy): (f64, f64)| (form(x + dx, y + dy) - expected).abs().max_element() > 0.02;
        if [(1e-3, 0.0), (-1e-3, 0.0), (0.0, 1e-3), (0.0, -1e-3)].into_iter().any(jumps) {
            at_edges += 1;
        } else {
            let found = Vec3::new(color[0], color[1], color[2]).as_dvec3();
            largest = largest.max((found - expected).abs().max_element());
        }
    }
    assert!(at_edges < 400, "{at_edges} pixels are at an edge");
    largest
}

#[test]
fn a_viewer_at_the_projector_sees_its_picture_upright() {
    let (mut scene, [picture, _]) = wall();
    let (eye, direction, up) = (Vec3::new(1.0, -0.5, 5.0), Vec3::new(0.2, 0.4, -1.0), Vec3::new(0.4, 1.0, 0.3));
    let vertical: f64 = 0.6;
    let fov = 2.0 * ((0.5 * vertical).tan() * f64::from(SIDES[0]) / f64::from(SIDES[1])).atan();
    scene.lights = vec![Light::point(eye, Vec3::ONE).with_projector(picture, direction, up, fov as f32)];
    let scale = 8;
    let camera = StereoCamera::look_at(eye, eye + direction)
        .up(up)
        .vertical_fov_degrees(vertical.to_degrees() as f32)
        .size(scale * SIDES[0], scale * SIDES[1])
        .interaxial(0.0);
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let options = Options::new(Method::Naive).linear(true);
    let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
    let width = (scale * SIDES[0]) as usize;
    let mut largest: f64 = 0.0;
    for (index, color) in pair.left.linear.iter().enumerate() {
        let place = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5) / f64::from(scale);
        let found = Vec3::new(color[0], color[1], color[2]).as_dvec3();
        // Every pixel shows the picture times the albedo and one number, the cosine.
        let expected = ALBEDO * picture_at(place);
        let cosine = found.dot(expected) / expected.length_squared().max(1e-9);
        assert!(cosine > 0.5 && cosine < 1.0 || expected.length() < 0.02, "{place}: {cosine}");
        largest = largest.max((found - cosine * expected).abs().max_element());
    }
    println!("largest difference {largest:.6}");
    assert!(largest < 1e-3, "{largest}");
}

fn wrong_surfaces(view: &View, expected: &View) -> usize {
    view.depth.iter().zip(&expected.depth).filter(|(depth, expected)| depth != expected).count()
}

#[test]
fn methods_agree_on_dots_behind_a_ball() {
    let (mut scene, _) = wall();
    scene.add_sphere(Sphere::new(Vec3::new(0.3, 0.1, 1.2), 0.6, MaterialId(1))).unwrap();
    let dots = scene.add_texture(Texture::dots(160, 120, 250, 7).unwrap());
    scene.lights =
        vec![Light::point(Vec3::new(0.5, 0.2, 5.0), Vec3::ONE).with_projector(dots, Vec3::NEG_Z, Vec3::Y, 0.7)];
    let camera = StereoCamera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO).size(96, 72).interaxial(0.2);
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let mut rendered = |method: Method| -> StereoPair {
        let options = Options::new(method).linear(true);
        renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap()
    };
    let [naive, by_rays, bracket] = [Method::Naive, Method::BRACKET_RAYS, Method::BRACKET].map(&mut rendered);
    let lit = naive.right.linear.iter().filter(|color| color[0] > 0.0).count();
    assert!(lit > 500 && lit < 4000, "{lit} lit pixels");
    for (expected, found) in [(&naive.left, &by_rays.left), (&naive.right, &by_rays.right)] {
        if is_exact(&renderer) {
            assert!(found.linear == expected.linear && found.rgba8 == expected.rgba8);
        }
    }
    assert_eq!(wrong_surfaces(&bracket.right, &naive.right), 0);
    let pairs = bracket.right.rgba8.iter().zip(&naive.right.rgba8);
    let unlike = pairs.filter(|(found, expected)| found != expected).count();
    assert!(unlike < 20, "{unlike} pixels have another colour");
}

#[test]
fn projectors_out_of_range_are_refused_by_name() {
    let point = Light::point(Vec3::Y, Vec3::ONE);
    let with = |direction, up, fov| point.with_projector(TextureId(0), direction, up, fov);
    let (down, up) = (Vec3::NEG_Y, Vec3::X);
    for (light, reason) in [
        (
            Light::sphere(Vec3::Y, 0.1, Vec3::ONE).with_projector(TextureId(0), down, up, 1.0),
            "only points have a projector",
        ),
        (point.with_projector(TextureId(2), down, up, 1.0), "the projector's texture 2 is out of range for 2 textures"),
        (with(Vec3::ZERO, up, 1.0), "the length of the projector's direction is 0; it must be finite and above 0"),
        (with(Vec3::NAN, up, 1.0), "the length of the projector's direction is NaN; it must be"),
        (with(down, Vec3::ZERO, 1.0), "the length of the projector's up is 0; it must be finite and above 0"),
        (with(down, 2.0 * Vec3::Y, 1.0), "the projector's up [0, 2, 0] is parallel to its direction [0, -1, 0]"),
        (with(down, up, 0.0), "the projector's field of view is 0; it must be at least 0.001 and less than π"),
        (with(down, up, PI as f32), "the projector's field of view is 3.1415927; it must be"),
        (with(down, up, f32::NAN), "the projector's field of view is NaN; it must be"),
    ] {
        let (mut scene, _) = wall();
        scene.lights.push(light);
        let Err(error @ Error::Scene { .. }) = renderer().upload(&scene).wait() else {
            panic!("{light:?} is not refused")
        };
        let expected = format!("invalid scene: light 0: {reason}");
        assert!(error.to_string().starts_with(&expected), "{error} is not {expected}");
    }
}
