// Surfaces in the form that lighting needs, light that arrives at them, and shadow rays.

//! use lane, pixels

// Surfaces at the hits of a lane's rays, in the form that lighting needs. Rays that miss have zeros.
struct Surfaces {
    there: B,
    point: F3,
    geometric_normal: F3,   // unit, towards the viewer
    shading_normal: F3,     // unit, on the geometric normal's side
    albedo: F3,
    component: U,
    reach: F,               // for triangles: at least the longest edge, world units
    specular: F3,
    grazing: F3,            // what a highlight by facets adds to `specular` at grazing angles
    exponent: F,            // Phong's exponent, or alpha of facets
    coat: F,                // share of the surface under a clear coat
    coat_alpha: F,          // width of the coat's highlight
    coat_normal: F3,        // unit
    emission: F3,
    sends: U,               // 1 for mirrors, glass and veils, which are shaded later
}

// Light that arrives at points: on a white diffuse surface, and as highlights that the surface reflects to the eye.
struct Light {
    diffuse: F3,
    shine: F3,
}

fn no_light() -> Light { return Light(all3(vec3f(0.0)), all3(vec3f(0.0))); }

//! if lights is some
// Shadow rays from a light to the points that a lane's rays hit.
struct ShadowRay {
    light: vec3f,
    end: F3,
    direction: F3,    // unit, from the light
    distance: F,
}

//! end
// A shadow ray ends at a small offset from the surface. The offset is the sum of these fractions of the point's
// distances from the eye and from the world's origin. The rounding error of the point grows with both distances. So the
// offset suits tiny scenes and points far from the origin; docs/ARCHITECTURE.md has the measurement.
const OFFSET_BY_DISTANCE: f32 = 1.0 / 131072.0;
const OFFSET_BY_PLACE: f32 = 1.0 / 2097152.0;
// The offset also grows with the triangle's reach, because the rounding error of t does. If the eye or light is so
// close to a triangle that t is computed in two f32 (LARGE), the reach is limited. The limit is the reach of the
// largest triangle for which f32 suffices.
const OFFSET_BY_REACH: f32 = 1.0 / 4194304.0;

// Returns the distance between a surface point and the origin of a ray that leaves it. The point was seen from
// `from_point`.
fn off_surface(point: vec3f, from_point: vec3f, reach: f32) -> f32 {
    let place = abs(point) * OFFSET_BY_PLACE + abs(point - from_point) * OFFSET_BY_DISTANCE;
    return max(max(place.x, place.y), place.z) + reach * OFFSET_BY_REACH;
}

// Colours and hits that a lane's primary rays found.
struct Samples {
    color: F3,
    depth: F,
    slot: U,
    component: U,
    bits: U,      // visibility bits of lights (visibility.wgsl)
}

// Returns the stored pixel of one ray, without marks.
fn pixel_of(samples: Samples, packed: U, ray: u32) -> Pixel {
    return Pixel(of_ray(samples.depth, ray), of_ray_u(samples.slot, ray), 0u, of_ray_u(packed, ray));
}
