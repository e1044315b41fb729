//! Every kernel in every variant against naga, the adapter, the table and the host's structs.

use std::{collections::BTreeSet, mem::offset_of};

use naga::valid::{Capabilities, ValidationFlags, Validator};

use super::*;
use crate::{
    ShadowReuse,
    cast::{ANY_HITS, ANY_HITS_IN_STEPS, CLOSEST_HITS, CLOSEST_HITS_IN_STEPS},
    steps::{
        bracket::{
            BOUND_TILES, CHOOSE, RESOLVE_TILES, SEARCH_TILES, SHADE_LISTED, SHADE_SKY, SHADE_TILES, TRACE_BOUNDED,
        },
        edges::MARK_EDGES,
        mirrors::{LIST_MIRRORS, TRACE_MIRRORED},
        reproject::{DEPTH_RANGE, GATHER_SLOTS, REPROJECT, REPROJECT_SCANLINE, REPROJECT_SLOTS},
        resolve::{RESOLVE_RIGHT, RESOLVE_TRUSTED, SHADE_TRACED, TAKE_OVER, TRACE_LISTED},
        show::{PACK, SHOW_COLOR, SHOW_DEPTH},
        soft::{SHADE_HITS, TRACE_HITS, TRACE_SOFT, TRACE_SOFT_ASKED, TRACE_SOFT_LISTED},
        trace::{TRACE_IN_STEPS, TRACE_LEFT},
    },
    traversal::{Boxes, Fetch, Traversal},
    variant::{Shadows, SkyKind},
    wgsl::{self, Condition, SHARED},
};

const ALL: [&Kernel; 35] = [
    &LIST_MIRRORS,
    &TRACE_MIRRORED,
    &TRACE_IN_STEPS,
    &CLOSEST_HITS_IN_STEPS,
    &ANY_HITS_IN_STEPS,
    &SHADE_SKY,
    &SHADE_TILES,
    &BOUND_TILES,
    &CHOOSE,
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
    &RESOLVE_TRUSTED,
    &TRACE_LISTED,
    &SHADE_TRACED,
    &TAKE_OVER,
    &TRACE_HITS,
    &TRACE_SOFT,
    &TRACE_SOFT_LISTED,
    &TRACE_SOFT_ASKED,
    &SHADE_HITS,
    &PACK,
    &SHOW_COLOR,
    &SHOW_DEPTH,
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
fn variants() -> Vec<Variant> {
    let traversals = Traversal::ALL.iter().flat_map(|&traversal| [(traversal, false), (traversal, true)]);
    let traversals: Vec<_> = traversals.filter(|(with, world)| with.boxes == Boxes::F32 || !world).collect();
    // Spheres, triangles, normals, ellipsoids.
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
    let rows = all_pairs([traversals.len(), kinds.len(), 4, 4, 3, 3, 3, 2, 6, 4, 2]);
    let with = |&[traversal, kind, light, kept, sky, bits, counting, close, surfaces, soft, cutouts]: &[usize; 11]| {
        let ((traversal, world_boxes), [spheres, triangles, normals, ellipsoids]) =
            (traversals[traversal], kinds[kind]);
        Variant {
            traversal,
            triangles,
            spheres,
            ellipsoids,
            normals,
            // What a scene has none of, textures of balls, and of triangles, with and without the others.
            uv: [2, 5].contains(&surfaces),
            colors: [3, 5].contains(&surfaces),
            textures: ![0, 4].contains(&surfaces),
            shine: surfaces > 3,
            mirrors: surfaces % 2 == 1,
            cutouts: triangles && cutouts == 1,
            lights: light > 0,
            shadows: shadows[light.saturating_sub(1)],
            // No soft light, lights, occlusion, both; what is never hidden among them.
            soft_lights: soft % 2 == 1,
            casts: soft == 0 || light % 2 == 1,
            shadow_rays: if soft % 2 == 1 { 16 } else { 0 },
            occlusion_rays: if soft > 1 { 32 } else { 0 },
            shares: soft > 0 && bits == 1,
            sky: [SkyKind::Constant, SkyKind::Gradient, SkyKind::Map][sky],
            world_boxes,
            close: close == 1,
            samples: kept & 1 == 1,
            second: kept & 2 == 2,
            linear: kept & 2 == 2,
            stack_size: 40,
            bits: [ShadowReuse::Rays, ShadowReuse::Two, ShadowReuse::Block][bits],
            count: counting > 0,
            cost_map: counting > 1,
        }
    };
    // What the scenes of spheres alone are paired with, a scene without primitives is paired with too.
    let spheres_alone = rows.iter().filter(|row| row[1] == 0);
    let empty = spheres_alone.map(|row| Variant { spheres: false, ..with(row) });
    rows.iter().map(with).chain(empty).collect()
}

/// Those of a kernel: `bracket`'s keep samples, mirrors' have mirrors, soft light's have such, and a scene without primitives has no tiles to bound.
fn variants_of(kernel: &Kernel) -> Vec<Variant> {
    let mut all = variants();
    if [LIST_MIRRORS.name, TRACE_MIRRORED.name].contains(&kernel.name) {
        all.retain(|with| with.triangles || with.spheres);
        all.iter_mut().for_each(|with| *with = Variant { mirrors: true, ..*with }.of_kernel(kernel));
    }
    if [&TRACE_SOFT, &TRACE_SOFT_LISTED, &TRACE_SOFT_ASKED, &SHADE_HITS].iter().any(|known| known.name == kernel.name) {
        all.retain(Variant::is_soft);
    }
    if [&SEARCH_TILES, &RESOLVE_TILES, &SHADE_SKY, &TRACE_BOUNDED, &SHADE_TILES, &SHADE_LISTED, &TRACE_SOFT_ASKED]
        .iter()
        .any(|known| known.name == kernel.name)
    {
        all.retain(|with| with.triangles || with.spheres);
        all.iter_mut().for_each(|with| with.samples = true);
    }
    all
}

/// The file and line below `shaders/` of a place in a kernel's text.
fn place(text: &str, location: Option<naga::SourceLocation>) -> String {
    location.and_then(|location| wgsl::origin(text, location.line_number as usize)).unwrap_or_else(|| "?".into())
}

fn parse(kernel: &Kernel, with: &Variant) -> naga::Module {
    let text = kernel.text(with);
    naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| {
        panic!("{}: {} {with:?}: {}", place(&text, error.location(&text)), kernel.name, error.emit_to_string(&text))
    })
}

/// Every distinct text, with its kernel and a variant that gives it.
fn modules() -> Vec<(&'static Kernel, Variant, String)> {
    let mut seen = BTreeSet::new();
    let all = ALL.into_iter().flat_map(|kernel| variants_of(kernel).into_iter().map(move |with| (kernel, with)));
    let all = all.map(|(kernel, with)| (kernel, with, kernel.text(&with)));
    all.filter(|(_, _, text)| seen.insert(text.clone())).collect()
}

#[test]
fn every_specialised_kernel_passes_naga_and_keeps_to_six_storage_buffers() {
    let modules = modules();
    assert!(modules.len() > 100, "{}", modules.len());
    for (kernel, with, text) in modules {
        let module = parse(kernel, &with);
        let info = Validator::new(ValidationFlags::all(), Capabilities::SHADER_FLOAT16_IN_FLOAT32)
            .validate(&module)
            .unwrap_or_else(|error| {
                let place = place(&text, error.location(&text));
                panic!("{place}: {} {with:?}: {}", kernel.name, error.emit_to_string(&text))
            });
        assert_eq!(module.entry_points.len(), 1);
        assert_eq!(format!("{}.wgsl", module.entry_points[0].name), kernel.main.file);
        let used = module.global_variables.iter().filter(|(handle, variable)| {
            !info.get_entry_point(0)[*handle].is_empty() && matches!(variable.space, naga::AddressSpace::Storage { .. })
        });
        assert!(used.count() <= 6, "{} {with:?}", kernel.name);
    }
}

/// For `scripts/check_wgsl.sh`, which shows them to a stricter front end than naga.
#[test]
fn every_distinct_module_is_written_to_target_wgsl() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/target/wgsl");
    let _ = std::fs::remove_dir_all(folder);
    std::fs::create_dir_all(folder).unwrap();
    let modules = modules();
    for (number, (kernel, _, text)) in modules.iter().enumerate() {
        std::fs::write(format!("{folder}/{number:04}_{}.wgsl", kernel.name), text).unwrap();
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
        // A layout has all of the scene's bindings, whether or not the kernel uses them.
        let scene = u32::from(kernel.touches.geometry()) + u32::from(kernel.touches.table());
        let mut count = match with.traversal.fetch {
            Fetch::Buffer => [0, scene, 0, 0],
            Fetch::Texture => [0, 0, scene, 0],
        };
        count[0] = u32::from(kernel.touches.geometry());
        for (_, variable) in module.global_variables.iter() {
            let Some(binding) = &variable.binding else { continue };
            raise(|limits| &mut limits.max_bind_groups, binding.group + 1);
            raise(|limits| &mut limits.max_bindings_per_bind_group, binding.binding + 1);
            let sampled = |class| !matches!(class, naga::ImageClass::Storage { .. });
            count[match (variable.space, &module.types[variable.ty].inner) {
                (naga::AddressSpace::Uniform, _) => 0,
                (naga::AddressSpace::Storage { .. }, _) => 1,
                (_, naga::TypeInner::Image { class, .. }) if sampled(*class) => 3,
                _ => 2,
            }] += u32::from(binding.group == 1);
        }
        let [uniforms, buffers, textures, sampled] = count;
        assert!(sampled <= 1, "{kernel:?}: {sampled} sampled textures");
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
    let gpu = crate::Gpu::open(std::env::var(crate::gpu::ADAPTER_VARIABLE).unwrap_or("software".into())).unwrap();
    let make = || {
        let pipelines = Kernels::new(&gpu);
        let mut built = BTreeSet::new();
        for kernel in ALL {
            for with in variants_of(kernel) {
                if built.insert((kernel.text(&with), with.count, with.cost_map)) {
                    pipelines.get(&gpu, kernel, with);
                }
            }
        }
        Ok(())
    };
    pollster::block_on(gpu.checked(make)).unwrap();
}

/// Beside the scene's nodes and primitives, which count once: six storage buffers and three storage textures in all.
#[test]
fn no_layout_has_more_than_five_storage_buffers_or_two_storage_textures_beside_the_scene_s() {
    let gpu = crate::Gpu::open(std::env::var(crate::gpu::ADAPTER_VARIABLE).unwrap_or("software".into())).unwrap();
    let kernels = Kernels::new(&gpu);
    for kernel in ALL {
        for with in variants_of(kernel) {
            let with = with.of_kernel(kernel);
            let own = kernels.program(kernel, &with).own;
            let count = |is: fn(&wgpu::BindingType) -> bool| own.iter().filter(|entry| is(&entry.ty)).count();
            let textures = count(|ty| matches!(ty, wgpu::BindingType::StorageTexture { .. }));
            let uniforms =
                count(|ty| matches!(ty, wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Uniform, .. }));
            let sampled = count(|ty| matches!(ty, wgpu::BindingType::Texture { .. }));
            let buffers = own.len() - textures - uniforms - sampled;
            let table = usize::from(kernel.touches.table());
            let (buffers, textures) = match with.traversal.fetch {
                Fetch::Buffer => (buffers + table, textures),
                Fetch::Texture => (buffers, textures + table),
            };
            assert!(buffers <= 5 && textures <= 2, "{} {with:?}: {buffers} buffers, {textures} textures", kernel.name);
        }
    }
}

#[test]
fn bindings_of_group_1_are_as_the_table_says() {
    for kernel in ALL {
        let module = parse(kernel, &variants_of(kernel)[0]);
        let mut found: Vec<_> = module
            .global_variables
            .iter()
            .filter_map(|(_, variable)| Some((variable.binding.as_ref()?, variable.space)))
            .filter(|(binding, _)| binding.group == 1 && (1..PICTURE_BINDING).contains(&binding.binding))
            .map(|(binding, space)| match space {
                naga::AddressSpace::Storage { access } if access.contains(naga::StorageAccess::STORE) => {
                    (binding.binding, Write)
                }
                _ => (binding.binding, Read),
            })
            .collect();
        found.sort_by_key(|(binding, _)| *binding);
        let stated: Vec<_> = kernel.storage.iter().zip(1..).map(|((_, access), binding)| (binding, *access)).collect();
        assert_eq!(found, stated, "{}", kernel.name);
    }
}

/// An independent compiler's word that only what is used is there. (naga follows calls; of what a constant `if` leaves out
/// it knows nothing.)
#[test]
fn no_kernel_has_a_function_or_variable_that_it_does_not_use() {
    for (kernel, with, text) in modules() {
        let all = parse(kernel, &with);
        let mut used = parse(kernel, &with);
        naga::compact::compact(&mut used, naga::compact::KeepUnused::No);
        let names = |module: &naga::Module| -> BTreeSet<String> {
            let functions = module.functions.iter().filter_map(|(_, function)| function.name.clone());
            // A binding is stated for the reader, whether or not some variant needs it.
            let variables = module.global_variables.iter().filter(|(_, variable)| variable.binding.is_none());
            functions.chain(variables.filter_map(|(_, variable)| variable.name.clone())).collect()
        };
        let unused: Vec<_> = names(&all).difference(&names(&used)).cloned().collect();
        assert!(unused.is_empty(), "{} {with:?}: {unused:?}\n{text}", kernel.name);
    }
}

#[test]
fn every_wgsl_file_is_known_and_every_shared_definition_is_part_of_a_kernel() {
    let folder = |name: &str| {
        let entries = std::fs::read_dir(format!("{}/shaders/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let names = entries.map(|entry| format!("{name}{}", entry.unwrap().file_name().into_string().unwrap()));
        names.filter(|name| name.ends_with(".wgsl")).collect::<BTreeSet<_>>()
    };
    assert_eq!(folder(""), ALL.iter().map(|kernel| kernel.main.file.to_owned()).collect());
    assert_eq!(folder("shared/"), SHARED.iter().map(|part| part.file.to_owned()).collect());
    let texts: Vec<_> = modules().into_iter().map(|(_, _, text)| text).collect();
    let lines: BTreeSet<_> = texts.iter().flat_map(|text| text.lines()).collect();
    let unused: Vec<_> = wgsl::shared()
        .iter()
        .filter(|definition| !lines.contains(&*format!("// {}:{}", definition.file, definition.line)))
        .map(|definition| format!("{}:{}: {}", definition.file, definition.line, definition.name))
        .collect();
    assert!(unused.is_empty(), "{unused:#?}");
}

#[test]
fn sections_ask_for_choices_and_values_that_there_are() {
    let all = ALL.into_iter().flat_map(|kernel| variants_of(kernel).into_iter().map(move |with| kernel.choices(&with)));
    let there: BTreeSet<_> = all.flatten().collect();
    for definition in wgsl::shared() {
        if let Some(Condition { choice, values }) = &definition.when {
            let known = values.iter().all(|value| there.contains(&(*choice, *value)));
            assert!(known, "{}:{}: {choice} is {values:?}", definition.file, definition.line);
        }
    }
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
    let with = Variant { spheres: true, triangles: true, cutouts: false, ..variants()[0] };
    let module = &parse(&TRACE_LEFT, &with);
    assert_layout!(
        module,
        Frame {
            source_eye,
            parallax_px,
            target_eye,
            screen_distance,
            source_corner,
            shift,
            target_corner,
            same_parallax,
            step_x,
            buffer_depth,
            step_y,
            row_begin,
            right_axis,
            row_end,
            image_size,
            longest,
            runs,
            forward,
            wider,
            first_row,
            cost_of_search,
            cost_of_shadow,
            cost_of_listed,
            second_parallax_px,
            second_same_parallax,
            bounces,
            words_read,
            soft_light,
            soft_slot,
            soft_first,
            soft_sources,
            seed,
            occlusion_radius,
            share_tolerance,
            exposure,
            filmic,
            zero_a,
            zero_b,
            zero,
        }
    );
    assert_layout!(module, Bvh { grid_origin, extent, grid_cell, zero });
    let stated = [
        ("grid_origin", offset_of!(layout::CutOutBvh, bvh.grid_origin)),
        ("extent", offset_of!(layout::CutOutBvh, bvh.extent)),
        ("grid_cell", offset_of!(layout::CutOutBvh, bvh.grid_cell)),
        ("zero", offset_of!(layout::CutOutBvh, bvh.zero)),
        ("cutouts", offset_of!(layout::CutOutBvh, cutouts)),
    ];
    let cut_out = parse(&TRACE_LEFT, &Variant { cutouts: true, ..with });
    assert_struct(&cut_out, "Bvh", &stated, size_of::<layout::CutOutBvh>());
    assert_layout!(module, Pixel { depth, slot, marks, color });
    let listed = parse(&TRACE_LISTED, &with);
    let header = listed.types.iter().find_map(|(_, kind)| match &kind.inner {
        naga::TypeInner::Struct { members, .. } if kind.name.as_deref() == Some("Lists") => Some(members[1].offset),
        _ => None,
    });
    assert_eq!(header.map(u64::from), Some(layout::LISTS_HEADS));
}

#[test]
fn counters_and_marks_have_the_same_numbers_in_both_languages() {
    let types: String = SHARED.iter().map(|part| part.text).collect();
    for (name, value) in [
        ("WORKGROUP", layout::WORKGROUP),
        ("LIST_WORKGROUP", layout::LIST_WORKGROUP),
        ("COUNTERS", layout::COUNTERS as u32),
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
        ("TILE_PIXELS", layout::TILE_PIXELS),
        ("TILE_WORDS", layout::TILE_WORDS),
    ] {
        let decimal = format!("const {name}: u32 = {value}u;");
        let hex = format!("const {name}: u32 = {value:#010x}u;");
        assert!(types.contains(&decimal) || types.contains(&hex), "{name}");
    }
    for (name, words) in
        [("LIST_WORDS", (layout::TILE_WORDS - 1) / 16), ("LIST_MOST", (layout::TILE_WORDS - 1) / 16 - 1)]
    {
        assert!(types.contains(&format!("const {name}: u32 = {words}u;")), "{name}");
    }
    assert!(types.contains("const FAR: f32 = 3.4e38;") && crate::FAR == 3.4e38);
    assert!(types.contains("const MISS: u32 = 0xffffffffu;") && crate::MISS == u32::MAX);
}
