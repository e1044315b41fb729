//! Tests the appearance of planes: textures, mirrors and glass, against closed forms.

use stereotrace::{
    Finish, Light, Material, MaterialId, Mesh, Method, Options, Plane, Scene, Sky, Sphere, StereoCamera, StereoPair,
    Texture, View,
    blocking::Wait,
    glam::{DVec3, Quat, Vec2, Vec3},
    testing::cpu::{Eye, Frame},
};

use super::{common::random::Random, common::renderer, tilt};

fn pair_of(scene: &Scene, camera: &StereoCamera, method: Method) -> StereoPair {
    let mut renderer = renderer();
    let uploaded = renderer.upload(scene).wait().unwrap();
    renderer.pair(&uploaded, camera).options(&Options::new(method).linear(true)).read().wait().unwrap()
}

fn left_of(scene: &Scene, camera: &StereoCamera, method: Method) -> View {
    pair_of(scene, camera, method).left
}

fn over(turn: Quat) -> StereoCamera {
    StereoCamera::look_at(turn * Vec3::new(0.4, 1.3, 4.0), turn * Vec3::new(0.0, 0.2, 0.0))
        .up(turn * Vec3::Y)
        .screen_distance(4.0)
        .size(96, 72)
        .interaxial_pixels(5.0)
}

fn linear(view: &View, index: usize) -> Vec3 {
    Vec3::from_slice(&view.linear[index][..3])
}

/// Returns a textured ground, as a plane or as a quad, with texture coordinates along the documented axes.
fn paved(texture: Texture, turn: Quat, tile: f32, is_plane: bool) -> Scene {
    let mut scene = Scene::new();
    let texture = scene.add_texture(texture);
    let material = scene.add_material(Material::new(Vec3::splat(0.9)).texture(texture));
    let (n, u) = (turn * Vec3::Y, turn * Vec3::new(0.8, 0.0, 0.6));
    let point = turn * Vec3::new(0.3, 0.0, -0.2);
    if is_plane {
        scene.add_plane(Plane::new(point, n, material).u_axis(u + 0.4 * n).tile(tile)).unwrap();
    } else {
        let v = n.cross(u);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec2::new(x, y) * 60.0);
        let positions = corners.map(|at| point + u * at.x + v * at.y).to_vec();
        let uv = corners.map(|at| at / tile);
        let mesh = Mesh::new(positions, vec![[0, 1, 2], [0, 2, 3]]).materials(vec![material]);
        scene.add_mesh(&mesh.uv(vec![[uv[0], uv[1], uv[2]], [uv[0], uv[2], uv[3]]])).unwrap();
    }
    scene
}

#[test]
fn a_picture_lies_along_the_axes_as_on_a_mesh_with_such_coordinates() {
    let mut random = Random::new(4);
    let pixels = (0..16 * 16).map(|_| [(); 4].map(|()| random.between(0.0, 255.9) as u8)).collect();
    let picture = Texture::image(16, 16, pixels).unwrap();
    for (tile, turn) in [(2.5, Quat::IDENTITY), (0.7, tilt())] {
        let [plane, quad] = [true, false]
            .map(|is_plane| left_of(&paved(picture.clone(), turn, tile, is_plane), &over(turn), Method::Naive));
        let (mut seen, mut worst) = (0, 0.0_f32);
        // Far pixels are left out. There a mesh limits the footprint of a pixel, and a plane does not.
        for index in (0..plane.depth.len()).filter(|&index| plane.depth[index] < 25.0) {
            seen += 1;
            worst = worst.max((linear(&plane, index) - linear(&quad, index)).abs().max_element());
        }
        println!("{tile}: {seen} pixels, worst {worst:e}");
        // The measured difference is at most 1.6e-4.
        assert!(seen > 3000 && worst < 5e-4, "{tile}: {seen} {worst}");
    }
}

/// Compares each pixel with the mean of 16 x 16 rays. Their texture coordinates are computed in double precision by the
/// documented rule.
#[test]
fn a_checkerboard_is_the_mean_of_what_a_pixel_sees_of_it() {
    let board = Texture::checkerboard(Vec3::ONE, Vec3::ZERO, 2).unwrap();
    for (tile, turn) in [(1.0, Quat::IDENTITY), (1.0, tilt()), (8.0, tilt()), (50.0, tilt())] {
        let scene = paved(board.clone(), turn, tile, true);
        let camera = over(turn);
        let view = left_of(&scene, &camera, Method::BRACKET);
        let (frame, plane) = (Frame::new(&camera.pose().unwrap()), scene.planes()[0]);
        let normal = plane.normal.as_dvec3().normalize();
        let axis = plane.u_axis.as_dvec3();
        let u = (axis - normal * axis.dot(normal)).normalize();
        let v = normal.cross(u);
        let eye = frame.eye(Eye::Left).as_dvec3();
        let way = |column: usize, row: usize| frame.direction(Eye::Left, column, row).as_dvec3();
        let (right, down) = (way(1, 0) - way(0, 0), way(0, 1) - way(0, 0));
        let is_first = |direction: DVec3| {
            let t = normal.dot(plane.point.as_dvec3() - eye) / normal.dot(direction);
            let offset = eye + direction * t - plane.point.as_dvec3();
            let square = |axis: DVec3| (offset.dot(axis) / f64::from(tile) * 2.0).floor() as i64;
            (square(u) + square(v)).rem_euclid(2) == 0
        };
        let (mut squares, mut near, mut count, mut sky) = (0.0, 0.0_f64, 0, 0);
        for index in (0..view.depth.len()).filter(|&index| view.depth[index].is_finite()) {
            let middle = way(index % 96, index / 96);
            let rays = (0..256).map(|ray| {
                middle
                    + right * ((f64::from(ray % 16) + 0.5) / 16.0 - 0.5)
                    + down * ((f64::from(ray / 16) + 0.5) / 16.0 - 0.5)
            });
            let rays: Vec<DVec3> = rays.filter(|ray| normal.dot(*ray) < 0.0).collect();
            sky += usize::from(rays.len() < 256);
            let mean = rays.iter().filter(|ray| is_first(**ray)).count() as f64 / rays.len() as f64;
            let error = f64::from(linear(&view, index).x) / f64::from(0.9_f32) - mean;
            squares += error * error;
            count += 1;
            // The pixel is near and sees one square without an edge.
            if (mean == 0.0 || mean == 1.0) && view.depth[index] < 4.0 {
                near = near.max(error.abs());
            }
        }
        let off = (squares / f64::from(count)).sqrt();
        println!(
            "tile {tile}: off by {off:.4} (root mean square of {count}, {sky} at the horizon), {near:.4} within squares"
        );
        // The measured error is at most 0.084. The error of a footprint that is a square of the same area is up to
        // 0.107.
        assert!(count > 3000 && off < 0.095 && near < 0.01, "{tile}: {off} {near}");
    }
}

/// Towards the horizon a checkerboard becomes the mean of its colours, without moire.
#[test]
fn a_checkerboard_fades_to_its_mean_towards_the_horizon() {
    let board = Texture::checkerboard(Vec3::ONE, Vec3::ZERO, 2).unwrap();
    for tile in [0.5, 2.0, 8.0] {
        let camera = over(Quat::IDENTITY).size(160, 160);
        let view = left_of(&paved(board.clone(), Quat::IDENTITY, tile, true), &camera, Method::Naive);
        let contrast = |row: usize| {
            let colors = (0..160).map(|column| (linear(&view, row * 160 + column).x / 0.9 - 0.5).abs());
            colors.fold(0.0, f32::max)
        };
        let rows: Vec<usize> = (0..160).filter(|row| view.depth[row * 160].is_finite()).collect();
        let far: Vec<f32> = rows.iter().take(4).map(|&row| contrast(row)).collect();
        let near = contrast(rows[rows.len() - 1]);
        println!("{tile}: {far:?} from the horizon on, {near} near");
        assert!(far[0] < 0.01 && far.iter().all(|&contrast| contrast < 0.2) && near > 0.45, "{tile}: {far:?} {near}");
    }
}

/// In a mirror on the ground the world appears upside down, under mirrored lamps. This also holds for pixels that are
/// reused from the first eye.
#[test]
fn a_mirror_shows_the_virtual_image() {
    let turn = tilt();
    let up = turn * Vec3::Y;
    let flip = |point: Vec3| point - 2.0 * up * point.dot(up);
    let balls = [(Vec3::new(-0.6, 0.8, 0.0), 0.5), (Vec3::new(0.7, 0.5, -0.8), 0.4)];
    let scene_of = |mirrored: bool| {
        let mut scene = Scene::new();
        let red = scene.add_material(Material::new(Vec3::new(0.8, 0.3, 0.1)));
        for (center, radius) in balls {
            let center = turn * center;
            scene.add_sphere(Sphere::new(if mirrored { flip(center) } else { center }, radius, red)).unwrap();
        }
        let lamp = turn * Vec3::new(2.0, 5.0, 3.0);
        scene.lights = vec![Light::point(if mirrored { flip(lamp) } else { lamp }, Vec3::splat(0.7))];
        scene.ambient = Some(Vec3::splat(0.2));
        scene.sky = Sky::Constant(Vec3::new(0.2, 0.4, 0.9));
        scene
    };
    let mut mirror = scene_of(false);
    let glossy = Material::new(Vec3::ZERO).specular(Vec3::ONE).finish(Finish::Mirror { fresnel: false });
    let glossy = mirror.add_material(glossy);
    mirror.add_plane(Plane::new(turn * Vec3::new(50.0, 0.0, 20.0), up, glossy)).unwrap();
    // The camera is rolled, so that depths differ along a row.
    let camera = over(turn).up(turn * Vec3::new(0.6, 1.0, 0.0));
    let image = pair_of(&scene_of(true), &camera, Method::Naive).right;
    for method in [Method::Naive, Method::BRACKET, Method::ATOMIC] {
        let view = pair_of(&mirror, &camera, method).right;
        let (mut seen, mut balls, mut off) = (0, 0, 0);
        for index in (0..view.depth.len()).filter(|&index| view.primitive[index] == 2) {
            seen += 1;
            balls += usize::from(image.depth[index].is_finite());
            off += usize::from((linear(&view, index) - linear(&image, index)).abs().max_element() > 1e-3);
        }
        println!("{method}: {seen} on the mirror, {balls} show balls, {off} are off");
        assert!(seen > 2000 && balls > 300 && off <= 3, "{method}: {seen} {balls} {off}");
    }
}

/// The half-space below a glass plane is glass. Rays bend by Snell's law as they enter it. Rays from below leave it or
/// are totally reflected.
#[test]
fn a_plane_of_glass_is_the_face_of_a_half_space() {
    let (turn, index) = (tilt(), 1.5_f64);
    let up = (turn * Vec3::Y).as_dvec3();
    let mut scene = Scene::new();
    let glass = Finish::Glass { index: index as f32, transmission: Vec3::ONE, fresnel: false };
    let glass = scene.add_material(Material::new(Vec3::ZERO).specular(Vec3::ZERO).finish(glass));
    let red = scene.add_material(Material::new(Vec3::new(0.8, 0.3, 0.1)));
    let ball = (turn * Vec3::new(0.1, -0.9, -0.3), 0.6);
    scene.add_sphere(Sphere::new(ball.0, ball.1, red)).unwrap();
    scene.add_plane(Plane::new(turn * Vec3::new(9.0, 0.0, -5.0), turn * Vec3::Y, glass)).unwrap();
    let sky = Vec3::new(0.2, 0.4, 0.9);
    scene.sky = Sky::Constant(sky);
    let meets_ball = |origin: DVec3, direction: DVec3| {
        let to = ball.0.as_dvec3() - origin;
        let middle = to.dot(direction);
        middle > 0.0 && (to - direction * middle).length() < f64::from(ball.1)
    };
    for (eye, target) in [(Vec3::new(0.4, 1.3, 4.0), Vec3::ZERO), (Vec3::new(0.4, -1.2, 4.0), Vec3::new(0.0, 0.2, 0.0))]
    {
        let camera = over(turn).eye(turn * eye).target(turn * target);
        let view = left_of(&scene, &camera, Method::BRACKET);
        let frame = Frame::new(&camera.pose().unwrap());
        let (mut seen, mut balls, mut off) = (0, 0, 0);
        for pixel in (0..view.depth.len()).filter(|&pixel| view.primitive[pixel] == 1) {
            let origin = frame.eye(Eye::Left).as_dvec3();
            let direction = frame.direction(Eye::Left, pixel % 96, pixel / 96).as_dvec3().normalize();
            let point = origin - direction * (origin.dot(up) / direction.dot(up));
            let entering = direction.dot(up) < 0.0;
            let normal = if entering { up } else { -up };
            let eta = if entering { 1.0 / index } else { index };
            let across = (direction - normal * direction.dot(normal)) * eta;
            let on = match across.length_squared() < 1.0 {
                true => across - normal * (1.0 - across.length_squared()).sqrt(),
                false => direction - 2.0 * normal * direction.dot(normal),
            };
            let expected = if meets_ball(point, on) { Vec3::new(0.8, 0.3, 0.1) } else { sky };
            seen += 1;
            balls += usize::from(expected != sky);
            off += usize::from((linear(&view, pixel) - expected).abs().max_element() > 1e-3);
        }
        println!("from {eye}: {seen} on the glass, {balls} show the ball, {off} are off");
        assert!(seen > 1500 && balls > 100 && off <= 3, "{eye}: {seen} {balls} {off}");
    }
}

#[test]
fn a_cut_out_plane_is_refused_by_name() {
    let mut scene = Scene::new();
    let board = scene.add_texture(Texture::checkerboard(Vec3::ONE, Vec3::ZERO, 2).unwrap());
    let holes = scene.add_material(Material::new(Vec3::ONE).cutout(board));
    scene.add_plane(Plane::new(Vec3::ZERO, Vec3::Y, MaterialId(0))).unwrap();
    scene.add_plane(Plane::new(Vec3::ZERO, Vec3::X, holes)).unwrap();
    let error = renderer().upload(&scene).wait().unwrap_err().to_string();
    assert!(error.contains("plane 1: its material 1 has a cut-out; only triangles can be cut out"), "{error}");
}
