//! A ray tracer in double precision, whose pictures serve as a reference. It uses brute force and textbook formulas,
//! and only the scenes of the crate's code. It follows the f32 rays of the kernels, so that only their arithmetic is
//! tested.
mod judged;

use rayon::prelude::*;
use stereotrace::{
    MISS, Scene, Sky, Texture, TextureKind, Wrap,
    glam::{DMat3, DVec2, DVec3, Vec2, Vec3},
    testing::cpu::{Eye, Frame},
};

pub(crate) use judged::judged;

/// A triangle, with values that every intersection test of it needs.
struct Triangle {
    corners: [DVec3; 3],
    normal: DVec3,
    albedo: DVec3,
    /// The cut-out's texture and its texture coordinates.
    cutout: Option<(Texture, [DVec2; 3])>,
}

struct Sphere {
    center: DVec3,
    radius: f64,
    albedo: DVec3,
}

/// A transformed sphere. `inverse` maps offsets from its centre to offsets from the unit sphere's centre.
struct Ellipsoid {
    center: DVec3,
    inverse: DMat3,
    albedo: DVec3,
}

/// A plane through a point, with the unit normal of the kernels, rounded to f32.
struct Plane {
    point: DVec3,
    normal: DVec3,
    albedo: DVec3,
}

/// A scene in double precision.
pub(crate) struct Truth {
    triangles: Vec<Triangle>,
    spheres: Vec<Sphere>,
    ellipsoids: Vec<Ellipsoid>,
    planes: Vec<Plane>,
    lights: Vec<(DVec3, DVec3)>,
    shadows: bool,
    ambient: DVec3,
    sky: DVec3,
}

/// The result of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// Infinite for a miss.
    pub t: f64,
    /// [`MISS`] for a miss.
    pub primitive: u32,
    /// Linear RGB in 0 to 1.
    pub linear: DVec3,
    /// Sine of the angle between ray and surface.
    pub slope: f64,
}

impl Seen {
    pub(crate) fn srgb(&self) -> [u8; 3] {
        self.linear.to_array().map(|value| {
            let encoded = if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
            (255.0 * encoded).round() as u8
        })
    }
}

impl Truth {
    pub(crate) fn new(scene: &Scene) -> Self {
        let albedo = |id: stereotrace::MaterialId| scene.materials()[id.0 as usize].albedo.as_dvec3();
        let triangle = |(id, triangle): (usize, &stereotrace::Triangle)| {
            let corners @ [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
            let uv = scene.uv().get(id).map_or([DVec2::ZERO; 3], |uv| uv.map(Vec2::as_dvec2));
            let texture = scene.materials()[triangle.material.0 as usize].cutout;
            let cutout = texture.map(|texture| (scene.textures()[texture.0 as usize].clone(), uv));
            Triangle { corners, normal: (b - a).cross(c - a), albedo: albedo(triangle.material), cutout }
        };
        let sphere = |sphere: &stereotrace::Sphere| Sphere {
            center: sphere.center.as_dvec3(),
            radius: f64::from(sphere.radius),
            albedo: albedo(sphere.material),
        };
        let ellipsoid = |one: &stereotrace::Ellipsoid| Ellipsoid {
            center: one.center.as_dvec3(),
            inverse: one.axes.as_dmat3().inverse(),
            albedo: albedo(one.material),
        };
        let plane = |one: &stereotrace::Plane| Plane {
            point: one.point.as_dvec3(),
            normal: one.normal.as_dvec3().normalize().as_vec3().as_dvec3(),
            albedo: albedo(one.material),
        };
        let Sky::Constant(sky) = scene.sky else { panic!("skies of one colour only") };
        Self {
            triangles: scene.triangles().iter().enumerate().map(triangle).collect(),
            spheres: scene.spheres().iter().map(sphere).collect(),
            ellipsoids: scene.ellipsoids().iter().map(ellipsoid).collect(),
            planes: scene.planes().iter().map(plane).collect(),
            lights: scene.lights.iter().map(|l| (l.position - scene.origin(), l.intensity.as_dvec3())).collect(),
            shadows: scene.shadows,
            ambient: scene.rendered_ambient().as_dvec3(),
            sky: sky.as_dvec3(),
        }
    }

    /// Returns the nearest t above 0 and its primitive, or infinity and [`MISS`]. For equal t, the smaller id wins.
    pub(crate) fn closest(&self, origin: DVec3, direction: DVec3) -> (f64, u32) {
        let mut best = (f64::INFINITY, MISS);
        let mut offer = |t: Option<f64>, id: usize| {
            if let Some(t) = t.filter(|&t| t > 0.0 && t < best.0) {
                best = (t, id as u32);
            }
        };
        for (id, triangle) in self.triangles.iter().enumerate() {
            offer(triangle.hit(origin, direction), id);
        }
        for (id, hits) in self.quadrics(origin, direction).enumerate() {
            let [near, far] = hits.unwrap_or([f64::NAN; 2]);
            offer(Some(if near > 0.0 { near } else { far }), self.triangles.len() + id);
        }
        for (id, plane) in self.planes.iter().enumerate() {
            offer(plane.hit(origin, direction), self.first_plane() + id);
        }
        best
    }

    /// Returns the id of the first plane.
    fn first_plane(&self) -> usize {
        self.triangles.len() + self.spheres.len() + self.ellipsoids.len()
    }

    /// Returns the hits of spheres, then of ellipsoids.
    fn quadrics(&self, origin: DVec3, direction: DVec3) -> impl Iterator<Item = Option<[f64; 2]>> + '_ {
        let spheres = self.spheres.iter().map(move |sphere| sphere.hits(origin, direction));
        spheres.chain(self.ellipsoids.iter().map(move |one| one.hits(origin, direction)))
    }

    /// Returns whether a primitive other than `own` is between two points.
    fn occluded(&self, from: DVec3, to: DVec3, own: u32) -> bool {
        // Coplanar neighbours of `own` are hit at t = 0 within rounding.
        let between = |t: f64| t > 1e-9 && t < 1.0;
        let direction = to - from;
        let triangles = self.triangles.iter().enumerate().filter(|(id, _)| *id as u32 != own);
        let quadrics = self.quadrics(from, direction).enumerate();
        let mut quadrics = quadrics.filter(|(id, _)| (self.triangles.len() + id) as u32 != own);
        triangles.into_iter().any(|(_, triangle)| triangle.hit(from, direction).is_some_and(between))
            || quadrics.any(|(_, hits)| hits.is_some_and(|t| t.into_iter().any(between)))
            || self.planes.iter().enumerate().any(|(id, plane)| {
                (self.first_plane() + id) as u32 != own && plane.hit(from, direction).is_some_and(between)
            })
    }

    /// Returns the surface and light that a ray sees, shaded as DESIGN, section 3, defines.
    pub(crate) fn see(&self, origin: Vec3, direction: Vec3) -> Seen {
        let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
        let (t, primitive) = self.closest(origin, direction);
        if primitive == MISS {
            return Seen { t, primitive, linear: self.sky, slope: 1.0 };
        }
        let point = origin + direction * t;
        let (normal, albedo) = match self.triangles.get(primitive as usize) {
            Some(triangle) => (triangle.normal.normalize(), triangle.albedo),
            None if primitive as usize >= self.first_plane() => {
                let plane = &self.planes[primitive as usize - self.first_plane()];
                (plane.normal.normalize(), plane.albedo)
            }
            None => {
                let index = primitive as usize - self.triangles.len();
                match self.spheres.get(index) {
                    Some(sphere) => ((point - sphere.center).normalize(), sphere.albedo),
                    None => {
                        let one = &self.ellipsoids[index - self.spheres.len()];
                        let normal = one.inverse.transpose() * (one.inverse * (point - one.center));
                        (normal.normalize(), one.albedo)
                    }
                }
            }
        };
        let cosine = normal.dot(direction);
        let normal = if cosine > 0.0 { -normal } else { normal };
        let lit = self.lights.iter().map(|&(position, intensity)| {
            let facing = normal.dot((position - point).normalize());
            let dark = facing <= 0.0 || (self.shadows && self.occluded(point, position, primitive));
            if dark { DVec3::ZERO } else { intensity * facing }
        });
        let light = self.ambient + lit.sum::<DVec3>();
        let linear = (albedo * light).clamp(DVec3::ZERO, DVec3::ONE);
        Seen { t, primitive, linear, slope: cosine.abs() / direction.length() }
    }

    /// Returns the view of an eye, row by row. t is depth, since directions have length 1 along the view axis.
    pub(crate) fn view(&self, frame: &Frame, eye: Eye) -> Vec<Seen> {
        let [width, height] = frame.size();
        let pixel = |index: usize| self.see(frame.eye(eye), frame.direction(eye, index % width, index / width));
        (0..width * height).into_par_iter().map(pixel).collect()
    }
}

impl Triangle {
    /// Returns t at the triangle's plane, if the ray passes within the triangle.
    fn hit(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let [a, b, c] = self.corners.map(|corner| corner - origin);
        let edge = |p: DVec3, q: DVec3| direction.dot(p.cross(q - p));
        let (u, v) = (edge(b, c), edge(c, a));
        if u * v < 0.0 {
            return None;
        }
        let w = edge(a, b);
        let inside = u.min(v).min(w) >= 0.0 || u.max(v).max(w) <= 0.0;
        let across = self.normal.dot(direction);
        let is_hole = |(texture, [at_a, at_b, at_c]): &(Texture, [DVec2; 3])| {
            !has_surface(texture, (*at_a * u + *at_b * v + *at_c * w) / (u + v + w))
        };
        let there = inside && across != 0.0 && !self.cutout.as_ref().is_some_and(is_hole);
        there.then(|| self.normal.dot(a) / across)
    }
}

impl Plane {
    /// Returns t, which is below 0 behind the ray. Returns `None` for hits farther away than 1e8 units.
    fn hit(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let t = self.normal.dot(self.point - origin) / self.normal.dot(direction);
        (t.is_finite() && t != 0.0 && t.abs() * direction.length() <= 1e8).then_some(t)
    }
}

/// Returns whether a cut-out has a surface at these texture coordinates.
fn has_surface(texture: &Texture, uv: DVec2) -> bool {
    let wrapped = |at: f64, size: u32| {
        let at = match texture.wrap {
            Wrap::Repeat => at.rem_euclid(1.0),
            Wrap::Mirror => 1.0 - (at.rem_euclid(2.0) - 1.0).abs(),
            Wrap::Clamp => at,
            other => panic!("{other:?}"),
        };
        (at * f64::from(size)).clamp(0.0, f64::from(size) - 1.0) as usize
    };
    match texture.kind() {
        TextureKind::Image { size: [width, height], pixels } => {
            // The first row is at the top.
            let row = *height as usize - 1 - wrapped(uv.y, *height);
            f64::from(pixels[row * *width as usize + wrapped(uv.x, *width)][3]) / 255.0 >= 0.5
        }
        TextureKind::Checkerboard { colors, squares } => {
            let color = colors[(wrapped(uv.x, *squares) + wrapped(uv.y, *squares)) % 2].as_dvec3();
            color.dot(DVec3::new(0.2126, 0.7152, 0.0722)) >= 0.5
        }
        other => panic!("{other:?}"),
    }
}

impl Ellipsoid {
    fn hits(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let unit = Sphere { center: self.inverse * (self.center - origin), radius: 1.0, albedo: DVec3::ZERO };
        unit.hits(DVec3::ZERO, self.inverse * direction)
    }
}

impl Sphere {
    fn hits(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let to_center = self.center - origin;
        let per_length_squared = 1.0 / direction.length_squared();
        let middle = to_center.dot(direction) * per_length_squared;
        let inside = self.radius * self.radius - (to_center - direction * middle).length_squared();
        let half = (inside * per_length_squared).sqrt();
        (inside >= 0.0).then_some([middle - half, middle + half])
    }
}
