//! Compares the host's structs and numbers with the structs and numbers of WGSL.

use std::mem::offset_of;

use super::{variants::variants, *};
use crate::{
    accel::facets,
    output::on_device::{COMBINE, Combining},
    render::denoise::SMOOTH_LIGHT_ONCE,
    shadow_buffer::READ_TEXELS,
    steps::{
        mirrors::TRACE_BOUNCED,
        paths::{ADD_BROUGHT, SCATTER_PATHS, TRACE_PATHS},
    },
    view::rig::{CameraModel, LensModel},
};

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

/// Returns the size of the heads of lists at the beginning of a struct, in bytes.
fn heads_of(module: &naga::Module, name: &str) -> u64 {
    let header = module.types.iter().find_map(|(_, kind)| match &kind.inner {
        naga::TypeInner::Struct { members, .. } if kind.name.as_deref() == Some(name) => Some(members[1].offset),
        _ => None,
    });
    header.unwrap().into()
}

#[test]
fn host_and_wgsl_structs_have_the_same_layout() {
    let with = Variant { spheres: true, triangles: true, cutouts: false, ..variants()[0] };
    let module = &parse(&TRACE_LEFT, &with);
    assert_layout!(
        module,
        Eyes {
            source_eye,
            parallax_px,
            target_eye,
            parallax_distance,
            source_corner,
            shift,
            target_corner,
            same_parallax,
            step_x,
            longest,
            step_y,
            wider,
            right_axis,
            at_infinity,
            forward,
            pixel_side,
            second_parallax_px,
            second_same_parallax,
        }
    );
    let around = parse(&TRACE_LEFT, &Variant { camera: CameraModel::Around, ..with });
    let stated = [
        ("centre", offset_of!(layout::CircleEyes, centre)),
        ("target_radius", offset_of!(layout::CircleEyes, target_radius)),
        ("right_axis", offset_of!(layout::CircleEyes, right_axis)),
        ("most_elevation", offset_of!(layout::CircleEyes, most_elevation)),
        ("up_axis", offset_of!(layout::CircleEyes, up_axis)),
        ("column_step", offset_of!(layout::CircleEyes, column_step)),
        ("forward", offset_of!(layout::CircleEyes, forward)),
        ("row_step", offset_of!(layout::CircleEyes, row_step)),
        ("middle", offset_of!(layout::CircleEyes, middle)),
        ("merge", offset_of!(layout::CircleEyes, merge)),
        ("wider", offset_of!(layout::CircleEyes, wider)),
        ("turn", offset_of!(layout::CircleEyes, turn)),
        ("wraps", offset_of!(layout::CircleEyes, wraps)),
        ("spare", offset_of!(layout::CircleEyes, spare)),
        ("_pad", offset_of!(layout::CircleEyes, _pad)),
    ];
    assert_struct(&around, "Eyes", &stated, size_of::<layout::Eyes>());
    let lens = parse(&TRACE_LEFT, &Variant { camera: CameraModel::Lens(LensModel::Radial), ..with });
    let stated = [
        ("target_eye", offset_of!(layout::LensEyes, target_eye)),
        ("focal_x", offset_of!(layout::LensEyes, focal_x)),
        ("target_corner", offset_of!(layout::LensEyes, target_corner)),
        ("focal_y", offset_of!(layout::LensEyes, focal_y)),
        ("step_x", offset_of!(layout::LensEyes, step_x)),
        ("principal_x", offset_of!(layout::LensEyes, principal_x)),
        ("step_y", offset_of!(layout::LensEyes, step_y)),
        ("principal_y", offset_of!(layout::LensEyes, principal_y)),
        ("radial", offset_of!(layout::LensEyes, radial)),
        ("divisor", offset_of!(layout::LensEyes, divisor)),
        ("tangential", offset_of!(layout::LensEyes, tangential)),
        ("spare", offset_of!(layout::LensEyes, spare)),
        ("_pad", offset_of!(layout::LensEyes, _pad)),
    ];
    assert_struct(&lens, "Eyes", &stated, size_of::<layout::Eyes>());
    let combine = parse(&COMBINE, &Variant::PIXELS);
    let stated = [
        ("decoded", offset_of!(Combining, decoded)),
        ("of_left", offset_of!(Combining, of_left)),
        ("of_right", offset_of!(Combining, of_right)),
        ("size", offset_of!(Combining, size)),
        ("arrangement", offset_of!(Combining, arrangement)),
        ("_pad", offset_of!(Combining, _pad)),
    ];
    assert_struct(&combine, "Combining", &stated, size_of::<Combining>());
    assert_layout!(module, Band { size, row_begin, row_end, first_row, runs, buffer_depth, jitter_seed });
    assert_layout!(
        module,
        Lighting { light, slot, first_ray, sources, seed, occlusion_radius, share_tolerance, bounces }
    );
    assert_layout!(module, Display { exposure, filmic, words_read, filter_kind });
    assert_layout!(module, Costs { least_spared, listed, disagreed, asked });
    assert_layout!(module, PathRay { ray, bounces, first, tolerance });
    assert_layout!(module, Frame { eyes, band, lighting, display, costs, paths });
    assert_layout!(module, Bvh { grid_origin, extent, grid_cell, zero, cutouts, parents });
    assert_layout!(module, Pixel { depth, slot, marks, color });
    let table = &parse(&READ_TEXELS, &with);
    let stated = [("mapping", offset_of!(layout::TableFrame, mapping)), ("band", offset_of!(layout::TableFrame, band))];
    assert_struct(table, "Frame", &stated, size_of::<layout::TableFrame>());
    assert_layout!(
        table,
        Mapping { light, theta_begin, axis_x, theta_step, axis_y, phi_begin, axis_z, phi_step, columns, margin }
    );
    let listed = parse(&TRACE_LISTED, &with);
    assert_eq!(heads_of(&listed, "Lists"), layout::LISTS_HEADS);
    let paths = &parse(&TRACE_PATHS, &Variant { paths: true, ..with });
    assert_eq!(heads_of(paths, "Paths"), layout::PATHS_HEADS);
    assert_layout!(paths, Path { origin, travelled, direction, density, weight, is_diffuse, entries, t, slot });
    let proposed = &parse(&SCATTER_PATHS, &Variant { paths: true, ..with });
    assert_layout!(proposed, LightRay { direction, far, scale, diffuse, glossy, _pad });
    assert_layout!(proposed, Proposed { start, is_open, emitted, travelled, weight, is_diffuse, albedo, _pad, rays });
    assert_layout!(paths, Brought { diffuse, paths, glossy, marks, squares, newest });
    let bounced = &parse(&TRACE_BOUNCED, &Variant { mirrors: true, ..with });
    assert_eq!(heads_of(bounced, "Bounced"), layout::BOUNCED_HEADS);
    assert_layout!(bounced, SentRay { origin, travelled, direction, depth, weight, t });
    assert_layout!(bounced, BouncedPixel { color, waiting, diffuse, slot, shine, sent, entries, _pad, rays });
    let parts = parse(&ADD_BROUGHT, &Variant { paths: true, linear: true, parts: true, ..with });
    assert_layout!(
        &parts,
        LightParts {
            diffuse,
            diffuse_variance,
            glossy,
            glossy_variance,
            albedo,
            normal,
            rest,
            point_x,
            point_y,
            point_z,
            coverage,
            lobe_width,
            reflectance,
            _pad
        }
    );
    let smooth = parse(&SMOOTH_LIGHT_ONCE, &Variant::PIXELS);
    assert_layout!(&smooth, Noisy { diffuse, diffuse_variance, glossy, glossy_variance });
    assert_layout!(&smooth, Guide { point, normal, lobe_width, _pad });
}

#[test]
fn counters_and_marks_have_the_same_numbers_in_both_languages() {
    let shared: String = SHARED.iter().map(|part| part.text).collect();
    let types = shared
        + include_str!("../../../shaders/bracket/choose.wgsl")
        + include_str!("../../../shaders/history/bound_by_history.wgsl");
    let numbers = [
        ("WORKGROUP", layout::WORKGROUP),
        ("LIST_WORKGROUP", layout::LIST_WORKGROUP),
        ("MOST_ACROSS", crate::gpu::MAX_WORKGROUPS),
        ("COUNTERS", layout::COUNTERS as u32),
        ("NO_NORMAL", layout::NO_NORMAL),
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
        ("WIDE_TILE", layout::WIDE_TILE),
        ("BUSY_RUN", layout::BUSY_RUN),
        ("QUAD", layout::QUAD),
        ("QUAD_RUN", layout::QUAD_RUN),
        ("TILE_PIXELS", layout::TILE_PIXELS),
        ("BOUND_WORDS", layout::BOUND_WORDS),
        ("TILE_WORDS", layout::TILE_WORDS),
        ("CHOSEN", layout::CHOSEN as u32),
        ("SENT_RAYS", layout::SENT_RAYS as u32),
        ("OWN_SHADOW_RAYS", layout::OWN_SHADOW_RAYS as u32),
        ("BRACKET_CHOSEN", layout::BRACKET_CHOSEN),
        ("TO_SEARCH", layout::TO_SEARCH),
        ("ALL_TRACED", layout::ALL_TRACED),
        ("SHARES_SIDE", facets::SIDE as u32),
    ];
    for (name, value) in numbers {
        let decimal = format!("const {name}: u32 = {value}u;");
        let hex = format!("const {name}: u32 = {value:#010x}u;");
        assert!(types.contains(&decimal) || types.contains(&hex), "{name}");
    }
    let host = include_str!("../layout.rs").lines().filter_map(|line| line.strip_prefix("pub(crate) const "));
    for name in host.filter_map(|line| line.split(':').next()) {
        let in_both = types.contains(&format!("const {name}: u32 ="));
        assert!(!in_both || numbers.iter().any(|(known, _)| *known == name), "{name} is not compared");
    }
    for (name, words) in
        [("LIST_WORDS", (layout::TILE_WORDS - 1) / 16), ("LIST_MOST", (layout::TILE_WORDS - 1) / 16 - 1)]
    {
        assert!(types.contains(&format!("const {name}: u32 = {words}u;")), "{name}");
    }
    assert!(types.contains("const FAR: f32 = 3.4e38;") && crate::FAR == 3.4e38);
    assert!(types.contains("const MISS: u32 = 0xffffffffu;") && crate::MISS == u32::MAX);
}
