//! The yardstick for primary rays: obvhs's own traversal of its own tree, on all cores.

use std::time::Duration;

use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
    ray::{Ray, RayHit},
    rt_triangle::RtTriangle,
};
use rayon::prelude::*;
use stereotrace::{
    Pose, Scene, Sphere,
    glam::{DVec3, Vec3, Vec3A},
};

/// A scene as obvhs likes it: primitives in the tree's order, so that a leaf's lie side by side.
pub(crate) struct ObvhsTracer {
    tree: Bvh2,
    /// Spheres leave a gap here.
    triangles: Vec<RtTriangle>,
    /// Triangles leave a gap here; empty if there is no sphere.
    spheres: Vec<Option<Sphere>>,
}

impl ObvhsTracer {
    pub(crate) fn new(scene: &Scene) -> Self {
        let solid = scene.triangles().iter().filter(|triangle| !triangle.is_degenerate());
        let triangles: Vec<RtTriangle> = solid
            .map(|triangle| {
                let [a, b, c] = triangle.corners.map(Vec3A::from);
                RtTriangle::new(a, b, c)
            })
            .collect();
        let sphere_box =
            |sphere: &Sphere| Aabb::new((sphere.center - sphere.radius).into(), (sphere.center + sphere.radius).into());
        let boxes: Vec<Aabb> =
            triangles.iter().map(RtTriangle::aabb).chain(scene.spheres().iter().map(sphere_box)).collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        let order = || tree.primitive_indices.iter().map(|&index| index as usize);
        let sphere = |index: usize| index.checked_sub(triangles.len()).map(|index| scene.spheres()[index]);
        Self {
            spheres: if scene.spheres().is_empty() { Vec::new() } else { order().map(sphere).collect() },
            triangles: order().map(|index| triangles.get(index).copied().unwrap_or_default()).collect(),
            tree,
        }
    }

    /// Depth along the view axis of what the left eye sees, infinite where there is nothing; row-major.
    pub(crate) fn depths(&self, pose: &Pose) -> Vec<f32> {
        let rays = Rays::of_left_eye(pose);
        let width = pose.size[0] as usize;
        let mut depths = vec![0.0; width * pose.size[1] as usize];
        depths.par_chunks_mut(width).enumerate().for_each(|(row, depths)| {
            for (column, depth) in depths.iter_mut().enumerate() {
                *depth = self.closest_hit(rays.through(column, row));
            }
        });
        depths
    }

    fn closest_hit(&self, ray: Ray) -> f32 {
        let mut hit = RayHit::none();
        self.tree.ray_traverse(ray, &mut hit, |ray, index| match self.spheres.get(index) {
            Some(Some(sphere)) => intersect(sphere, ray),
            _ => self.triangles[index].intersect(ray),
        });
        hit.t
    }
}

fn intersect(sphere: &Sphere, ray: &Ray) -> f32 {
    let to = Vec3A::from(sphere.center) - ray.origin;
    let (a, b) = (ray.direction.length_squared(), to.dot(ray.direction));
    let root = b * b - a * (to.length_squared() - sphere.radius * sphere.radius);
    if root < 0.0 {
        return f32::INFINITY;
    }
    let root = root.sqrt();
    let near = (b - root) / a;
    let t = if near >= ray.tmin { near } else { (b + root) / a };
    if t >= ray.tmin && t <= ray.tmax { t } else { f32::INFINITY }
}

/// The left eye's rays as the library makes them: of length one along the view axis, so that t is the depth.
struct Rays {
    eye: Vec3A,
    corner: Vec3,
    step_x: Vec3,
    step_y: Vec3,
}

impl Rays {
    fn of_left_eye(pose: &Pose) -> Self {
        let [forward, right, up]: [DVec3; 3] = [pose.forward, pose.right, pose.up].map(Vec3::as_dvec3);
        let [width, height] = pose.size.map(f64::from);
        let d = f64::from(pose.screen_distance);
        let [screen_width, screen_height] = pose.screen_size.map(f64::from);
        let left_edge = -0.5 * screen_width + 0.5 * f64::from(pose.interaxial);
        Self {
            eye: pose.eye_position(-1.0).into(),
            corner: (forward + right * (left_edge / d) + up * (0.5 * screen_height / d)).as_vec3(),
            step_x: (right * (screen_width / width / d)).as_vec3(),
            step_y: (up * (-screen_height / height / d)).as_vec3(),
        }
    }

    fn through(&self, column: usize, row: usize) -> Ray {
        let direction = self.corner + self.step_x * (column as f32 + 0.5) + self.step_y * (row as f32 + 0.5);
        Ray::new_inf(self.eye, direction.into())
    }
}
