//! Formats the text over the picture.

use stereotrace::{Method, StereoPair};

use super::{
    keys::{HELP, HELP_AROUND},
    settings::{Mode, Settings},
    work::Frame,
};

/// Data of the text.
pub(super) struct Status<'a> {
    pub(super) settings: &'a Settings,
    pub(super) frame: Option<&'a Frame>,
    pub(super) adapter: Option<&'a str>,
    /// Whether the frame shows the current settings.
    pub(super) is_current: bool,
    pub(super) note: Option<&'a str>,
    pub(super) display_width: f32,
}

/// Returns the lines that list all keys.
pub(super) fn help(is_around: bool) -> Vec<String> {
    let (first, rest) = HELP.split_at(8);
    let first = if is_around { &HELP_AROUND[..] } else { first };
    first.iter().chain(rest).map(|(key, does)| format!("{key:<13}{does}")).collect()
}

/// Returns the texts over the picture.
pub(super) fn texts(status: &Status<'_>) -> Vec<String> {
    let settings = status.settings;
    let mut lines = vec![shown(settings)];
    let Some(frame) = status.frame else {
        lines.push("uploading the scene ...".into());
        return lines;
    };
    let (pair, ms) = (&frame.pair, 1e3 * frame.time.as_secs_f64());
    let state = match (frame.whole, status.is_current) {
        (true, true) => "",
        (_, false) => ", rendering the next",
        (false, true) => ", a draft",
    };
    let (w, h) = (pair.left.width, pair.left.height);
    lines.push(format!("{w}x{h}, {}, {ms:.0} ms{state}", samples(settings, frame)));
    lines.push(method(settings.options.method, pair));
    match &settings.head {
        None => lines.extend(depth(status, pair)),
        Some(head) => {
            let [right, up] = head.angles().map(f64::to_degrees);
            lines.push(format!("head {right:.0} degrees right, {up:.0} up; {:.0} degrees high", head.fov()));
            let (e, d) = (pair.pose.interaxial, settings.place.screen_distance());
            lines.push(format!("e {e:.4}, no parallax at {d:.4}"));
        }
    }
    lines.extend(status.adapter.map(str::to_owned));
    lines.extend(status.note.map(str::to_owned));
    lines.push("H: keys".into());
    lines
}

/// Returns whether text over this share of the rows conflicts with less at the lower edge than at the upper one. Text
/// has no parallax, so that nearer content behind it contradicts it.
pub(super) fn is_better_below(pair: &StereoPair, share: f32) -> bool {
    let nearest = |is_below: bool| {
        let views = [&pair.left, &pair.right].into_iter();
        let depths = views.flat_map(|view| {
            let covered = ((view.height as f32 * share).ceil() as usize).min(view.height as usize);
            let covered = covered * view.width as usize;
            let first = if is_below { view.depth.len() - covered } else { 0 };
            &view.depth[first..first + covered]
        });
        depths.copied().fold(f32::INFINITY, f32::min)
    };
    let above = nearest(false);
    above < pair.pose.screen_distance && nearest(true) > above
}

/// Returns the lines about depth in a planar pair.
fn depth(status: &Status<'_>, pair: &StereoPair) -> Vec<String> {
    let pose = &pair.pose;
    let px = pose.interaxial_px * status.settings.size()[0] as f32 / pose.size[0] as f32; // a draft has fewer pixels
    let ranges = [&pair.left, &pair.right].map(|view| view.depth_range());
    let (nearest, farthest) = (ranges[0].0.min(ranges[1].0), ranges[0].1.max(ranges[1].1));
    let comfort = pose.comfort(nearest, farthest, status.display_width);
    let (near, far) = (comfort.negative_parallax_percent, comfort.positive_parallax_percent);
    let mut lines = vec![
        format!("e {:.4} ({px:.1} px), d {:.4}", pose.interaxial, pose.screen_distance),
        format!("parallax {near:.2}% to {far:.2}% of the width"),
    ];
    lines.extend(comfort.warnings().into_iter().map(|warning| format!("warning: {warning}")));
    lines
}

fn shown(settings: &Settings) -> String {
    let swapped = if settings.eyes.swap { ", eyes swapped" } else { "" };
    match settings.mode {
        Mode::Anaglyph => {
            let kind = settings.eyes.anaglyph;
            format!("anaglyph {kind}: {}{swapped}", kind.glasses())
        }
        mode => format!("{}{swapped}", mode.name()),
    }
}

fn samples(settings: &Settings, frame: &Frame) -> String {
    let counted = stereotrace::message::counted;
    match (frame.whole, settings.options.adaptive, frame.paths) {
        (true, Some(_), _) => "adaptive samples".into(),
        (true, None, 0) => counted(settings.options.samples, "sample", "samples"),
        (true, None, paths) => counted(paths, "path", "paths"),
        (false, ..) => "1 sample".into(),
    }
}

fn method(asked: Method, pair: &StereoPair) -> String {
    let statistics = &pair.statistics;
    let used = match statistics.method {
        used if used == asked => String::new(),
        used => format!(" ({used})"),
    };
    match statistics.reused + statistics.bad + statistics.missed {
        0 => format!("{asked}{used}: the second eye traced in full"),
        _ => format!("{asked}{used}: {:.2}% of the second eye re-traced", 100.0 * statistics.retraced_share()),
    }
}

#[cfg(test)]
mod tests {
    use stereotrace::{Builtin, Gpu, Options, Renderer, blocking::Wait};

    use super::*;

    #[test]
    fn text_is_below_where_nearer_content_is_above_alone() {
        let mut renderer = Renderer::new(Gpu::open("software").wait().unwrap());
        let scene = renderer.upload(&Builtin::Spheres.scene()).wait().unwrap();
        let camera = Builtin::Spheres.camera(16, 10);
        let mut pair = renderer.pair(&scene, &camera).options(&Options::new(Method::Naive)).read().wait().unwrap();
        let screen = pair.pose.screen_distance;
        let last = pair.left.depth.len() - 1;
        for (above, below, expected) in
            [(2.0, 3.0, false), (1.0, 0.9, false), (0.9, 1.0, true), (0.9, 0.8, false), (0.8, 0.9, true)]
        {
            for view in [&mut pair.left, &mut pair.right] {
                view.depth.fill(f32::INFINITY);
                // In rows between the edges nothing counts.
                view.depth[5 * 16] = 0.1 * screen;
            }
            pair.right.depth[16] = above * screen;
            pair.left.depth[last] = below * screen;
            assert_eq!(is_better_below(&pair, 0.2), expected, "{above} above, {below} below");
        }
    }
}
