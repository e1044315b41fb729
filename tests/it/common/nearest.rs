//! Traces rays in double precision, without code of the library.

use stereotrace::{
    MISS, Scene,
    glam::{DMat3, DVec3, Vec3},
};

/// Returns t of a ray's nearest hit in double precision, by a loop over all primitives. Returns infinity for a miss.
pub(crate) fn nearest(scene: &Scene, origin: DVec3, direction: DVec3) -> f64 {
    nearest_primitive(scene, origin, direction).0
}

/// Returns t of a ray's nearest hit, like [`nearest`], and the id of its primitive.
pub(crate) fn nearest_primitive(scene: &Scene, origin: DVec3, direction: DVec3) -> (f64, u32) {
    let triangles = scene.triangles().iter().map(|triangle| {
        let [a, b, c] = triangle.corners.map(|corner| corner.as_dvec3() - origin);
        let weights = [b.cross(c), c.cross(a), a.cross(b)].map(|edge| edge.dot(direction));
        let normal = (b - a).cross(c - a);
        let is_inside = weights.iter().all(|w| *w >= 0.0) || weights.iter().all(|w| *w <= 0.0);
        if is_inside { normal.dot(a) / normal.dot(direction) } else { f64::NAN }
    });
    let ball = |center: Vec3, inverse: DMat3| {
        let (o, d) = (inverse * (origin - center.as_dvec3()), inverse * direction);
        let (middle, squared) = (-o.dot(d) / d.length_squared(), d.length_squared());
        let half = (middle * middle - (o.length_squared() - 1.0) / squared).sqrt();
        if middle > half { middle - half } else { middle + half }
    };
    let spheres = scene.spheres().iter().map(|sphere| ball(sphere.center, DMat3::IDENTITY / f64::from(sphere.radius)));
    let ellipsoids = scene.ellipsoids().iter().map(|one| ball(one.center, one.axes.as_dmat3().inverse()));
    let planes = scene.planes().iter().map(|plane| {
        let normal = plane.normal.as_dvec3();
        normal.dot(plane.point.as_dvec3() - origin) / normal.dot(direction)
    });
    let all = triangles.chain(spheres).chain(ellipsoids).chain(planes).zip(0..);
    all.filter(|(t, _)| *t > 0.0).fold((f64::INFINITY, MISS), |best, found| if found.0 < best.0 { found } else { best })
}
