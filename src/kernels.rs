//! The table of kernels: which WGSL parts each is made of, its bindings, and what it is specialised to.
//!
//! A kernel's text is its parts one after the other. What a scene does not have (spheres, vertex normals, lights, a
//! sky gradient, anything to hit) is not among the parts, so it is not in the kernel that runs (DESIGN, section 6).

use crate::{
    GBuffer, Method, Overlap, Scene, ShadowReuse, Sky,
    bvh::PackedBvh,
    cast,
    large::LARGE,
    layout,
    method::Verify,
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
        Part {
            #[cfg(test)]
            file: $file,
            text: include_str!(concat!("../shaders/", $file)),
        }
    };
}

/// How a kernel uses a storage buffer of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    Read,
    Write,
}

/// What a kernel touches besides its own buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Touches {
    Pixels,
    Geometry,
    /// Geometry and the shading table.
    Shading,
    /// Geometry and a table of rays.
    RayList,
    /// A table of the primitives' objects.
    Objects,
}

impl Touches {
    pub(crate) fn geometry(self) -> bool {
        !matches!(self, Self::Pixels | Self::Objects)
    }

    pub(crate) fn table(self) -> bool {
        matches!(self, Self::Shading | Self::RayList | Self::Objects)
    }
}

/// A compute kernel. Its one entry point has its file's name; group 1 has the frame at binding 0 and then `storage`.
pub(crate) struct Kernel {
    pub(crate) name: &'static str,
    pub(crate) touches: Touches,
    pub(crate) storage: &'static [Access],
    extra: &'static [Part],
    main: Part,
}

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

/// What kernels keep of each pixel besides its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Kept {
    /// What `bracket` needs of a left sample.
    Samples,
    Ids,
    Depth,
    None,
}

impl Kept {
    /// What a method's frame keeps on the device, at least what the user wants of it.
    pub(crate) fn of(wanted: GBuffer, method: Method) -> Self {
        match (wanted, method) {
            (_, Method::Auto | Method::Reuse { overlap: Overlap::Bracket(_), .. }) => Self::Samples,
            // Edges are told by objects.
            (_, Method::Reuse { verify: Verify::Edges, .. }) | (GBuffer::Ids, _) => Self::Ids,
            (_, Method::Reuse { .. }) | (GBuffer::Depth, _) => Self::Depth,
            (GBuffer::None, _) => Self::None,
        }
    }

    /// Bytes of a `PixelHit`.
    pub(crate) fn bytes(self) -> u64 {
        match self {
            Self::Samples | Self::Ids => size_of::<layout::PixelHit>() as u64,
            Self::Depth => 4,
            Self::None => 0,
        }
    }
}

/// Where the right view's pixels are when it is composed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum RightView {
    Traced,
    Left,
    Marked,
}

impl RightView {
    pub(crate) fn of(method: Method) -> Self {
        match method {
            Method::Auto | Method::Naive | Method::Reuse { overlap: Overlap::Bracket(_), .. } => Self::Traced,
            Method::Ideal => Self::Left,
            Method::Reuse { .. } => Self::Marked,
        }
    }
}

/// What a pipeline is specialised to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Specialisation {
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
    pub(crate) hits: Kept,
    /// Words of a traversal's stack.
    pub(crate) stack_size: u32,
    pub(crate) verify: Verify,
    /// Which shadow bits are taken over.
    pub(crate) bits: ShadowReuse,
    /// Where right pixels come from, for compose.
    pub(crate) right: RightView,
    /// Count nodes and primitive tests.
    pub(crate) count: bool,
    /// Count them for each pixel.
    pub(crate) cost_map: bool,
}

impl Specialisation {
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
        hits: Kept::Ids,
        stack_size: 0,
        verify: Verify::None,
        bits: ShadowReuse::Rays,
        right: RightView::Traced,
        count: false,
        cost_map: false,
    };

    /// What a scene needs; verification and counting are the frame's to choose.
    pub(crate) fn of(scene: &Scene, traversal: Traversal, packed: &PackedBvh) -> Self {
        Self {
            traversal,
            triangles: scene.triangles().iter().any(|triangle| !triangle.is_degenerate()),
            spheres: !scene.spheres().is_empty(),
            normals: scene.has_normals(),
            lights: !scene.lights.is_empty(),
            shadows: Shadows::of(scene),
            sky: SkyKind::of(&scene.sky),
            world_boxes: packed.world_boxes,
            close: false,
            hits: Kept::Ids,
            stack_size: packed.stack_size,
            verify: Verify::All,
            bits: ShadowReuse::Rays,
            right: RightView::Traced,
            count: false,
            cost_map: false,
        }
    }

    /// With nodes and primitive tests counted or not. What is counted is one ray a lane, on every adapter: so the figures
    /// do not depend on it.
    pub(crate) fn counting(self, count: bool, cost_map: bool) -> Self {
        let count = count || cost_map;
        let rays = if count { RaysPerLane::One } else { self.traversal.rays };
        Self { count, cost_map, traversal: Traversal { rays, ..self.traversal }, ..self }
    }
}

use Access::{Read, Write};

/// Where in group 1 is bound what threads keep from step to step (`src/steps.rs`), and the texture of left samples.
pub(crate) const STEPS_BINDING: u32 = 14;
pub(crate) const SAMPLES_BINDING: u32 = 15;

const COUNT: Part = part!("shared/count.wgsl");
const LIGHT_TRACED: Part = part!("shared/light_traced.wgsl");
const LIGHT_TAKEN: Part = part!("shared/light_taken.wgsl");
const LIGHT_TAKEN_OR_TRACED: Part = part!("shared/light_taken_or_traced.wgsl");
const TAKEN_BITS: Part = part!("shared/taken_bits.wgsl");
const APPEND: Part = part!("shared/append.wgsl");
const LISTED_PIXELS: Part = part!("shared/listed_pixels.wgsl");
const LISTED_TILE: Part = part!("shared/listed_tile.wgsl");
const RIGHT_HITS: Part = part!("shared/right_hits.wgsl");
const TILES: Part = part!("shared/tiles.wgsl");
const TILE: Part = part!("shared/tile.wgsl");
const KEEP_PIXELS: Part = part!("shared/keep_pixels.wgsl");
const RAY_LIST: Part = part!("shared/ray_list.wgsl");
const PARALLAX: Part = part!("shared/parallax.wgsl");
const MARKS: Part = part!("shared/marks.wgsl");
const LISTS: Part = part!("shared/lists.wgsl");

pub(crate) const TRACE_LEFT: Kernel = Kernel {
    name: "trace_left",
    touches: Touches::Shading,
    storage: &[Write, Write, Write],
    extra: &[COUNT, LIGHT_TRACED, KEEP_PIXELS],
    main: part!("trace_left.wgsl"),
};
pub(crate) const REPROJECT: Kernel = Kernel {
    name: "reproject",
    touches: Touches::Pixels,
    storage: &[Read, Write],
    extra: &[PARALLAX],
    main: part!("reproject.wgsl"),
};
pub(crate) const REPROJECT_SLOTS: Kernel = Kernel {
    name: "reproject_slots",
    touches: Touches::Pixels,
    storage: &[Read, Write, Write],
    extra: &[PARALLAX],
    main: part!("reproject_slots.wgsl"),
};
pub(crate) const REPROJECT_SCANLINE: Kernel = Kernel {
    name: "reproject_scanline",
    touches: Touches::Pixels,
    storage: &[Read, Write],
    extra: &[PARALLAX],
    main: part!("reproject_scanline.wgsl"),
};
pub(crate) const MARK_EDGES: Kernel = Kernel {
    name: "mark_edges",
    touches: Touches::Objects,
    storage: &[Read, Write],
    extra: &[PARALLAX, MARKS],
    main: part!("mark_edges.wgsl"),
};
pub(crate) const GATHER_SLOTS: Kernel = Kernel {
    name: "gather_slots",
    touches: Touches::Pixels,
    storage: &[Read, Write],
    extra: &[],
    main: part!("gather_slots.wgsl"),
};
pub(crate) const DEPTH_RANGE: Kernel = Kernel {
    name: "depth_range",
    touches: Touches::Pixels,
    storage: &[Read, Write],
    extra: &[],
    main: part!("depth_range.wgsl"),
};
pub(crate) const RESOLVE_RIGHT: Kernel = Kernel {
    name: "resolve_right",
    touches: Touches::Geometry,
    storage: &[Read, Write, Write, Write],
    extra: &[COUNT, MARKS, LISTS, APPEND],
    main: part!("resolve_right.wgsl"),
};
pub(crate) const TRACE_LISTED: Kernel = Kernel {
    name: "trace_listed",
    touches: Touches::Shading,
    storage: &[Write, Write, Write, Write],
    extra: &[COUNT, LISTS, LISTED_PIXELS, LIGHT_TRACED],
    main: part!("trace_listed.wgsl"),
};
pub(crate) const BOUND_TILES: Kernel = Kernel {
    name: "bound_tiles",
    touches: Touches::Pixels,
    storage: &[Read, Write, Write],
    extra: &[PARALLAX, TILES],
    main: part!("bound_tiles.wgsl"),
};
pub(crate) const SEARCH_TILES: Kernel = Kernel {
    name: "search_tiles",
    touches: Touches::Geometry,
    storage: &[Read, Write, Write, Write],
    extra: &[COUNT, TILES, TILE, LISTS, APPEND],
    main: part!("search_tiles.wgsl"),
};
pub(crate) const RESOLVE_TILES: Kernel = Kernel {
    name: "resolve_tiles",
    touches: Touches::Shading,
    storage: &[Read, Write, Write, Write, Write],
    extra: &[COUNT, TILES, MARKS, LISTS, APPEND, LISTED_PIXELS, LISTED_TILE, PARALLAX, TAKEN_BITS, LIGHT_TAKEN],
    main: part!("resolve_tiles.wgsl"),
};
pub(crate) const SHADE_SKY: Kernel = Kernel {
    name: "shade_sky",
    touches: Touches::Shading,
    storage: &[Write, Write, Write, Write],
    extra: &[COUNT, TILES, LISTS, LISTED_PIXELS, LISTED_TILE, LIGHT_TRACED],
    main: part!("shade_sky.wgsl"),
};
pub(crate) const TRACE_BOUNDED: Kernel = Kernel {
    name: "trace_bounded",
    touches: Touches::Shading,
    storage: &[Write, Write, Write, Write],
    extra: &[COUNT, MARKS, LISTS, LISTED_PIXELS, PARALLAX, RIGHT_HITS, TAKEN_BITS, LIGHT_TAKEN_OR_TRACED],
    main: part!("trace_bounded.wgsl"),
};
pub(crate) const SHADE_LISTED: Kernel = Kernel {
    name: "shade_listed",
    touches: Touches::Shading,
    storage: &[Write, Read, Write, Write],
    extra: &[COUNT, LISTS, LISTED_PIXELS, PARALLAX, RIGHT_HITS, TAKEN_BITS, LIGHT_TAKEN_OR_TRACED],
    main: part!("shade_listed.wgsl"),
};
pub(crate) const CLOSEST_HITS: Kernel = Kernel {
    name: "closest_hits",
    touches: Touches::RayList,
    storage: &[Write, Write],
    extra: &[COUNT, RAY_LIST],
    main: part!("closest_hits.wgsl"),
};
pub(crate) const ANY_HITS: Kernel = Kernel {
    name: "any_hits",
    touches: Touches::RayList,
    storage: &[Write, Write],
    extra: &[COUNT, RAY_LIST],
    main: part!("any_hits.wgsl"),
};
pub(crate) const TRACE_IN_STEPS: Kernel = Kernel {
    name: "trace_in_steps",
    touches: Touches::Shading,
    storage: &[Write, Write, Write],
    extra: &[COUNT, LIGHT_TRACED, KEEP_PIXELS],
    main: part!("trace_in_steps.wgsl"),
};
pub(crate) const CLOSEST_HITS_IN_STEPS: Kernel = Kernel { name: "closest_hits_in_steps", ..CLOSEST_HITS };
pub(crate) const ANY_HITS_IN_STEPS: Kernel = Kernel { name: "any_hits_in_steps", ..ANY_HITS };
pub(crate) const COMPOSE: Kernel = Kernel {
    name: "compose",
    touches: Touches::Pixels,
    storage: &[Read, Read, Read, Write],
    extra: &[MARKS],
    main: part!("compose.wgsl"),
};

/// What kernels need of a device's limits; those that they don't ask for are taken from `others`.
pub(crate) fn limits_over(others: wgpu::Limits) -> wgpu::Limits {
    wgpu::Limits {
        max_bind_groups: 3,
        max_bindings_per_bind_group: SAMPLES_BINDING + 1,
        max_storage_buffers_per_shader_stage: 8,
        max_storage_textures_per_shader_stage: 4,
        max_uniform_buffers_per_shader_stage: 2,
        max_buffers_and_acceleration_structures_per_shader_stage: 10,
        max_compute_invocations_per_workgroup: layout::LIST_WORKGROUP,
        max_compute_workgroup_size_x: layout::LIST_WORKGROUP,
        max_compute_workgroup_size_y: layout::WORKGROUP,
        max_compute_workgroup_size_z: 1,
        max_compute_workgroups_per_dimension: cast::BATCH as u32 / layout::LIST_WORKGROUP,
        ..others
    }
}

impl Kernel {
    /// Pixels of a thread's block in x and in y.
    pub(crate) fn block(&self, with: &Specialisation) -> u32 {
        if !self.touches.geometry() { 1 } else { with.traversal.rays.block() }
    }

    /// How a kernel uses the texture of left samples, at `SAMPLES_BINDING` of group 1.
    pub(crate) fn samples(&self, with: &Specialisation) -> Option<Access> {
        match self.name {
            "trace_left" if with.hits == Kept::Samples => Some(Write),
            "resolve_tiles" | "trace_bounded" | "shade_listed" => Some(Read),
            _ => None,
        }
    }

    /// Whether its threads leave work to the next dispatch (`src/steps.rs`).
    pub(crate) fn in_steps(&self) -> bool {
        matches!(self.name, "trace_in_steps" | "closest_hits_in_steps" | "any_hits_in_steps")
    }

    /// The files a kernel is made of, in order.
    pub(crate) fn parts(&self, with: &Specialisation) -> Vec<Part> {
        let hits = match with.hits {
            Kept::Samples => part!("shared/hits_samples.wgsl"),
            Kept::Ids => part!("shared/hits_ids.wgsl"),
            Kept::Depth => part!("shared/hits_depth.wgsl"),
            Kept::None => part!("shared/hits_none.wgsl"),
        };
        let mut parts = vec![part!("shared/types.wgsl"), hits];
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
        if self.name == RESOLVE_RIGHT.name {
            parts.push(match with.verify {
                Verify::All => part!("shared/verify_all.wgsl"),
                // Gaps are no candidates any more, and edges have been marked.
                Verify::Gaps | Verify::Edges | Verify::None => part!("shared/verify_none.wgsl"),
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
        if self.name == COMPOSE.name {
            parts.push(match with.right {
                RightView::Traced => part!("shared/right_traced.wgsl"),
                RightView::Left => part!("shared/right_is_left.wgsl"),
                RightView::Marked => part!("shared/right_marked.wgsl"),
            });
        }
        parts
    }

    /// The text that the driver gets.
    pub(crate) fn text(&self, with: &Specialisation) -> String {
        // Six samples are told apart by their normals, two have room for an occluder.
        let (stack, occluders, close) = (with.stack_size, with.bits == ShadowReuse::Two, with.close);
        let mut text = format!(
            "const STACK_SIZE: u32 = {stack}u;\nconst KEEP_OCCLUDERS: bool = {occluders};\nconst CLOSE: bool = {close};\nconst LARGE: f32 = {LARGE:?};\n"
        );
        for part in self.parts(with) {
            text += part.text;
        }
        text
    }
}

/// How primitives are projected onto a tile.
fn bounds_parts(with: &Specialisation) -> Vec<Part> {
    let (triangles, spheres) = (part!("shared/bounds_triangle.wgsl"), part!("shared/bounds_sphere.wgsl"));
    match (with.triangles, with.spheres) {
        (true, true) => vec![triangles, spheres, part!("shared/bounds_mixed.wgsl")],
        (true, false) => vec![triangles, part!("shared/bounds_triangles.wgsl")],
        (false, true) => vec![spheres, part!("shared/bounds_spheres.wgsl")],
        (false, false) => vec![],
    }
}

fn geometry_parts(with: &Specialisation) -> Vec<Part> {
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use naga::valid::{Capabilities, ValidationFlags, Validator};

    use super::*;
    use crate::layout;

    const ALL: [&Kernel; 21] = [
        &TRACE_IN_STEPS,
        &CLOSEST_HITS_IN_STEPS,
        &ANY_HITS_IN_STEPS,
        &SHADE_SKY,
        &BOUND_TILES,
        &SEARCH_TILES,
        &TRACE_BOUNDED,
        &RESOLVE_TILES,
        &SHADE_LISTED,
        &REPROJECT_SCANLINE,
        &MARK_EDGES,
        &CLOSEST_HITS,
        &ANY_HITS,
        &TRACE_LEFT,
        &REPROJECT,
        &REPROJECT_SLOTS,
        &GATHER_SLOTS,
        &DEPTH_RANGE,
        &RESOLVE_RIGHT,
        &TRACE_LISTED,
        &COMPOSE,
    ];

    /// Rows of choices, one below each of `counts`, such that any two choices for two options meet in some row.
    fn all_pairs<const N: usize>(counts: [usize; N]) -> Vec<[usize; N]> {
        let choices = |option: usize| (0..counts[option]).map(move |choice| (option, choice));
        let pairs_of = |a, b| choices(a).flat_map(move |x| choices(b).map(move |y| (x, y)));
        let mut open: BTreeSet<_> = (0..N).flat_map(|b| (0..b).flat_map(move |a| pairs_of(a, b))).collect();
        let mut rows = Vec::new();
        // A row begins with a pair that has not met yet. Its other choices are those that make most such pairs meet.
        while let Some(&(first, second)) = open.first() {
            let mut row = vec![first, second];
            for option in (0..N).filter(|&option| option != first.0 && option != second.0) {
                let meets = |new: (usize, usize)| {
                    row.iter().filter(|&&made| open.contains(&(made.min(new), made.max(new)))).count()
                };
                let best = choices(option).rev().max_by_key(|&new| meets(new)).unwrap();
                row.push(best);
            }
            open.retain(|(a, b)| !(row.contains(a) && row.contains(b)));
            row.sort_unstable();
            rows.push(std::array::from_fn(|option| row[option].1));
        }
        rows
    }

    /// Not all combinations, which are tens of thousands, but any two choices together.
    fn specialisations() -> Vec<Specialisation> {
        let traversals = Traversal::ALL.into_iter().flat_map(|traversal| [(traversal, false), (traversal, true)]);
        let traversals: Vec<_> = traversals.filter(|(with, world)| with.boxes == Boxes::F32 || !world).collect();
        // Spheres, triangles, normals.
        let kinds = [[true, false, false], [false, true, false], [false, true, true], [true, true, false], [true; 3]];
        let shadows = [Shadows::None, Shadows::FromLight, Shadows::FromSurface];
        let rows = all_pairs([traversals.len(), kinds.len(), 4, 4, 3, 3, 3, 3, 2, 2]);
        let with = |&[traversal, kind, light, hits, sky, bits, right, counting, close, verify]: &[usize; 10]| {
            let ((traversal, world_boxes), [spheres, triangles, normals]) = (traversals[traversal], kinds[kind]);
            Specialisation {
                traversal,
                triangles,
                spheres,
                normals,
                lights: light > 0,
                shadows: shadows[light.saturating_sub(1)],
                sky: [SkyKind::Constant, SkyKind::Gradient, SkyKind::Map][sky],
                world_boxes,
                close: close == 1,
                hits: [Kept::Ids, Kept::Depth, Kept::None, Kept::Samples][hits],
                stack_size: 40,
                verify: [Verify::None, Verify::All][verify],
                bits: [ShadowReuse::Rays, ShadowReuse::Two, ShadowReuse::Block][bits],
                right: [RightView::Traced, RightView::Left, RightView::Marked][right],
                count: counting > 0,
                cost_map: counting > 1,
            }
        };
        // What the scenes of spheres alone are paired with, a scene without primitives is paired with too.
        let spheres_alone = rows.iter().filter(|row| row[1] == 0);
        let empty = spheres_alone.map(|row| Specialisation { spheres: false, ..with(row) });
        rows.iter().map(with).chain(empty).collect()
    }

    /// Those of a kernel: `bracket`'s keep samples, and a scene without primitives has no tiles to bound.
    fn specialisations_of(kernel: &Kernel) -> Vec<Specialisation> {
        let mut all = specialisations();
        if [&SEARCH_TILES, &RESOLVE_TILES, &SHADE_SKY, &TRACE_BOUNDED, &SHADE_LISTED]
            .iter()
            .any(|known| known.name == kernel.name)
        {
            all.retain(|with| with.triangles || with.spheres);
            all.iter_mut().for_each(|with| with.hits = Kept::Samples);
        }
        if kernel.name == MARK_EDGES.name {
            all.iter_mut().for_each(|with| with.hits = Kept::Ids);
        }
        all
    }

    fn parse(kernel: &Kernel, with: &Specialisation) -> naga::Module {
        let text = kernel.text(with);
        naga::front::wgsl::parse_str(&text)
            .unwrap_or_else(|error| panic!("{} {with:?}: {}", kernel.name, error.emit_to_string(&text)))
    }

    /// Every distinct text, with its kernel and a specialisation that gives it.
    fn modules() -> Vec<(&'static Kernel, Specialisation, String)> {
        let mut seen = BTreeSet::new();
        let all =
            ALL.into_iter().flat_map(|kernel| specialisations_of(kernel).into_iter().map(move |with| (kernel, with)));
        let all = all.map(|(kernel, with)| (kernel, with, kernel.text(&with)));
        all.filter(|(_, _, text)| seen.insert(text.clone())).collect()
    }

    #[test]
    fn every_specialised_kernel_passes_naga_and_keeps_to_webgpu_s_eight_storage_buffers() {
        let modules = modules();
        assert!(modules.len() > 100, "{}", modules.len());
        for (kernel, with, text) in modules {
            let module = parse(kernel, &with);
            let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
                .validate(&module)
                .unwrap_or_else(|error| panic!("{} {with:?}: {}", kernel.name, error.emit_to_string(&text)));
            assert_eq!(module.entry_points.len(), 1);
            assert_eq!(format!("{}.wgsl", module.entry_points[0].name), kernel.main.file);
            let used = module.global_variables.iter().filter(|(handle, variable)| {
                !info.get_entry_point(0)[*handle].is_empty()
                    && matches!(variable.space, naga::AddressSpace::Storage { .. })
            });
            assert!(used.count() <= 8, "{} {with:?}", kernel.name);
        }
    }

    /// For `scripts/check_wgsl.sh`, which shows them to a stricter front end than naga. Above each part stands its file and the
    /// line before its first, so that an error in the whole text can be told by file and line.
    #[test]
    fn every_distinct_module_is_written_to_target_wgsl() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/target/wgsl");
        let _ = std::fs::remove_dir_all(folder);
        std::fs::create_dir_all(folder).unwrap();
        let modules = modules();
        for (number, (kernel, with, text)) in modules.iter().enumerate() {
            let head = text.len() - kernel.parts(with).iter().map(|part| part.text.len()).sum::<usize>();
            let mut marked = text[..head].to_owned();
            for part in kernel.parts(with) {
                marked += &format!("// file: shaders/{}\n{}", part.file, part.text);
            }
            std::fs::write(format!("{folder}/{number:04}_{}.wgsl", kernel.name), marked).unwrap();
        }
        assert_eq!(std::fs::read_dir(folder).unwrap().count(), modules.len());
    }

    #[test]
    fn the_limits_asked_for_are_those_that_some_kernel_needs() {
        let mut needed = wgpu::Limits::downlevel_webgl2_defaults();
        let asked = limits_over(needed.clone());
        needed.max_compute_workgroups_per_dimension = asked.max_compute_workgroups_per_dimension; // a launch's, not a kernel's
        needed.max_bind_groups = 0;
        needed.max_bindings_per_bind_group = 0;
        needed.max_uniform_buffers_per_shader_stage = 0;
        needed.max_buffers_and_acceleration_structures_per_shader_stage = 0;
        for (kernel, with, _) in modules() {
            let module = parse(kernel, &with);
            let [x, y, z] = module.entry_points[0].workgroup_size;
            let mut raise = |limit: fn(&mut wgpu::Limits) -> &mut u32, to: u32| {
                let limit = limit(&mut needed);
                *limit = to.max(*limit);
            };
            raise(|limits| &mut limits.max_compute_workgroup_size_x, x);
            raise(|limits| &mut limits.max_compute_workgroup_size_y, y);
            raise(|limits| &mut limits.max_compute_workgroup_size_z, z);
            raise(|limits| &mut limits.max_compute_invocations_per_workgroup, x * y * z);
            let mut count = [0; 3];
            for (_, variable) in module.global_variables.iter() {
                let Some(binding) = &variable.binding else { continue };
                raise(|limits| &mut limits.max_bind_groups, binding.group + 1);
                raise(|limits| &mut limits.max_bindings_per_bind_group, binding.binding + 1);
                count[match variable.space {
                    naga::AddressSpace::Uniform => 0,
                    naga::AddressSpace::Storage { .. } => 1,
                    _ => 2,
                }] += 1;
            }
            let [uniforms, buffers, textures] = count;
            raise(|limits| &mut limits.max_uniform_buffers_per_shader_stage, uniforms);
            raise(|limits| &mut limits.max_storage_buffers_per_shader_stage, buffers);
            raise(|limits| &mut limits.max_storage_textures_per_shader_stage, textures);
            raise(|limits| &mut limits.max_buffers_and_acceleration_structures_per_shader_stage, uniforms + buffers);
        }
        assert_eq!(needed, asked);
        assert!(asked.check_limits(&wgpu::Limits::default()), "more than WebGPU promises");
    }

    #[test]
    fn every_specialised_kernel_makes_a_pipeline() {
        let gpu = crate::Gpu::open(&std::env::var(crate::gpu::ADAPTER_VARIABLE).unwrap_or("software".into())).unwrap();
        let make = || {
            let pipelines = crate::gpu::Pipelines::new(&gpu);
            let mut built = BTreeSet::new();
            for kernel in ALL {
                for with in specialisations_of(kernel) {
                    if built.insert((kernel.text(&with), with.count, with.cost_map)) {
                        pipelines.get(&gpu, kernel, with);
                    }
                }
            }
            Ok(())
        };
        pollster::block_on(gpu.checked(make)).unwrap();
    }

    #[test]
    fn bindings_of_group_1_are_as_the_table_says() {
        for kernel in ALL {
            let module = parse(kernel, &specialisations_of(kernel)[0]);
            let mut found: Vec<_> = module
                .global_variables
                .iter()
                .filter_map(|(_, variable)| Some((variable.binding.as_ref()?, variable.space)))
                .filter(|(binding, _)| binding.group == 1 && (1..STEPS_BINDING).contains(&binding.binding))
                .map(|(binding, space)| match space {
                    naga::AddressSpace::Storage { access } if access.contains(naga::StorageAccess::STORE) => {
                        (binding.binding, Write)
                    }
                    _ => (binding.binding, Read),
                })
                .collect();
            found.sort_by_key(|(binding, _)| *binding);
            let stated: Vec<_> = kernel.storage.iter().enumerate().map(|(i, access)| (i as u32 + 1, *access)).collect();
            assert_eq!(found, stated, "{}", kernel.name);
        }
    }

    #[test]
    fn every_wgsl_file_is_part_of_a_kernel() {
        let mut used = BTreeSet::new();
        for kernel in ALL {
            for with in specialisations_of(kernel) {
                used.extend(kernel.parts(&with).iter().map(|part| part.file.to_owned()));
            }
        }
        let mut there = BTreeSet::new();
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders");
        for folder in ["", "shared/"] {
            for entry in std::fs::read_dir(format!("{root}/{folder}")).unwrap() {
                let name = entry.unwrap().file_name().into_string().unwrap();
                if name.ends_with(".wgsl") {
                    there.insert(format!("{folder}{name}"));
                }
            }
        }
        assert_eq!(used, there);
    }

    macro_rules! assert_layout {
        ($module:expr, $name:ident { $($field:ident),* $(,)? }) => {{
            let host = layout::$name::default();
            let base = &raw const host as usize;
            let stated = vec![$((stringify!($field), &raw const host.$field as usize - base)),*];
            assert_struct($module, stringify!($name), &stated, size_of::<layout::$name>());
        }};
    }

    fn assert_struct(module: &naga::Module, name: &str, stated: &[(&str, usize)], size: usize) {
        let found = module.types.iter().find_map(|(_, kind)| match &kind.inner {
            naga::TypeInner::Struct { members, span } if kind.name.as_deref() == Some(name) => Some((members, span)),
            _ => None,
        });
        let (members, span) = found.unwrap_or_else(|| panic!("WGSL has no struct {name}"));
        let members: Vec<_> = members.iter().map(|m| (m.name.as_deref().unwrap_or(""), m.offset as usize)).collect();
        assert_eq!(members, stated, "{name}");
        assert_eq!(*span as usize, size, "size of {name}");
    }

    #[test]
    fn host_and_wgsl_structs_have_the_same_layout() {
        let with = Specialisation { spheres: true, triangles: true, ..specialisations()[0] };
        let module = &parse(&TRACE_LEFT, &with);
        assert_layout!(
            module,
            Frame {
                left_eye,
                interaxial_px,
                right_eye,
                screen_distance,
                left_corner,
                interaxial,
                right_corner,
                eye,
                step_x,
                buffer_depth,
                step_y,
                row_begin,
                right_axis,
                row_end,
                image_size,
                longest,
                _pad,
                forward,
                wider,
            }
        );
        assert_layout!(module, Bvh { grid_origin, extent, grid_cell, zero });
        assert_layout!(module, PixelHit { depth, primitive });
        let listed = parse(&TRACE_LISTED, &with);
        let header = listed.types.iter().find_map(|(_, kind)| match &kind.inner {
            naga::TypeInner::Struct { members, .. } if kind.name.as_deref() == Some("Lists") => Some(members[1].offset),
            _ => None,
        });
        assert_eq!(header.map(u64::from), Some(layout::LISTS_HEADS));
    }

    #[test]
    fn counters_and_marks_have_the_same_numbers_in_both_languages() {
        let types = [part!("shared/types.wgsl"), MARKS, TILES, LISTS].map(|part| part.text).concat();
        for (name, value) in [
            ("WORKGROUP", layout::WORKGROUP),
            ("LIST_WORKGROUP", layout::LIST_WORKGROUP),
            ("COUNTERS", layout::COUNTERS as u32),
            ("VIEW_WORDS", layout::VIEW_WORDS as u32),
            ("SHADOW_RAYS", layout::SHADOW_RAYS as u32),
            ("NODES_VISITED", layout::NODES_VISITED as u32),
            ("PRIMITIVES_TESTED", layout::PRIMITIVES_TESTED as u32),
            ("BAD_PIXELS", layout::BAD_PIXELS as u32),
            ("MISSED_PIXELS", layout::MISSED_PIXELS as u32),
            ("LOST_CANDIDATES", layout::LOST_CANDIDATES as u32),
            ("NEAREST_DEPTH", layout::NEAREST_DEPTH as u32),
            ("FARTHEST_DEPTH", layout::FARTHEST_DEPTH as u32),
            ("CUT_SHORT", layout::CUT_SHORT as u32),
            ("BAD", layout::BAD),
            ("MISSED", layout::MISSED),
            ("ASKED", layout::ASKED),
            ("GAP_PIXELS", layout::GAP_PIXELS as u32),
            ("TO_TRACE", layout::TO_TRACE),
            ("TO_LIGHT", layout::TO_LIGHT),
            ("TO_RESOLVE", layout::TO_RESOLVE),
            ("SKY", layout::SKY),
            ("TILE", layout::TILE),
            ("TILE_BLOCKS", layout::TILE_BLOCKS),
            ("LIST_WORDS", layout::LIST_WORDS),
        ] {
            let decimal = format!("const {name}: u32 = {value}u;");
            let hex = format!("const {name}: u32 = {value:#010x}u;");
            assert!(types.contains(&decimal) || types.contains(&hex), "{name}");
        }
        assert!(types.contains("const FAR: f32 = 3.4e38;") && crate::FAR == 3.4e38);
        assert!(types.contains("const MISS: u32 = 0xffffffffu;") && crate::MISS == u32::MAX);
    }
}
