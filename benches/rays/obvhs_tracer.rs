//! Reference for comparison: obvhs's own traversal of its own tree, on all cores.

use std::time::Duration;

use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
    ray::{Ray, RayHit},
    rt_triangle::RtTriangle,
};
use rayon::prelude::*;
use stereotrace::{FAR, Scene, Sphere, glam::Vec3A};

/// Number of rays per task.
const TASK: usize = 1024;

/// A scene in obvhs's layout: primitives are in the tree's order, so that a leaf's primitives are adjacent.
pub(crate) struct ObvhsTracer {
    tree: Bvh2,
    /// Triangles in the tree's order, with default triangles in the places of spheres.
    triangles: Vec<RtTriangle>,
    /// Spheres in the tree's order, with `None` in the places of triangles; empty if there are no spheres.
    spheres: Vec<Option<Sphere>>,
}

impl ObvhsTracer {
    /// Builds the tree as the library builds its own by default.
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

    /// Returns t of each ray's closest hit, infinite for a miss.
    pub(crate) fn closest_hits(&self, rays: &[stereotrace::Ray]) -> Vec<f32> {
        let closest = |ray: &stereotrace::Ray| {
            let mut hit = RayHit::none();
            let found = self.tree.ray_traverse(of(ray), &mut hit, |ray, index| self.intersect(ray, index));
            if found { hit.t } else { f32::INFINITY }
        };
        in_parallel(rays, closest)
    }

    /// Returns whether each ray hits anything.
    pub(crate) fn any_hits(&self, rays: &[stereotrace::Ray]) -> Vec<bool> {
        in_parallel(rays, |ray| !self.tree.ray_traverse_miss(of(ray), |ray, index| self.intersect(ray, index)))
    }

    /// Does the same as [`Self::any_hits`], for rays from their ends to their origins.
    pub(crate) fn any_hits_reversed(&self, rays: &[stereotrace::Ray]) -> Vec<bool> {
        let any = |ray: &stereotrace::Ray| {
            let end = ray.origin.as_vec3() + ray.direction * ray.t_max;
            let back = Ray::new(end.into(), (-ray.direction).into(), 0.0, ray.t_max);
            !self.tree.ray_traverse_miss(back, |ray, index| self.intersect(ray, index))
        };
        in_parallel(rays, any)
    }

    fn intersect(&self, ray: &Ray, index: usize) -> f32 {
        match self.spheres.get(index) {
            Some(Some(sphere)) => intersect(sphere, ray),
            _ => self.triangles[index].intersect(ray),
        }
    }
}

fn of(ray: &stereotrace::Ray) -> Ray {
    Ray::new(ray.origin.as_vec3().into(), ray.direction.into(), ray.t_min, ray.t_max.min(FAR))
}

fn in_parallel<T: Send + Default + Clone>(
    rays: &[stereotrace::Ray],
    trace: impl Fn(&stereotrace::Ray) -> T + Sync,
) -> Vec<T> {
    let mut found = vec![T::default(); rays.len()];
    found.par_chunks_mut(TASK).zip(rays.par_chunks(TASK)).for_each(|(found, rays)| {
        for (found, ray) in found.iter_mut().zip(rays) {
            *found = trace(ray);
        }
    });
    found
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
