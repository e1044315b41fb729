//! Pipeline variants: the properties for which kernels are specialised, and the resulting choices of WGSL sections.
//! Only this module makes choices.
//!
//! `src/kernel/wgsl.rs` links a kernel's text. The text has no code for features that the scene lacks (DESIGN, section
//! 6). Examples are spheres, ellipsoids, vertex normals, lights, a sky gradient, or any primitives at all.

mod choices;

use crate::{
    Material, Scene, ShadowReuse, Sky,
    ask::shadow_buffer::Reading,
    kernel::traversal::{Boxes, Fetch, RaysPerLane, Stack, Tracing, Traversal},
    kernel::{Canvas, Hits, Role, SampleUse, Shading},
    view::rig::CameraModel,
};

/// The direction of shadow rays, if there are any.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Shadows {
    None,
    FromLight,
    FromSurface,
}

impl Shadows {
    /// Shadow rays start at the light, unless it is farther away than this multiple of the scene's longest side. A
    /// ray's end is offset from the surface by a share of the ray's length. For farther lights the offset would be
    /// visible.
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

/// Indices of a primitive's optional texels. They follow the three texels that all primitives have, and a fourth one
/// for vertex normals or ellipsoids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TexelPlaces {
    /// Index of the first of two texels with texture coordinates.
    pub(crate) uv: usize,
    /// Index of the texel with the corners' colours.
    pub(crate) colors: usize,
    /// Number of texels per primitive.
    pub(crate) count: usize,
}

impl TexelPlaces {
    /// Returns the indices, given whether there is a fourth texel, texture coordinates and colours.
    pub(crate) fn of(fourth: bool, has_uv: bool, has_colors: bool) -> Self {
        let uv = if fourth { 4 } else { 3 };
        let colors = if has_uv { uv + 2 } else { uv };
        Self { uv, colors, count: colors + usize::from(has_colors) }
    }
}

/// Returns the number of texels per material in the shading table. `more` says whether some material has highlights,
/// emits light, or reflects or transmits rays. `principled` says whether some material is physically based, and `coats`
/// whether some has a clear coat.
pub(crate) fn material_texels(more: bool, principled: bool, coats: bool) -> usize {
    match (more, principled) {
        (_, true) => 10 + usize::from(coats),
        (true, false) => 4,
        (false, false) => 1,
    }
}

/// The kind of a sky.
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

/// Returns the number of texels per light in the shading table. `soft` says whether some light is not a point light,
/// `fading` whether some light has a falloff or a cone, and `projectors` whether some light projects a picture.
pub(crate) fn light_texels(soft: bool, fading: bool, projectors: bool) -> usize {
    match (soft || fading, projectors) {
        (_, true) => 7,
        (true, false) => 4,
        (false, false) => 2,
    }
}

/// Role of a kernel in soft light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SoftRole {
    /// The frame or the kernel has no soft light.
    None,
    /// Other kernels add soft light.
    Skipped,
    /// The kernel adds soft light according to the masks.
    Masked,
    /// The kernel fills the masks.
    Asked,
    /// The kernel traces its own rays to soft lights.
    Followed,
}

/// Properties for which a pipeline is specialised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Variant {
    pub(crate) traversal: Traversal,
    pub(crate) camera: CameraModel,
    pub(crate) triangles: bool,
    /// Whether the scene has spheres or ellipsoids.
    pub(crate) spheres: bool,
    /// Whether the scene has ellipsoids. Spheres are then traced as ellipsoids.
    pub(crate) ellipsoids: bool,
    /// Number of planes. The tree does not contain them.
    pub(crate) planes: u32,
    pub(crate) normals: bool,
    /// Whether primitives have texture coordinates (`uv`), and whether they have colours at their corners (`colors`).
    pub(crate) uv: bool,
    pub(crate) colors: bool,
    /// Whether some material is textured, or some corner has a colour.
    pub(crate) textures: bool,
    /// Whether some material has highlights or emits light.
    pub(crate) shine: bool,
    /// Whether some highlights are normalised.
    pub(crate) normalised: bool,
    /// Whether some material is physically based.
    pub(crate) principled: bool,
    /// Whether some material has a clear coat.
    pub(crate) coats: bool,
    /// Whether some surface reflects or transmits rays: a mirror, glass or a transparent surface.
    pub(crate) mirrors: bool,
    /// Whether some material, and so possibly some triangle, is cut out.
    pub(crate) cutouts: bool,
    pub(crate) lights: bool,
    pub(crate) shadows: Shadows,
    /// Whether some lights are not point lights.
    pub(crate) soft_lights: bool,
    /// Whether some lights have a falloff or a cone.
    pub(crate) fading: bool,
    /// Whether some lights project a picture.
    pub(crate) projectors: bool,
    /// Whether lights cast shadows.
    pub(crate) casts: bool,
    /// Number of rays to each soft light (`shadow_rays`) and into the surroundings (`occlusion_rays`); 0 without such
    /// light.
    pub(crate) shadow_rays: u32,
    pub(crate) occlusion_rays: u32,
    /// Whether sky light replaces ambient light.
    pub(crate) sky_light: bool,
    /// Whether paths of light replace ambient light.
    pub(crate) paths: bool,
    /// Whether views reuse shares of soft light in addition to visibility bits.
    pub(crate) shares: bool,
    pub(crate) sky: SkyKind,
    /// Whether each box is widened in proportion to its own distance, for scenes far larger than their detail.
    pub(crate) world_boxes: bool,
    /// Whether an eye or a light is close to a large primitive.
    pub(crate) close: bool,
    /// Whether source samples are kept for reuse.
    pub(crate) samples: bool,
    /// Whether views also query a second source.
    pub(crate) second: bool,
    /// Whether light is kept in parts.
    pub(crate) parts: bool,
    /// Whether linear colour is kept.
    pub(crate) linear: bool,
    /// Whether only the pixels in a mask are computed.
    pub(crate) masked: bool,
    /// Number of jittered samples per side of a pixel; 0 or 1 without jitter.
    pub(crate) jitter: u32,
    /// Size of a traversal's stack, in words.
    pub(crate) stack_size: u32,
    /// Rule for the reuse of visibility bits.
    pub(crate) bits: ShadowReuse,
    /// Whether visited nodes and primitive tests are counted.
    pub(crate) count: bool,
    /// Whether they are also counted per pixel.
    pub(crate) cost_map: bool,
    /// How points query shadow-buffers before shadow rays are traced; `None` if the frame uses no shadow-buffers.
    pub(crate) shadow_buffer: Option<Reading>,
}

impl Variant {
    /// Variant of kernels that do not read the scene.
    pub(crate) const PIXELS: Self = Self {
        traversal: Traversal {
            fetch: Fetch::Texture,
            boxes: Boxes::Grid16,
            rays: RaysPerLane::One,
            stack: Stack::Private,
            tracing: Tracing::Kernels,
        },
        camera: CameraModel::Planar,
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
        principled: false,
        coats: false,
        mirrors: false,
        cutouts: false,
        lights: false,
        shadows: Shadows::None,
        soft_lights: false,
        fading: false,
        projectors: false,
        casts: true,
        shadow_rays: 0,
        occlusion_rays: 0,
        sky_light: false,
        paths: false,
        shares: false,
        sky: SkyKind::Constant,
        world_boxes: false,
        close: false,
        samples: false,
        second: false,
        parts: false,
        linear: false,
        masked: false,
        jitter: 0,
        stack_size: 0,
        bits: ShadowReuse::Rays,
        count: false,
        cost_map: false,
        shadow_buffer: None,
    };

    /// Returns the variant for a scene with a tree of these properties. Properties of the frame, such as counting, are
    /// set later.
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
            principled: scene.has_principled(),
            coats: scene.has_coats(),
            normalised: scene.materials().iter().any(Material::shines_normalised),
            mirrors: (triangles || balls || planes > 0) && scene.materials().iter().any(Material::sends_rays),
            cutouts: triangles && scene.is_cut_out(),
            lights: !scene.lights.is_empty(),
            shadows: Shadows::of(scene),
            soft_lights: scene.soft_lights().next().is_some(),
            fading: scene.has_fading_lights(),
            projectors: scene.has_projectors(),
            casts: scene.shadows,
            sky: SkyKind::of(&scene.sky),
            world_boxes,
            stack_size,
            ..Self::PIXELS
        }
    }

    /// Reduces the variant to the properties on which kernels of a role depend. Kernels that do not read the scene are
    /// the same for every scene.
    pub(crate) fn of_role(self, role: Role) -> Self {
        let with = match role {
            // The kernel depends on whether samples have shares.
            Role::MarkBusy if self.shares && self.is_soft() => {
                Self { camera: self.camera, triangles: true, soft_lights: true, shares: true, ..Self::PIXELS }
            }
            Role::Pixels | Role::MarkBusy => Self { camera: self.camera, ..Self::PIXELS },
            Role::LinearPixels => {
                Self { camera: self.camera, linear: self.linear, jitter: self.jitter, ..Self::PIXELS }
            }
            Role::Objects => Self { camera: self.camera, traversal: self.traversal, ..Self::PIXELS },
            // Each lane marks a single texel.
            Role::Draw(Canvas::Texels) => {
                Self { camera: CameraModel::Planar, traversal: self.traversal.rays(RaysPerLane::One), ..self.unlit() }
            }
            // T-buffers and shadow-buffers have planar pixels or none.
            Role::Draw(Canvas::Picture | Canvas::Middles) | Role::Hits(Hits::Drawn) => {
                Self { camera: CameraModel::Planar, ..self.unlit() }
            }
            // Each lane traces one secondary ray or lists one pixel. Secondary rays start anywhere, so they count as
            // close.
            Role::Hits(Hits::Bounced) => {
                Self { traversal: self.traversal.rays(RaysPerLane::One), close: true, ..self.unlit() }
            }
            Role::Hits(_) | Role::RayList(_) => self.unlit(),
            Role::Shade(Shading::ListMirrors | Shading::Mirrored | Shading::MirroredLit) => Self {
                traversal: self.traversal.rays(RaysPerLane::One),
                close: true,
                paths: false,
                samples: false,
                second: false,
                bits: ShadowReuse::Rays,
                shares: false,
                ..self
            },
            // Paths start anywhere, like the rays above. They find lights themselves.
            Role::Paths => Self {
                traversal: self.traversal.rays(RaysPerLane::One),
                close: true,
                lights: false,
                shadows: Shadows::None,
                samples: false,
                second: false,
                bits: ShadowReuse::Rays,
                shares: false,
                shadow_rays: 0,
                ..self
            },
            // The kernel reads hits, materials and samples.
            Role::SharePaths => Self {
                traversal: self.traversal.rays(RaysPerLane::One),
                paths: true,
                principled: self.principled,
                coats: self.coats,
                shine: self.shine,
                soft_lights: self.soft_lights,
                fading: self.fading,
                projectors: self.projectors,
                mirrors: self.mirrors,
                samples: true,
                bits: ShadowReuse::Rays,
                ..self.unlit()
            },
            Role::Shade(_) => self,
        };
        let does = role.does();
        let asks = does.queries_shadow_buffers && with.casts_from_lights();
        Self {
            masked: self.masked && does.minds_mask,
            parts: self.parts && role == Role::Paths,
            shadow_buffer: with.shadow_buffer.filter(|_| asks),
            ..with
        }
    }

    /// Returns the indices of a primitive's optional texels.
    fn texel_places(&self) -> TexelPlaces {
        TexelPlaces::of(self.ellipsoids || (self.triangles && self.normals), self.uv, self.colors)
    }

    /// Returns the variant of kernels that shade nothing.
    fn unlit(self) -> Self {
        Self {
            textures: false,
            shine: false,
            normalised: false,
            mirrors: false,
            lights: false,
            shadows: Shadows::None,
            soft_lights: false,
            fading: false,
            projectors: false,
            casts: true,
            shadow_rays: 0,
            occlusion_rays: 0,
            sky_light: false,
            paths: false,
            shares: false,
            sky: SkyKind::Constant,
            samples: false,
            second: false,
            parts: false,
            linear: false,
            bits: ShadowReuse::Rays,
            shadow_buffer: None,
            ..self
        }
    }

    /// Returns whether some light is sampled by several rays.
    pub(crate) fn is_soft(&self) -> bool {
        (self.soft_lights || self.occlusion_rays > 0) && (self.has_tree() || self.planes > 0)
    }

    /// Returns whether shadow rays start at point lights.
    pub(crate) fn casts_from_lights(&self) -> bool {
        self.lights && self.shadows == Shadows::FromLight && (self.has_tree() || self.planes > 0)
    }

    /// Returns whether there are primitives other than planes.
    pub(crate) fn has_tree(&self) -> bool {
        self.triangles || self.spheres
    }

    /// Returns how kernels of a role take part in soft light.
    pub(crate) fn soft_role(&self, role: Role) -> SoftRole {
        if self.is_soft() { role.does().soft } else { SoftRole::None }
    }

    /// Returns how kernels of a role use samples of source views.
    pub(crate) fn sample_use(&self, role: Role) -> SampleUse {
        match role.does().samples {
            SampleUse::Written if !self.samples => SampleUse::None,
            used => used,
        }
    }

    /// Returns whether kernels of a role read a second source's samples.
    fn reads_second(&self, role: Role) -> bool {
        self.second && matches!(role, Role::Shade(_)) && self.sample_use(role) == SampleUse::Read
    }

    /// Enables or disables the counting of visited nodes and primitive tests. Counting kernels trace one ray per lane
    /// on every adapter and use no ray queries, so that counters do not depend on the adapter.
    pub(crate) fn counting(self, count: bool, cost_map: bool) -> Self {
        let count = count || cost_map;
        let traversal = match count {
            true => self.traversal.rays(RaysPerLane::One).stack(Stack::Private).tracing(Tracing::Kernels),
            false => self.traversal,
        };
        Self { count, cost_map, traversal, ..self }
    }
}
