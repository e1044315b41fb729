//! Renders a stereo pair of an OBJ file or of a built-in scene, and an anaglyph of it:
//!
//! ```sh
//! cargo run --release --example anaglyph                                  # the built-in hall
//! cargo run --release --example anaglyph -- bunny.obj                     # a camera that fits the object
//! cargo run --release --example anaglyph -- sponza.obj --eye -13.5,2.2,-0.3 --target 10,3.2,0.2 --screen 6
//! cargo run --release --example anaglyph -- builtin:spheres --method naive --packing cross-eyed --out out/spheres
//! ```
//!
//! It writes `left.png`, `right.png` and `anaglyph.png` into the folder `out`, and says what they cost. Steps are in
//! [`run`]; `arguments.rs` makes scene and camera of the command line, `report.rs` the table at the end.

mod arguments;
mod report;

use std::{
    error::Error,
    fs,
    io::{self, IsTerminal, Write},
    ops::ControlFlow,
    path::PathBuf,
    process::ExitCode,
    time::{Duration, Instant},
};

use stereotrace::{
    Gpu, Method, Options, Progress, Renderer, StereoPair,
    metrics::compare,
    output::{anaglyph, packed},
};

use crate::{
    arguments::Arguments,
    report::{Report, WallTimes},
};

fn main() -> ExitCode {
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("error,stereotrace=warn")).init();
    let result = Arguments::read().and_then(|arguments| run(&arguments)).and_then(|report| print(&report));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {}", single_line(&error.to_string()));
            ExitCode::FAILURE
        }
    }
}

fn print(report: &str) -> Result<(), Box<dyn Error>> {
    match io::stdout().write_all(report.as_bytes()) {
        // Who reads only the first lines (`| head`) closes the pipe: no fault.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(format!("standard output: {error}").into()),
        _ => Ok(()),
    }
}

/// A message as one line: those of the graphics driver have several.
fn single_line(text: &str) -> String {
    text.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Renders and writes everything; returns the table.
fn run(arguments: &Arguments) -> Result<String, Box<dyn Error>> {
    let begin = Instant::now();
    let mut scene = arguments.scene()?;
    let camera = arguments.stereo_camera(&scene)?;
    arguments.light(&mut scene, &camera)?;
    fs::create_dir_all(&arguments.out).map_err(|error| format!("{}: {error}", arguments.out.display()))?;
    let read = begin.elapsed();

    let begin = Instant::now();
    let mut renderer = Renderer::new(Gpu::new()?);
    let uploaded = renderer.upload(&scene)?;
    let build = begin.elapsed();

    let begin = Instant::now();
    let mut options = Options::new(arguments.method);
    options.count = arguments.count;
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
            let naive = renderer.render(&uploaded, &camera, &Options::new(Method::Naive))?;
            Some(compare(&pair.right, &naive.right, &pair.pose)?)
        }
        false => None,
    };
    let files = write(arguments, &pair)?;
    let adapter = renderer.gpu().adapter_name();
    Ok(Report { arguments, adapter: &adapter, scene: &scene, pair: &pair, wall, difference, files: &files }.to_string())
}

/// Writes the pictures and returns their paths.
fn write(arguments: &Arguments, pair: &StereoPair) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let (left, right) = if arguments.swap { (&pair.right, &pair.left) } else { (&pair.left, &pair.right) };
    let mut pictures = vec![
        ("left.png".to_owned(), left.picture()),
        ("right.png".to_owned(), right.picture()),
        ("anaglyph.png".to_owned(), anaglyph(left, right, arguments.anaglyph)),
    ];
    if let Some(packing) = arguments.packing {
        pictures.push((format!("{packing}.png"), packed(left, right, packing)));
    }
    if arguments.dump {
        pictures.push(("retrace.png".to_owned(), pair.retrace_picture()));
    }
    let mut files = Vec::new();
    let mut path = |name: &str| {
        files.push(arguments.out.join(name));
        arguments.out.join(name)
    };
    for (name, picture) in pictures {
        picture.save_png(path(&name))?;
    }
    if arguments.dump {
        for (eye, view) in [("left", left), ("right", right)] {
            view.save_depth(path(&format!("{eye}_depth.pfm")))?;
            view.save_primitive_ids(path(&format!("{eye}_id.pfm")))?;
        }
    }
    Ok(files)
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
