//! Defines the options of rendering: the picture's size, and the options that the library names.

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};
use stereotrace::{AmbientOcclusion, Error, Finish, Lighting, Options, Scene, Setting};

use super::values::{ExposureArgument, OcclusionArgument, exposure, occlusion, size};
use crate::{studio, usage::Usage};

/// Default size of an eye's picture: width and height in pixels.
pub(super) const SIZE: [u32; 2] = [1280, 720];

/// Heading of these options.
const HEADING: &str = "What the picture looks like";

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = HEADING)]
pub(crate) struct PictureArguments {
    /// Size of one eye's picture in pixels [default: 1280x720]
    ///
    /// By default it is 2048x1024 for --projection 360, 1024x1024 for 180, and the size in the file of --calib.
    #[arg(long = "size", value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    pub(super) size_said: Option<[u32; 2]>,
    #[command(flatten)]
    options: OptionArguments,
}

/// Options of the library by name, as the command line gives them.
#[derive(Clone, Debug, Default)]
struct OptionArguments {
    given: Vec<(&'static str, String)>,
    occlusion: Option<OcclusionArgument>,
    exposure: Option<ExposureArgument>,
}

/// Name of the option that the command gives a default radius.
const OCCLUSION: &str = "ambient_occlusion";
/// Name of the option that the command can choose by the scene.
const EXPOSURE: &str = "exposure";

impl Args for OptionArguments {
    fn augment_args(command: Command) -> Command {
        command.args(Setting::ALL.iter().map(argument))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for OptionArguments {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let names = Setting::ALL.iter().map(|setting| setting.name);
        let names = names.filter(|name| ![OCCLUSION, EXPOSURE].contains(name));
        let given = names.filter_map(|name| Some((name, matches.get_one::<String>(name)?.clone())));
        let (occlusion, exposure) = (matches.get_one(OCCLUSION).copied(), matches.get_one(EXPOSURE).copied());
        Ok(Self { given: given.collect(), occlusion, exposure })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Returns the argument of an option.
fn argument(setting: &'static Setting) -> Arg {
    let name = setting.name;
    let default = Options::default().get(name).unwrap_or_default();
    let shown = match name {
        "samples" => "4 for a file without --plain or --cameras, else 1".to_owned(),
        "lighting" => "paths=4:3 for pictures of a file with physically based materials, without --plain, --cameras, \
                       --adaptive, --ambient-occlusion or --sky-rays; else direct"
            .into(),
        "denoise" => "true for pictures by paths by default; else false".into(),
        EXPOSURE => "auto for pictures of a file without --plain or --cameras, else 0".into(),
        "shadow_rays" => format!("{default}; 4 for a file without --plain, --cameras, --samples or --adaptive"),
        OCCLUSION => {
            "off; a radius of 0.1 of the scene's diagonal, or 0.3 for a file without --plain or --cameras".into()
        }
        _ => default.clone(),
    };
    let (short, long) = setting.about.split_once("\n\n").unwrap_or((setting.about, ""));
    let short = if ["off", "false"].contains(&shown.as_str()) {
        short.to_owned()
    } else {
        format!("{short} [default: {shown}]")
    };
    let mut argument = Arg::new(name).long(name.replace('_', "-")).help(short.clone()).help_heading(HEADING);
    if !long.is_empty() {
        argument = argument.long_help(format!("{short}\n\n{long}"));
    }
    if default == "false" {
        let argument = argument.value_name("BOOL").num_args(0..=1).require_equals(true).default_missing_value("true");
        return argument.value_parser(move |text: &str| checked(name, text));
    }
    argument = argument.value_name(setting.form.trim_end_matches("|off")).allow_hyphen_values(true);
    match name {
        "adaptive" => argument.conflicts_with("samples").value_parser(move |text: &str| checked(name, text)),
        "sky_rays" => argument.alias("sky-light").value_parser(move |text: &str| checked(name, text)),
        EXPOSURE => argument.value_name("EV|auto").value_parser(exposure),
        OCCLUSION => {
            argument.value_name("N[:RADIUS]").alias("occlusion").conflicts_with("sky_rays").value_parser(occlusion)
        }
        _ => argument.value_parser(move |text: &str| checked(name, text)),
    }
}

/// Checks an option's value.
fn checked(name: &str, text: &str) -> Result<String, String> {
    let options = Options::default().set(name, text).and_then(|options| options.check());
    options.map(|()| text.to_owned()).map_err(|error| match error {
        Error::Options { reason, .. } | Error::Samples { reason, .. } => reason,
        other => other.to_string(),
    })
}

impl PictureArguments {
    /// Checks the options together.
    pub(super) fn check(&self) -> Result<(), Usage> {
        // The radius does not matter.
        let occlusion = self.options.occlusion.map(|OcclusionArgument(rays, _)| AmbientOcclusion::new(rays, 1.0));
        let options = self.said().and_then(|options| options.ambient_occlusion(occlusion).check());
        options.map_err(|error| Usage(error.to_string()))
    }

    /// Returns whether the command line gives an option.
    pub(crate) fn gives(&self, name: &str) -> bool {
        self.options.given.iter().any(|(given, _)| *given == name)
    }

    /// Returns whether options on the command line leave the light of the automatic look open.
    pub(crate) fn leaves_light_open(&self) -> bool {
        self.options.occlusion.is_none() && !["lighting", "adaptive", "sky_rays"].iter().any(|name| self.gives(name))
    }

    /// Returns the arguments with the defaults of the automatic look of a file: antialiasing, and ambient occlusion
    /// unless lights or the sky light are given. `by_paths` asks for light by paths instead. Options on the command
    /// line keep their values.
    pub(crate) fn flattered(&self, lights_are_said: bool, scene: &Scene, by_paths: bool) -> Self {
        let mut settled = self.clone();
        let mut default = |name: &'static str, value: String| {
            if !self.gives(name) {
                settled.options.given.push((name, value));
            }
        };
        if !self.gives("samples") && !self.gives("adaptive") {
            default("shadow_rays", studio::RAYS.to_string());
            default("samples", studio::SAMPLES.to_string());
        }
        if by_paths {
            default("lighting", studio::PATHS.into());
            default("denoise", "true".into());
        }
        // Ambient occlusion treats glass as opaque, so objects in a glass case would be black.
        let has_glass = scene.materials().iter().any(|material| matches!(material.finish, Finish::Glass { .. }));
        // Paths find occluders themselves.
        let is_direct = settled.said().is_ok_and(|options| options.lighting == Lighting::Direct);
        let asks = self.options.occlusion.is_some() || self.gives("sky_rays");
        if !lights_are_said && !has_glass && !asks && is_direct {
            let rays = settled.said().map_or(Options::default().shadow_rays, |options| options.shadow_rays);
            settled.options.occlusion = Some(OcclusionArgument(rays, None));
        }
        settled
    }

    /// Returns whether the exposure is chosen by the scene. `otherwise` applies if the command line does not say.
    pub(crate) fn chooses_exposure(&self, otherwise: bool) -> bool {
        self.options.exposure.map_or(otherwise, |exposure| exposure == ExposureArgument::Auto)
    }

    /// Returns the options that the command line gives, with the library's defaults elsewhere.
    fn said(&self) -> Result<Options, Error> {
        let stops = if let Some(ExposureArgument::Stops(stops)) = self.options.exposure { stops } else { 0.0 };
        let options = Options::default().exposure(stops);
        self.options.given.iter().try_fold(options, |options, (name, value)| options.set(name, value))
    }

    /// Returns the render options for a scene. `reach` is the default radius of ambient occlusion, as a share of the
    /// scene's diagonal.
    pub(crate) fn options(&self, scene: &Scene, reach: f32) -> Result<Options, Error> {
        let diagonal = scene.bounds().map(|(low, high)| low.distance(high) as f32).filter(|diagonal| *diagonal > 0.0);
        let occlusion = self.options.occlusion.and_then(|OcclusionArgument(rays, radius)| {
            let radius = radius.or(diagonal.map(|diagonal| reach * diagonal))?;
            Some(AmbientOcclusion::new(rays, radius))
        });
        Ok(self.said()?.ambient_occlusion(occlusion))
    }
}
