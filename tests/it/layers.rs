//! Tests the surfaces along lines of sight against double precision that shares no code with them.

use crate::common;

use common::renderer;
use stereotrace::{
    Equirectangular, EyeLayers, Finish, LayerClass, Layering, Layers, MISS, Material, MaterialId, Mesh, Method,
    Occlusion, Options, Plane, Pose, Projection, Scene, Span, Sphere, StereoCamera, StereoPair, Texture,
    blocking::Wait,
    glam::{DVec3, Vec2, Vec3},
};

/// A surface on a line, found by a loop over all primitives.
#[derive(Clone, Copy, Debug)]
struct Met {
    t: f64,
    primitive: u32,
    normal: DVec3,
}

/// Returns all hits of a ray in the order of t.
fn all_hits(scene: &Scene, origin: DVec3, direction: DVec3) -> Vec<Met> {
    let mut found = Vec::new();
    for (triangle, primitive) in scene.triangles().iter().zip(0..) {
        let [a, b, c] = triangle.corners.map(|corner| corner.as_dvec3() - origin);
        let weights = [b.cross(c), c.cross(a), a.cross(b)].map(|edge| edge.dot(direction));
        let normal = (b - a).cross(c - a);
        if weights.iter().all(|w| *w > 0.0) || weights.iter().all(|w| *w < 0.0) {
            found.push(Met { t: normal.dot(a) / normal.dot(direction), primitive, normal: normal.normalize() });
        }
    }
    let mut primitive = scene.triangles().len() as u32;
    for sphere in scene.spheres() {
        let (center, radius) = (sphere.center.as_dvec3(), f64::from(sphere.radius));
        let (offset, squared) = (origin - center, direction.length_squared());
        let middle = -offset.dot(direction) / squared;
        let half = (middle * middle - (offset.length_squared() - radius * radius) / squared).sqrt();
        for t in [middle - half, middle + half] {
            found.push(Met { t, primitive, normal: (offset + direction * t) / radius });
        }
        primitive += 1;
    }
    for plane in scene.planes() {
        let normal = plane.normal.as_dvec3();
        let t = normal.dot(plane.point.as_dvec3() - origin) / normal.dot(direction);
        found.push(Met { t, primitive, normal });
        primitive += 1;
    }
    found.retain(|met| met.t > 1e-9);
    found.sort_by(|a, b| a.t.total_cmp(&b.t));
    found
}

fn material_of(scene: &Scene, primitive: u32) -> &Material {
    let (index, triangles) = (primitive as usize, scene.triangles().len());
    let spheres = triangles + scene.spheres().len();
    let id = match index {
        _ if index < triangles => scene.triangles()[index].material,
        _ if index < spheres => scene.spheres()[index - triangles].material,
        _ => scene.planes()[index - spheres].material,
    };
    &scene.materials()[id.0 as usize]
}

fn is_see_through(material: &Material) -> bool {
    matches!(material.finish, Finish::Glass { .. }) || material.opacity < 1.0
}

/// The ray through a place of an eye's picture.
fn ray(pose: &Pose, side: f64, [column, row]: [f64; 2]) -> (DVec3, DVec3) {
    let [right, up, forward] = [pose.right, pose.up, pose.forward].map(|axis| axis.as_dvec3());
    let eye = pose.eye + right * (0.5 * side * f64::from(pose.interaxial));
    let [w, h] = pose.size.map(f64::from);
    let x = (column / w - 0.5) * f64::from(pose.screen_size[0]);
    let y = (0.5 - row / h) * f64::from(pose.screen_size[1]);
    let to = pose.eye + forward * f64::from(pose.screen_distance) + right * x + up * y - eye;
    (eye, to / to.dot(forward))
}

/// The place of a point in an eye's picture.
fn place(pose: &Pose, side: f64, point: DVec3) -> [f64; 2] {
    let [right, up, forward] = [pose.right, pose.up, pose.forward].map(|axis| axis.as_dvec3());
    let eye = pose.eye + right * (0.5 * side * f64::from(pose.interaxial));
    let to = (point - eye) / (point - eye).dot(forward) * f64::from(pose.screen_distance);
    let at = eye + to - pose.eye;
    let [w, h] = pose.size.map(f64::from);
    [
        (at.dot(right) / f64::from(pose.screen_size[0]) + 0.5) * w,
        (0.5 - at.dot(up) / f64::from(pose.screen_size[1])) * h,
    ]
}

fn camera() -> StereoCamera {
    let eye = DVec3::new(0.3, 1.2, 5.0);
    StereoCamera::look_at(eye, DVec3::new(0.0, 0.7, 0.0)).size(96, 64).screen_distance(5.0).interaxial(0.25)
}

/// Returns a scene whose materials are: 0 matte, 1 a veil, 2 glass, 3 a mirror, 4 cut out.
fn materials() -> Scene {
    let mut scene = Scene::new();
    scene.add_material(Material::new(Vec3::splat(0.5)).opacity(0.3));
    let glass = Finish::Glass { index: 1.5, transmission: Vec3::ONE, fresnel: true };
    scene.add_material(Material::new(Vec3::ZERO).finish(glass));
    scene.add_material(Material::new(Vec3::ZERO).specular(Vec3::splat(0.9)).finish(Finish::Mirror { fresnel: false }));
    let holes = scene.add_texture(Texture::image(2, 1, vec![[255; 4], [255, 255, 255, 0]]).unwrap());
    scene.add_material(Material::new(Vec3::splat(0.7)).cutout(holes));
    scene
}

fn wall(z: f32, [left, right]: [f32; 2], material: u32) -> Mesh {
    let corner = |x, y| Vec3::new(x, y, z - 0.1 * x);
    let positions = vec![corner(left, 0.0), corner(right, 0.0), corner(right, 2.1), corner(left, 2.0)];
    let uv = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    let uv = vec![[uv[0], uv[1], uv[2]], [uv[0], uv[2], uv[3]]];
    Mesh::new(positions, vec![[0, 1, 2], [0, 2, 3]]).uv(uv).materials(vec![MaterialId(material); 2])
}

fn traced(scene: &Scene, layering: Layering) -> (StereoPair, Layers) {
    let mut renderer = renderer();
    let uploaded = renderer.upload(scene).wait().unwrap();
    let pair = renderer.pair(&uploaded, &camera()).options(&Options::new(Method::Naive)).read().wait().unwrap();
    let layers = renderer.layers(&uploaded, scene, &pair, &layering).wait().unwrap();
    (pair, layers)
}

fn eyes(layers: &Layers) -> [(f64, &EyeLayers); 2] {
    [(-1.0, &layers.left), (1.0, &layers.right)]
}

/// Returns, for each pixel, its index and its centre.
fn pixels(layers: &EyeLayers) -> impl Iterator<Item = (usize, [f64; 2])> + use<> {
    let width = layers.width as usize;
    (0..layers.count.len()).map(move |pixel| (pixel, [(pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5]))
}

/// Returns whether the same surfaces are beside a place, so that rounding changes none of them.
fn is_safe(scene: &Scene, pose: &Pose, side: f64, [column, row]: [f64; 2]) -> bool {
    let at = |x: f64, y: f64| {
        let (eye, direction) = ray(pose, side, [column + x, row + y]);
        Vec::from_iter(all_hits(scene, eye, direction).iter().map(|met| met.primitive))
    };
    [(1e-3, 0.0), (-1e-3, 0.0), (0.0, 1e-3), (0.0, -1e-3)].iter().all(|&(x, y)| at(x, y) == at(0.0, 0.0))
}

#[test]
fn straight_lines_meet_all_surfaces_up_to_the_first_opaque_one() {
    let mut scene = materials();
    for mesh in [wall(1.2, [-0.8, 0.9], 1), wall(-2.0, [-3.0, 2.0], 0), wall(0.2, [0.2, 1.6], 2)] {
        scene.add_mesh(&mesh).unwrap();
    }
    scene.add_sphere(Sphere::new(Vec3::new(-0.9, 0.8, 0.1), 0.6, MaterialId(2))).unwrap();
    scene.add_sphere(Sphere::new(Vec3::new(0.5, 0.6, -0.8), 0.5, MaterialId(0))).unwrap();
    scene.add_plane(Plane::new(Vec3::ZERO, Vec3::Y, MaterialId(0))).unwrap();
    let (pair, layers) = traced(&scene, Layering::new(6));
    let (mut seen, mut deep) = ([0; 6], 0);
    for (side, eye) in eyes(&layers) {
        for (pixel, center) in pixels(eye).filter(|(_, center)| is_safe(&scene, &pair.pose, side, *center)) {
            let (origin, direction) = ray(&pair.pose, side, center);
            let hits = all_hits(&scene, origin, direction);
            let end = hits.iter().position(|met| !is_see_through(material_of(&scene, met.primitive)));
            let expected = &hits[..end.map_or(hits.len(), |end| end + 1).min(6)];
            assert_eq!(eye.count[pixel] as usize, expected.len(), "{center:?} {expected:?}");
            deep = deep.max(expected.len());
            for layer in 0..6 {
                let place_of = layer * eye.count.len() + pixel;
                let Some(met) = expected.get(layer) else {
                    assert_eq!((eye.primitive[place_of], eye.class[place_of]), (MISS, LayerClass::None));
                    continue;
                };
                assert_eq!(eye.primitive[place_of], met.primitive, "{center:?} layer {layer}");
                let depth = f64::from(eye.depth[place_of]);
                assert!((1.0 / depth - 1.0 / met.t).abs() < 1e-6, "{center:?} layer {layer}: {depth} {}", met.t);
                let point = origin + direction * met.t;
                let other = place(&pair.pose, -side, point);
                let disparity = side * (other[0] - center[0]);
                let found = f64::from(eye.disparity[place_of]);
                assert!((found - disparity).abs() < 1e-4, "{center:?} layer {layer}: {found} {disparity}");
                let Some(class) = class_of(&scene, &pair.pose, -side, other, met, point) else { continue };
                assert_eq!(eye.class[place_of], class, "{center:?} layer {layer}");
                seen[class as usize] += 1;
            }
        }
    }
    assert!(deep >= 4 && seen[..4].iter().all(|&count| count > 20), "{deep} {seen:?}");
}

/// Returns whether an eye sees a point at a place of its picture, or `None` near an edge.
fn class_of(scene: &Scene, pose: &Pose, side: f64, at: [f64; 2], met: &Met, point: DVec3) -> Option<LayerClass> {
    let [w, h] = pose.size.map(f64::from);
    if !((0.0..w).contains(&at[0]) && (0.0..h).contains(&at[1])) {
        return Some(LayerClass::OutOfFrame);
    }
    let (eye, _) = ray(pose, side, at);
    let before = |hits: &[Met]| Vec::from_iter(hits.iter().filter(|met| met.t < 1.0 - 1e-6).map(|met| met.primitive));
    let hidden_by = |aside: DVec3| before(&all_hits(scene, eye, point + aside - eye));
    // Beside the point along its surface, since hits before it depend on where the line goes.
    let along = <[DVec3; 2]>::from(met.normal.any_orthonormal_pair());
    let hits = hidden_by(DVec3::ZERO);
    if along.iter().any(|axis| hidden_by(*axis * 4e-3) != hits || hidden_by(*axis * -4e-3) != hits) {
        return None;
    }
    let others = hits.iter().map(|&primitive| material_of(scene, primitive));
    Some(match others.clone().all(is_see_through) {
        true if hits.is_empty() => LayerClass::Visible,
        true => LayerClass::Through,
        false => LayerClass::Hidden,
    })
}

#[test]
fn lines_pass_holes_and_points_of_no_opacity() {
    let mut scene = materials();
    let alpha = scene.add_texture(Texture::image(2, 1, vec![[255, 255, 255, 0], [255, 255, 255, 128]]).unwrap());
    let veil = scene.add_material(Material::new(Vec3::ONE).texture(alpha).alpha_blend(true));
    for mesh in [wall(0.5, [-1.0, 0.0], 4), wall(0.5, [0.1, 1.1], veil.0), wall(-1.0, [-9.0, 9.0], 0)] {
        scene.add_mesh(&mesh).unwrap();
    }
    let (pair, layers) = traced(&scene, Layering::new(3));
    let eye = &layers.left;
    let mut seen = [0; 4];
    for (pixel, center) in pixels(eye).filter(|(_, center)| is_safe(&scene, &pair.pose, -1.0, *center)) {
        let (origin, direction) = ray(&pair.pose, -1.0, center);
        let Some(met) = all_hits(&scene, origin, direction).first().copied() else { continue };
        let point = origin + direction * met.t;
        let primitives = [0, 1].map(|layer| eye.primitive[layer * eye.count.len() + pixel]);
        let expected = match met.primitive {
            // The right half of the texture is a hole.
            0 | 1 if (point.x + 0.5).abs() < 0.02 => continue,
            0 | 1 if point.x < -0.5 => (0, [met.primitive, MISS]),
            // Its left half is transparent.
            2 | 3 if (point.x - 0.6).abs() < 0.02 => continue,
            2 | 3 if point.x > 0.6 => (1, [met.primitive, primitives[1]]),
            0..=3 => (2, [primitives[0], MISS]),
            _ => (3, [met.primitive, MISS]),
        };
        assert_eq!(primitives, expected.1, "{center:?}");
        match expected.0 {
            1 => assert!([4, 5, MISS].contains(&primitives[1]), "{center:?} {primitives:?}"),
            2 => assert!([4, 5, MISS].contains(&primitives[0]), "{center:?} {primitives:?}"),
            _ => {}
        }
        seen[expected.0] += 1;
    }
    assert!(seen.iter().all(|&count| count > 30), "{seen:?}");
}

/// Continues a line through a scene by its bends, in double precision. Returns the first surface after them.
fn followed(scene: &Scene, mut origin: DVec3, mut direction: DVec3, bends: u32) -> Option<(DVec3, u32)> {
    for bend in 0..=bends {
        direction = direction.normalize();
        let met = *all_hits(scene, origin + direction * 1e-7, direction).first()?;
        let point = origin + direction * (met.t + 1e-7);
        if bend == bends {
            return Some((point, met.primitive));
        }
        let outside = met.normal.dot(direction) < 0.0;
        let normal = if outside { met.normal } else { -met.normal };
        let cosine = -normal.dot(direction);
        let mirrored = direction + 2.0 * cosine * normal;
        direction = match material_of(scene, met.primitive).finish {
            Finish::Mirror { .. } => mirrored,
            Finish::Glass { index, .. } => {
                let eta = if outside { 1.0 / f64::from(index) } else { f64::from(index) };
                let squared = 1.0 - eta * eta * (1.0 - cosine * cosine);
                if squared <= 0.0 { mirrored } else { eta * direction + (eta * cosine - squared.sqrt()) * normal }
            }
            _ => return None,
        };
        origin = point;
    }
    None
}

/// Checks all surfaces after bends: the other eye's line through the place that the disparities give must reach the
/// same point. Returns the number of points of each class.
fn check_bent(scene: &Scene, pose: &Pose, layers: &Layers) -> [usize; 6] {
    let mut seen = [0; 6];
    for (side, eye) in eyes(layers) {
        for (pixel, center) in pixels(eye) {
            for layer in (0..eye.surfaces as usize).map(|layer| layer * eye.count.len() + pixel) {
                if eye.bends[layer] == 0 {
                    continue;
                }
                seen[eye.class[layer] as usize] += 1;
                let (origin, direction) = ray(pose, side, center);
                let point = followed(scene, origin, direction, eye.bends[layer]);
                let Some((point, primitive)) = point else { panic!("{center:?}: no such line") };
                let position = Vec3::from_array(eye.position[layer]).as_dvec3();
                assert!(
                    position.distance(point) < 5e-5 * f64::from(eye.distance[layer]),
                    "{center:?}: {position} {point}"
                );
                assert_eq!(eye.primitive[layer], primitive, "{center:?}");
                if !matches!(eye.class[layer], LayerClass::Visible | LayerClass::Hidden) {
                    continue;
                }
                let [x, y] = [eye.disparity[layer], eye.vertical_disparity[layer]].map(|apart| side * f64::from(apart));
                let other = |aside: [f64; 2]| {
                    let (origin, direction) = ray(pose, -side, [center[0] + x + aside[0], center[1] + y + aside[1]]);
                    followed(scene, origin, direction, eye.bends[layer])
                };
                if eye.class[layer] == LayerClass::Hidden {
                    let there = other([0.0; 2]);
                    assert!(there.is_none_or(|(there, _)| there.distance(point) > 1e-3), "{center:?}: {there:?}");
                    continue;
                }
                let here = other([0.0; 2]).unwrap_or_else(|| panic!("{center:?}: not seen at {x} {y}"));
                assert_eq!(here.1, primitive, "{center:?}");
                // The error in pixels, by how far the line moves over a part of a pixel.
                let moved = [[0.1, 0.0], [0.0, 0.1]].map(|aside| other(aside).map(|(point, _)| point.distance(here.0)));
                let Some(px) = moved[0].zip(moved[1]).map(|(x, y)| 10.0 * x.min(y)) else { continue };
                assert!(here.0.distance(point) < 1e-3 * px + 1e-6, "{center:?}: {} of {px}", here.0.distance(point));
            }
        }
    }
    seen
}

#[test]
fn a_plane_mirror_shows_points_where_their_images_are() {
    let mut scene = materials();
    scene.add_mesh(&wall(-1.0, [-1.5, 1.4], 3)).unwrap();
    scene.add_mesh(&wall(6.5, [-9.0, 9.0], 0)).unwrap();
    scene.add_sphere(Sphere::new(Vec3::new(0.4, 0.7, 0.6), 0.4, MaterialId(0))).unwrap();
    let (pair, layers) = traced(&scene, Layering::new(2).mirrored(true));
    let seen = check_bent(&scene, &pair.pose, &layers);
    let (mut images, [a, b, c]) = (0, scene.triangles()[0].corners.map(|corner| corner.as_dvec3()));
    let normal = (b - a).cross(c - a).normalize();
    for (side, eye) in eyes(&layers) {
        for (pixel, center) in pixels(eye).filter(|(pixel, _)| eye.count[*pixel] == 2) {
            let layer = eye.count.len() + pixel;
            let point = Vec3::from_array(eye.position[layer]).as_dvec3();
            let image = point - 2.0 * (point - a).dot(normal) * normal;
            let other = place(&pair.pose, -side, image);
            assert!((f64::from(eye.disparity[layer]) - side * (other[0] - center[0])).abs() < 1e-3, "{center:?}");
            assert!(eye.vertical_disparity[layer].abs() < 1e-3, "{center:?}");
            let depth = (image - pair.pose.eye).dot(pair.pose.forward.as_dvec3());
            assert!((f64::from(eye.depth[layer]) / depth - 1.0).abs() < 1e-5, "{center:?}");
            images += 1;
        }
    }
    assert!(images > 700 && seen[0] > 600 && seen[2] > 50 && seen[4] == 0, "{images} {seen:?}");
}

#[test]
fn curved_mirrors_and_glass_show_points_where_the_other_eye_finds_them() {
    let mut scene = materials();
    scene.add_mesh(&wall(-1.5, [-3.0, 3.0], 0)).unwrap();
    scene.add_sphere(Sphere::new(Vec3::new(-0.8, 0.8, 0.0), 0.6, MaterialId(3))).unwrap();
    scene.add_sphere(Sphere::new(Vec3::new(0.9, 0.8, 0.2), 0.6, MaterialId(2))).unwrap();
    scene.add_sphere(Sphere::new(Vec3::new(0.0, 1.6, 0.6), 0.3, MaterialId(0))).unwrap();
    scene.add_plane(Plane::new(Vec3::ZERO, Vec3::Y, MaterialId(0))).unwrap();
    let (pair, layers) = traced(&scene, Layering::new(4).mirrored(true).refracted(true));
    let seen = check_bent(&scene, &pair.pose, &layers);
    // The other eye does not see all of the glass ball's back through its front.
    assert!(seen[0] > 1300 && seen[4] < 200, "{seen:?}");
}

#[test]
fn the_first_layer_is_the_ground_truth_of_pictures() {
    let mut scene = materials();
    for mesh in [wall(1.2, [-0.8, 0.9], 1), wall(-2.0, [-3.0, 2.0], 0), wall(0.2, [0.2, 1.6], 3)] {
        scene.add_mesh(&mesh).unwrap();
    }
    scene.add_sphere(Sphere::new(Vec3::new(-0.9, 0.8, 0.1), 0.6, MaterialId(2))).unwrap();
    scene.add_sphere(Sphere::new(Vec3::new(-1.6, 1.2, 0.5), 0.3, MaterialId(0))).unwrap();
    scene.add_sphere(Sphere::new(Vec3::new(1.4, 1.2, 0.9), 0.3, MaterialId(0))).unwrap();
    let around = camera().projection(Projection::Equirectangular(Equirectangular::new(Span::Full))).size(256, 128);
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    for camera in [camera(), around.interaxial(0.25)] {
        let pair = renderer.pair(&uploaded, &camera).read().wait().unwrap();
        let truth = renderer.ground_truth(&uploaded, &scene, &pair).wait().unwrap();
        let layers = renderer.layers(&uploaded, &scene, &pair, &Layering::new(3)).wait().unwrap();
        let mut hidden = [0; 2];
        for (truth, layers) in [(&truth.left, &layers.left), (&truth.right, &layers.right)] {
            let first = ..truth.depth.len();
            assert_eq!(layers.depth[first], truth.depth);
            assert_eq!(layers.primitive[first], truth.primitive);
            assert_eq!(layers.object[first], truth.object);
            assert_eq!(layers.material[first], truth.material);
            assert_eq!(layers.shading_normal[first], truth.shading_normal);
            let surfaces = (0..truth.depth.len()).filter(|&pixel| truth.primitive[pixel] != MISS);
            for pixel in surfaces {
                assert_eq!(layers.disparity[pixel], truth.disparity[pixel]);
                assert!((layers.distance[pixel] / truth.distance[pixel] - 1.0).abs() < 1e-6);
                let expected = match (layers.class[pixel], truth.occlusion[pixel]) {
                    (LayerClass::Visible, Occlusion::Visible) => true,
                    (LayerClass::Through | LayerClass::Hidden, Occlusion::Hidden) => {
                        hidden[usize::from(layers.class[pixel] == LayerClass::Hidden)] += 1;
                        true
                    }
                    (class, occlusion) => class == LayerClass::OutOfFrame && occlusion == Occlusion::OutOfFrame,
                };
                assert!(expected, "{:?} {:?}", layers.class[pixel], truth.occlusion[pixel]);
            }
        }
        assert!(hidden.iter().all(|&count| count > 4), "{hidden:?}");
    }
}

#[test]
fn layers_that_cannot_be_made_are_refused() {
    let scene = materials();
    let mut scene = scene;
    scene.add_sphere(Sphere::new(Vec3::ZERO, 1.0, MaterialId(0))).unwrap();
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let pair = renderer.pair(&uploaded, &camera()).read().wait().unwrap();
    let refused = |surfaces| {
        let layers = renderer.layers(&uploaded, &scene, &pair, &Layering::new(surfaces)).wait();
        layers.unwrap_err().to_string()
    };
    assert!(refused(0).contains("layers: 0 surfaces; it must be 1 to 32"), "{}", refused(0));
    assert!(refused(33).contains("33 surfaces"), "{}", refused(33));
    let other = materials();
    let layers = renderer.layers(&uploaded, &other, &pair, &Layering::new(2)).wait();
    assert!(layers.unwrap_err().to_string().contains("the ground truth's scene"));
}
