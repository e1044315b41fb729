// Lights (DESIGN, section 3). visibility.wgsl determines which points see a light, and soft.wgsl handles lights other
// than point lights.

//! use aims, counters, fetch, in_steps, lane, light, projectors, reflectance, shadows, soft, table, visibility

//! if lights is some
fn direct_light(surfaces: Surfaces, eye: vec3f) -> Light {
    let point = surfaces.point;
    let reach_x = abs(point.x) * OFFSET_BY_PLACE + abs(point.x - eye.x) * OFFSET_BY_DISTANCE;
    let reach_y = abs(point.y) * OFFSET_BY_PLACE + abs(point.y - eye.y) * OFFSET_BY_DISTANCE;
    let reach_z = abs(point.z) * OFFSET_BY_PLACE + abs(point.z - eye.z) * OFFSET_BY_DISTANCE;
    let reach = max(max(reach_x, reach_y), reach_z);
    let away = max(max(abs(point.x - eye.x), abs(point.y - eye.y)), abs(point.z - eye.z));
    var sum = sum_so_far();
    let light_count = sources_of(table_texel(AMBIENT).w);
    var slot = first_slot();
    var light = first_light();
    loop {
        if light_kind(light) != POINT {
            let soft = soft_light(surfaces, eye, light, slot_of(light, slot));
            sum = Light(add3(sum.diffuse, soft.diffuse), add3(sum.shine, soft.shine));
            slot += 1u;
            light += 1u;
            if light >= light_count { break; }
            continue;
        }
        let position = shading_vector(LIGHTS + LIGHT_TEXELS * light);
        let intensity = shading_vector(LIGHTS + LIGHT_TEXELS * light + 1u);
        let straight = minus3(point, all3(position));
        let way = max(max(abs(straight.x), abs(straight.y)), abs(straight.z));
        var offset = reach + way * OFFSET_BY_LIGHT;
        if CLOSE {
            offset += min(surfaces.reach, max(away, way) * LARGE) * OFFSET_BY_REACH;
        } else {
            offset += surfaces.reach * OFFSET_BY_REACH;
        }
        let aside = times3(surfaces.geometric_normal, offset);
        let from_light = add3(straight, aside);
        let distance = sqrt(dot3(from_light, from_light));
        let direction = times3(from_light, 1.0 / distance);
        let cosine = -dot3(surfaces.shading_normal, direction);
        // Light from behind the triangle itself is excluded, even if a smooth normal faces the light.
        let faces = (cosine > F(0.0)) & (dot3(surfaces.geometric_normal, direction) < F(0.0)) & is_lit_here(surfaces);
        if any_ray(faces) {
            let lit = lit_by(light, faces, ShadowRay(position, add3(point, aside), direction, distance));
            if is_put_off(faces) { break; }
            let arriving = times3(intensities_along(light, intensity, straight), faded_rays(light, straight));
            sum.diffuse = add3(sum.diffuse, times3(arriving, select(F(0.0), cosine, lit)));
            if SHINE {
                let shine = product3(arriving, highlight(surfaces, direction, eye));
                sum.shine = add3(sum.shine, select3(all3(vec3f(0.0)), shine, lit));
            }
        }
        light += 1u;
        spend_round();
        if light >= light_count || is_tired() { break; }
    }
    cut_short |= light < light_count && !keep_lights(sum, light);
    return sum;
}

//! if lights is some and fading is none
fn faded_rays(light: u32, straight: F3) -> F { return F(1.0); }

//! if lights is some and fading is some
// Returns the shares of a point light's intensity that arrive at the points of a lane's rays. `straight` leads from the
// light to the points.
fn faded_rays(light: u32, straight: F3) -> F {
    var shares = F(1.0);
    var ray = 0u;
    loop {
        let to_light = -of_ray3(straight, ray);
        shares = with_ray(shares, ray, faded(light, POINT, to_light, to_light));
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return shares;
}

//! if lights is none
// There is only ambient light.
fn direct_light(surfaces: Surfaces, eye: vec3f) -> Light {
    return no_light();
}
