// CwBvh, after Ylitie, Karras & Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs",
// in obvhs's format: eight children a node, 8-bit boxes on a grid of the node's own, 80 bytes = 5 texels:
//
//   0  grid origin; exponents of its x, y, z steps, and a bit for each child that is an inner node
//   1  first child, first slot, then a byte for each child: inner node: 001 and 24 + its place among the eight;
//      leaf: primitives in unary (3 bits) and offset of its first slot (5 bits); empty: 0
//   2  low x of the eight children, high x; 3 and 4 the same for y and z
//
// A group is (first child or slot, bits): inner nodes in bits 24 to 31 in the order of the ray's octant, the highest to
// be visited first, above the node's inner-node bits; or primitives in bits 0 to 23.

const INNER: u32 = 0xff000000u;

fn four_bytes(word: u32) -> vec4f {
    return vec4f((vec4u(word) >> vec4u(0u, 8u, 16u, 24u)) & vec4u(255u));
}

// The near and far planes of four children on an axis, in t.
fn planes(word: u32, step: f32, offset: f32) -> vec4f {
    return four_bytes(word) * step + offset;
}

// The bits that four children raise in the group when their boxes are entered.
fn child_bits(meta_word: u32, octant: u32, entered: vec4<bool>) -> u32 {
    let inner = ((meta_word & (meta_word << 1u) & 0x10101010u) >> 4u) * 0xffu;
    let shifts = vec4u(0u, 8u, 16u, 24u);
    let place = (vec4u(meta_word ^ (octant & inner)) >> shifts) & vec4u(31u);
    let bits = (vec4u(meta_word) >> (shifts + vec4u(5u))) & vec4u(7u);
    let raised = select(vec4u(0u), bits << place, entered);
    return raised.x | raised.y | raised.z | raised.w;
}

fn trace(ray: Ray) -> Hit {
    let sheared = shear(ray);
    let inverse = 1.0 / select(ray.direction, vec3f(1e-30), abs(ray.direction) < vec3f(1e-30));
    let reach = abs(bvh.grid_origin - ray.origin);
    let slack = (bvh.extent + max(max(reach.x, reach.y), reach.z)) * (1.0 / 2097152.0);
    let widen = slack * abs(inverse);
    let backwards = inverse < vec3f(0.0);
    let towards = select(vec3u(0x04040404u, 0x02020202u, 0x01010101u), vec3u(0u), backwards);
    let octant = towards.x | towards.y | towards.z;

    var hit = Hit(FAR, MISS, 0u);
    var stack: array<vec2u, STACK_SIZE>;
    stack[0] = vec2u(0u);
    var top = 0;
    var nodes_left = vec2u(0u, 0x80000000u);
    var slots_left = vec2u(0u);
    loop {
        // Down, until a leaf is entered or nothing is left.
        loop {
            if COUNT { nodes_visited += 1u; }
            let bit = firstLeadingBit(nodes_left.y);
            let place = (bit - 24u) ^ (octant & 7u);
            let before = countOneBits(nodes_left.y & ~(0xffffffffu << place));
            let node = 5u * (nodes_left.x + before);
            nodes_left.y &= ~(1u << bit);
            if (nodes_left.y & INNER) != 0u {
                top += 1;
                stack[top] = nodes_left;
            }
            let grid = node_texel(node);
            let links = node_texel(node + 1u);
            let x = node_texel(node + 2u);
            let y = node_texel(node + 3u);
            let z = node_texel(node + 4u);
            let cell = bitcast<vec3f>(((vec3u(grid.w) >> vec3u(0u, 8u, 16u)) & vec3u(255u)) << vec3u(23u));
            let step = cell * inverse;
            let offset = (bitcast<vec3f>(grid.xyz) - ray.origin) * inverse;
            let near = offset - widen;
            let far = offset + widen;
            let near_x = select(x.xy, x.zw, backwards.x);
            let near_y = select(y.xy, y.zw, backwards.y);
            let near_z = select(z.xy, z.zw, backwards.z);
            let far_x = select(x.zw, x.xy, backwards.x);
            let far_y = select(y.zw, y.xy, backwards.y);
            let far_z = select(z.zw, z.xy, backwards.z);
            let entry_a = max(max(planes(near_x.x, step.x, near.x), planes(near_y.x, step.y, near.y)),
                max(planes(near_z.x, step.z, near.z), vec4f(0.0)));
            let entry_b = max(max(planes(near_x.y, step.x, near.x), planes(near_y.y, step.y, near.y)),
                max(planes(near_z.y, step.z, near.z), vec4f(0.0)));
            let exit_a = min(min(planes(far_x.x, step.x, far.x), planes(far_y.x, step.y, far.y)),
                min(planes(far_z.x, step.z, far.z), vec4f(hit.t)));
            let exit_b = min(min(planes(far_x.y, step.x, far.x), planes(far_y.y, step.y, far.y)),
                min(planes(far_z.y, step.z, far.z), vec4f(hit.t)));
            let bits = child_bits(links.z, octant, entry_a <= exit_a * BOX_MARGIN)
                | child_bits(links.w, octant, entry_b <= exit_b * BOX_MARGIN);
            nodes_left = vec2u(links.x, (bits & INNER) | (grid.w >> 24u));
            slots_left = vec2u(links.y, bits & ~INNER);
            if bits == 0u {
                nodes_left = stack[top];
                top -= 1;
            }
            if slots_left.y != 0u || nodes_left.y == 0u { break; }
        }
        if slots_left.y == 0u { break; }
        // Across: the primitives of all leaves of this node that were entered.
        loop {
            if COUNT { primitives_tested += 1u; }
            let bit = firstLeadingBit(slots_left.y);
            slots_left.y &= ~(1u << bit);
            let slot = slots_left.x + bit;
            let candidate = intersect_primitive(slot, sheared, 0.0);
            let nearer = candidate.t < hit.t || (candidate.t == hit.t && candidate.primitive < hit.primitive);
            if candidate.t >= 0.0 && nearer {
                hit = Hit(candidate.t, candidate.primitive, slot);
            }
            if slots_left.y == 0u { break; }
        }
        if (nodes_left.y & INNER) == 0u {
            nodes_left = stack[top];
            top -= 1;
        }
        if nodes_left.y == 0u { break; }
    }
    return hit;
}
