//! Prints the table of picture, scene, depth and written files, and with --stats of method and cost.

use std::{
    fmt::{self, Display, Formatter},
    path::PathBuf,
    time::Duration,
};

use serde_json::{Value, json};
use stereotrace::{
    Comfort, Lighting, Pose, Statistics, Work,
    message::{counted, escaped, noun},
    metrics::Difference,
    output::Packing,
};

use super::render::Arguments;
use crate::{
    arguments::Stage,
    pictures::Seen,
    summary::Summary,
    target::{EyesArguments, is_single_picture},
};

/// Elapsed wall-clock times.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallTimes {
    /// Reading or making the scene.
    pub(crate) read: Duration,
    /// Building the BVH and uploading it.
    pub(crate) build: Duration,
    /// Building the pipelines, rendering and reading the pictures back. Pictures whose rows are written as they arrive
    /// are compressed meanwhile.
    pub(crate) render: Duration,
}

/// Data of the table. [`Display`] prints it as text.
pub(crate) struct Report<'a> {
    pub(crate) arguments: &'a Arguments,
    pub(crate) stage: &'a Stage,
    pub(crate) pose: &'a Pose,
    pub(crate) statistics: &'a Statistics,
    pub(crate) seen: Seen,
    pub(crate) wall: WallTimes,
    /// Difference between the right view and the right view of `naive`, if --compare is given.
    pub(crate) difference: Option<Difference>,
    pub(crate) files: &'a [PathBuf],
}

impl Display for Report<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let pose = self.pose;
        let WallTimes { read, build, render } = self.wall;
        let seconds = (read + build + render).as_secs_f64();
        let [width, height] = pose.size;
        let adapter = self.stage.renderer.gpu().adapter_name();
        line(f, "picture", format!("{width}x{height} for each eye, in {seconds:.1} s by {adapter}"))?;
        line(f, "scene", scene_line(self.stage))?;
        self.light_lines(f)?;
        let e = pose.interaxial;
        let screen = match (self.is_around(), pose.screen_distance.is_finite()) {
            (true, _) => "in all directions".into(),
            (false, true) => format!("screen at {:.4}", pose.screen_distance),
            (false, false) => "parallel".into(),
        };
        line(f, "eyes", format!("{e:.4} apart, {screen}"))?;
        if self.arguments.stats {
            self.statistics_lines(f)?;
        } else if self.stage.options.count {
            self.count_lines(f)?;
        }
        if let Some(difference) = &self.difference {
            difference_lines(f, difference)?;
        }
        if self.seen.only_sky {
            line(f, "warning", "the left eye sees only sky: check --eye and --target")?;
        }
        if !self.is_around() {
            self.comfort_lines(f)?;
        }
        self.open_line(f)?;
        if self.files.len() > 1 {
            for (index, file) in self.files.iter().enumerate() {
                line(f, if index == 0 { "wrote" } else { "" }, file.display())?;
            }
        }
        Ok(())
    }
}

impl Report<'_> {
    pub(crate) fn summary(&self) -> Summary {
        Summary { text: self.to_string(), json: self.json(), ..Summary::default() }
    }

    /// Returns the report as JSON: lengths in world units, times in milliseconds.
    fn json(&self) -> Value {
        let (pose, statistics, scene) = (self.pose, self.statistics, &self.stage.scene);
        let passes = statistics.times.as_ref().map(|times| {
            Vec::from_iter(times.passes.iter().map(|(pass, time)| json!({ "pass": pass, "ms": milliseconds(*time) })))
        });
        let comfort = self.comfort();
        let wall = [self.wall.read, self.wall.build, self.wall.render].map(milliseconds);
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "adapter": self.stage.renderer.gpu().adapter_name(),
            "scene": {
                "name": self.stage.name,
                "triangles": scene.triangles().len(),
                "without_area": scene.degenerate_count(),
                "spheres": scene.spheres().len(),
                "ellipsoids": scene.ellipsoids().len(),
                "planes": scene.planes().len(),
                "lights": scene.lights.len(),
            },
            "camera": {
                "size": pose.size,
                "eye": pose.eye.to_array(),
                "forward": pose.forward.to_array(),
                "right": pose.right.to_array(),
                "up": pose.up.to_array(),
                "screen_distance": pose.screen_distance,
                "interaxial": pose.interaxial,
                "interaxial_px": pose.interaxial_px,
            },
            "light": {
                "lighting": self.stage.options.get("lighting").ok(),
                "denoise": self.stage.options.denoise,
                "exposure": self.stage.options.exposure,
            },
            "method": { "asked": self.stage.options.method.to_string(), "used": statistics.method.to_string() },
            "ms": { "read": wall[0], "build": wall[1], "render": wall[2], "passes": passes },
            "rays": { "left": rays(&statistics.left), "right": rays(&statistics.right) },
            "second_eye": self.stage.options.count.then(|| statistics.second_eye()),
            "retraced_share": statistics.retraced_share(),
            "to_naive": self.difference.as_ref().map(difference_json),
            "comfort": (!self.is_around()).then(|| json!({
                "parallax_px": [comfort.negative_parallax_px, comfort.positive_parallax_px],
                "parallax_percent": [comfort.negative_parallax_percent, comfort.positive_parallax_percent],
                "warnings": comfort.warnings(),
            })),
            "files": Vec::from_iter(self.files.iter().map(|file| file.to_string_lossy())),
        })
    }

    fn is_around(&self) -> bool {
        self.pose.projection.equirectangular().is_some()
    }

    fn comfort(&self) -> Comfort {
        let (nearest, farthest) = self.seen.depths;
        self.pose.comfort(nearest, farthest, self.arguments.display_width)
    }

    /// Writes how the right eye was made, and at which cost.
    fn statistics_lines(&self, f: &mut Formatter<'_>) -> fmt::Result {
        line(f, "method", self.method_line())?;
        if let Some(choice) = self.statistics.choice {
            line(f, "chose", choice)?;
        }
        self.time_lines(f)?;
        self.work_lines(f)?;
        line(f, "re-traced", retraced(self.statistics))
    }

    /// Writes the file to open, and what one needs to see depth in it.
    fn open_line(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let eyes = self.arguments.eyes.suiting(self.pose);
        let name =
            eyes.packing.map_or("anaglyph".into(), |it| EyesArguments::packed_name(it, self.pose, &self.stage.name));
        let of_both = match self.files {
            [only] => Some(only),
            files => files.iter().find(|file| file.file_stem().is_some_and(|stem| *stem == *name)),
        };
        let Some(file) = of_both else { return Ok(()) };
        let how = match (is_single_picture(file), eyes.packing) {
            (false, _) => "it holds both views".into(),
            (true, Some(packing)) => viewing(packing, eyes.swap).into(),
            (true, None) => {
                let reversed = if eyes.swap { ", worn reversed (--swap)" } else { "" };
                format!("wear glasses, {}{reversed}", eyes.anaglyph.glasses())
            }
        };
        line(f, "open", format!("{}: {how}", file.display()))
    }

    fn time_lines(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.statistics.times {
            None => line(f, "passes", "no timestamps")?,
            Some(times) => {
                let total = [("together", times.total())];
                for (index, (pass, time)) in times.passes.iter().chain(&total).enumerate() {
                    let heading = if index == 0 { "passes" } else { "" };
                    line(f, heading, format!("{pass:<16}{:>10.2} ms", milliseconds(*time)))?;
                }
            }
        }
        let WallTimes { read, build, render } = self.wall;
        let [read, build, render] = [read, build, render].map(|time| time.as_secs_f64());
        line(f, "clock", format!("read {read:.2} s, build and upload {build:.2} s, render {render:.2} s"))
    }

    fn work_lines(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let statistics = self.statistics;
        line(f, "rays", format!("{:<6}{:>12}{:>14}{:>12}{:>12}", "", "primary", "verification", "shadow", "all"))?;
        for (eye, work) in [("left", &statistics.left), ("right", &statistics.right)] {
            let (rays, all) = (work.rays, work.rays.total());
            let counts = format!("{:>12}{:>14}{:>12}{all:>12}", rays.primary, rays.verification, rays.shadow);
            line(f, "", format!("{eye:<6}{counts}"))?;
        }
        let buffer = statistics.shadow_buffer;
        if buffer.bytes > 0 {
            let (texels, mib) = (noun(buffer.filled, "texel", "texels"), buffer.bytes.div_ceil(1 << 20));
            line(f, "", format!("shadow-buffers: {} {texels} filled; {mib} MiB", buffer.filled))?;
        }
        if self.stage.options.count { self.count_lines(f) } else { Ok(()) }
    }

    fn count_lines(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let statistics = self.statistics;
        for (eye, work) in [("left", &statistics.left), ("right", &statistics.right)] {
            let heading = if eye == "left" { "work" } else { "" };
            let (nodes, tests) = (work.nodes, work.primitive_tests);
            let (node, test) = (noun(nodes, "node", "nodes"), noun(tests, "test", "tests"));
            line(f, heading, format!("{eye:<6}{nodes:>12} {node}{tests:>12} primitive {test}"))?;
        }
        line(f, "", format!("the second eye cost {:.3} of the first", statistics.second_eye()))
    }

    fn method_line(&self) -> String {
        let (method, statistics) = (self.stage.options.method, self.statistics);
        match statistics.buffer_depth {
            0 => method.to_string(),
            slots => {
                let lost = counted(statistics.lost_candidates, "candidate", "candidates");
                format!("{method}: {} per pixel, {lost} lost", counted(slots, "slot", "slots"))
            }
        }
    }

    fn light_lines(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let options = &self.stage.options;
        if let Lighting::Paths { bounces, samples } = options.lighting {
            let (paths, bounces) = (counted(samples, "path", "paths"), counted(bounces, "bounce", "bounces"));
            let noise = if options.denoise { ", denoised" } else { "" };
            line(f, "light", format!("{paths} per pixel, {bounces}{noise}"))?;
            if self.stage.is_by_paths_by_default {
                line(f, "", "--lighting direct is faster; --samples 16 --lighting paths=32 is finer")?;
            }
        }
        match options.exposure {
            0.0 => Ok(()),
            stops => line(f, "exposure", format!("{stops:+} stops")),
        }
    }

    fn comfort_lines(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let comfort = self.comfort();
        let (near, far) = (comfort.negative_parallax_percent.abs(), comfort.positive_parallax_percent);
        let warnings = comfort.warnings();
        let fits = if warnings.is_empty() { "comfortable" } else { "uncomfortable" };
        let depth = format!("{near:.1}% of the width before the screen, {far:.1}% behind it");
        line(f, "depth", format!("{depth}: {fits} on a display {} m wide", self.arguments.display_width))?;
        for warning in warnings {
            line(f, "warning", warning)?;
        }
        Ok(())
    }
}

/// Returns how to see depth in a picture of both eyes.
fn viewing(packing: Packing, is_swapped: bool) -> &'static str {
    match packing {
        _ if is_swapped => "the eyes are exchanged (--swap)",
        Packing::SideBySide | Packing::HalfSideBySide => {
            "view it in a headset or on a 3D display, or with parallel eyes"
        }
        Packing::CrossEyed => "view it with crossed eyes",
        Packing::TopBottom | Packing::HalfTopBottom => "view it in a headset or on a 3D display",
        _ => "view it on a 3D display with this pattern",
    }
}

fn rays(work: &Work) -> Value {
    let rays = work.rays;
    json!({ "primary": rays.primary, "verification": rays.verification, "shadow": rays.shadow, "all": rays.total() })
}

pub(super) fn difference_json(difference: &Difference) -> Value {
    json!({
        "identical_percent": difference.identical_percent,
        "wrong_surface_percent": difference.wrong_surface_percent,
        "mse": difference.mse,
        // JSON has no infinity, which identical pictures would need.
        "psnr": Some(difference.psnr).filter(|psnr| psnr.is_finite()),
        "p999": difference.p999,
        "surface_percent": difference.surface_percent,
        "identical_of_surfaces_percent": difference.identical_of_surfaces_percent,
        "wrong_of_surfaces_percent": difference.wrong_of_surfaces_percent,
    })
}

/// Returns a line with the scene's name and its counts of primitives and lights.
pub(super) fn scene_line(stage: &Stage) -> String {
    let scene = &stage.scene;
    let dropped = match scene.degenerate_count() {
        0 => String::new(),
        count => format!(" ({count} without area, dropped)"),
    };
    let some = |count: usize, one: &str, many: &str| match count {
        0 => String::new(),
        count => format!(", {}", counted(count, one, many)),
    };
    let triangles = counted(scene.triangles().len(), "triangle", "triangles");
    let spheres = counted(scene.spheres().len(), "sphere", "spheres");
    let ellipsoids = some(scene.ellipsoids().len(), "ellipsoid", "ellipsoids");
    let planes = some(scene.planes().len(), "plane", "planes");
    let lights = counted(scene.lights.len(), "light", "lights");
    format!("{}: {triangles}{dropped}, {spheres}{ellipsoids}{planes}, {lights}", stage.name)
}

/// Writes a line of the table. Control characters in names of scenes and files are escaped.
pub(super) fn line(f: &mut impl fmt::Write, heading: &str, text: impl Display) -> fmt::Result {
    writeln!(f, "{heading:<11}{}", escaped(&text.to_string()))
}

fn difference_lines(f: &mut Formatter<'_>, difference: &Difference) -> fmt::Result {
    // The percentage is rounded down, so that 100.00% means that all pixels are identical.
    let down = |percent: f64| (100.0 * percent).floor() / 100.0;
    let (identical, wrong) = (down(difference.identical_percent), difference.wrong_surface_percent);
    let text = format!("{identical:.2}% of the right eye identical, {wrong:.3}% wrong surface");
    line(f, "to naive", format!("{text}, MSE {:.2}, PSNR {:.1} dB", difference.mse, difference.psnr))?;
    let (identical, wrong) = (down(difference.identical_of_surfaces_percent), difference.wrong_of_surfaces_percent);
    let text = format!("{identical:.2}% of surface pixels identical, {wrong:.3}% wrong surface");
    line(f, "", format!("{text}; surfaces cover {:.2}% of the pixels", difference.surface_percent))
}

fn milliseconds(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}

fn retraced(statistics: &Statistics) -> String {
    let pixels = statistics.reused + statistics.bad + statistics.missed;
    if pixels == 0 {
        return "nothing reused: the right eye was traced in full".into();
    }
    let percent = |count: u64| 100.0 * count as f64 / pixels as f64;
    let (all, bad, missed) = (100.0 * statistics.retraced_share(), percent(statistics.bad), percent(statistics.missed));
    format!("{all:.2}% of the right eye (bad {bad:.2}%, missed {missed:.2}%)")
}
