// Bvh2 as obvhs has it: 32 bytes a node, f32 boxes, siblings side by side. The loops are those of shared/bvh.wgsl.

// Node: min, primitive count (0: inner), max, index of the first child or slot. Links as in shared/bvh.wgsl, made here.
fn node_link(low: vec4u, high: vec4u) -> u32 {
    return select(LEAF | ((low.w - 1u) << 28u) | high.w, high.w, low.w == 0u);
}

fn f32_box_entry(low: vec4u, high: vec4u, past: vec3f, before: vec3f, inverse: vec3f, t_best: f32) -> f32 {
    let t_low = (bitcast<vec3f>(low.xyz) - past) * inverse;
    let t_high = (bitcast<vec3f>(high.xyz) - before) * inverse;
    let near = min(t_low, t_high);
    let far = max(t_low, t_high);
    let entry = max(max(near.x, near.y), max(near.z, 0.0));
    let exit = min(min(far.x, far.y), min(far.z, t_best));
    return select(NO_ENTRY, entry, entry <= exit * BOX_MARGIN);
}

fn trace(ray: Ray) -> Hit {
    let sheared = shear(ray);
    let inverse = 1.0 / select(ray.direction, vec3f(1e-30), abs(ray.direction) < vec3f(1e-30));
    let reach = abs(bvh.grid_origin - ray.origin) + abs(ray.origin);
    let slack = (bvh.extent + max(max(reach.x, reach.y), reach.z)) * (1.0 / 2097152.0);
    let past = ray.origin + slack;
    let before = ray.origin - slack;

    var hit = Hit(FAR, MISS, 0u);
    var stack: array<u32, STACK_SIZE>;
    stack[0] = DONE;
    var top = 0;
    var link = node_texel(1u).w;
    loop {
        loop {
            if COUNT { nodes_visited += 1u; }
            let a_low = node_texel(2u * link);
            let a_high = node_texel(2u * link + 1u);
            let b_low = node_texel(2u * link + 2u);
            let b_high = node_texel(2u * link + 3u);
            let entry_a = f32_box_entry(a_low, a_high, past, before, inverse, hit.t);
            let entry_b = f32_box_entry(b_low, b_high, past, before, inverse, hit.t);
            let a_link = node_link(a_low, a_high);
            let b_link = node_link(b_low, b_high);
            let a_first = entry_a <= entry_b;
            if max(entry_a, entry_b) < NO_ENTRY {
                top += 1;
                stack[top] = select(a_link, b_link, a_first);
            }
            if min(entry_a, entry_b) < NO_ENTRY {
                link = select(b_link, a_link, a_first);
            } else {
                link = stack[top];
                top -= 1;
            }
            if (link & LEAF) != 0u { break; }
        }
        if link == DONE { break; }
        var slot = link & FIRST_SLOT;
        var last = slot + ((link >> 28u) & 7u);
        loop {
            if COUNT { primitives_tested += 1u; }
            let candidate = intersect_primitive(slot, sheared, 0.0);
            let nearer = candidate.t < hit.t || (candidate.t == hit.t && candidate.primitive < hit.primitive);
            if candidate.t >= 0.0 && nearer {
                hit = Hit(candidate.t, candidate.primitive, slot);
            }
            slot += 1u;
            if slot > last {
                link = stack[top];
                top -= 1;
                slot = link & FIRST_SLOT;
                last = slot + ((link >> 28u) & 7u);
            }
            if (link & LEAF) == 0u || link == DONE { break; }
        }
        if link == DONE { break; }
    }
    return hit;
}
