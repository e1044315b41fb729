// Traversal of the BVH. closest_hit and any_hit share one loop, and every ray uses it.
//
// The rays of a lane have a common origin and share a stack: if one ray must visit a node, all rays test it. A node is
// a pair of child boxes, each with a link. A link with LEAF set is a run of 1 to 8 primitives. It holds (count - 1) in
// bits 28 to 30, and the first slot in the bits below. Other links are indices of pairs. The root is pair 0.

//! use boxes, counters, cutouts, fetch, in_steps, lane, pixels, primitive, primitives, rays, stack

//! if tracing is kernels
fn traverse(rays: Rays, t_min: F, t_max: F, any_is_enough: bool) -> Hits {
    let scales = scales_of(rays);
    let direction = rays.direction;
    let inverse = F3(reciprocal(direction.x), reciprocal(direction.y), reciprocal(direction.z));
    let offsets = offsets_from(rays.origin);

    var hits = Hits(t_max, U(MISS), select(U(0u), U(MISS), any_is_enough));
    var stack: Stack;
    clear(&stack);
    var link = 0u;
    resume(&hits, &stack, &link);
    var slot: u32;
    var last: u32;
    // Boxes that begin beyond this t are skipped.
    var reach = hits.t;
    // Primitives with an uncertain test are deferred. They are few, and handling them in these loops would slow down
    // all rays of a software adapter's vector.
    var put_off = PutOff();
    loop {
        // Both inner loops test their condition at the end, since software adapters run the body once in any case.
        loop {
            // Descends: follows the nearer child and pushes the farther one. If both boxes are missed, pops a link.
            loop {
                if COUNT { nodes_visited += 1u; }
                let place = pair_place(link);
                let a = child_at(place, 0u, offsets);
                let b = child_at(place, 1u, offsets);
                let entry_a = box_entry(a, inverse, t_min, reach);
                let entry_b = box_entry(b, inverse, t_min, reach);
                let a_first = entry_a <= entry_b;
                let both = max(entry_a, entry_b) < NO_ENTRY;
                let nearer = select(b.link, a.link, a_first);
                let farther = select(a.link, b.link, a_first);
                if is_climbing(&stack) {
                    link = climb(&stack, link, nearer, farther, both);
                } else {
                    visit(&stack, link);
                    if both { push(&stack, farther); }
                    if min(entry_a, entry_b) < NO_ENTRY { link = nearer; } else { link = pop(&stack); }
                }
                spend_round();
                if (link & LEAF) != 0u || is_tired() { break; }
            }
            if link == DONE || is_step_over(link) { break; }
            // Tests the primitives of this leaf and of the leaves on top of the stack.
            slot = link & FIRST_SLOT;
            last = slot + ((link >> 28u) & 7u);
            loop {
                if COUNT { primitives_tested += 1u; }
                spend_round();
                let primitive = primitive_at(slot);
                let found = intersect(primitive, rays, scales, t_min);
                if any_is_enough {
                    let hit = found.hit & (found.t >= t_min) & (found.t <= hits.t);
                    hits.t = select(hits.t, F(NEVER), hit);
                    hits.slot = select(hits.slot, U(slot), hit);
                } else {
                    let hit = found.hit & is_nearer(hits, found.t, t_min, primitive.id);
                    hits.t = select(hits.t, found.t, hit);
                    hits.primitive = select(hits.primitive, U(primitive.id), hit);
                    hits.slot = select(hits.slot, U(slot), hit);
                }
                let doubted = bits_of(found.doubtful);
                if is_too_many(put_off, doubted) { break; }
                put_off = put_off_also(put_off, slot, doubted);
                slot += 1u;
                if slot > last {
                    link = pop(&stack);
                    slot = link & FIRST_SLOT;
                    last = slot + ((link >> 28u) & 7u);
                }
                if any_is_enough && all_rays(hits.t == F(NEVER)) { link = DONE; }
                if (link & LEAF) == 0u || link == DONE { break; }
            }
            reach = hits.t;
            if (link & LEAF) != 0u || is_tired() { break; }
        }
        let waiting = (link & LEAF) != 0u && link != DONE;
        hits = settled(hits, rays, t_min, put_off, any_is_enough);
        put_off = PutOff();
        if !waiting { break; }
        // Pushes the rest of the leaf onto the stack. The next round visits the root, misses its boxes and pops the
        // rest of the leaf.
        push(&stack, LEAF | ((last - slot) << 28u) | slot);
        link = 0u;
        reach = F(NEVER);
        // The visit of the root and the repeated primitive test are not counted.
        if COUNT {
            nodes_visited -= 1u;
            primitives_tested -= 1u;
        }
    }
    let kept = keep_traversal(hits, &stack, link);
    cut_short |= (link != DONE) & !kept;
    return hits;
}

//! end
// Returns the hits after the second test of the deferred primitives.
fn settled(before: Hits, rays: Rays, t_min: F, put_off: PutOff, any_is_enough: bool) -> Hits {
    var hits = before;
    var left = put_off;
    loop {
        hits = settled_by_one(hits, rays, t_min, left.last, any_is_enough);
        left = PutOff(left.before, 0u);
        if left.last == 0u { break; }
    }
    return hits;
}

// Runs the second test of one deferred primitive, one ray per round.
fn settled_by_one(before: Hits, rays: Rays, t_min: F, doubtful: u32, any_is_enough: bool) -> Hits {
    var hits = before;
    var left = with_bits(doubtful);
    let slot = doubtful >> RAY_BITS;
    let primitive = primitive_at(slot);
    loop {
        let ray = first_ray(left);
        let direction = of_ray3(rays.direction, ray);
        let seen = look_again(primitive, rays.origin, direction, of_ray(t_min, ray));
        let t = at_second_look(primitive, slot, rays.origin, direction, seen);
        let chosen = RAY_INDEX == U(ray);
        let hit = chosen & left & is_nearer(hits, F(t), t_min, primitive.id);
        hits.t = select(hits.t, select(F(t), F(NEVER), any_is_enough), hit);
        hits.primitive = select(hits.primitive, U(primitive.id), hit & B(!any_is_enough));
        hits.slot = select(hits.slot, U(slot), hit);
        left &= !chosen;
        if !any_ray(left) { break; }
    }
    return hits;
}

//! if planes is none
// Returns the slot of any primitive with a hit in [t_min, t_max], or MISS. Scenes with planes use the version in
// planes.wgsl.
fn any_slot(rays: Rays, t_min: F, t_max: F) -> U {
    return traverse(rays, t_min, t_max, true).slot;
}

//! if primitives is triangles or spheres or mixed and planes is none
// Returns the nearest hits with t in [t_min, t_max]. At equal t the smallest primitive id wins. t_min must be at least
// 0. A ray with t_max NEVER is not traced.
fn closest_hit(rays: Rays, t_min: F, t_max: F) -> Hits {
    return traverse(rays, t_min, t_max, false);
}

// Returns whether each ray hits anything with t in [t_min, t_max]. The conditions of closest_hit apply.
fn any_hit(rays: Rays, t_min: F, t_max: F) -> B {
    return any_slot(rays, t_min, t_max) != U(MISS);
}

//! if primitives is none and planes is none
// This kernel has no traversal, so every ray misses.

fn closest_hit(rays: Rays, t_min: F, t_max: F) -> Hits {
    return Hits(t_max, U(MISS), U(0u));
}

fn any_hit(rays: Rays, t_min: F, t_max: F) -> B {
    return t_max < t_max;
}
