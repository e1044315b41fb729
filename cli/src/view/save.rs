//! Writes the shown picture, and prints the command line that renders the same picture.

use std::{
    error::Error,
    ffi::{OsStr, OsString},
    fmt::Display,
    fs,
    path::{Path, PathBuf},
};

use clap::{CommandFactory, parser::ValueSource};
use stereotrace::{Light, LightShape, Options, Scene, Setting, StereoPair, message, output::Batch};

use super::settings::{Mode, Settings};
use crate::{arguments::Cli, target::EyesArguments};

/// Arguments that the printed command line replaces, or that do not affect the picture.
const REPLACED: [&str; 11] =
    ["size_said", "anaglyph", "packing", "swap", "out", "frames", "screenshot", "replay", "no_text", "quiet", "json"];
/// Arguments that are also replaced if the camera was moved.
const CAMERA: [&str; 10] =
    ["eye", "target", "up", "fov", "screen", "interaxial", "interaxial_px", "comfort", "calib", "calib_scale"];
/// Arguments that are also replaced if lights were placed around the first camera.
const LIGHT: [&str; 4] = ["light", "lights", "light_radius", "ambient"];

/// Argument of the command line.
#[derive(Debug)]
struct Given {
    id: String,
    /// Option name with its dashes; `None` for a positional argument.
    option: Option<String>,
    values: Vec<OsString>,
}

/// The command line that the window was opened with.
#[derive(Debug)]
pub(super) struct Origin {
    given: Vec<Given>,
    /// Whether lights were placed around the first camera.
    lights_by_camera: bool,
}

impl Origin {
    /// Parses a command line, which begins with the program's name.
    pub(super) fn new(words: impl IntoIterator<Item = OsString>, lights_by_camera: bool) -> Result<Self, clap::Error> {
        let mut command = Cli::command();
        command.build();
        let all = command.clone().try_get_matches_from(words)?;
        let matches = all.subcommand_matches("view");
        let arguments = command.find_subcommand("view").into_iter().flat_map(clap::Command::get_arguments);
        let said = |id: &str| matches.filter(|matches| matches.value_source(id) == Some(ValueSource::CommandLine));
        let given = arguments.filter_map(|argument| {
            let id = argument.get_id().as_str();
            let values = match argument.get_action().takes_values() {
                true => said(id)?.get_raw(id)?.map(OsStr::to_owned).collect(),
                false => said(id).map(|_| Vec::new())?,
            };
            let option = argument.get_long().map(|name| format!("--{name}"));
            Some(Given { id: id.to_owned(), option, values })
        });
        Ok(Self { given: given.collect(), lights_by_camera })
    }

    /// Returns the command line that renders these settings into a file or folder.
    pub(super) fn command(&self, settings: &Settings, scene: &Scene, out: &Path) -> Vec<OsString> {
        let moved = settings.is_moved();
        let lights = (moved && self.lights_by_camera).then(|| light_words(scene)).flatten();
        let mut words = ["stereotrace", "render"].map(OsString::from).to_vec();
        for Given { id, option, values } in &self.given {
            let id = &id.as_str();
            let is_option = Setting::ALL.iter().any(|setting| setting.name == *id);
            if is_option
                || REPLACED.contains(id)
                || moved && CAMERA.contains(id)
                || lights.is_some() && LIGHT.contains(id)
            {
                continue;
            }
            match option {
                None => words.extend(values.iter().cloned()),
                Some(option) if values.is_empty() => words.push(option.into()),
                Some(option) => {
                    words.extend(values.iter().map(|value| {
                        let mut word = OsString::from(format!("{option}="));
                        word.push(value);
                        word
                    }));
                }
            }
        }
        let mut say = |option: &str, value: String| {
            words.push(option.into());
            words.extend((value != "true").then(|| value.into()));
        };
        let [width, height] = settings.size();
        say("--size", format!("{width}x{height}"));
        if moved {
            let place = &settings.place;
            say("--eye", point(place.eye().to_array()));
            say("--target", point(place.target().to_array()));
            say("--up", point(settings.camera().up_direction().to_array()));
            if let Some(fov) = place.fov() {
                say("--fov", fov.to_string());
                say("--screen", place.screen_distance().to_string());
            }
            say("--interaxial", place.interaxial().to_string());
        }
        // The automatic look of a file replaces two defaults, so these are always named.
        let always = |name: &str| {
            ["method", "shadow_rays"].contains(&name) || name == "samples" && settings.options.adaptive.is_none()
        };
        for Setting { name, .. } in Setting::ALL {
            let value = |options: &Options| options.get(name).unwrap_or_default();
            let (value, default) = (value(&settings.options), value(&Options::default()));
            if value != default || always(name) {
                say(&format!("--{}", name.replace('_', "-")), value);
            }
        }
        lights.into_iter().flatten().for_each(|(option, value)| say(option, value));
        match settings.eyes_written().packing {
            Some(packing) => say("--packing", packing.to_string()),
            None => say("--anaglyph", settings.eyes.anaglyph.to_string()),
        }
        if settings.eyes.swap {
            words.push("--swap".into());
        }
        words.extend(["--out".into(), out.into()]);
        words
    }
}

fn point([x, y, z]: [impl Display; 3]) -> String {
    format!("{x},{y},{z}")
}

/// Returns a scene's lights as options. Returns `None` if a light has a shape without an option; such a light was not
/// placed around a camera.
fn light_words(scene: &Scene) -> Option<Vec<(&'static str, String)>> {
    let word = |light: &Light| {
        let (place, intensity) = (point(light.position.to_array()), point(light.intensity.to_array()));
        match light.shape {
            LightShape::Point => Some(("--light", format!("{place}:{intensity}"))),
            LightShape::Sphere { radius } => Some(("--light", format!("{place}:{intensity}:{radius}"))),
            _ => None,
        }
    };
    let mut words = scene.lights.iter().map(word).collect::<Option<Vec<_>>>()?;
    if words.is_empty() {
        words.push(("--lights", "0".into()));
    }
    words.extend(scene.ambient.map(|ambient| ("--ambient", point(ambient.to_array()))));
    Some(words)
}

/// Returns a command line quoted for a shell.
pub(super) fn quoted(words: &[OsString]) -> String {
    let words = words.iter().map(|word| {
        let text = word.to_string_lossy();
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_=+./,:@%".contains(c);
        let steers = |c: char| message::escaped(c.encode_utf8(&mut [0; 4])).starts_with('\\') && c != '\\';
        if !text.is_empty() && text.chars().all(is_plain) {
            return text.into_owned();
        }
        if !text.contains(steers) {
            return format!("'{}'", text.replace('\'', r"'\''"));
        }
        let escaped = text.chars().map(|c| match c {
            '\'' | '\\' => format!("\\{c}"),
            c if steers(c) => c.encode_utf8(&mut [0; 4]).bytes().map(|byte| format!("\\x{byte:02x}")).collect(),
            c => c.to_string(),
        });
        format!("$'{}'", String::from_iter(escaped))
    });
    Vec::from_iter(words).join(" ")
}

/// Writes a pair in the format of the window's mode: one picture, or a folder of both eyes if the mode shows one eye at
/// a time. An equirectangular pair is written as `render` packs it, whichever part the window shows. Each call uses a
/// new file name. Either all files are written, or none.
pub(super) fn write(
    settings: &Settings,
    pair: &StereoPair,
    folder: &Path,
    name: &str,
) -> Result<PathBuf, Box<dyn Error>> {
    fs::create_dir_all(folder)
        .map_err(|error| format!("{}: the folder can't be created: {error}", crate::shown(folder)))?;
    let eyes = settings.eyes_written();
    let is_around = settings.head.is_some();
    let of_both = is_around || !matches!(settings.mode, Mode::Wiggle | Mode::Left | Mode::Right);
    let ending = if of_both { ".png" } else { "" };
    let paths = (1..).map(|number: u64| {
        let name = format!("{name}-{number:03}");
        let tagged = eyes.packing.filter(|_| is_around);
        let name = tagged.map_or(name.clone(), |packing| EyesArguments::packed_name(packing, &pair.pose, &name));
        folder.join(name + ending)
    });
    let path = paths.into_iter().find(|path| path.symlink_metadata().is_err()).expect("numbers don't end");
    let mut batch = Batch::new();
    if of_both {
        batch.add_png(&path, &eyes.picture(&pair.left, &pair.right))?;
    } else {
        fs::create_dir(&path).map_err(|error| format!("{}: {error}", crate::shown(&path)))?;
        let (left, right) = eyes.ordered(&pair.left, &pair.right);
        batch.add_png(path.join("left.png"), &left.picture())?;
        batch.add_png(path.join("right.png"), &right.picture())?;
        batch.add_png(path.join("anaglyph.png"), &eyes.picture(&pair.left, &pair.right))?;
    }
    batch.commit()?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use stereotrace::{Builtin, Gpu, Renderer, blocking::Wait, glam::Vec3};

    use super::*;
    use crate::{
        arguments::{Command, Purpose},
        folder::Folder,
    };

    fn words(words: &[&str]) -> Vec<OsString> {
        words.iter().map(OsString::from).collect()
    }

    #[test]
    fn what_was_given_is_said_again_but_for_the_window_s_own() {
        let line = ["stereotrace", "view", "a b.obj", "--up=-1,0,0", "--plain", "--frames", "3", "--json", "--no-text"];
        let more = ["--adapter", "software", "--eye", "1,2,3", "--light", "1,2,3", "--light", "4,5,6"];
        let origin = Origin::new(words(&[&line[..], &more].concat()), false).unwrap();
        let ids = Vec::from_iter(origin.given.iter().map(|given| given.id.as_str()));
        assert!(
            ["scene", "up", "plain", "adapter", "eye", "light", "frames"].iter().all(|id| ids.contains(id)),
            "{ids:?}"
        );
        let of = |id: &str| origin.given.iter().find(|given| given.id == id).unwrap();
        assert_eq!((of("light").values.len(), of("plain").values.len()), (2, 0));
        assert_eq!(of("scene").option, None);
        assert!(!ids.contains(&"method") && !ids.contains(&"size"));
    }

    #[test]
    fn every_name_in_the_lists_is_an_argument() {
        let mut command = Cli::command();
        command.build();
        let view = command.find_subcommand("view").unwrap();
        for id in REPLACED.iter().chain(&CAMERA).chain(&LIGHT) {
            assert!(view.get_arguments().any(|argument| argument.get_id() == id), "{id}");
        }
    }

    /// Returns the picture that `view` writes after `change`, and the picture that the printed command line makes.
    fn shown_and_made_again(line: &[&str], change: impl FnOnce(&mut Settings)) -> [image::RgbaImage; 2] {
        let folder = Folder::new("view");
        let line = [&["stereotrace", "view", "--adapter", "software"], line].concat();
        let Cli { global, command: Command::View(arguments) } = Cli::parse_from(&line) else { panic!("view") };
        let (subject, eyes) = arguments.parts();
        let mut stage = subject.open(Purpose::Pictures, &global).unwrap();
        let mut settings = Settings::new(&stage, eyes, subject.size()).unwrap();
        change(&mut settings);
        let uploaded = stage.renderer.upload(&stage.scene).wait().unwrap();
        let pair = stage.renderer.pair(&uploaded, &settings.camera()).options(&settings.options).read().wait().unwrap();
        let path = write(&settings, &pair, &folder.file("out"), "scene").unwrap();

        let origin = Origin::new(words(&line), subject.lights_stand_by_camera()).unwrap();
        let again = folder.file("again.png");
        let command = origin.command(&settings, &stage.scene, &again);
        let Cli { global, command: Command::Render(arguments) } = Cli::parse_from(&command) else { panic!("render") };
        crate::commands::render::run(&arguments, &global)
            .unwrap_or_else(|error| panic!("{}: {error}", quoted(&command)));
        [path, again].map(|path| image::open(path).unwrap().into_rgba8())
    }

    fn is_made_again(line: &[&str], change: impl FnOnce(&mut Settings)) {
        let [shown, again] = shown_and_made_again(line, change);
        assert!(shown.pixels().any(|pixel| pixel != shown.get_pixel(0, 0)), "{line:?}: nothing is seen");
        assert!(shown == again, "{line:?}: another picture");
    }

    /// Moves the eyes by typical mouse and key input.
    fn moved(settings: &mut Settings) {
        settings.move_eyes(|place| place.orbit(0.31, -0.12)).unwrap();
        settings.move_eyes(|place| place.zoom(0.7)).unwrap();
        settings.move_eyes(|place| place.spread(1.21)).unwrap();
        settings.move_eyes(|place| place.move_screen(0.9)).unwrap();
    }

    const PYRAMID: &str =
        "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1.5 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 1 4 3 2\n";

    const CAMERAS: &str = r#"{ "one": { "eye": [3, 2, 4], "target": [0, 0.5, 0], "up": [0, 1, 0], "vfov_deg": 47,
        "screen_distance": 5, "eye_separation": 0.2,
        "lights": [{ "position": [4, 5, 6], "intensity": [0.6, 0.6, 0.5] }] } }"#;

    #[test]
    fn built_in_scenes_are_made_again_by_the_command_that_is_printed() {
        let hall = ["builtin:hall", "--size", "64x48"];
        is_made_again(&hall, |_| {});
        let lights = ["--lights", "3", "--ambient", "0.3", "--samples", "4", "--packing", "cross-eyed", "--swap"];
        is_made_again(&[&hall[..], &lights].concat(), moved);
        let camera = ["--up=0.2,1,0", "--eye=0,1.7,-4", "--interaxial-px", "9", "--adaptive", "8:3"];
        is_made_again(&[&hall[..], &camera].concat(), moved);
        is_made_again(&hall, |settings| {
            settings.window = [75, 41];
            settings.mode = Mode::SideBySide;
            settings.step_method(false);
            settings.step_samples(false);
            settings.step_anaglyph();
        });
    }

    #[test]
    fn files_are_made_again_with_the_lights_that_stood_around_the_first_camera() {
        let folder = Folder::new("view-files");
        let scene = folder.write("a scene.obj", PYRAMID);
        let cameras = folder.write("cameras.json", CAMERAS);
        let [scene, cameras] = [&scene, &cameras].map(|path| path.to_str().unwrap());
        let size = ["--size", "48x40"];
        is_made_again(&[&[scene], &size[..]].concat(), |_| {});
        for more in [
            &[][..],
            &["--lights", "2", "--light-radius", "0.2", "--plain"],
            &["--light", "3,4,5", "--sky-rays", "4"],
            &["--cameras", cameras, "--camera", "one"],
        ] {
            is_made_again(&[&[scene], &size[..], more].concat(), moved);
        }
        is_made_again(&[&[scene], &size[..]].concat(), |settings| settings.window = [90, 33]);
    }

    #[test]
    fn eyes_that_are_shown_one_at_a_time_are_written_both() {
        let folder = Folder::new("view-eyes");
        let mut renderer = Renderer::new(Gpu::open("software").wait().unwrap());
        let uploaded = renderer.upload(&Builtin::Spheres.scene()).wait().unwrap();
        let pair = renderer.pair(&uploaded, &Builtin::Spheres.camera(20, 10)).read().wait().unwrap();
        let Cli { global, command: Command::View(arguments) } =
            Cli::parse_from(["stereotrace", "view", "builtin:spheres", "--size", "20x10", "--adapter", "software"])
        else {
            panic!("view")
        };
        let (subject, eyes) = arguments.parts();
        let mut settings = Settings::new(&subject.open(Purpose::Pictures, &global).unwrap(), eyes, [20, 10]).unwrap();
        let out = folder.file("out");
        assert_eq!(write(&settings, &pair, &out, "x").unwrap(), out.join("x-001.png"));
        assert_eq!(write(&settings, &pair, &out, "x").unwrap(), out.join("x-002.png"));
        settings.mode = Mode::Wiggle;
        for expected in ["x-001", "x-002"] {
            let path = write(&settings, &pair, &out, "x").unwrap();
            assert_eq!(path, out.join(expected));
            assert!(["left.png", "right.png", "anaglyph.png"].iter().all(|name| path.join(name).is_file()));
        }
        fs::write(folder.file("taken"), "").unwrap();
        assert!(
            write(&settings, &pair, &folder.file("taken"), "x").unwrap_err().to_string().contains("can't be created")
        );
    }

    #[test]
    fn shells_read_what_was_meant() {
        assert_eq!(quoted(&words(&["a-b_c/d.obj", "--eye", "1,-2e-3,3", ""])), "a-b_c/d.obj --eye 1,-2e-3,3 ''");
        assert_eq!(quoted(&words(&["it's $HOME", "a\\b"])), r"'it'\''s $HOME' 'a\b'");
        assert_eq!(quoted(&words(&["\u{1b}[2J'\u{202e}"])), r"$'\x1b[2J\'\xe2\x80\xae'");
    }

    #[test]
    fn lights_without_an_option_stay_the_scene_s_own() {
        let mut scene = Scene::new();
        scene.lights = vec![Light::point(Vec3::X, Vec3::ONE), Light::sphere(Vec3::Y, 0.25, Vec3::splat(0.5))];
        let said = light_words(&scene).unwrap();
        assert_eq!(said, [("--light", "1,0,0:1,1,1".into()), ("--light", "0,1,0:0.5,0.5,0.5:0.25".to_owned())]);
        scene.lights.push(Light::directional(Vec3::Y, 0.0, Vec3::ONE));
        assert_eq!(light_words(&scene), None);
    }
}
