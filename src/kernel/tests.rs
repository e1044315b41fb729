//! Validates every kernel in every variant with naga, builds pipelines on the adapter, and compares layouts with the
//! host.

mod layouts;
mod shapes;
mod variants;

use std::{collections::BTreeSet, sync::OnceLock};

use naga::valid::{Capabilities, ValidationFlags, Validator};

use super::*;
use crate::gpu::limits_over;
use crate::{
    kernel::wgsl::{self, Condition, SHARED},
    steps::{resolve::TRACE_LISTED, trace::TRACE_LEFT},
    view::rig::CameraModel,
};

use variants::{ALL, variants_of};

/// Returns the file and line below `shaders/` of a location in a kernel's text.
fn place(text: &str, location: Option<naga::SourceLocation>) -> String {
    location.and_then(|location| wgsl::origin(text, location.line_number as usize)).unwrap_or_else(|| "?".into())
}

/// A distinct text, with its kernel and a variant that produces it.
type Module = (&'static Kernel, Variant, String);

/// Returns every distinct text that browsers accept too.
fn portable_modules() -> Vec<&'static Module> {
    let all = modules();
    let portable: Vec<_> = all.iter().filter(|(_, _, text)| is_portable(text)).collect();
    let (before, left_out) = (all.len(), all.len() - portable.len());
    assert!((before / 100..before / 5).contains(&left_out), "{before}, {left_out}");
    portable
}

fn is_portable(text: &str) -> bool {
    !text.contains("ray_query")
}

/// Returns every distinct text. They are linked once for all tests, since that takes seconds.
fn modules() -> &'static [Module] {
    static MODULES: OnceLock<Vec<Module>> = OnceLock::new();
    MODULES.get_or_init(|| {
        let mut seen = BTreeSet::new();
        let all = ALL.iter().flat_map(|kernel| variants_of(kernel).into_iter().map(move |with| (*kernel, with)));
        let all = all.map(|(kernel, with)| (kernel, with, kernel.linked(&with).text));
        all.filter(|(_, _, text)| seen.insert(text.clone())).collect()
    })
}

/// Parses each text once for all checks of its module, since that takes a minute.
#[test]
fn every_specialised_kernel_is_valid_lean_bound_as_linked_and_within_the_limits_asked_for() {
    let modules = modules();
    assert!(modules.len() > 100, "{}", modules.len());
    let asked = limits_over(wgpu::Limits::downlevel_webgl2_defaults());
    let mut needed = no_limits(&asked);
    for (kernel, with, text) in modules {
        let module = parse_text(kernel, with, text);
        validate(kernel, with, text, &module);
        assert_bound_as_linked(kernel, with, &module);
        if is_portable(text) {
            raise_limits(&mut needed, kernel, &module);
        }
        assert_lean(kernel, with, text, module);
    }
    assert_eq!(needed, asked);
    assert!(asked.check_limits(&wgpu::Limits::default()), "more than WebGPU promises");
}

fn parse(kernel: &Kernel, with: &Variant) -> naga::Module {
    parse_text(kernel, with, &kernel.linked(with).text)
}

fn parse_text(kernel: &Kernel, with: &Variant, text: &str) -> naga::Module {
    naga::front::wgsl::parse_str(text).unwrap_or_else(|error| {
        panic!("{}: {} {with:?}: {}", place(text, error.location(text)), kernel.name, error.emit_to_string(text))
    })
}

/// Verifies that a module is valid, has the entry point of its file's name, and uses at most seven storage buffers.
fn validate(kernel: &Kernel, with: &Variant, text: &str, module: &naga::Module) {
    let capabilities = Capabilities::SHADER_FLOAT16_IN_FLOAT32 | Capabilities::RAY_QUERY;
    let info = Validator::new(ValidationFlags::all(), capabilities).validate(module).unwrap_or_else(|error| {
        let place = place(text, error.location(text));
        panic!("{place}: {} {with:?}: {}", kernel.name, error.emit_to_string(text))
    });
    assert_eq!(module.entry_points.len(), 1);
    let (_, file) = kernel.main.file.split_once('/').unwrap();
    assert_eq!(format!("{}.wgsl", module.entry_points[0].name), file);
    let used = module.global_variables.iter().filter(|(handle, variable)| {
        !info.get_entry_point(0)[*handle].is_empty() && matches!(variable.space, naga::AddressSpace::Storage { .. })
    });
    assert!(used.count() <= 7, "{} {with:?}", kernel.name);
}

/// Writes modules for `scripts/check_wgsl.sh`, which checks them with a stricter front end than naga.
#[test]
fn every_distinct_module_is_written_to_target_wgsl() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/target/wgsl");
    let _ = std::fs::remove_dir_all(folder);
    std::fs::create_dir_all(folder).unwrap();
    let modules = portable_modules();
    for (number, (kernel, _, text)) in modules.iter().enumerate() {
        std::fs::write(format!("{folder}/{number:04}_{}.wgsl", kernel.name), text).unwrap();
    }
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), modules.len());
}

/// Writes the modules of GPUs for `scripts/check_shapes.sh`, which compiles them for a GPU.
#[test]
fn modules_of_gpus_are_written_to_target_shapes() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/target/shapes");
    let _ = std::fs::remove_dir_all(folder);
    std::fs::create_dir_all(folder).unwrap();
    let mut seen = BTreeSet::new();
    for kernel in ALL {
        for (kind, text) in shapes::modules_of(kernel) {
            if seen.insert(text.clone()) {
                std::fs::write(format!("{folder}/{}.{kind}.wgsl", kernel.name), text).unwrap();
            }
        }
    }
    assert!(seen.len() > 90, "{}", seen.len());
}

/// Returns the limits before any kernel. The number of workgroups belongs to a dispatch, not to a kernel.
fn no_limits(asked: &wgpu::Limits) -> wgpu::Limits {
    wgpu::Limits {
        max_compute_workgroups_per_dimension: asked.max_compute_workgroups_per_dimension,
        max_compute_workgroup_storage_size: 0,
        max_bind_groups: 0,
        max_bindings_per_bind_group: 0,
        max_uniform_buffers_per_shader_stage: 0,
        max_buffers_and_acceleration_structures_per_shader_stage: 0,
        ..wgpu::Limits::downlevel_webgl2_defaults()
    }
}

/// Raises limits to what a module needs.
fn raise_limits(needed: &mut wgpu::Limits, kernel: &Kernel, module: &naga::Module) {
    let [x, y, z] = module.entry_points[0].workgroup_size;
    let mut raise = |limit: fn(&mut wgpu::Limits) -> &mut u32, to: u32| {
        let limit = limit(needed);
        *limit = to.max(*limit);
    };
    raise(|limits| &mut limits.max_compute_workgroup_size_x, x);
    raise(|limits| &mut limits.max_compute_workgroup_size_y, y);
    raise(|limits| &mut limits.max_compute_workgroup_size_z, z);
    raise(|limits| &mut limits.max_compute_invocations_per_workgroup, x * y * z);
    let layouts = module.global_variables.iter().filter(|(_, one)| one.space == naga::AddressSpace::WorkGroup);
    let bytes = |ty: naga::Handle<naga::Type>| module.types[ty].inner.size(module.to_ctx()).next_multiple_of(16);
    let storage = layouts.map(|(_, variable)| bytes(variable.ty)).sum();
    raise(|limits| &mut limits.max_compute_workgroup_storage_size, storage);
    let mut count = [0; 4];
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
        }] += 1;
    }
    let [uniforms, buffers, textures, sampled] = count;
    assert!(sampled <= 3, "{kernel:?}: {sampled} sampled textures");
    raise(|limits| &mut limits.max_uniform_buffers_per_shader_stage, uniforms);
    raise(|limits| &mut limits.max_storage_buffers_per_shader_stage, buffers);
    raise(|limits| &mut limits.max_storage_textures_per_shader_stage, textures);
    raise(|limits| &mut limits.max_buffers_and_acceleration_structures_per_shader_stage, uniforms + buffers);
}

/// Builds every 27th variant of each kernel, and every 81st of kernels that draw on tables, at least one of each, with
/// offsets that differ between kernels. The long form (`STEREOTRACE_TESTS=long`) builds every third and every ninth.
/// Drivers are too slow to build all variants. naga and Tint validate all of them.
#[test]
fn specialised_kernels_make_pipelines() {
    let gpu = crate::Gpu::under_test();
    let make = || {
        let pipelines = Kernels::default();
        let mut built = BTreeSet::new();
        for (index, kernel) in ALL.into_iter().enumerate() {
            let long = std::env::var_os("STEREOTRACE_TESTS").is_some_and(|form| form == "long");
            let on_tables = matches!(kernel.role, Role::Draw(Canvas::Middles | Canvas::Texels));
            let variants = variants_of(kernel);
            let step = [27, 3][usize::from(long)] * if on_tables { 3 } else { 1 };
            let step = step.min(variants.len());
            for with in variants.into_iter().skip(index % step).step_by(step) {
                let text = kernel.linked(&with).text;
                let can_build = gpu.has_ray_queries() || !text.contains("ray_query");
                if can_build && built.insert((text, with.count, with.cost_map)) {
                    pipelines.get(&gpu, kernel, with);
                }
            }
        }
        Ok(())
    };
    pollster::block_on(gpu.checked(make)).unwrap();
}

/// Verifies that the bindings of a linked text are those that naga sees.
fn assert_bound_as_linked(kernel: &Kernel, with: &Variant, module: &naga::Module) {
    let bindings = kernel.linked(with).bindings;
    let mut seen: Vec<_> = module.global_variables.iter().filter(|(_, found)| found.binding.is_some()).collect();
    seen.sort_by_key(|(_, found)| found.binding.as_ref().unwrap().binding);
    assert_eq!(bindings.len(), seen.len(), "{}", kernel.name);
    for (binding, (_, found)) in bindings.iter().zip(seen) {
        assert_eq!(Resource::named(found.name.as_deref().unwrap()), binding.resource, "{}", kernel.name);
        let is_same = match (binding.ty, found.space) {
            (wgpu::BindingType::Buffer { ty, .. }, naga::AddressSpace::Uniform) => {
                ty == wgpu::BufferBindingType::Uniform
            }
            (wgpu::BindingType::Buffer { ty, .. }, naga::AddressSpace::Storage { access }) => {
                let read_only = !access.contains(naga::StorageAccess::STORE);
                ty == wgpu::BufferBindingType::Storage { read_only }
            }
            (wgpu::BindingType::StorageTexture { access, .. }, naga::AddressSpace::Handle) => {
                let naga::TypeInner::Image { class, .. } = module.types[found.ty].inner else { panic!("{found:?}") };
                let naga::ImageClass::Storage { access: seen, .. } = class else { panic!("{class:?}") };
                (access == wgpu::StorageTextureAccess::WriteOnly) == seen.contains(naga::StorageAccess::STORE)
            }
            (wgpu::BindingType::Texture { .. }, naga::AddressSpace::Handle) => true,
            (wgpu::BindingType::AccelerationStructure { .. }, naga::AddressSpace::Handle) => {
                matches!(module.types[found.ty].inner, naga::TypeInner::AccelerationStructure { .. })
            }
            _ => false,
        };
        assert!(is_same, "{}: {binding:?} is {found:?}", kernel.name);
    }
}

/// Verifies with naga that texts have only definitions that they use. naga follows calls, but does not evaluate
/// constant `if` conditions.
fn assert_lean(kernel: &Kernel, with: &Variant, text: &str, mut module: naga::Module) {
    let names = |module: &naga::Module| -> BTreeSet<String> {
        let functions = module.functions.iter().filter_map(|(_, function)| function.name.clone());
        // Bindings are excluded. They are declared for the reader, whether or not a variant needs them.
        let variables = module.global_variables.iter().filter(|(_, variable)| variable.binding.is_none());
        functions.chain(variables.filter_map(|(_, variable)| variable.name.clone())).collect()
    };
    let all = names(&module);
    naga::compact::compact(&mut module, naga::compact::KeepUnused::No);
    let used = names(&module);
    let unused: Vec<_> = all.difference(&used).collect();
    assert!(unused.is_empty(), "{} {with:?}: {unused:?}\n{text}", kernel.name);
}

#[test]
fn files_list_the_shared_files_that_they_use_and_these_form_no_circle() {
    for part in SHARED.iter().copied().chain(ALL.iter().map(|kernel| kernel.main)) {
        let [found, listed] = wgsl::uses_of(part);
        assert_eq!(listed, found, "{}", part.file);
    }
    // Each round removes the files that use none of the remaining files. A cycle would remain.
    let mut left: Vec<_> = SHARED.iter().map(|part| (part.file, wgsl::uses_of(*part)[0].clone())).collect();
    while !left.is_empty() {
        let (above, below): (Vec<_>, Vec<_>) = left.iter().cloned().partition(|(_, uses)| !uses.is_empty());
        assert!(!below.is_empty(), "a circle among {:?}", above.iter().map(|(file, _)| file).collect::<Vec<_>>());
        let is_gone = |name: &&str| below.iter().any(|(file, _)| *file == format!("shared/{name}.wgsl"));
        left = above
            .into_iter()
            .map(|(file, uses)| (file, uses.into_iter().filter(|name| !is_gone(name)).collect()))
            .collect();
    }
}

#[test]
fn every_wgsl_file_is_known_and_every_shared_definition_is_part_of_a_kernel() {
    let shaders = format!("{}/shaders", env!("CARGO_MANIFEST_DIR"));
    let names_in = |folder: std::path::PathBuf| {
        let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let name = |path: std::path::PathBuf| path.strip_prefix(&shaders).unwrap().to_str().unwrap().to_owned();
        entries.filter(|path| path.is_file()).map(name).collect::<Vec<_>>()
    };
    let folders = std::fs::read_dir(&shaders).unwrap().map(|entry| entry.unwrap().path());
    let there: BTreeSet<String> = folders.flat_map(names_in).collect();
    let known = ALL.iter().map(|kernel| kernel.main).chain(SHARED.iter().copied());
    assert_eq!(there, known.map(|part| part.file.to_owned()).collect());
    let texts: Vec<_> = modules().iter().map(|(_, _, text)| text).collect();
    let lines: BTreeSet<_> = texts.iter().flat_map(|text| text.lines()).collect();
    let unused: Vec<_> = wgsl::shared()
        .iter()
        .filter(|definition| !lines.contains(&*format!("// {}:{}", definition.file, definition.line)))
        .map(|definition| format!("{}:{}: {}", definition.file, definition.line, definition.name))
        .collect();
    assert!(unused.is_empty(), "{unused:#?}");
}

/// A feature that a frame does not use costs nothing, since the text for the driver does not contain it.
#[test]
fn buffers_that_take_the_place_of_rays_are_in_no_text_without_them() {
    let mut with_tables = 0;
    for (kernel, with, text) in modules() {
        let reads = with.of_role(kernel.role).shadow_buffer.is_some();
        assert_eq!(text.contains("shadow_buffers"), reads, "{}", kernel.name);
        assert!(reads || !text.contains("said_by_table"), "{}", kernel.name);
        let draws = matches!(kernel.role, Role::Draw(_) | Role::Hits(Hits::Drawn));
        assert!(draws || !text.contains("t_buffer["), "{}", kernel.name);
        with_tables += usize::from(reads);
    }
    assert!(with_tables > 20);
}

#[test]
fn lenses_are_in_no_text_of_other_cameras() {
    let mut with_lenses = 0;
    for (kernel, with, text) in modules() {
        let is_seen_through = text.contains("undistorted(");
        let has_lens = matches!(with.of_role(kernel.role).camera, CameraModel::Lens(_));
        assert!(has_lens || !is_seen_through, "{}", kernel.name);
        with_lenses += usize::from(is_seen_through);
    }
    assert!(with_lenses > 5);
}

#[test]
fn sections_ask_for_choices_and_values_that_there_are() {
    let all = ALL
        .into_iter()
        .flat_map(|kernel| variants_of(kernel).into_iter().map(move |with| kernel.choices(&with.of_role(kernel.role))));
    let there: BTreeSet<_> = all.flatten().collect();
    for definition in wgsl::shared() {
        for Condition { choice, values } in &definition.when {
            let known = values.iter().all(|value| there.contains(&(*choice, *value)));
            assert!(known, "{}:{}: {choice} is {values:?}", definition.file, definition.line);
        }
    }
}
