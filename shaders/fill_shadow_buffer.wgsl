// Fills rows of a light's shadow-buffer: the nearest hit along the direction of each texel's middle (docs/SHADOW-BUFFER.md).
//
// launch  one thread per block of texels (a texel, or 2x2) of the rows at work
// adds    counters   [COUNTERS]                    as of a view
// writes  filled     [rows at work][per_row]       t as bits, place of the primitive; MISS: nothing hit; UNFILLED: not known

// A light and where directions stand in its table; src/cpu/shadow_buffer.rs has the same.
struct Filling {
    light: vec3f,            // world position
    theta_begin: f32,        // of the first row, radians
    axis_x: vec3f,           // unit: where phi is 0 on the equator
    theta_step: f32,         // a row
    axis_y: vec3f,           // where phi is pi / 2
    phi_begin: f32,          // of the first column
    axis_z: vec3f,           // the pole at theta = 0
    phi_step: f32,           // a column
    row_begin: u32,          // rows of this dispatch
    row_end: u32,
    columns: u32,
    per_row: u32,            // texels of a row of `filled`
}

@group(1) @binding(0) var<uniform> filling: Filling;
@group(1) @binding(1) var<storage, read_write> counters: array<atomic<u32>>;
@group(1) @binding(2) var<storage, read_write> filled: array<vec2u>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn fill_shadow_buffer(@builtin(global_invocation_id) id: vec3u) {
    let first = pixel_in_tile(id.xy) * BLOCK + vec2u(0u, filling.row_begin);
    let columns = RAY_X + U(first.x);
    let rows = RAY_Y + U(first.y);
    let wanted = (columns < U(filling.columns)) & (rows < U(filling.row_end));
    if !any_ray(wanted) { return; }
    let theta = (F(rows) + 0.5) * filling.theta_step + filling.theta_begin;
    let phi = (F(columns) + 0.5) * filling.phi_step + filling.phi_begin;
    let x = sin(theta) * cos(phi);
    let y = sin(theta) * sin(phi);
    let z = cos(theta);
    let direction = F3(
        x * filling.axis_x.x + y * filling.axis_y.x + z * filling.axis_z.x,
        x * filling.axis_x.y + y * filling.axis_y.y + z * filling.axis_z.y,
        x * filling.axis_x.z + y * filling.axis_y.z + z * filling.axis_z.z,
    );
    let hits = closest_hit(Rays(filling.light, direction), F(0.0), select(F(NEVER), F(FAR), wanted));
    let nothing = hits.primitive == U(MISS);
    // Of a traversal that was cut short nothing is known.
    let slots = select(select(hits.slot, U(MISS), nothing), U(UNFILLED), B(cut_short));
    let t = select(hits.t, F(FAR), nothing);
    var ray = 0u;
    loop {
        if of_ray_b(wanted, ray) {
            let row = of_ray_u(rows, ray) - filling.row_begin;
            filled[row * filling.per_row + of_ray_u(columns, ray)] = vec2u(bitcast<u32>(of_ray(t, ray)), of_ray_u(slots, ray));
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    count_view(0u, 0u, nodes_visited, primitives_tested);
}
