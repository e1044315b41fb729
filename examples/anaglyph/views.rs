//! Many views of one scene, as pictures of their own or as a quilt for a light-field display.

use std::{error::Error, fmt::Write, ops::ControlFlow, time::Instant};

use stereotrace::{
    Method, Renderer, Rig, StereoCamera, UploadedScene, Views,
    metrics::compare,
    output::{Batch, quilt, quilt_name},
};

use crate::{ProgressLine, arguments::Arguments, message::counted, shown};

/// Renders and writes them; returns what is said of them.
pub(crate) fn run(
    arguments: &Arguments,
    renderer: &mut Renderer,
    scene: &UploadedScene,
    camera: StereoCamera,
    eyes: u32,
) -> Result<String, Box<dyn Error>> {
    if let Some([columns, rows]) = arguments.quilt
        && u64::from(columns) * u64::from(rows) != u64::from(eyes)
    {
        return Err(format!("a quilt of {columns}x{rows} is not filled by {}", counted(eyes, "view", "views")).into());
    }
    let rig = Rig::row(camera, eyes as usize);
    let begin = Instant::now();
    let mut options = arguments.options(arguments.method);
    options.count = arguments.count;
    let mut line = ProgressLine::new();
    let mut progress = |progress| {
        line.show(progress);
        ControlFlow::Continue(())
    };
    let views = pollster::block_on(renderer.render_views_async(scene, &rig, &options, &mut progress));
    line.clear();
    let views = views?;
    let render = begin.elapsed();

    let mut batch = Batch::new();
    if let Some([columns, rows]) = arguments.quilt {
        let name = quilt_name(&arguments.scene_name(), &views, columns, rows);
        batch.add_png(arguments.out.join(name), &quilt(&views, columns, rows)?)?;
    } else {
        for (index, view) in views.views.iter().enumerate() {
            batch.add_png(arguments.out.join(format!("view_{index:04}.png")), &view.view.picture())?;
        }
    }
    let files = batch.commit()?;

    let traced = views.views.iter().enumerate().filter(|(index, view)| view.made_from == *index).count();
    let mut text = format!(
        "{} of which {traced} traced, in {} of {}: {:.1} ms\n",
        counted(eyes, "view", "views"),
        counted(files.len(), "file", "files"),
        shown(&arguments.out),
        render.as_secs_f64() * 1e3,
    );
    if arguments.count && traced < views.views.len() {
        writeln!(text, "each other view costs {:.3} of a traced one, by counters", views.other_views())?;
    }
    if arguments.compare {
        let naive = renderer.render_views(scene, &rig, &arguments.options(Method::Naive))?;
        text += &compared(&views, &naive)?;
    }
    Ok(text)
}

/// How far the views are from those of `naive`: the worst one, and all together.
fn compared(views: &Views, naive: &Views) -> Result<String, Box<dyn Error>> {
    let (mut least, mut sum, mut wrong) = (100.0_f64, 0.0, 0.0_f64);
    for (view, truth) in views.views.iter().zip(&naive.views) {
        let difference = compare(&view.view, &truth.view, &views.pose)?;
        least = least.min(difference.identical_percent);
        sum += difference.identical_percent;
        wrong = wrong.max(difference.wrong_surface_percent);
    }
    let mean = sum / views.views.len() as f64;
    Ok(format!(
        "against naive: {mean:.3}% identical, {least:.3}% in the worst view; wrong surface at most {wrong:.3}%\n"
    ))
}
