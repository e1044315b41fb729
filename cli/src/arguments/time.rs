//! Defines the options of a scene file's animation.

use std::error::Error;

use clap::Args;
use stereotrace::Animation;

use super::values::finite;

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "How it moves")]
pub(crate) struct TimeArguments {
    /// Animation of a glTF file: its name, its number counted from 0, or none [default: the first one. Only `sequence`
    /// plays it without --time]
    #[arg(long, value_name = "NAME|N|none")]
    animation: Option<String>,
    /// Time of the animation in seconds; for `sequence`, that of picture 0 [default: 0 for `sequence`, else the file's
    /// pose at rest]
    #[arg(long, value_name = "SECONDS", value_parser = finite, allow_hyphen_values = true)]
    time: Option<f64>,
}

impl TimeArguments {
    /// Returns the animation that the options choose, or `None` for a scene at rest.
    pub(super) fn animation(&self, animations: &[Animation]) -> Result<Option<Animation>, Box<dyn Error>> {
        let wanted = match self.animation.as_deref() {
            Some("none") => return Ok(None),
            None if animations.is_empty() => match self.time {
                Some(time) => return Err(format!("--time {time}: the scene has no animations").into()),
                None => return Ok(None),
            },
            None => return Ok(animations.first().cloned()),
            Some(wanted) => wanted,
        };
        let by_name = animations.iter().position(|animation| animation.name() == wanted);
        let by_number = || wanted.parse().ok().filter(|number: &usize| *number < animations.len());
        match by_name.or_else(by_number) {
            Some(place) => Ok(Some(animations[place].clone())),
            None => {
                let names = Vec::from_iter(animations.iter().take(20).map(Animation::name)).join(", ");
                let there_are = if names.is_empty() { "the scene has none".into() } else { format!("use {names}") };
                Err(format!("--animation {wanted}: no such animation; {there_are}").into())
            }
        }
    }

    /// Returns the time of --time in seconds. It is 0 if only an animation is chosen.
    pub(super) fn seconds(&self) -> Option<f64> {
        self.time.or_else(|| self.animation.as_ref().map(|_| 0.0))
    }
}
