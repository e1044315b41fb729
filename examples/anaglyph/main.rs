//! Renders a stereo pair of an OBJ file or of a built-in scene, and an anaglyph of it:
//!
//! ```sh
//! cargo run --release --example anaglyph                                  # the built-in hall
//! cargo run --release --example anaglyph -- bunny.obj                     # a camera that fits the object
//! cargo run --release --example anaglyph -- sponza.obj --eye -13.5,2.2,-0.3 --target 10,3.2,0.2 --screen 6
//! cargo run --release --example anaglyph -- builtin:spheres --method naive --packing cross-eyed --out out/spheres
//! cargo run --release --example anaglyph -- --size 512x512 --interaxial-px 2 --views 45 --quilt 9x5
//! ```
//!
//! It writes `left.png`, `right.png` and `anaglyph.png` into the folder `out`, and says what they cost. Steps are in
//! [`run`]; `arguments.rs` makes scene and camera of the command line, `report.rs` the table at the end.

mod arguments;
#[path = "../../src/message.rs"]
#[allow(dead_code, reason = "the example uses a part of it")]
mod message;
mod report;
mod studio;
#[cfg(test)]
mod tests;
mod values;
mod views;

use std::{
    error::Error,
    fs,
    io::{self, IsTerminal, Write},
    ops::ControlFlow,
    path::Path,
    process::ExitCode,
    time::{Duration, Instant},
};

use stereotrace::{
    BvhBuild, Gpu, Method, Progress, Renderer, Scene, StereoCamera, StereoPair,
    metrics::compare,
    output::{Batch, anaglyph, packed},
    scene::builtin::spheres_turned,
};

use crate::{
    arguments::Arguments,
    report::{Report, WallTimes},
};

fn main() -> ExitCode {
    #[cfg(target_os = "linux")]
    keep_mesa_quiet();
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("error,stereotrace=warn")).init();
    let result = Arguments::read().and_then(|arguments| run(&arguments)).and_then(|report| print(&report));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {}", error_line(&*error));
            ExitCode::FAILURE
        }
    }
}

/// Without a user's session, Mesa prints `error: XDG_RUNTIME_DIR is invalid or not set in the environment.`, which means nothing
/// here and looks like an error of ours. What stops it must be in the environment before the program starts, so it starts
/// itself again.
#[cfg(target_os = "linux")]
fn keep_mesa_quiet() {
    use std::{env, os::unix::process::CommandExt, path::Path, process::Command};

    let in_session = env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).is_dir());
    if in_session || env::var_os("NODEVICE_SELECT").is_some() {
        return;
    }
    if let Ok(program) = env::current_exe() {
        // This comes back only where it fails, and then the line does no harm.
        let _ = Command::new(program).args(env::args_os().skip(1)).env("NODEVICE_SELECT", "1").exec();
    }
}

fn print(report: &str) -> Result<(), Box<dyn Error>> {
    match io::stdout().write_all(report.as_bytes()) {
        // Who reads only the first lines (`| head`) closes the pipe: no fault.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(format!("standard output: {error}").into()),
        _ => Ok(()),
    }
}

/// An error's message as one line that does not steer the terminal.
fn error_line(error: &dyn Error) -> String {
    message::escaped(&single_line(&error.to_string()))
}

/// A message as one line: those of the graphics driver have several.
fn single_line(text: &str) -> String {
    text.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
}

/// A path as it is printed: names must not steer the terminal.
fn shown(path: &Path) -> String {
    message::escaped(&path.to_string_lossy())
}

/// Makes the folder to write into.
fn make_folder(path: &Path) -> Result<(), String> {
    let fault = |error: io::Error| match path.exists() {
        true => format!("{}: it is no folder; --out takes a folder to write into", shown(path)),
        false => format!("{}: the folder can't be made: {error}", shown(path)),
    };
    fs::create_dir_all(path).map_err(fault)
}

/// Renders and writes everything; returns the table.
fn run(arguments: &Arguments) -> Result<String, Box<dyn Error>> {
    let begin = Instant::now();
    let mut scene = arguments.scene()?;
    let camera = arguments.stereo_camera(&scene)?;
    arguments.light(&mut scene, &camera)?;
    let arguments = &arguments.reaching(&scene);
    make_folder(&arguments.out)?;
    let mut read = begin.elapsed();

    let gpu = Gpu::new()?;
    let begin = Instant::now();
    arguments.sky(&mut scene, &gpu)?;
    read += begin.elapsed();
    let mut renderer = Renderer::new(gpu);
    if let Some(frames) = arguments.frames {
        return film(arguments, &mut renderer, &scene, &camera, frames);
    }
    let begin = Instant::now();
    let uploaded = renderer.upload(&scene)?;
    let build = begin.elapsed();
    if let Some(eyes) = arguments.views {
        return views::run(arguments, &mut renderer, &uploaded, camera, eyes);
    }

    let begin = Instant::now();
    let mut options = arguments.options(arguments.method);
    options.count = arguments.count;
    options.cost_map = arguments.dump;
    let mut line = ProgressLine::new();
    let pair = renderer.render_with(&uploaded, &camera, &options, &mut |progress| {
        line.show(progress);
        ControlFlow::Continue(())
    });
    line.clear();
    let pair = pair?;
    let wall = WallTimes { read, build, render: begin.elapsed() };

    let difference = match arguments.compare {
        true => {
            let truth = arguments.options(Method::Naive).shadow_buffer(None);
            let naive = renderer.render(&uploaded, &camera, &truth)?;
            Some(compare(&pair.right, &naive.right, &pair.pose)?)
        }
        false => None,
    };
    let mut batch = Batch::new();
    add_pictures(&mut batch, arguments, &pair, "")?;
    let files = batch.commit()?;
    let adapter = renderer.gpu().adapter_name();
    Ok(Report { arguments, adapter: &adapter, scene: &scene, pair: &pair, wall, difference, files: &files }.to_string())
}

/// Renders the spheres as they turn once, a tree built anew for each picture. The pictures appear when all are there.
fn film(
    arguments: &Arguments,
    renderer: &mut Renderer,
    still: &Scene,
    camera: &StereoCamera,
    frames: u32,
) -> Result<String, Box<dyn Error>> {
    let (mut build, mut render) = (Duration::ZERO, Duration::ZERO);
    let mut batch = Batch::new();
    for frame in 0..frames {
        let mut scene = spheres_turned(std::f32::consts::TAU * frame as f32 / frames as f32)?;
        (scene.lights, scene.ambient, scene.sky) = (still.lights.clone(), still.ambient, still.sky.clone());
        let begin = Instant::now();
        let uploaded = renderer.upload_with(&scene, BvhBuild::Fast)?;
        build += begin.elapsed();
        let begin = Instant::now();
        let pair = renderer.render(&uploaded, camera, &arguments.options(arguments.method))?;
        render += begin.elapsed();
        add_pictures(&mut batch, arguments, &pair, &format!("_{frame:04}"))?;
    }
    batch.commit()?;
    let each = |time: Duration| time.as_secs_f64() * 1e3 / f64::from(frames);
    Ok(format!(
        "{} in {}, by {}: build and upload {:.1} ms each, render {:.1} ms each\n",
        message::counted(frames, "frame", "frames"),
        shown(&arguments.out),
        arguments.method,
        each(build),
        each(render),
    ))
}

/// Adds a pair's pictures and maps to what is written; `number` goes behind each name.
fn add_pictures(
    batch: &mut Batch,
    arguments: &Arguments,
    pair: &StereoPair,
    number: &str,
) -> Result<(), Box<dyn Error>> {
    let (left, right) = if arguments.swap { (&pair.right, &pair.left) } else { (&pair.left, &pair.right) };
    let mut pictures = vec![
        (format!("left{number}.png"), left.picture()),
        (format!("right{number}.png"), right.picture()),
        (format!("anaglyph{number}.png"), anaglyph(left, right, arguments.anaglyph)),
    ];
    if let Some(packing) = arguments.packing {
        pictures.push((format!("{packing}{number}.png"), packed(left, right, packing)));
    }
    if arguments.dump {
        pictures.push((format!("retrace{number}.png"), pair.retrace_picture()));
        pictures.extend(pair.shadow_picture().map(|picture| (format!("shadows{number}.png"), picture)));
        // One scale for both eyes: white is what all but a thousandth of the left pixels stay below.
        let mut costs = pair.left.cost.clone();
        costs.sort_unstable();
        let white = costs.get(costs.len() * 999 / 1000).copied().unwrap_or(1);
        for (eye, view) in [("left", left), ("right", right)] {
            let picture = view.cost_picture(white);
            pictures.extend(picture.map(|picture| (format!("{eye}_time_white_{white}{number}.png"), picture)));
        }
    }
    for (name, picture) in pictures {
        batch.add_png(arguments.out.join(name), &picture)?;
    }
    if arguments.dump && number.is_empty() {
        for (eye, view) in [("left", left), ("right", right)] {
            batch.add_depth(arguments.out.join(format!("{eye}_depth.pfm")), view)?;
            batch.add_primitive_ids(arguments.out.join(format!("{eye}_id.pfm")), view)?;
        }
    }
    Ok(())
}

/// How far the frame is, on a terminal's last line, for frames that take their time.
struct ProgressLine {
    begin: Instant,
    on_terminal: bool,
    shown: bool,
}

impl ProgressLine {
    const PATIENCE: Duration = Duration::from_millis(500);

    fn new() -> Self {
        Self { begin: Instant::now(), on_terminal: io::stderr().is_terminal(), shown: false }
    }

    fn show(&mut self, progress: Progress) {
        if self.on_terminal && self.begin.elapsed() > Self::PATIENCE {
            let _ = write!(io::stderr(), "\r\x1b[K{:3.0}% {}", 100.0 * progress.done, progress.pass);
            self.shown = true;
        }
    }

    fn clear(&self) {
        if self.shown {
            let _ = write!(io::stderr(), "\r\x1b[K");
        }
    }
}
