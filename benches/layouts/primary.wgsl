// The left view's primary rays, closest hit only. `trace` is the layout's.
//
// launch  one thread per pixel
// writes  hits  [height * width]  depth along the view axis (FAR: nothing), primitive id (MISS: nothing), counts

struct BenchHit {
    depth: f32,
    primitive: u32,
    nodes_visited: u32,        // 0 unless COUNT is set
    primitives_tested: u32,
}

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read_write> hits: array<BenchHit>;

@compute @workgroup_size(8, 8)
fn primary(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let hit = trace(Ray(frame.left_eye, pixel_direction(frame.left_corner, pixel)));
    hits[pixel_index(pixel)] = BenchHit(hit.t, hit.primitive, nodes_visited, primitives_tested);
}
