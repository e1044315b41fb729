//! What kernels are specialised to, and the WGSL parts that follow from it: the only place that picks them.
//!
//! A kernel's text is its parts one after the other. What a scene does not have (spheres, vertex normals, lights, a
//! sky gradient, anything to hit) is not among the parts, so it is not in the kernel that runs (DESIGN, section 6).

use crate::{
    Scene, ShadowReuse, Sky,
    bvh::PackedBvh,
    kernels::{
        Access::{Read, Write},
        Kernel, Touches,
    },
    large::LARGE,
    steps::{bracket::SEARCH_TILES, resolve::TAKE_OVER},
    traversal::{Boxes, Fetch, RaysPerLane, Traversal},
};

/// A WGSL file: its name below `shaders/` and its text.
#[derive(Clone, Copy)]
pub(crate) struct Part {
    #[cfg(test)]
    pub(crate) file: &'static str,
    pub(crate) text: &'static str,
}

macro_rules! part {
    ($file:literal) => {
        $crate::variant::Part {
            #[cfg(test)]
            file: $file,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $file)),
        }
    };
}
pub(crate) use part;

/// Which way shadow rays run, if there are any.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Shadows {
    None,
    FromLight,
    FromSurface,
}

impl Shadows {
    /// Shadow rays run from the light, but not from one farther off than this many times the scene's largest side: their
    /// end would be off the surface by a visible part of it.
    const FAR_LIGHT: f32 = 64.0;

    fn of(scene: &Scene) -> Self {
        let far = |(low, high): (glam::Vec3, glam::Vec3)| {
            let reach = Self::FAR_LIGHT * (high - low).max_element();
            scene.lights.iter().any(|light| light.position.clamp(low, high).distance(light.position) > reach)
        };
        match scene.bounds() {
            _ if !scene.shadows => Self::None,
            Some(bounds) if far(bounds) => Self::FromSurface,
            _ => Self::FromLight,
        }
    }

    fn part(self) -> Part {
        match self {
            Self::None => part!("shared/shadows_none.wgsl"),
            Self::FromLight => part!("shared/shadows_from_light.wgsl"),
            Self::FromSurface => part!("shared/shadows_from_surface.wgsl"),
        }
    }
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

/// What a pipeline is specialised to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Variant {
    pub(crate) traversal: Traversal,
    pub(crate) triangles: bool,
    pub(crate) spheres: bool,
    pub(crate) normals: bool,
    pub(crate) lights: bool,
    pub(crate) shadows: Shadows,
    pub(crate) sky: SkyKind,
    /// Boxes are widened each by its own distance, for scenes far larger than their detail.
    pub(crate) world_boxes: bool,
    /// An eye or a light is close to a large primitive.
    pub(crate) close: bool,
    /// What views take over of a source's samples is kept.
    pub(crate) samples: bool,
    /// Linear colour is kept.
    pub(crate) linear: bool,
    /// Words of a traversal's stack.
    pub(crate) stack_size: u32,
    /// Which shadow bits are taken over.
    pub(crate) bits: ShadowReuse,
    /// Count nodes and primitive tests.
    pub(crate) count: bool,
    /// Count them for each pixel.
    pub(crate) cost_map: bool,
}

impl Variant {
    /// What a kernel that doesn't touch the scene is specialised to: nothing.
    pub(crate) const PIXELS: Self = Self {
        traversal: Traversal { fetch: Fetch::Texture, boxes: Boxes::Grid16, rays: RaysPerLane::One },
        triangles: false,
        spheres: false,
        normals: false,
        lights: false,
        shadows: Shadows::None,
        sky: SkyKind::Constant,
        world_boxes: false,
        close: false,
        samples: false,
        linear: false,
        stack_size: 0,
        bits: ShadowReuse::Rays,
        count: false,
        cost_map: false,
    };

    /// What a scene needs; counting is the frame's to choose.
    pub(crate) fn of(scene: &Scene, traversal: Traversal, packed: &PackedBvh) -> Self {
        Self::over_tree(scene, traversal, packed.world_boxes, packed.stack_size)
    }

    /// The same where all that is known of the tree is this.
    pub(crate) fn over_tree(scene: &Scene, traversal: Traversal, world_boxes: bool, stack_size: u32) -> Self {
        Self {
            traversal,
            triangles: scene.triangles().iter().any(|triangle| !triangle.is_degenerate()),
            spheres: !scene.spheres().is_empty(),
            normals: scene.has_normals(),
            lights: !scene.lights.is_empty(),
            shadows: Shadows::of(scene),
            sky: SkyKind::of(&scene.sky),
            world_boxes,
            close: false,
            samples: false,
            linear: false,
            stack_size,
            bits: ShadowReuse::Rays,
            count: false,
            cost_map: false,
        }
    }

    /// What a kernel depends on of it: one that doesn't touch the scene is the same for every scene.
    pub(crate) fn of_kernel(self, kernel: &Kernel) -> Self {
        match kernel.touches {
            Touches::Pixels => Self { linear: self.linear && kernel.name == TAKE_OVER.name, ..Self::PIXELS },
            Touches::Objects => Self { traversal: self.traversal, ..Self::PIXELS },
            Touches::Geometry => Self { bits: ShadowReuse::Rays, ..self.unlit() },
            Touches::Shading => self,
            Touches::RayList => Self { bits: ShadowReuse::Rays, ..self.unlit() },
        }
    }

    /// For kernels that shade nothing.
    fn unlit(self) -> Self {
        Self { lights: false, shadows: Shadows::None, sky: SkyKind::Constant, samples: false, linear: false, ..self }
    }

    /// With nodes and primitive tests counted or not. What is counted is one ray a lane, on every adapter: so the figures
    /// do not depend on it.
    pub(crate) fn counting(self, count: bool, cost_map: bool) -> Self {
        let count = count || cost_map;
        let rays = if count { RaysPerLane::One } else { self.traversal.rays };
        Self { count, cost_map, traversal: self.traversal.rays(rays), ..self }
    }
}

impl Kernel {
    /// The files a kernel is made of, in order.
    pub(crate) fn parts(&self, with: &Variant) -> Vec<Part> {
        let mut parts = vec![part!("shared/types.wgsl")];
        if self.touches != Touches::Pixels {
            parts.push(match with.traversal.fetch {
                Fetch::Texture => part!("shared/table_texture.wgsl"),
                Fetch::Buffer => part!("shared/table_buffer.wgsl"),
            });
        }
        if self.touches.geometry() {
            parts.push(match with.traversal.rays {
                RaysPerLane::One => part!("shared/rays_1.wgsl"),
                RaysPerLane::Four => part!("shared/rays_2x2.wgsl"),
            });
            parts.push(part!("shared/lane.wgsl"));
            parts.push(match with.traversal.fetch {
                Fetch::Texture => part!("shared/fetch_texture.wgsl"),
                Fetch::Buffer => part!("shared/fetch_buffer.wgsl"),
            });
            parts.extend(geometry_parts(with));
            parts.push(match self.in_steps() {
                true => part!("shared/in_steps.wgsl"),
                false => part!("shared/in_one_go.wgsl"),
            });
        }
        if self.touches == Touches::Shading {
            parts.push(match with.sky {
                SkyKind::Constant => part!("shared/sky_constant.wgsl"),
                SkyKind::Gradient => part!("shared/sky_gradient.wgsl"),
                SkyKind::Map => part!("shared/sky_map.wgsl"),
            });
            match with.lights {
                true => {
                    let shadows = if with.triangles || with.spheres { with.shadows } else { Shadows::None };
                    parts.extend([shadows.part(), part!("shared/lights.wgsl")]);
                }
                false => parts.extend([Shadows::None.part(), part!("shared/lights_none.wgsl")]),
            }
            if matches!(self.name, "resolve_tiles" | "trace_bounded" | "shade_listed") {
                parts.push(match with.bits {
                    ShadowReuse::Rays => part!("shared/bits_none.wgsl"),
                    ShadowReuse::Two => part!("shared/bits_two.wgsl"),
                    ShadowReuse::Block => part!("shared/bits_block.wgsl"),
                });
            }
            parts.push(part!("shared/shade.wgsl"));
            parts.push(match with.linear {
                true => part!("shared/linear_kept.wgsl"),
                false => part!("shared/linear_none.wgsl"),
            });
        }
        if self.name == TAKE_OVER.name {
            parts.push(match with.linear {
                true => part!("shared/linear_taken.wgsl"),
                false => part!("shared/linear_left.wgsl"),
            });
        }
        match self.samples(with) {
            Some(Read) => parts.push(part!("shared/samples_read.wgsl")),
            Some(Write) => parts.push(part!("shared/samples_written.wgsl")),
            None if self.touches == Touches::Shading => parts.push(part!("shared/samples_none.wgsl")),
            None => {}
        }
        parts.extend(self.extra);
        if self.name == SEARCH_TILES.name {
            parts.extend(bounds_parts(with));
        }
        parts.push(self.main);
        parts
    }

    /// The text that the driver gets.
    pub(crate) fn text(&self, with: &Variant) -> String {
        // Six samples are told apart by their normals, two have room for an occluder.
        let (stack, occluders, close) = (with.stack_size, with.bits == ShadowReuse::Two, with.close);
        let bits = self.samples(with) == Some(Write);
        let mut text = format!(
            "const STACK_SIZE: u32 = {stack}u;\nconst KEEP_OCCLUDERS: bool = {occluders};\nconst KEEP_BITS: bool = {bits};\n\
             const CLOSE: bool = {close};\nconst LARGE: f32 = {LARGE:?};\n"
        );
        for part in self.parts(with) {
            text += part.text;
        }
        text
    }
}

/// How primitives are projected onto a tile.
fn bounds_parts(with: &Variant) -> Vec<Part> {
    let (triangles, spheres) = (part!("shared/bounds_triangle.wgsl"), part!("shared/bounds_sphere.wgsl"));
    match (with.triangles, with.spheres) {
        (true, true) => vec![triangles, spheres, part!("shared/bounds_mixed.wgsl")],
        (true, false) => vec![triangles, part!("shared/bounds_triangles.wgsl")],
        (false, true) => vec![spheres, part!("shared/bounds_spheres.wgsl")],
        (false, false) => vec![],
    }
}

fn geometry_parts(with: &Variant) -> Vec<Part> {
    if !with.triangles && !with.spheres {
        return vec![part!("shared/bvh_empty.wgsl")];
    }
    let boxes = match with.traversal.boxes {
        Boxes::Grid16 => part!("shared/boxes_16bit.wgsl"),
        Boxes::F32 if with.world_boxes => part!("shared/boxes_world.wgsl"),
        Boxes::F32 => part!("shared/boxes_f32.wgsl"),
    };
    let mut parts = vec![part!("shared/bvh.wgsl"), boxes, part!("shared/double_float.wgsl")];
    if with.triangles {
        parts.push(part!("shared/triangle.wgsl"));
        parts.push(match with.normals {
            true => part!("shared/normal_smooth.wgsl"),
            false => part!("shared/normal_flat.wgsl"),
        });
    }
    if with.spheres {
        parts.push(part!("shared/sphere.wgsl"));
    }
    parts.push(match (with.triangles, with.spheres) {
        (true, true) => part!("shared/primitives_mixed.wgsl"),
        (true, false) => part!("shared/primitives_triangles.wgsl"),
        _ => part!("shared/primitives_spheres.wgsl"),
    });
    parts
}
