// Scattering of light at the vertices of paths: diffuse reflection, highlights, mirrors, glass and veils. DESIGN
// (section 3) has the formulas.

//! use aims, dice, display, facets, lane, light, looks, materials, planes, primitive, primitives, rays, reflectance
//! use surfaces

//! if light is paths
// A point where a path meets a surface.
struct Vertex {
    point: vec3f,
    offset: f32,               // distance from the surface at which rays begin
    to_viewer: vec3f,          // unit
    from_outside: bool,
    geometric_normal: vec3f,   // unit, on the viewer's side
    normal: vec3f,             // unit, for shading
    emission: vec3f,
    left: vec3f,               // share of light per world unit that the inside lets pass, if the viewer is inside
    is_chosen: bool,           // whether it is on a primitive that is chosen as a light source
    outward: vec3f,            // unit, from a sphere's centre
    radius: f32,               // of a sphere, or 0
    lobes: Lobes,
}

fn vertex_at(rays: Rays, hits: Hits) -> Vertex {
    let surface = surface_at(rays, hits, 0u);
    let material = material_at(surface.material);
    let direction = of_ray3(rays.direction, 0u);
    let to_viewer = -normalize(direction);
    let point = rays.origin + direction * of_ray(hits.t, 0u);
    let factor = texture_factor(rays, hits, surface, material.texture, 0u);
    let look = look_at(rays, hits, surface, material, factor, 0u);
    return Vertex(
        point,
        off_surface(point, rays.origin, surface.reach),
        to_viewer,
        surface.from_outside,
        surface.geometric_normal,
        look.normal,
        look.emission,
        look.left,
        material.is_chosen && can_be_chosen(surface, of_ray_u(hits.slot, 0u)),
        surface.outward,
        surface.radius,
        look.lobes,
    );
}

//! if light is paths and planes is none and texels is corners or spheres
fn can_be_chosen(surface: Surface, slot: u32) -> bool { return true; }

//! if light is paths and planes is none and texels is ellipsoids
fn can_be_chosen(surface: Surface, slot: u32) -> bool { return (surface.component & IS_SPHERE) == 0u; }

//! if light is paths and planes is some and texels is corners or spheres
fn can_be_chosen(surface: Surface, slot: u32) -> bool { return slot >= PLANES; }

//! if light is paths and planes is some and texels is ellipsoids
fn can_be_chosen(surface: Surface, slot: u32) -> bool {
    return slot >= PLANES && (surface.component & IS_SPHERE) == 0u;
}

//! if light is paths
// Returns the origin of a ray that leaves a vertex, on the viewer's side of the surface (1) or on the other side (-1).
fn leaving(vertex: Vertex, side: f32) -> vec3f {
    return vertex.point + vertex.geometric_normal * (side * vertex.offset);
}

// Reflectance times cosine for one direction of light, and the densities per steradian with which `scattered` chooses
// this direction in either lobe.
struct Reflected {
    glossy: vec3f,
    diffuse: f32,           // for an albedo of 1
    diffuse_density: f32,
    glossy_density: f32,
}

fn reflectance_of(vertex: Vertex, to_light: vec3f) -> Reflected {
    var result: Reflected;
    if dot(vertex.geometric_normal, to_light) <= 0.0 { return result; }
    let lobes = vertex.lobes;
    let chance = glossy_chance(lobes);
    let cosine = dot(vertex.normal, to_light);
    if cosine > 0.0 {
        result.diffuse = cosine * INVERSE_PI;
        result.diffuse_density = (1.0 - chance) * lobes.opacity * result.diffuse;
        if lobes.alpha > LEAST_ALPHA && !lobes.is_glass {
            let facets = reflected_by_facets(lobes.alpha, vertex.normal, vertex.to_viewer, to_light);
            result.glossy = schlick(lobes, facets.aside) * facets.share;
            result.glossy_density = chance * (1.0 - lobes.coat_chance) * lobes.opacity * facets.density;
        }
    }
    if COATS && lobes.coat_alpha > LEAST_ALPHA && dot(lobes.coat_normal, to_light) > 0.0 {
        let facets = reflected_by_facets(lobes.coat_alpha, lobes.coat_normal, vertex.to_viewer, to_light);
        result.glossy += coat_schlick(lobes, facets.aside) * facets.share;
        result.glossy_density += chance * lobes.coat_chance * lobes.opacity * facets.density;
    }
    return result;
}

// Light that facets of reflectance 1 reflect to the viewer from one direction.
struct FacetLight {
    share: f32,     // reflectance times cosine
    density: f32,   // of the direction, per steradian
    aside: f32,     // cosine of the angle between the direction and the facet
}

fn reflected_by_facets(alpha: f32, normal: vec3f, to_viewer: vec3f, to_light: vec3f) -> FacetLight {
    let cosine = dot(normal, to_light);
    let facing = max(dot(normal, to_viewer), 1e-4);
    let half_way = normalize(to_light + to_viewer);
    let facets = facet_density(alpha, clamp(dot(half_way, normal), 0.0, 1.0));
    return FacetLight(
        facets * facet_visibility(alpha, cosine, facing) * cosine,
        facets * bounded_density(alpha, facing),
        clamp(dot(half_way, to_light), 0.0, 1.0),
    );
}

// The way of a path from a vertex to the next.
struct Scattered {
    direction: vec3f,   // unit
    side: f32,          // 1 on the viewer's side of the surface, -1 on the other side, 0 if the path ends
    weight: vec3f,      // reflectance times cosine over density; diffuse reflection is for an albedo of 1
    density: f32,       // density of the direction per steradian, in this lobe; 0 for a single direction
    is_diffuse: bool,
}

// Chooses a lobe by `choice`, in [0, 1), and a direction by a point in the unit square.
fn scattered(vertex: Vertex, choice: f32, at: vec2f) -> Scattered {
    let lobes = vertex.lobes;
    var result: Scattered;
    if choice >= lobes.opacity {
        // The ray goes straight through a veil.
        result.direction = -vertex.to_viewer;
        result.side = -1.0;
        result.weight = vec3f(1.0);
        return result;
    }
    let chosen = choice / lobes.opacity;
    let chance = glossy_chance(lobes);
    if chosen >= chance && chance < 1.0 {
        let sides = across(vertex.normal);
        let turn = TWO_PI * at.y;
        let aside = (sides[0] * cos(turn) + sides[1] * sin(turn)) * sqrt(at.x);
        result.direction = normalize(vertex.normal * sqrt(max(1.0 - at.x, 0.0)) + aside);
        result.side = select(0.0, 1.0, dot(vertex.geometric_normal, result.direction) > 0.0);
        result.weight = vec3f(1.0 / (1.0 - chance));
        result.density = (1.0 - chance) * lobes.opacity * max(dot(vertex.normal, result.direction), 0.0) * INVERSE_PI;
        result.is_diffuse = true;
        return result;
    }
    if lobes.is_glass {
        result = through_glass(vertex, chosen / chance, at);
        result.weight /= chance;
        return result;
    }
    let in_coat = COATS && chosen < chance * lobes.coat_chance;
    let normal = select(vertex.normal, lobes.coat_normal, in_coat);
    let alpha = select(lobes.alpha, lobes.coat_alpha, in_coat);
    if alpha <= LEAST_ALPHA {
        let cosine = dot(normal, vertex.to_viewer);
        let mirrored = normal * (2.0 * cosine) - vertex.to_viewer;
        result.direction = normalize(kept_above(mirrored, vertex.geometric_normal));
        result.side = 1.0;
        let upright = clamp(cosine, 0.0, 1.0);
        result.weight = select(schlick(lobes, upright), vec3f(coat_schlick(lobes, upright)), in_coat);
        result.weight /= chance * select(1.0 - lobes.coat_chance, lobes.coat_chance, in_coat);
    } else {
        let facing = max(dot(normal, vertex.to_viewer), 1e-4);
        let bound = bound_of(alpha, facing);
        let facet = facet_towards(normal, vertex.to_viewer, facing, alpha, bound, at);
        result.direction = normalize(facet * (2.0 * dot(vertex.to_viewer, facet)) - vertex.to_viewer);
        let there = reflectance_of(vertex, result.direction);
        result.density = there.glossy_density;
        result.side = select(0.0, 1.0, there.glossy_density > 0.0);
        result.weight = there.glossy * (lobes.opacity / max(there.glossy_density, 1e-30));
    }
    return result;
}

// Light that glass reflects and transmits from the direction to the viewer.
struct Split {
    back: vec3f,
    passed: vec3f,
    ahead: vec3f,    // direction of the transmitted ray, unit
}

// Splits light at glass or at a facet of it with this normal. `from_outside` says on which side the viewer is.
fn split_by_glass(vertex: Vertex, normal: vec3f, to_viewer: vec3f, from_outside: bool) -> Split {
    let lobes = vertex.lobes;
    let cosine = clamp(dot(normal, to_viewer), 0.0, 1.0);
    // Snell's law: eta is the index on the ray's side over the index on the other side.
    let eta = select(lobes.index, 1.0 / lobes.index, from_outside || lobes.is_thin);
    let squared = 1.0 - eta * eta * (1.0 - cosine * cosine);
    if squared <= 0.0 { return Split(vec3f(1.0), vec3f(0.0), to_viewer); }
    let inner = sqrt(squared);
    var ahead = normalize(normal * (eta * cosine - inner) - to_viewer * eta);
    if lobes.is_thin {
        let mirrored = normal * (2.0 * cosine) - to_viewer;
        ahead = mirrored - vertex.normal * (2.0 * dot(mirrored, vertex.normal));
    }
    if !lobes.is_fresnel {
        return Split(lobes.reflectance, lobes.transmission * (1.0 - lobes.reflectance), ahead);
    }
    let share = fresnel(cosine, inner, eta);
    return Split(lobes.reflectance * share, lobes.transmission * (1.0 - share), ahead);
}

// Chooses between reflection and refraction at glass or at a facet of it.
fn past_glass(vertex: Vertex, normal: vec3f, to_viewer: vec3f, from_outside: bool, choice: f32) -> Scattered {
    let split = split_by_glass(vertex, normal, to_viewer, from_outside);
    let chance = luminance(split.back) / max(luminance(split.back) + luminance(split.passed), 1e-30);
    var result: Scattered;
    if choice < chance {
        result.direction = normal * (2.0 * dot(normal, to_viewer)) - to_viewer;
        result.side = 1.0;
        result.weight = split.back / chance;
    } else {
        result.direction = split.ahead;
        result.side = -1.0;
        result.weight = split.passed / max(1.0 - chance, 1e-30);
    }
    return result;
}

// Chooses the way of light at glass. Light that rough glass sends on is found by chance alone.
fn through_glass(vertex: Vertex, choice: f32, at: vec2f) -> Scattered {
    if vertex.lobes.alpha > LEAST_ALPHA { return through_facets(vertex, choice, at); }
    var result = past_glass(vertex, vertex.normal, vertex.to_viewer, vertex.from_outside, choice);
    if result.side > 0.0 { result.direction = normalize(kept_above(result.direction, vertex.geometric_normal)); }
    return result;
}

// Maximum number of facets of rough glass that light meets before it leaves.
const MOST_FACETS: u32 = 16u;

// Follows light from facet to facet of rough glass, until it leaves (after Heitz et al. 2016, "Multiple-Scattering
// Microfacet BSDFs with the Smith Model", but without heights). So no light is lost between facets.
fn through_facets(vertex: Vertex, first_choice: f32, first_at: vec2f) -> Scattered {
    let alpha = vertex.lobes.alpha;
    var words = bitcast<vec3u>(vec3f(first_at, first_choice));
    var choice = first_choice;
    var at = first_at;
    var side = 1.0;
    var to_viewer = vertex.to_viewer;
    var facing = max(dot(to_viewer, vertex.normal), 1e-4);
    var weight = vec3f(1.0);
    var result: Scattered;
    var facets = 0u;
    loop {
        let normal = vertex.normal * side;
        let facet = facet_towards(normal, to_viewer, facing, alpha, 1.0, at);
        let way = past_glass(vertex, facet, to_viewer, vertex.from_outside == (side > 0.0), choice);
        weight *= way.weight;
        side *= way.side;
        words = scrambled(words);
        let chances = vec3f(words >> vec3u(8u)) / 16777216.0;
        let is_outside = dot(vertex.geometric_normal, way.direction) * side > 0.0;
        let upright = dot(vertex.normal, way.direction) * side;
        if is_outside && upright > 0.0 && chances.x < facets_seen(alpha, upright) {
            result.direction = normalize(way.direction);
            result.side = side;
            result.weight = weight;
            break;
        }
        facets += 1u;
        if facets >= MOST_FACETS { break; }
        // Light that goes up and does not leave meets facets from below.
        to_viewer = -normalize(way.direction);
        facing = dot(to_viewer, vertex.normal) * side;
        at = chances.yz;
        words = scrambled(words);
        choice = f32(words.x >> 8u) / 16777216.0;
    }
    return result;
}
