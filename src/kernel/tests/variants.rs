//! The kernels, and the variants that tests use.

use std::collections::BTreeSet;

use super::*;
use crate::{
    ShadowReuse, ShadowRule,
    ask::shadow_buffer::Reading,
    frame::show::{FILTER_SAMPLES, PACK, SHOW_COLOR, SHOW_DEPTH, SHOW_SAMPLES},
    kernel::traversal::{Boxes, Tracing, Traversal},
    kernel::variant::{Shadows, SkyKind},
    output::on_device::COMBINE,
    render::cast::{ANY_HITS, ANY_HITS_IN_STEPS, CLOSEST_HITS, CLOSEST_HITS_IN_STEPS},
    render::denoise::{SMOOTH_LIGHT_ONCE, SMOOTH_VARIANCES},
    shadow_buffer::{
        DRAW_FEW_MIDDLES, DRAW_MORE_MIDDLES, DRAW_PARTS_MIDDLES, MARK_FEW_TEXELS, MARK_MORE_TEXELS, MARK_PARTS_TEXELS,
        PROJECT_MIDDLES, PROJECT_TEXELS, READ_MIDDLES, READ_TEXELS,
    },
    steps::{
        bracket::{
            BOUND_TILES, CHOOSE, MARK_BUSY, RESOLVE_TILES, SEARCH_TILES, SEARCH_TILES_TOGETHER, SEARCH_WIDE_TILES,
            SHADE_LISTED, SHADE_SKY, SHADE_TILES, TRACE_BOUNDED,
        },
        edges::MARK_EDGES,
        history::{
            BOUND_BY_HISTORY, MARK_BUSY_BY_HISTORY, SHADE_RECALLED, SHADE_RECALLED_LISTED, SHADE_RECALLED_SKY,
            TRACE_SOFT_RECALLED,
        },
        mirrors::{
            BEGIN_BOUNCED, FINISH_BOUNCED, LIGHT_BOUNCED, LIST_MIRRORS, SEND_BOUNCED, TRACE_BOUNCED, TRACE_MIRRORED,
        },
        paths::{
            ADD_BROUGHT, BEGIN_LISTED_PATHS, BEGIN_LISTED_VERTICES, BEGIN_PATHS, BEGIN_VERTICES, KEEP_BROUGHT,
            LIGHT_PATHS, RECALL_BROUGHT, SCATTER_PATHS, SHARE_BROUGHT, TRACE_PATH_RAYS, TRACE_PATHS,
        },
        reproject::{DEPTH_RANGE, GATHER_SLOTS, REPROJECT, REPROJECT_SCANLINE, REPROJECT_SLOTS},
        resolve::{RESOLVE_RIGHT, RESOLVE_TRUSTED, SHADE_TRACED, TAKE_OVER, TRACE_LISTED},
        soft::{SHADE_HITS, TRACE_HITS, TRACE_SOFT, TRACE_SOFT_ASKED, TRACE_SOFT_LISTED},
        trace::{TRACE_IN_STEPS, TRACE_LEFT},
    },
    t_buffer::{BEGIN_PASS, DRAW_FEW, DRAW_MORE, DRAW_PARTS, PROJECT_PRIMITIVES, READ_T_BUFFER, TRACE_NAMELESS},
    view::rig::{CameraModel, LensModel},
};

pub(super) const ALL: [&Kernel; 83] = [
    &LIST_MIRRORS,
    &TRACE_MIRRORED,
    &BEGIN_BOUNCED,
    &TRACE_BOUNCED,
    &LIGHT_BOUNCED,
    &SEND_BOUNCED,
    &FINISH_BOUNCED,
    &BEGIN_PATHS,
    &BEGIN_LISTED_PATHS,
    &SHARE_BROUGHT,
    &RECALL_BROUGHT,
    &KEEP_BROUGHT,
    &TRACE_PATHS,
    &BEGIN_VERTICES,
    &BEGIN_LISTED_VERTICES,
    &TRACE_PATH_RAYS,
    &SCATTER_PATHS,
    &LIGHT_PATHS,
    &ADD_BROUGHT,
    &SMOOTH_VARIANCES,
    &SMOOTH_LIGHT_ONCE,
    &TRACE_IN_STEPS,
    &CLOSEST_HITS_IN_STEPS,
    &ANY_HITS_IN_STEPS,
    &SHADE_SKY,
    &SHADE_TILES,
    &BOUND_BY_HISTORY,
    &MARK_BUSY_BY_HISTORY,
    &SHADE_RECALLED,
    &SHADE_RECALLED_LISTED,
    &SHADE_RECALLED_SKY,
    &TRACE_SOFT_RECALLED,
    &BOUND_TILES,
    &MARK_BUSY,
    &CHOOSE,
    &SEARCH_TILES,
    &SEARCH_WIDE_TILES,
    &SEARCH_TILES_TOGETHER,
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
    &RESOLVE_TRUSTED,
    &TRACE_LISTED,
    &SHADE_TRACED,
    &TAKE_OVER,
    &TRACE_HITS,
    &TRACE_SOFT,
    &TRACE_SOFT_LISTED,
    &TRACE_SOFT_ASKED,
    &SHADE_HITS,
    &BEGIN_PASS,
    &PROJECT_PRIMITIVES,
    &DRAW_FEW,
    &DRAW_MORE,
    &DRAW_PARTS,
    &READ_T_BUFFER,
    &TRACE_NAMELESS,
    &PACK,
    &SHOW_COLOR,
    &SHOW_SAMPLES,
    &FILTER_SAMPLES,
    &SHOW_DEPTH,
    &COMBINE,
    &PROJECT_MIDDLES,
    &DRAW_FEW_MIDDLES,
    &DRAW_MORE_MIDDLES,
    &DRAW_PARTS_MIDDLES,
    &READ_MIDDLES,
    &PROJECT_TEXELS,
    &MARK_FEW_TEXELS,
    &MARK_MORE_TEXELS,
    &MARK_PARTS_TEXELS,
    &READ_TEXELS,
];

/// Kernels of frames that `naive` renders, and kernels without cameras. Pictures of lenses need no others.
const WITH_LENSES: [&str; 27] = [
    "trace_left",
    "trace_in_steps",
    "trace_hits",
    "trace_soft",
    "shade_hits",
    "list_mirrors",
    "trace_mirrored",
    "begin_bounced",
    "trace_bounced",
    "light_bounced",
    "send_bounced",
    "finish_bounced",
    "begin_paths",
    "trace_paths",
    "begin_vertices",
    "trace_path_rays",
    "scatter_paths",
    "light_paths",
    "add_brought",
    "smooth_variances",
    "smooth_light_once",
    "closest_hits",
    "any_hits",
    "closest_hits_in_steps",
    "any_hits_in_steps",
    "pack",
    "show_color",
];

/// Returns rows of choices, each below its entry in `counts`, such that any two choices of two options occur together
/// in some row.
pub(super) fn all_pairs<const N: usize>(counts: [usize; N]) -> Vec<[usize; N]> {
    let choices = |option: usize| (0..counts[option]).map(move |choice| (option, choice));
    let pairs_of = |a, b| choices(a).flat_map(move |x| choices(b).map(move |y| (x, y)));
    let mut open: BTreeSet<_> = (0..N).flat_map(|b| (0..b).flat_map(move |a| pairs_of(a, b))).collect();
    let mut rows = Vec::new();
    // A row begins with a pair that has not occurred. Its other choices are the ones that add the most new pairs.
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

/// Returns variants in which any two choices occur together. There would be tens of thousands of combinations of all
/// choices.
pub(super) fn variants() -> Vec<Variant> {
    let traversals = Traversal::ALL.iter().flat_map(|&traversal| [(traversal, false), (traversal, true)]);
    let traversals = traversals.filter(|(with, world)| with.boxes == Boxes::F32 || !world);
    let queries = (Traversal::GPU.tracing(Tracing::RayQueries), false);
    let traversals: Vec<_> = traversals.chain([queries]).collect();
    // The columns are spheres, triangles, normals and ellipsoids.
    let kinds = [
        [true, false, false, false],
        [false, true, false, false],
        [false, true, true, false],
        [true, true, false, false],
        [true, true, true, false],
        [true, false, false, true],
        [true, true, false, true],
        [true; 4],
    ];
    let shadows = [Shadows::None, Shadows::FromLight, Shadows::FromSurface];
    let rows = all_pairs([traversals.len(), kinds.len(), 4, 4, 3, 3, 3, 2, 8, 6, 2, 2, 3, 2, 4, 4, 2]);
    let with = |row: &[usize; 17]| {
        let &[
            traversal,
            kind,
            light,
            kept,
            sky,
            bits,
            counting,
            close,
            surfaces,
            soft,
            cutouts,
            masked,
            planes,
            jitter,
            buffer,
            camera,
            paths,
        ] = row;
        let ((traversal, world_boxes), [spheres, triangles, normals, ellipsoids]) =
            (traversals[traversal], kinds[kind]);
        Variant {
            traversal,
            camera: [
                CameraModel::Planar,
                CameraModel::Around,
                CameraModel::Lens(LensModel::Radial),
                CameraModel::Lens(LensModel::Fisheye),
            ][camera],
            triangles,
            spheres,
            ellipsoids,
            planes: [0, 1, 8][planes],
            normals,
            // Some surfaces have none of these features. Textures occur on spheres and on triangles, with and without
            // the others.
            uv: [2, 5].contains(&surfaces),
            colors: [3, 5].contains(&surfaces),
            textures: ![0, 4, 6].contains(&surfaces),
            shine: surfaces > 3,
            principled: [1, 4, 5, 7].contains(&surfaces),
            coats: [4, 7].contains(&surfaces),
            normalised: surfaces > 5,
            mirrors: surfaces % 2 == 1,
            cutouts: triangles && cutouts == 1,
            lights: light > 0,
            shadows: shadows[light.saturating_sub(1)],
            // `soft` is 0 for no soft light, 1 for extended lights, 2 for occlusion, and 3 for both. It is 4 for sky
            // light, and 5 for sky light with extended lights. In some variants lights cast no shadows.
            soft_lights: soft % 2 == 1,
            fading: light > 0 && (light + soft) % 2 == 1,
            projectors: light > 0 && (light + soft) % 3 == 1,
            casts: soft == 0 || light % 2 == 1,
            shadow_rays: if soft % 2 == 1 { 16 } else { 0 },
            occlusion_rays: if soft > 1 { 32 } else { 0 },
            sky_light: soft > 3,
            paths: paths == 1,
            shares: soft > 0 && bits == 1,
            sky: [SkyKind::Constant, SkyKind::Gradient, SkyKind::Map][sky],
            world_boxes,
            close: close == 1,
            samples: kept & 1 == 1,
            second: kept & 2 == 2,
            parts: kept & 1 == 1,
            linear: kept & 2 == 2,
            masked: masked == 1,
            jitter: [0, 3][jitter],
            stack_size: 40,
            bits: [ShadowReuse::Rays, ShadowReuse::Two, ShadowReuse::Block][bits],
            // Counting kernels use no ray queries.
            count: counting > 0 && traversal.tracing == Tracing::Kernels,
            cost_map: counting > 1 && traversal.tracing == Tracing::Kernels,
            shadow_buffer: [None, Some(ShadowRule::Object), Some(ShadowRule::DEPTH), Some(ShadowRule::HYBRID)][buffer]
                .map(|rule| Reading::new(rule, 0b101)),
        }
    };
    // The choices of rows with spheres only also occur in scenes without a tree. These are empty or have planes only.
    let spheres_alone = rows.iter().filter(|row| row[1] == 0);
    let empty = spheres_alone.map(|row| Variant { spheres: false, ..with(row) });
    rows.iter().map(with).chain(empty).collect()
}

/// Returns the variants of a kernel. All variants keep samples if the kernel reads them, have mirrors if it is for
/// mirrors, and have soft light if it samples soft light. Kernels that reuse samples have no lenses. Scenes without a
/// tree have no tiles to bound and nothing to draw.
pub(super) fn variants_of(kernel: &Kernel) -> Vec<Variant> {
    let mut all = variants();
    match kernel.role {
        Role::Shade(Shading::ListMirrors | Shading::Mirrored | Shading::MirroredLit) => {
            all.retain(|with| with.has_tree() || with.planes > 0);
            all.iter_mut().for_each(|with| with.mirrors = true);
        }
        Role::Hits(Hits::Bounced) => all.retain(|with| with.has_tree() || with.planes > 0),
        Role::Paths | Role::SharePaths => {
            all.retain(|with| with.has_tree() || with.planes > 0);
            all.iter_mut().for_each(|with| (with.paths, with.linear) = (true, true));
        }
        Role::Shade(Shading::Soft | Shading::SoftListed) => all.retain(Variant::is_soft),
        Role::Shade(Shading::SoftUnknown | Shading::RecalledSoft) => {
            all.retain(|with| with.is_soft() && with.has_tree())
        }
        // Shadow-buffers are also read in scenes with planes only.
        Role::Draw(Canvas::Middles | Canvas::Texels) if kernel.main.file.contains("/read_") => {}
        Role::Hits(Hits::Tiles | Hits::Drawn) | Role::Draw(_) => all.retain(Variant::has_tree),
        Role::Shade(
            Shading::Sky
            | Shading::Reused
            | Shading::Unknown
            | Shading::RecalledSky
            | Shading::Recalled
            | Shading::RecalledUnknown,
        ) => all.retain(Variant::has_tree),
        Role::Pixels | Role::LinearPixels | Role::MarkBusy | Role::Objects | Role::RayList(_) => {}
        Role::Hits(Hits::View | Hits::Checked | Hits::Trusted | Hits::Listed) => {}
        Role::Shade(Shading::Traced(_) | Shading::Source | Shading::Listed) => {}
    }
    if !WITH_LENSES.contains(&kernel.name) {
        let is_lens = |with: &&mut Variant| matches!(with.camera, CameraModel::Lens(_));
        all.iter_mut().filter(is_lens).for_each(|with| with.camera = CameraModel::Planar);
    }
    if kernel.role.does().samples == SampleUse::Read {
        all.iter_mut().for_each(|with| with.samples = true);
    }
    all
}
