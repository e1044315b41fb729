// Bvh2 with 16-bit boxes on a scene-wide grid: the library's own traversal.

fn trace(ray: Ray) -> Hit {
    return closest_hit(ray, 0.0, FAR);
}
