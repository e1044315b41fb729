// Microfacets: the GGX distribution of normals with Smith's height-correlated masking (Heitz 2014, "Understanding the
// Masking-Shadowing Function"), equal in all directions.

//! use aims, display, fetch, materials, table

//! if light is paths
const TWO_PI: f32 = 6.2831853;
const INVERSE_PI: f32 = 0.31830989;

// Highlights with a smaller alpha are mirrors.
const LEAST_ALPHA: f32 = 1e-3;

// Reflectance at normal incidence of a clear coat with an index of refraction of 1.5.
const COAT_REFLECTANCE: f32 = 0.04;

// How a surface scatters light, for one direction to the viewer.
struct Lobes {
    diffuse: vec3f,         // albedo of diffuse reflection, below what the highlight lets through
    opacity: f32,           // share of the background that the surface hides
    reflectance: vec3f,     // of the highlight or mirror at normal incidence, with light reflected between facets
    alpha: f32,             // width of the highlight
    grazing: vec3f,         // what the reflectance gains towards grazing angles
    glossy: f32,            // brightness of the highlight, mirror or glass under a white sky
    transmission: vec3f,    // share of the light that enters glass and is transmitted
    index: f32,             // index of refraction of glass
    is_glass: bool,
    is_thin: bool,          // whether glass does not refract
    is_fresnel: bool,       // whether glass splits light by the angle
    coat: f32,              // share of the surface under a clear coat
    coat_alpha: f32,        // width of the coat's highlight
    coat_chance: f32,       // share of the coat in `glossy`
    coat_normal: vec3f,     // unit; normal textures do not turn it
}

// Returns the alpha of a surface's highlight. It is 0 for mirrors, glass and veils, and 1 for matte surfaces.
fn lobe_width(lobes: Lobes) -> f32 {
    if lobes.opacity < 1.0 || lobes.is_glass { return 0.0; }
    let alpha = select(lobes.alpha, min(lobes.alpha, lobes.coat_alpha), lobes.coat > 0.0);
    return select(1.0, clamp(alpha, 0.0, 1.0), lobes.glossy > 0.0);
}

// Returns Phong's exponent as the alpha of a lobe of about the same width (Walter et al. 2007, "Microfacet Models for
// Refraction through Rough Surfaces", section 5.2).
fn alpha_of_exponent(exponent: f32) -> f32 { return sqrt(2.0 / (phong_exponent(exponent) + 2.0)); }

// Returns the lobes of a surface with this albedo, seen at an angle of this cosine.
fn lobes_of(material: Material, albedo: vec3f, cosine: f32) -> Lobes {
    var lobes: Lobes;
    lobes.diffuse = albedo;
    lobes.opacity = 1.0;
    if MATERIAL_TEXELS == 1u { return lobes; }
    lobes.opacity = material.opacity;
    if material.kind == GLASS {
        lobes.reflectance = material.specular;
        lobes.is_fresnel = material.fresnel;
        lobes.is_glass = true;
        lobes.transmission = material.transmission;
        lobes.index = material.index;
        lobes.glossy = 1.0;
        return lobes;
    }
    let facing = clamp(cosine, 0.0, 1.0);
    if material.kind == MIRROR {
        let mirror = material.specular;
        if material.fresnel { return with_highlights(lobes, mirror, 1.0, mirror, 0.0, 0.0, facing); }
        lobes.reflectance = material.specular;
        lobes.glossy = luminance(material.specular);
        return lobes;
    }
    if all(material.specular == vec3f(0.0)) { return lobes; }
    // Highlights that do not conserve energy may have more.
    let specular = min(material.specular, vec3f(1.0));
    return with_highlights(lobes, specular, 1.0, specular, 0.0, alpha_of_exponent(material.exponent), facing);
}

// Reflectance at normal incidence and what it gains towards grazing angles, by Schlick's approximation. The factor is
// that of light reflected between facets (Turquin 2019, "Practical Multiple Scattering Compensation for Microfacet
// Models"); `lost` is the share that one reflection loses over the share that it does not. `edge` is the reflectance at
// grazing angles.
struct Schlick {
    plain: vec3f,
    grazing: vec3f,
}

fn schlick_of(reflectance: vec3f, edge: vec3f, lost: f32) -> Schlick {
    let gain = 1.0 + reflectance * lost;
    return Schlick(reflectance * gain, (edge - reflectance) * gain);
}

// Adds the highlights of a dielectric, which lies above diffuse reflection, and of a metal. Their reflectances are
// those at normal incidence; `edge` is a dielectric's at grazing angles.
fn with_highlights(
    before: Lobes,
    dielectric: vec3f,
    edge: f32,
    metal: vec3f,
    metallic: f32,
    alpha: f32,
    facing: f32,
) -> Lobes {
    var lobes = before;
    lobes.alpha = alpha;
    let shares = highlight_shares(alpha, facing);
    let lost = 1.0 / (shares.x + shares.y) - 1.0;
    let above = schlick_of(dielectric, max(vec3f(edge), dielectric), lost);
    let bare = schlick_of(metal, vec3f(1.0), lost);
    lobes.reflectance = mix(above.plain, bare.plain, metallic);
    lobes.grazing = mix(above.grazing, bare.grazing, metallic);
    lobes.glossy = luminance(lobes.reflectance * (shares.x + shares.y) + lobes.grazing * shares.y);
    lobes.diffuse *= 1.0 - (above.plain * (shares.x + shares.y) + above.grazing * shares.y);
    return lobes;
}

// Returns the shares of `reflected_shares`, or those of a mirror.
fn highlight_shares(alpha: f32, facing: f32) -> vec2f {
    if alpha > LEAST_ALPHA { return reflected_shares(alpha, facing); }
    return vec2f(1.0 - pow(1.0 - facing, 5.0), pow(1.0 - facing, 5.0));
}

// Adds a clear coat of this share and alpha. What it reflects does not reach the surface below.
fn with_coat(before: Lobes, share: f32, alpha: f32, normal: vec3f, to_viewer: vec3f) -> Lobes {
    var lobes = before;
    if share <= 0.0 || lobes.is_glass { return lobes; }
    let facing = clamp(dot(normal, to_viewer), 0.0, 1.0);
    lobes.coat_normal = normal;
    let shares = highlight_shares(alpha, facing);
    let reflected = share * (COAT_REFLECTANCE * shares.x + shares.y);
    lobes.coat = share;
    lobes.coat_alpha = alpha;
    lobes.diffuse *= 1.0 - reflected;
    lobes.reflectance *= 1.0 - reflected;
    lobes.grazing *= 1.0 - reflected;
    lobes.glossy = lobes.glossy * (1.0 - reflected) + reflected;
    lobes.coat_chance = reflected / max(lobes.glossy, 1e-30);
    return lobes;
}

// Returns the coat's reflectance for the cosine of the angle to a facet's normal.
fn coat_schlick(lobes: Lobes, cosine: f32) -> f32 {
    return lobes.coat * (COAT_REFLECTANCE + (1.0 - COAT_REFLECTANCE) * pow(1.0 - cosine, 5.0));
}

// Returns the probability that a path follows the highlight, mirror or glass rather than diffuse reflection.
fn glossy_chance(lobes: Lobes) -> f32 {
    return lobes.glossy / max(lobes.glossy + luminance(lobes.diffuse), 1e-30);
}

// Returns the reflectance for the cosine of the angle to a facet's normal.
fn schlick(lobes: Lobes, cosine: f32) -> vec3f {
    return lobes.reflectance + lobes.grazing * pow(1.0 - cosine, 5.0);
}

// Returns the share of light that smooth glass reflects, for the index on the viewer's side over that on the other.
fn glass_share(eta: f32, cosine: f32) -> f32 {
    let squared = 1.0 - eta * eta * (1.0 - cosine * cosine);
    if squared <= 0.0 { return 1.0; }
    return fresnel(cosine, sqrt(squared), eta);
}

// Returns the density of facets whose normals have this cosine with the surface's normal.
fn facet_density(alpha: f32, upright: f32) -> f32 {
    let squared = alpha * alpha;
    let d = (upright * upright) * (squared - 1.0) + 1.0;
    return squared * INVERSE_PI / max(d * d, 1e-30);
}

// Returns the share of facets that both directions see, over four times both cosines.
fn facet_visibility(alpha: f32, to_light: f32, to_viewer: f32) -> f32 {
    let squared = alpha * alpha;
    let a = to_light * sqrt(to_viewer * to_viewer * (1.0 - squared) + squared);
    let b = to_viewer * sqrt(to_light * to_light * (1.0 - squared) + squared);
    return 0.5 / max(a + b, 1e-30);
}

// Reflected directions are chosen by the facets that the viewer sees, among those that reflect upwards (Eto and
// Tokuyoshi 2023, "Bounded VNDF Sampling for Smith-GGX Reflections"). Equations 5 and 6 bound the cosine.
fn bound_of(alpha: f32, to_viewer: f32) -> f32 {
    let scale = 1.0 + sqrt(max(1.0 - to_viewer * to_viewer, 0.0));
    let squared = alpha * alpha;
    let limit = scale * scale;
    return (1.0 - squared) * limit / (limit + squared * to_viewer * to_viewer);
}

// Returns a direction's density over the density of its facets.
fn bounded_density(alpha: f32, to_viewer: f32) -> f32 {
    let sine = alpha * alpha * max(1.0 - to_viewer * to_viewer, 0.0);
    return 0.5 / (bound_of(alpha, to_viewer) * to_viewer + sqrt(sine + to_viewer * to_viewer));
}

// Chooses a facet that the viewer sees, by a point in the unit square. `facing` is the cosine of the viewer's angle to
// the normal. `bound` is the result of bound_of, or 1 for facets that need not reflect upwards.
fn facet_towards(normal: vec3f, to_viewer: vec3f, facing: f32, alpha: f32, bound: f32, at: vec2f) -> vec3f {
    let sides = across(normal);
    let seen = normalize(vec3f(dot(to_viewer, sides[0]), dot(to_viewer, sides[1]), facing));
    let stretched = normalize(vec3f(seen.xy * alpha, seen.z));
    let lowest = bound * stretched.z;
    let z = (1.0 - at.x) * (1.0 + lowest) - lowest;
    let aside = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    let turn = TWO_PI * at.y;
    let summed = stretched + vec3f(aside * cos(turn), aside * sin(turn), z);
    let facet = normalize(vec3f(summed.xy * alpha, max(summed.z, 1e-6)));
    return sides[0] * facet.x + sides[1] * facet.y + normal * facet.z;
}

// Returns the share of facets that a direction sees, among those that face it.
fn facets_seen(alpha: f32, cosine: f32) -> f32 {
    let squared = cosine * cosine;
    return 2.0 / (1.0 + sqrt(1.0 + alpha * alpha * max(1.0 - squared, 0.0) / max(squared, 1e-12)));
}

// Number of cosines, and of roughnesses, in the table of reflected shares.
const SHARES_SIDE: u32 = 32u;

// Returns the share of a white sky's light that facets reflect to the viewer: the factor of the reflectance at normal
// incidence, and the part that does not depend on it. The table (src/accel/facets.rs) is bilinear in the cosine and in
// the square root of alpha.
fn reflected_shares(alpha: f32, cosine: f32) -> vec2f {
    let first = table_texel(table_texel(FOR_PATHS).w).x;
    let place = clamp(vec2f(cosine, sqrt(alpha)), vec2f(0.0), vec2f(1.0)) * f32(SHARES_SIDE - 1u);
    let corner = min(vec2u(place), vec2u(SHARES_SIDE - 2u));
    let way = place - vec2f(corner);
    // A texel holds the shares of two neighbouring cosines.
    let low = bitcast<vec4f>(table_texel(first + corner.y * SHARES_SIDE + corner.x));
    let high = bitcast<vec4f>(table_texel(first + (corner.y + 1u) * SHARES_SIDE + corner.x));
    let both = mix(low, high, way.y);
    return mix(both.xy, both.zw, way.x);
}

//! end
// Returns the share of unpolarised light that glass reflects, by Fresnel's equations for the cosines on both sides.
fn fresnel(cosine: f32, inner: f32, eta: f32) -> f32 {
    let across = (eta * cosine - inner) / (eta * cosine + inner);
    let along_plane = (cosine - eta * inner) / (cosine + eta * inner);
    return 0.5 * (across * across + along_plane * along_plane);
}
