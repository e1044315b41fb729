//! `info`: shows what a scene contains, how comfortable its picture is to view, and this machine's adapters.

use std::{error::Error, fmt::Write};

use clap::Args;
use serde_json::{Value, json};
use stereotrace::{
    Builtin,
    glam::DVec3,
    message::{counted, escaped},
    wgpu,
};

use super::report::scene_line;
use crate::{
    arguments::{Global, Purpose, Stage, Subject, above_zero, depths},
    summary::Summary,
};

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// Width in metres of the display that comfort is computed for
    #[arg(long, value_name = "METRES", default_value_t = 0.6, value_parser = above_zero, allow_hyphen_values = true)]
    display_width: f32,
    #[command(flatten)]
    pub(crate) subject: Subject,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let mut stage = arguments.subject.open(Purpose::Data, global)?;
    let mut text = format!("stereotrace {}\n", env!("CARGO_PKG_VERSION"));
    let machine = machine(&stage, &mut text)?;
    let builtins = Builtin::ALL.iter().map(Builtin::to_string);
    let builtins = Vec::from_iter(builtins);
    writeln!(text, "built in   {}", builtins.join(", "))?;
    let scene = scene(&mut stage, arguments, &mut text)?;
    let json = json!({
        "version": env!("CARGO_PKG_VERSION"), "machine": machine, "builtin": builtins, "scene": scene
    });
    Ok(Summary { text, json, ..Summary::default() })
}

/// Lists the adapters, and the limits of the one that renders.
fn machine(stage: &Stage, text: &mut String) -> Result<Value, Box<dyn Error>> {
    let gpu = stage.renderer.gpu();
    let (limits, own) = (gpu.device().limits(), gpu.adapter_name());
    // OpenGL would list the same hardware again, and its driver may print to the terminal.
    let backends = wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY);
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends = backends;
    let there = pollster::block_on(wgpu::Instance::new(descriptor).enumerate_adapters(backends));
    let names = there.iter().map(wgpu::Adapter::get_info).map(|info| {
        escaped(&format!("{} ({:?}, {:?}; {})", info.name, info.device_type, info.backend, info.driver_info))
    });
    let names = Vec::from_iter(names);
    writeln!(text, "adapter    {}", escaped(&own))?;
    let (binding, side) = (limits.max_storage_buffer_binding_size, limits.max_texture_dimension_2d);
    writeln!(text, "           a scene can have {} MiB, a view {side} pixels per side", binding >> 20)?;
    let timestamps = gpu.device().features().contains(wgpu::Features::TIMESTAMP_QUERY);
    writeln!(text, "           {}", if timestamps { "timestamps for each pass" } else { "no timestamps" })?;
    for (index, name) in names.iter().enumerate() {
        writeln!(text, "{:<11}{name}", if index == 0 { "available" } else { "" })?;
    }
    Ok(json!({
        "adapter": own,
        "max_storage_buffer_binding_size": binding,
        "max_buffer_size": limits.max_buffer_size,
        "max_texture_dimension_2d": side,
        "timestamps": timestamps,
        "adapters": names,
    }))
}

/// Lists the scene's contents, its camera, the depths that the camera sees, and the comfort of the pair.
fn scene(stage: &mut Stage, arguments: &Arguments, text: &mut String) -> Result<Value, Box<dyn Error>> {
    writeln!(text, "scene      {}", escaped(&scene_line(stage)))?;
    // Every scene has a grey material first, in addition to the file's.
    let (materials, objects) = (stage.scene.materials().len() - 1, stage.scene.object_count());
    let textured = stage.scene.materials().iter().filter(|material| material.texture.is_some()).count();
    writeln!(
        text,
        "           {}, {textured} of them textured; {}",
        counted(materials, "material", "materials"),
        counted(objects, "object", "objects")
    )?;
    for animation in &stage.animations {
        writeln!(text, "           animation {}, {:.2} s", escaped(animation.name()), animation.duration())?;
    }
    let bounds = stage.scene.bounds();
    if let Some((low, high)) = bounds {
        writeln!(text, "           from {low} to {high}")?;
    }
    let origin = stage.scene.origin();
    if origin != DVec3::ZERO {
        writeln!(text, "           stored relative to its origin {origin}")?;
    }
    let info = stage.uploaded.info();
    let bytes = info.node_bytes + info.primitive_bytes;
    let build = info.build.as_secs_f64();
    writeln!(
        text,
        "           {:.1} MiB of BVH and primitives, built in {build:.2} s",
        bytes as f64 / f64::from(1 << 20)
    )?;

    let pose = stage.camera.pose()?;
    let [width, height] = pose.size;
    let (near, far) = depths(&mut stage.renderer, &stage.uploaded, &stage.camera)?;
    let (e, px, d) = (pose.interaxial, pose.interaxial_px, pose.screen_distance);
    let is_around = pose.projection.equirectangular().is_some();
    let screen = if is_around { ", equirectangular".into() } else { format!(" ({px:.2} px), d = {d:.4}") };
    writeln!(text, "camera     {width}x{height}, e = {e:.4}{screen}; at {} along {}", pose.eye, pose.forward)?;
    let reach = if far == f32::INFINITY { "the sky".into() } else { format!("{far:.4}") };
    writeln!(text, "           visible depths from {near:.4} to {reach}")?;
    let comfort = pose.comfort(near, far, arguments.display_width);
    let (near_percent, far_percent) = (comfort.negative_parallax_percent, comfort.positive_parallax_percent);
    if !is_around {
        writeln!(
            text,
            "comfort    parallax {near_percent:.2}% to {far_percent:.2}% of the width, on a display {} m wide",
            arguments.display_width
        )?;
    }
    for warning in comfort.warnings() {
        writeln!(text, "           warning: {warning}")?;
    }
    let finite = |value: f32| Some(value).filter(|value| value.is_finite());
    Ok(json!({
        "name": stage.name,
        "triangles": stage.scene.triangles().len(),
        "spheres": stage.scene.spheres().len(),
        "ellipsoids": stage.scene.ellipsoids().len(),
        "planes": stage.scene.planes().len(),
        "lights": stage.scene.lights.len(),
        "materials": materials,
        "textured": textured,
        "normals": stage.scene.has_normals(),
        "objects": objects,
        "animations": stage.animations.iter().map(|one| json!([one.name(), one.duration()])).collect::<Vec<_>>(),
        "origin": origin.to_array(),
        "bounds": bounds.map(|(low, high)| [low.to_array(), high.to_array()]),
        "bytes": bytes,
        "depth": { "nearest": finite(near), "farthest": finite(far) },
        "comfort": (!is_around).then(|| {
            json!({ "parallax_percent": [near_percent, far_percent], "warnings": comfort.warnings() })
        }),
    }))
}
