//! What kernels are specialised to, and the choices that follow from it for their WGSL: the only place that makes them.
//!
//! `src/wgsl.rs` puts a kernel's text together. What a scene does not have (spheres, ellipsoids, vertex normals,
//! lights, a sky gradient, anything to hit) is not chosen, so it is not in the kernel that runs (DESIGN, section 6).

mod choices;

use crate::{
    Material, Scene, ShadowReuse, Sky,
    bvh::PackedBvh,
    kernels::{Kernel, Touches},
    shadow_buffer::Reading,
    steps::{
        bracket::MARK_BUSY,
        mirrors::{LIST_MIRRORS, TRACE_MIRRORED},
        resolve::TAKE_OVER,
    },
    traversal::{Boxes, Fetch, RaysPerLane, Traversal},
};

/// Which way shadow rays run, if there are any.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Shadows {
    None,
    FromLight,
    FromSurface,
}

impl Shadows {
    /// Shadow rays run from the light, but not from one farther off than this many times the scene's largest side:
    /// their end would be off the surface by a visible part of it.
    const FAR_LIGHT: f32 = 64.0;

    fn of(scene: &Scene) -> Self {
        let points = || scene.lights.iter().filter(|light| !light.is_soft());
        let far = |(low, high): (glam::Vec3, glam::Vec3)| {
            let reach = Self::FAR_LIGHT * (high - low).max_element();
            let places = || points().map(|light| scene.local_position(light));
            places().any(|place| place.clamp(low, high).distance(place) > reach)
        };
        match scene.local_bounds() {
            _ if !scene.shadows || points().next().is_none() => Self::None,
            Some(bounds) if far(bounds) => Self::FromSurface,
            _ => Self::FromLight,
        }
    }
}

/// Where the texels of a primitive stand that not all scenes have: behind three that all have, and a fourth of vertex
/// normals or ellipsoids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TexelPlaces {
    /// The first of two with texture coordinates.
    pub(crate) uv: usize,
    /// The one with the corners' colours.
    pub(crate) colors: usize,
    /// Of all together.
    pub(crate) count: usize,
}

impl TexelPlaces {
    /// With a fourth texel or not, and what each primitive has besides.
    pub(crate) fn of(fourth: bool, has_uv: bool, has_colors: bool) -> Self {
        let uv = if fourth { 4 } else { 3 };
        let colors = if has_uv { uv + 2 } else { uv };
        Self { uv, colors, count: colors + usize::from(has_colors) }
    }
}

/// Texels of a material in the shading table; `more` where some material shines or sends rays on.
pub(crate) fn material_texels(more: bool) -> usize {
    if more { 4 } else { 1 }
}

/// How a sky is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum SkyKind {
    Constant,
    Gradient,
    Map,
}

impl SkyKind {
    fn of(sky: &Sky) -> Self {
        match sky {
            Sky::Constant(_) => Self::Constant,
            Sky::Gradient { .. } => Self::Gradient,
            Sky::Map(_) => Self::Map,
        }
    }
}

/// Texels of a light in the shading table; `soft` where some light is not a point.
pub(crate) fn light_texels(soft: bool) -> usize {
    if soft { 4 } else { 2 }
}

/// What a kernel does about lights that are not points, and ambient light that surroundings keep off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SoftRole {
    /// There is none.
    None,
    /// Others add it.
    Skipped,
    /// It adds what masks say.
    Masked,
    /// It makes the masks.
    Asked,
    /// It traces its own rays.
    Followed,
}

/// What a pipeline is specialised to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Variant {
    pub(crate) traversal: Traversal,
    pub(crate) triangles: bool,
    /// Spheres or ellipsoids.
    pub(crate) spheres: bool,
    /// Some of them are ellipsoids: then spheres are traced as such.
    pub(crate) ellipsoids: bool,
    /// Planes, which are in no tree.
    pub(crate) planes: u32,
    pub(crate) normals: bool,
    /// Primitives have texture coordinates, and colours at their corners.
    pub(crate) uv: bool,
    pub(crate) colors: bool,
    /// Some material is textured, or some corner has a colour.
    pub(crate) textures: bool,
    /// Some material has highlights or gives off light.
    pub(crate) shine: bool,
    /// Some highlights conserve energy.
    pub(crate) normalised: bool,
    /// Some surface sends rays on: a mirror, glass or a veil.
    pub(crate) mirrors: bool,
    /// Some material, and so some triangle maybe, is cut out.
    pub(crate) cutouts: bool,
    pub(crate) lights: bool,
    pub(crate) shadows: Shadows,
    /// Some lights are not points.
    pub(crate) soft_lights: bool,
    /// Whether those cast shadows.
    pub(crate) casts: bool,
    /// Rays to each of them, and into the surroundings; 0 for no such light.
    pub(crate) shadow_rays: u32,
    pub(crate) occlusion_rays: u32,
    /// The surroundings are asked for the sky's light, in place of ambient light.
    pub(crate) sky_light: bool,
    /// Views take over shares of them, besides bits.
    pub(crate) shares: bool,
    pub(crate) sky: SkyKind,
    /// Boxes are widened each by its own distance, for scenes far larger than their detail.
    pub(crate) world_boxes: bool,
    /// An eye or a light is close to a large primitive.
    pub(crate) close: bool,
    /// What views take over of a source's samples is kept.
    pub(crate) samples: bool,
    /// Views ask a second source too.
    pub(crate) second: bool,
    /// Linear colour is kept.
    pub(crate) linear: bool,
    /// Only pixels that a mask names are worked on.
    pub(crate) masked: bool,
    /// Samples a side of a pixel that are jittered; 0 or 1: none.
    pub(crate) jitter: u32,
    /// Words of a traversal's stack.
    pub(crate) stack_size: u32,
    /// Which shadow bits are taken over.
    pub(crate) bits: ShadowReuse,
    /// Count nodes and primitive tests.
    pub(crate) count: bool,
    /// Count them for each pixel.
    pub(crate) cost_map: bool,
    /// Points ask shadow-buffers before they trace shadow rays.
    pub(crate) shadow_buffer: Option<Reading>,
}

impl Variant {
    /// What a kernel that doesn't touch the scene is specialised to: nothing.
    pub(crate) const PIXELS: Self = Self {
        traversal: Traversal { fetch: Fetch::Texture, boxes: Boxes::Grid16, rays: RaysPerLane::One },
        triangles: false,
        spheres: false,
        ellipsoids: false,
        planes: 0,
        normals: false,
        uv: false,
        colors: false,
        textures: false,
        shine: false,
        normalised: false,
        mirrors: false,
        cutouts: false,
        lights: false,
        shadows: Shadows::None,
        soft_lights: false,
        casts: true,
        shadow_rays: 0,
        occlusion_rays: 0,
        sky_light: false,
        shares: false,
        sky: SkyKind::Constant,
        world_boxes: false,
        close: false,
        samples: false,
        second: false,
        linear: false,
        masked: false,
        jitter: 0,
        stack_size: 0,
        bits: ShadowReuse::Rays,
        count: false,
        cost_map: false,
        shadow_buffer: None,
    };

    /// What a scene needs; counting is the frame's to choose.
    pub(crate) fn of(scene: &Scene, traversal: Traversal, packed: &PackedBvh) -> Self {
        Self::over_tree(scene, traversal, packed.world_boxes, packed.stack_size)
    }

    /// The same where all that is known of the tree is this.
    pub(crate) fn over_tree(scene: &Scene, traversal: Traversal, world_boxes: bool, stack_size: u32) -> Self {
        let triangles = scene.triangles().iter().any(|triangle| !triangle.is_degenerate());
        let balls = !scene.spheres().is_empty() || !scene.ellipsoids().is_empty();
        let planes = scene.planes().len() as u32;
        Self {
            traversal,
            triangles,
            spheres: balls,
            ellipsoids: !scene.ellipsoids().is_empty(),
            planes,
            normals: scene.has_normals(),
            uv: !scene.uv().is_empty(),
            colors: !scene.colors().is_empty(),
            textures: scene.is_textured(),
            shine: scene.materials().iter().any(Material::shines),
            normalised: scene.materials().iter().any(Material::shines_normalised),
            mirrors: (triangles || balls || planes > 0) && scene.materials().iter().any(Material::sends_rays),
            cutouts: triangles && scene.is_cut_out(),
            lights: !scene.lights.is_empty(),
            shadows: Shadows::of(scene),
            soft_lights: scene.soft_lights().next().is_some(),
            casts: scene.shadows,
            sky: SkyKind::of(&scene.sky),
            world_boxes,
            stack_size,
            ..Self::PIXELS
        }
    }

    /// What a kernel depends on of it: one that doesn't touch the scene is the same for every scene.
    pub(crate) fn of_kernel(self, kernel: &Kernel) -> Self {
        let with = match kernel.touches {
            // Whether samples have shares.
            Touches::Pixels if kernel.name == MARK_BUSY.name && self.shares && self.is_soft() => {
                Self { triangles: true, soft_lights: true, shares: true, ..Self::PIXELS }
            }
            Touches::Pixels => Self { linear: self.linear && kernel.name == TAKE_OVER.name, ..Self::PIXELS },
            Touches::Objects => Self { traversal: self.traversal, ..Self::PIXELS },
            // A texel a lane.
            Touches::Geometry if kernel.name.ends_with("_texels") => {
                Self { traversal: self.traversal.rays(RaysPerLane::One), bits: ShadowReuse::Rays, ..self.unlit() }
            }
            Touches::Geometry => Self { bits: ShadowReuse::Rays, ..self.unlit() },
            // One ray a lane, which starts anywhere; and where none is cast, a pixel a lane.
            Touches::Shading if [LIST_MIRRORS.name, TRACE_MIRRORED.name].contains(&kernel.name) => Self {
                traversal: self.traversal.rays(RaysPerLane::One),
                close: true,
                samples: false,
                second: false,
                bits: ShadowReuse::Rays,
                shares: false,
                ..self
            },
            Touches::Shading => self,
            Touches::RayList => Self { bits: ShadowReuse::Rays, ..self.unlit() },
        };
        Self { masked: self.masked && kernel.minds_mask(), shadow_buffer: kernel.shadow_buffer(&with), ..with }
    }

    /// Where the texels of a primitive stand that not all scenes have.
    fn texel_places(&self) -> TexelPlaces {
        TexelPlaces::of(self.ellipsoids || (self.triangles && self.normals), self.uv, self.colors)
    }

    /// For kernels that shade nothing.
    fn unlit(self) -> Self {
        Self {
            textures: false,
            shine: false,
            normalised: false,
            mirrors: false,
            lights: false,
            shadows: Shadows::None,
            soft_lights: false,
            casts: true,
            shadow_rays: 0,
            occlusion_rays: 0,
            sky_light: false,
            shares: false,
            sky: SkyKind::Constant,
            samples: false,
            second: false,
            linear: false,
            shadow_buffer: None,
            ..self
        }
    }

    /// Whether there is light that is asked for by more than a ray.
    pub(crate) fn is_soft(&self) -> bool {
        (self.soft_lights || self.occlusion_rays > 0) && (self.has_tree() || self.planes > 0)
    }

    /// Whether shadow rays run from points among its lights.
    pub(crate) fn casts_from_lights(&self) -> bool {
        self.lights && self.shadows == Shadows::FromLight && (self.has_tree() || self.planes > 0)
    }

    /// Whether there is anything to hit but planes.
    pub(crate) fn has_tree(&self) -> bool {
        self.triangles || self.spheres
    }

    pub(crate) fn soft_role(&self, kernel: &Kernel) -> SoftRole {
        match kernel.name {
            _ if !self.is_soft() || kernel.touches != Touches::Shading => SoftRole::None,
            "trace_soft" | "trace_soft_listed" | "trace_soft_asked" => SoftRole::Asked,
            "trace_mirrored" => SoftRole::Followed,
            "shade_hits" | "shade_tiles" | "shade_listed" | "shade_traced" => SoftRole::Masked,
            "trace_left" | "trace_in_steps" => SoftRole::Skipped,
            _ => SoftRole::None,
        }
    }

    /// With nodes and primitive tests counted or not. What is counted is one ray a lane, on every adapter: so the
    /// figures do not depend on it.
    pub(crate) fn counting(self, count: bool, cost_map: bool) -> Self {
        let count = count || cost_map;
        let rays = if count { RaysPerLane::One } else { self.traversal.rays };
        Self { count, cost_map, traversal: self.traversal.rays(rays), ..self }
    }
}
