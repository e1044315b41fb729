//! Tests ground truth for motion against double precision that shares no code with it.

use std::f64::consts::{PI, TAU};

use crate::common;

use common::{ball, nearest::nearest_primitive, renderer};
use stereotrace::{
    Ellipsoid, Equirectangular, EyeFlow, Flow, FlowClass, MISS, Material, MaterialId, Mesh, Method, Moment, Options,
    Plane, Pose, Projection, Scene, Span, Sphere, StereoCamera, StereoPair, View,
    blocking::Wait,
    glam::{DAffine3, DMat3, DQuat, DVec3, Vec3},
};

/// Objects of [`scene`] in their order.
const BALL: usize = 0;
const BENT: usize = 1;
const WALL: usize = 2;
const SPHERE: usize = 3;
const ELLIPSOID: usize = 4;
const GROUND: usize = 5;

fn translated(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

/// Returns the motion of an object from time 0 to a time. The bent mesh has none: its vertices move on their own.
fn motion(object: usize, time: f64) -> DAffine3 {
    let about = |center: DVec3, turn: DQuat| {
        DAffine3::from_translation(center) * DAffine3::from_quat(turn) * DAffine3::from_translation(-center)
    };
    match object {
        BALL => {
            translated(0.3 * time, 0.1 * time, 0.0)
                * about(DVec3::new(-1.0, 0.9, 0.2), DQuat::from_rotation_y(0.9 * time))
        }
        SPHERE => translated(-0.5 * time, 0.2 * time, 0.4 * time),
        ELLIPSOID => about(DVec3::new(1.4, 0.9, -0.3), DQuat::from_axis_angle(DVec3::ONE.normalize(), 1.1 * time)),
        GROUND => translated(0.0, -0.2 * time, 0.0) * DAffine3::from_quat(DQuat::from_rotation_y(0.2 * time)),
        _ => DAffine3::IDENTITY,
    }
}

/// Returns a strip that bends with time, as skinned meshes do.
fn bent(time: f64) -> Mesh {
    let place = |index: u32| {
        let (along, across) = (f64::from(index / 2) / 8.0, f64::from(index % 2));
        let angle = along * (0.5 + 1.5 * time);
        DVec3::new(-0.4 + 1.2 * angle.sin(), 0.2 + 0.9 * across + 0.3 * time, 1.4 - 0.8 * angle.cos()).as_vec3()
    };
    let triangles =
        (0..8).flat_map(|step| [[2 * step, 2 * step + 2, 2 * step + 1], [2 * step + 2, 2 * step + 3, 2 * step + 1]]);
    Mesh::new((0..18).map(place).collect(), triangles.collect())
}

fn scene(time: f64) -> Scene {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::new(Vec3::splat(0.6)));
    let mut round = ball(Vec3::new(-1.0, 0.9, 0.2), 0.7, 8);
    for position in &mut round.positions {
        *position = motion(BALL, time).transform_point3(position.as_dvec3()).as_vec3();
    }
    let wall = [(-2.5, 0.0), (2.0, 0.0), (2.5, 2.6), (-2.0, 2.2)].map(|(x, y)| Vec3::new(x, y, -2.0 - 0.2 * x));
    for mesh in [round, bent(time), Mesh::new(wall.to_vec(), vec![[0, 1, 2], [0, 2, 3]])] {
        scene.add_mesh(&mesh).unwrap();
    }
    let center = motion(SPHERE, time).transform_point3(DVec3::new(0.5, 0.5, 0.7)).as_vec3();
    scene.add_sphere(Sphere::new(center, 0.4, material)).unwrap();
    let turn = motion(ELLIPSOID, time);
    let axes = DMat3::from_diagonal(DVec3::new(0.9, 0.3, 0.5));
    let center = turn.transform_point3(DVec3::new(1.4, 0.9, -0.3)).as_vec3();
    scene.add_ellipsoid(Ellipsoid::new(center, (turn.matrix3 * axes).as_mat3(), material)).unwrap();
    let ground = motion(GROUND, time);
    let point = ground.transform_point3(DVec3::ZERO).as_vec3();
    let u_axis = ground.transform_vector3(DVec3::X).as_vec3();
    scene.add_plane(Plane::new(point, Vec3::Y, MaterialId(0)).u_axis(u_axis).tile(0.7)).unwrap();
    scene
}

fn camera(time: f64) -> StereoCamera {
    let eye = DVec3::new(0.2 + 0.4 * time, 1.4, 4.5 - 0.3 * time);
    StereoCamera::look_at(eye, DVec3::new(0.5 * time, 0.8, 0.0)).size(120, 72).screen_distance(5.0).interaxial(0.2)
}

/// The pair at time `now`, and its flow to time `then`.
fn flow_of(
    (now, now_camera): (&Scene, StereoCamera),
    (then, then_camera): (&Scene, StereoCamera),
) -> (StereoPair, Flow, Pose) {
    let mut renderer = renderer();
    let uploaded = renderer.upload(now).wait().unwrap();
    let options = Options::new(Method::BRACKET_RAYS);
    let pair = renderer.pair(&uploaded, &now_camera).options(&options).read().wait().unwrap();
    let uploaded = renderer.upload(then).wait().unwrap();
    let flow = renderer.flow(&pair, now, Moment { scene: then, uploaded: &uploaded, camera: &then_camera });
    let flow = flow.wait().unwrap();
    (pair, flow, then_camera.pose().unwrap())
}

fn eyes<'a>(pair: &'a StereoPair, flow: &'a Flow) -> [(f64, &'a View, &'a EyeFlow); 2] {
    [(-1.0, &pair.left, &flow.left), (1.0, &pair.right, &flow.right)]
}

/// A camera model that tests write on their own.
trait Model {
    /// The ray through a point of an eye's picture.
    fn ray(&self, side: f64, place: [f64; 2]) -> (DVec3, DVec3);
    /// The place of a point in an eye's picture, and whether the eye can see it.
    fn place(&self, side: f64, point: DVec3) -> ([f64; 2], bool);
    /// The place of an infinitely distant point.
    fn distant(&self, side: f64, direction: DVec3) -> ([f64; 2], bool) {
        let eye = self.ray(side, [0.0; 2]).0;
        self.place(side, eye + direction.normalize() * 1e12)
    }
    fn size(&self) -> [f64; 2];
    /// A difference of columns by the shorter way.
    fn apart(&self, columns: f64) -> f64 {
        columns
    }
}

/// Two eyes that look through one screen.
struct Screen(Pose);

impl Model for Screen {
    fn ray(&self, side: f64, [column, row]: [f64; 2]) -> (DVec3, DVec3) {
        let pose = &self.0;
        let [right, up, forward] = [pose.right, pose.up, pose.forward].map(|axis| axis.as_dvec3());
        let eye = pose.eye + right * (0.5 * side * f64::from(pose.interaxial));
        let [w, h] = pose.size.map(f64::from);
        let x = (column / w - 0.5) * f64::from(pose.screen_size[0]);
        let y = (0.5 - row / h) * f64::from(pose.screen_size[1]);
        (eye, pose.eye + forward * f64::from(pose.screen_distance) + right * x + up * y - eye)
    }

    fn place(&self, side: f64, point: DVec3) -> ([f64; 2], bool) {
        let pose = &self.0;
        let [right, up, forward] = [pose.right, pose.up, pose.forward].map(|axis| axis.as_dvec3());
        let eye = pose.eye + right * (0.5 * side * f64::from(pose.interaxial));
        let to = point - eye;
        let on_screen = eye + to * (f64::from(pose.screen_distance) / to.dot(forward)) - pose.eye;
        let [w, h] = pose.screen_size.map(f64::from);
        let column = (on_screen.dot(right) / w + 0.5) * f64::from(pose.size[0]);
        ([column, (0.5 - on_screen.dot(up) / h) * f64::from(pose.size[1])], to.dot(forward) > 0.0)
    }

    fn size(&self) -> [f64; 2] {
        self.0.size.map(f64::from)
    }
}

/// Two eyes on a viewing circle of radius r, without merged poles. An eye sees a point at distance D along the ground
/// at an azimuth that differs by `asin(r / D)`.
struct Round(Pose, f64);

impl Model for Round {
    fn ray(&self, side: f64, [column, row]: [f64; 2]) -> (DVec3, DVec3) {
        let [w, h] = self.size();
        let (sin, cos) = ((column / w - 0.5) * self.1).sin_cos();
        let [right, forward] = [self.0.right, self.0.forward].map(|axis| axis.as_dvec3());
        let aside = right * cos - forward * sin;
        let direction = right * sin + forward * cos + DVec3::Y * ((0.5 - row / h) * PI).tan();
        (self.0.eye + aside * (0.5 * side * f64::from(self.0.interaxial)), direction)
    }

    fn place(&self, side: f64, point: DVec3) -> ([f64; 2], bool) {
        let [w, h] = self.size();
        let to = point - self.0.eye;
        let [x, z] = [self.0.right, self.0.forward].map(|axis| axis.as_dvec3().dot(to));
        let (away, radius) = (x.hypot(z), 0.5 * f64::from(self.0.interaxial));
        let azimuth = x.atan2(z) - side * (radius / away).asin();
        let s = (away * away - radius * radius).sqrt();
        let column = (azimuth / self.1 + 0.5) * w;
        let column = if self.1 == TAU { column.rem_euclid(w) } else { column };
        ([column, (0.5 - to.y.atan2(s) / PI) * h], away > radius)
    }

    fn size(&self) -> [f64; 2] {
        self.0.size.map(f64::from)
    }

    fn apart(&self, columns: f64) -> f64 {
        let [w, _] = self.size();
        if self.1 == TAU { columns - w * (columns / w).round() } else { columns }
    }
}

/// Where a point of a primitive is at the other time.
fn moved(primitive: u32, (now, then): (&Scene, &Scene), times: [f64; 2], point: DVec3) -> DVec3 {
    let object = now.object_of(primitive) as usize;
    if object == BENT {
        // Weights by the areas of the triangles that the point makes with the edges.
        let [a, b, c] = now.triangles()[primitive as usize].corners.map(|corner| corner.as_dvec3());
        let area = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a).length();
        let areas = [area(point, b, c), area(a, point, c), area(a, b, point)];
        let corners = then.triangles()[primitive as usize].corners.map(|corner| corner.as_dvec3());
        return (0..3).map(|corner| corners[corner] * areas[corner]).sum::<DVec3>() / areas.iter().sum::<f64>();
    }
    (motion(object, times[1]) * motion(object, times[0]).inverse()).transform_point3(point)
}

/// Largest differences from double precision.
#[derive(Debug, Default)]
struct Worst {
    flow: f64,
    disparity: f64,
    displacement: f64,
    /// Pixels whose class differs.
    classes: usize,
    counts: [usize; 4],
    sky: usize,
}

fn compare(
    scenes: (&Scene, &Scene),
    times: [f64; 2],
    models: [&dyn Model; 2],
    eyes: [(f64, &View, &EyeFlow); 2],
) -> Worst {
    let mut worst = Worst::default();
    let [now, then] = models;
    for (side, view, flow) in eyes {
        let width = view.width as usize;
        for (index, &class) in flow.class.iter().enumerate() {
            let center = [index % width, index / width].map(|place| place as f64 + 0.5);
            let (origin, direction) = now.ray(side, center);
            let (t, primitive) = nearest_primitive(scenes.0, origin, direction);
            // At the edges of primitives rounding decides which one is hit.
            if primitive != view.primitive[index] {
                continue;
            }
            worst.counts[class as usize] += 1;
            let before = origin + direction * t;
            let disparity = |places: [[f64; 2]; 2], model: &dyn Model| model.apart(places[0][0] - places[1][0]);
            let of_point =
                |model: &dyn Model, point| disparity([-1.0, 1.0].map(|side| model.place(side, point).0), model);
            let of_sky = |model: &dyn Model| disparity([-1.0, 1.0].map(|side| model.distant(side, direction).0), model);
            let (after, (place, is_ahead), change) = match primitive {
                MISS => (DVec3::ZERO, then.distant(side, direction), of_sky(then) - of_sky(now)),
                _ => {
                    let after = moved(primitive, scenes, times, before);
                    (after, then.place(side, after), of_point(then, after) - of_point(now, before))
                }
            };
            worst.sky += usize::from(primitive == MISS);
            if !is_ahead {
                assert!(class == FlowClass::Behind && flow.flow[index].iter().all(|value| value.is_nan()));
                continue;
            }
            let expected = [then.apart(place[0] - center[0]), place[1] - center[1]];
            // Points almost in the plane of the eyes are arbitrarily far outside.
            let is_near = expected.into_iter().all(|step| step.abs() < 300.0);
            for axis in if is_near { 0..2 } else { 0..0 } {
                worst.flow = worst.flow.max((f64::from(flow.flow[index][axis]) - expected[axis]).abs());
            }
            if is_near {
                worst.disparity = worst.disparity.max((f64::from(flow.disparity_change[index]) - change).abs());
            }
            let displacement = if primitive == MISS { DVec3::ZERO } else { after - before };
            let found = DVec3::from_array(flow.displacement[index].map(f64::from));
            worst.displacement = worst.displacement.max(found.distance(displacement));
            let is_inside = (0..2).all(|axis| place[axis] >= 0.0 && place[axis] < then.size()[axis]);
            let (eye, towards) = then.ray(side, place);
            let towards = if primitive == MISS { towards } else { after - eye };
            let limit = if primitive == MISS { 1e30 } else { 1.0 - 1e-5 };
            // At an occluder's edge rounding decides.
            let aside = towards.any_orthogonal_vector().normalize() * towards.length() * 1e-6;
            let about = [DVec3::ZERO, aside, -aside, aside.cross(towards).normalize() * aside.length()];
            let hidden = about.map(|offset| nearest_primitive(scenes.1, eye, towards + offset).0 < limit);
            let is_right = match class {
                FlowClass::Visible => is_inside && hidden.contains(&false),
                FlowClass::Hidden => is_inside && hidden.contains(&true),
                FlowClass::OutOfFrame => !is_inside,
                _ => false,
            };
            worst.classes += usize::from(!is_right);
        }
    }
    println!("{worst:?}");
    worst
}

/// Objects and camera move; then only one of them; and time runs backwards too.
#[test]
fn flow_is_that_of_double_precision() {
    let behind = camera(0.0).target(DVec3::new(9.0, 1.0, 7.0));
    let mut counts = [0; 4];
    for (name, times, cameras) in [
        ("all moves", [0.0, 1.0], [camera(0.0), camera(1.0)]),
        ("backwards", [1.0, 0.0], [camera(1.0), camera(0.0)]),
        ("the camera moves", [0.5, 0.5], [camera(0.5), camera(1.5)]),
        ("the scene moves", [0.2, 0.9], [camera(0.0), camera(0.0)]),
        ("the camera turns away", [0.0, 0.3], [camera(0.0), behind]),
        ("to another size and interaxial", [0.3, 0.0], [camera(0.3), camera(0.0).size(90, 60).interaxial(0.3)]),
    ] {
        let (now, then) = (scene(times[0]), scene(times[1]));
        let (pair, flow, pose) = flow_of((&now, cameras[0]), (&then, cameras[1]));
        print!("{name}: ");
        let worst = compare((&now, &then), times, [&Screen(pair.pose), &Screen(pose)], eyes(&pair, &flow));
        (0..4).for_each(|class| counts[class] += worst.counts[class]);
        // The measured differences are 8e-5, 6e-6 and 4e-5. The last is of the ground near the horizon.
        assert!(worst.flow < 4e-4 && worst.disparity < 3e-5 && worst.displacement < 2e-4, "{name}: {worst:?}");
        assert_eq!(worst.classes, 0, "{name}: {worst:?}");
    }
    assert!(counts.into_iter().all(|count| count > 1000), "{counts:?}");
}

#[test]
fn flow_all_around_is_that_of_double_precision() {
    for (span, turn) in [(Span::Full, TAU), (Span::Half, PI)] {
        let camera = |time: f64| {
            let eye = DVec3::new(0.2 + 0.3 * time, 0.9, 0.9 - 0.2 * time);
            let around = Projection::Equirectangular(Equirectangular { span, merge: None });
            let camera = StereoCamera::look_at(eye, eye + DVec3::new(0.6 * time - 1.0, 0.0, -1.0)).projection(around);
            camera.size(if span == Span::Full { 160 } else { 80 }, 80).interaxial(0.1)
        };
        let (now, then) = (scene(0.0), scene(0.8));
        let (pair, flow, pose) = flow_of((&now, camera(0.0)), (&then, camera(0.8)));
        let worst =
            compare((&now, &then), [0.0, 0.8], [&Round(pair.pose, turn), &Round(pose, turn)], eyes(&pair, &flow));
        assert!(worst.flow < 3e-4 && worst.disparity < 2e-4 && worst.displacement < 3e-6, "{worst:?}");
        assert_eq!(worst.classes, 0, "{worst:?}");
        assert!(worst.counts[0] > 1000 && worst.counts[1] > 200, "{worst:?}");
    }
}

/// A visible point that moves forwards and back again returns to its pixel. The flow back is interpolated between the
/// four pixels around it if these show the same object.
#[test]
fn flow_forwards_and_backwards_agree() {
    let (now, then) = (scene(0.0), scene(0.2));
    let (pair, forward, _) = flow_of((&now, camera(0.0)), (&then, camera(0.2)));
    let (other, backward, _) = flow_of((&then, camera(0.2)), (&now, camera(0.0)));
    let [width, height] = pair.pose.size.map(|side| side as usize);
    for ((_, view, forward), (_, then, backward)) in eyes(&pair, &forward).into_iter().zip(eyes(&other, &backward)) {
        let mut off = Vec::new();
        for (index, class) in forward.class.iter().enumerate() {
            let at: [f64; 2] = std::array::from_fn(|axis| {
                [index % width, index / width][axis] as f64 + f64::from(forward.flow[index][axis])
            });
            let corner = at.map(|place| place.floor().max(0.0) as usize);
            if *class != FlowClass::Visible || corner[0] + 1 >= width || corner[1] + 1 >= height {
                continue;
            }
            let four = [0, 1, width, width + 1].map(|step| corner[1] * width + corner[0] + step);
            if four.iter().any(|&pixel| then.object[pixel] != view.object[index]) {
                continue;
            }
            let share = [at[0] - corner[0] as f64, at[1] - corner[1] as f64];
            let weights = [
                (1.0 - share[0]) * (1.0 - share[1]),
                share[0] * (1.0 - share[1]),
                (1.0 - share[0]) * share[1],
                share[0] * share[1],
            ];
            let back = |axis: usize| -> f64 {
                four.iter().zip(weights).map(|(&pixel, weight)| weight * f64::from(backward.flow[pixel][axis])).sum()
            };
            off.push((0..2).map(|axis| (back(axis) + f64::from(forward.flow[index][axis])).abs()).fold(0.0, f64::max));
        }
        off.sort_by(f64::total_cmp);
        let [median, most] = [off.len() / 2, off.len() * 99 / 100].map(|place| off[place]);
        // 8e-5 and 0.028 were measured. The last is the error of the interpolation.
        println!("{} pixels: {median:e} and {most:e} px", off.len());
        assert!(off.len() > 6000 && median < 3e-4 && most < 0.06, "{} {median} {most}", off.len());
    }
}

#[test]
fn scenes_and_cameras_that_have_no_flow_are_refused_by_name() {
    let mut renderer = renderer();
    let (now, camera) = (scene(0.0), camera(0.0));
    let uploaded = renderer.upload(&now).wait().unwrap();
    let pair = renderer.pair(&uploaded, &camera).read().wait().unwrap();
    let copied = renderer.pair(&uploaded, &camera).options(&Options::new(Method::ATOMIC)).read().wait().unwrap();
    let refused = |pair: &StereoPair, scene: &Scene, then: Moment<'_>| {
        renderer.flow(pair, scene, then).wait().map(|_| ()).unwrap_err().to_string()
    };
    let then = Moment { scene: &now, uploaded: &uploaded, camera: &camera };
    let mut longer = now.clone();
    longer.set_mesh(WALL as u32, &bent(0.0).name("sail")).unwrap();
    let message = refused(&pair, &longer, then);
    assert!(message.contains("mesh 2 'sail' has 2 triangles instead of 16"), "{message}");
    longer = now.clone();
    longer.add_sphere(Sphere::new(Vec3::ZERO, 1.0, MaterialId(0))).unwrap();
    let message = refused(&pair, &now, Moment { scene: &longer, ..then });
    assert!(message.contains("it has 2 spheres instead of 1"), "{message}");
    let message = refused(&pair, &now, Moment { scene: &scene(1.0), ..then });
    assert!(message.contains("was uploaded"), "{message}");
    let toed_in = camera.projection(Projection::ToeIn);
    assert!(refused(&pair, &now, Moment { camera: &toed_in, ..then }).contains("toed-in"));
    let around = camera.projection(Projection::Equirectangular(Equirectangular::new(Span::Full)));
    assert!(refused(&pair, &now, Moment { camera: &around, ..then }).contains("projection is equirectangular"));
    assert!(refused(&copied, &now, then).contains("half a pixel"));
}
