//! Makes lists of every kind of ray that rendering a stereo pair traces.

use stereotrace::testing::random;

use stereotrace::{
    FAR, Pose, Ray, Scene,
    glam::{DVec3, Vec3},
    testing::cpu::{Eye, Frame},
};

use self::random::pcg;

/// Query of a ray: closest hit or any hit.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Query {
    Closest,
    Any,
}

/// Rays of one kind, in lists that are traced one after another.
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    pub(crate) query: Query,
    pub(crate) lists: Vec<Vec<Ray>>,
}

impl Kind {
    pub(crate) fn rays(&self) -> usize {
        self.lists.iter().map(Vec::len).sum()
    }
}

/// Caller's closest-hit query, which returns t of each ray.
pub(crate) type LeftHits<'a> = &'a dyn Fn(&[Ray]) -> Vec<f32>;

/// Returns all kinds of rays. `left_hits` returns the depths of the left eye's hits, infinite for a miss.
pub(crate) fn kinds(scene: &Scene, pose: &Pose, left_hits: LeftHits<'_>) -> Vec<Kind> {
    let frame = Frame::new(pose);
    let pixels = in_blocks(frame.size());
    let (left, right) = (frame.eye(Eye::Left), frame.eye(Eye::Right));
    let through = |eye| pixels.iter().map(|&[column, row]| frame.direction(eye, column, row)).collect::<Vec<_>>();
    let (left_directions, right_directions) = (through(Eye::Left), through(Eye::Right));
    let primary: Vec<Ray> = left_directions.iter().map(|direction| Ray::new(left, *direction)).collect();
    let depth = left_hits(&primary);
    let points: Vec<Vec3> = left_directions
        .iter()
        .zip(&depth)
        .filter(|(_, depth)| depth.is_finite())
        .map(|(direction, depth)| left + *direction * *depth)
        .collect();
    let towards = |from: Vec3, t_max: f32| {
        let ray = |point: &Vec3| Ray::new(from, *point - from).t_max(t_max);
        points.iter().map(ray).collect()
    };
    // These are the rays of a method that knows the right eye's depth to within two percent.
    let interval = |(direction, depth): (&Vec3, &f32)| {
        let depth = depth.min(FAR);
        Ray::new(right, *direction).t_min(0.98 * depth).t_max(1.02 * depth)
    };
    let scattered = right_directions.iter().enumerate().filter(|(index, _)| pcg(*index as u32).is_multiple_of(10));
    // Each ray starts at its own point, into the half space that contains the eye.
    let bounced = points.iter().enumerate().map(|(index, point)| {
        let unit = |word: u32| pcg(3 * index as u32 + word) as f32 / u32::MAX as f32 - 0.5;
        let around = Vec3::new(unit(0), unit(1), unit(2));
        let direction = if around.dot(left - *point) < 0.0 { -around } else { around };
        Ray::new(*point, direction).t_min(1e-3)
    });
    let bounced: Vec<Ray> = bounced.collect();
    vec![
        Kind { name: "primary", query: Query::Closest, lists: vec![primary] },
        Kind {
            name: "shadow",
            query: Query::Any,
            lists: scene.lights.iter().map(|light| towards(light.position.as_vec3(), 0.9999)).collect(),
        },
        Kind { name: "length-limited", query: Query::Any, lists: vec![towards(right, 0.999)] },
        Kind {
            name: "interval",
            query: Query::Closest,
            lists: vec![right_directions.iter().zip(&depth).map(interval).collect()],
        },
        Kind {
            name: "scattered 10%",
            query: Query::Closest,
            lists: vec![scattered.map(|(_, direction)| Ray::new(right, *direction)).collect()],
        },
        Kind { name: "bounced, sorted", query: Query::Closest, lists: vec![sorted(&bounced)] },
        Kind { name: "bounced", query: Query::Closest, lists: vec![bounced] },
    ]
}

/// Returns rays sorted by the octant of their direction, and then along a Morton curve of 64³ cells of their origins.
fn sorted(rays: &[Ray]) -> Vec<Ray> {
    let low = rays.iter().fold(DVec3::INFINITY, |low, ray| low.min(ray.origin));
    let high = rays.iter().fold(DVec3::NEG_INFINITY, |high, ray| high.max(ray.origin));
    let spread = |cell: u32| (0..6).map(|bit| (cell >> bit & 1) << (3 * bit)).sum::<u32>();
    let key = |ray: &Ray| {
        let cells = ((ray.origin - low) / (high - low).max(DVec3::splat(1e-20)) * 63.0).to_array();
        let [x, y, z] = cells.map(|cell| spread(cell as u32));
        let octant = ray.direction.to_array().iter().fold(0, |bits, &part| bits << 1 | u32::from(part < 0.0));
        octant << 18 | x | y << 1 | z << 2
    };
    let mut sorted = rays.to_vec();
    sorted.sort_by_cached_key(key);
    sorted
}

/// Returns all pixels in the kernels' order: tiles of 8x4, each divided into blocks of 2x2.
fn in_blocks([width, height]: [usize; 2]) -> Vec<[usize; 2]> {
    let mut pixels = Vec::with_capacity(width * height);
    for tile_y in (0..height).step_by(4) {
        for tile_x in (0..width).step_by(8) {
            for place in 0..32 {
                let (block, within) = (place / 4, place % 4);
                let (x, y) = (tile_x + block % 4 * 2 + within % 2, tile_y + block / 4 * 2 + within / 2);
                if x < width && y < height {
                    pixels.push([x, y]);
                }
            }
        }
    }
    pixels
}
