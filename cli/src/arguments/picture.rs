//! Defines the options of rendering: the picture's size, and the options that the library names.

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};
use stereotrace::{AmbientOcclusion, Error, Finish, Lighting, Options, Scene, Setting};

use super::values::{OcclusionArgument, occlusion, size};
use crate::studio;

/// Default size of an eye's picture: width and height in pixels.
pub(super) const SIZE: [u32; 2] = [1280, 720];

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Picture")]
pub(crate) struct PictureArguments {
    /// Size of one eye's picture in pixels [default: 1280x720, or the size in the --calib file]
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
}

/// Name of the option that the command gives a default radius.
const OCCLUSION: &str = "ambient_occlusion";

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
        let names = Setting::ALL.iter().map(|setting| setting.name).filter(|name| *name != OCCLUSION);
        let given = names.filter_map(|name| Some((name, matches.get_one::<String>(name)?.clone())));
        Ok(Self { given: given.collect(), occlusion: matches.get_one(OCCLUSION).copied() })
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
    let mut argument = Arg::new(name).long(name.replace('_', "-")).help(short.clone()).help_heading("Picture");
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
    /// Returns the size of an eye's picture: width and height in pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.size_said.unwrap_or(SIZE)
    }

    /// Returns whether the command line gives an option.
    fn gives(&self, name: &str) -> bool {
        self.options.given.iter().any(|(given, _)| *given == name)
    }

    /// Returns the arguments with the defaults of the automatic look of a file: antialiasing, and ambient occlusion
    /// unless lights or the sky light are given. Options on the command line keep their values.
    pub(crate) fn flattered(&self, lights_are_said: bool, scene: &Scene) -> Self {
        let mut settled = self.clone();
        if !self.gives("samples") && !self.gives("adaptive") {
            if !self.gives("shadow_rays") {
                settled.options.given.push(("shadow_rays", studio::RAYS.to_string()));
            }
            settled.options.given.push(("samples", studio::SAMPLES.to_string()));
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

    /// Returns the options that the command line gives, with the library's defaults elsewhere.
    fn said(&self) -> Result<Options, Error> {
        self.options.given.iter().try_fold(Options::default(), |options, (name, value)| options.set(name, value))
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
