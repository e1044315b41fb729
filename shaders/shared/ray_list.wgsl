// A list of rays. Each ray has two texels: direction and t_min, then origin and t_max. The rays of a lane have a common
// origin. frame.band.size.x is the number of rays.

//! use fetch, frame, lane, rays

//! if fetch is buffer
var<storage, read> ray_list: array<vec4u>;

fn ray_texel(index: u32) -> vec4u { return ray_list[index]; }

//! if fetch is texture
var ray_list: texture_storage_2d<rgba32uint, read>;

fn ray_texel(index: u32) -> vec4u { return textureLoad(ray_list, texel_position(index)); }

//! end
struct ListedRays {
    rays: Rays,
    t_min: F,
    t_max: F,
}

fn listed_rays(first: u32) -> ListedRays {
    var origin: vec3f;
    var direction: F3;
    var t_min: F;
    var t_max = F(NEVER);
    var ray = 0u;
    loop {
        if first + ray < frame.band.size.x {
            let near = bitcast<vec4f>(ray_texel(2u * (first + ray)));
            direction = with_ray3(direction, ray, near.xyz);
            t_min = with_ray(t_min, ray, near.w);
            let far = bitcast<vec4f>(ray_texel(2u * (first + ray) + 1u));
            origin = far.xyz;
            t_max = with_ray(t_max, ray, far.w);
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return ListedRays(Rays(origin, direction), t_min, t_max);
}
