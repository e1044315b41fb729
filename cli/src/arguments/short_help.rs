//! Makes the short help of `-h`, which shows the common options and examples on one screen. `--help` shows all options.

use clap::{Arg, Command, CommandFactory};

use super::Cli;

/// Options that `-h` shows. Commands without examples show all their options.
const COMMON: &[&str] = &[
    "scene",
    "out",
    "size_said",
    "method",
    "samples",
    "packing",
    "cameras",
    "eye",
    "target",
    "fov",
    "screen",
    "interaxial",
    "sky",
    "orbit",
    "path",
    "quilt",
    "display",
    "layout",
    "pairs",
    "methods",
    "seconds",
    "quiet",
    "help",
];

/// Example command lines of each command.
const EXAMPLES: [(&str, &[&str]); 8] = [
    (
        "render",
        &[
            "stereotrace render                              the built-in hall, into out/",
            "stereotrace render bunny.obj --out bunny.png    an anaglyph of your model",
            "stereotrace render room.glb --camera Desk --samples 16 --packing side-by-side --out room.jpg",
            "stereotrace render room.obj --sky studio.hdr --sky-rays 16 --out room.png",
        ],
    ),
    (
        "sequence",
        &[
            "stereotrace sequence bunny.obj --orbit 72 --out turn.mp4    a turntable, as a film",
            "stereotrace sequence fox.glb --fps 30 --ground-truth --out fox    an animation, with optical flow",
        ],
    ),
    (
        "views",
        &[
            "stereotrace views bunny.obj --display looking-glass-go    a quilt, into out/",
            "stereotrace views room.glb --views 8 --out row    eight views, as files",
        ],
    ),
    ("view", &["stereotrace view bunny.obj    a window with a live anaglyph"]),
    (
        "dataset",
        &[
            "stereotrace dataset room.obj --pairs 200 --layout kitti --size 1242x375 --out data",
            "stereotrace dataset room.obj --orbit 72 --layout middlebury --out turn",
            "stereotrace dataset verify data    what is missing or changed",
        ],
    ),
    (
        "compare",
        &[
            "stereotrace compare    every method, on the built-in hall",
            "stereotrace compare sponza.obj --methods bracket,atomic",
        ],
    ),
    ("bench", &["stereotrace bench    out/bench.json and out/bench.html, in about a minute"]),
    ("info", &["stereotrace info bunny.obj    the file's content, and this machine's adapters"]),
];

/// Returns the command line, with its short help.
pub(crate) fn command() -> Command {
    let short = |arg: Arg| if COMMON.contains(&arg.get_id().as_str()) { arg } else { arg.hide_short_help(true) };
    with_examples(short)
}

/// Returns the command line with all options, for the manual.
pub(crate) fn whole_command() -> Command {
    with_examples(|arg| arg)
}

fn with_examples(short: impl Fn(Arg) -> Arg + Copy) -> Command {
    let mut whole = Cli::command().mut_args(short);
    for (name, examples) in EXAMPLES {
        let examples = format!("Examples:\n  {}", examples.join("\n  "));
        let short_examples = format!("{examples}\n\nThese are the common options; `--help` has all of them.");
        whole = whole.mut_subcommand(name, |command| {
            command.mut_args(short).after_help(short_examples).after_long_help(examples)
        });
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_help_is_one_screen_and_long_help_has_the_rest() {
        let mut whole = command();
        whole.build();
        let mut seen = Vec::new();
        for (name, _) in EXAMPLES {
            let command = whole.find_subcommand_mut(name).unwrap();
            let (short, long) = (command.render_help().to_string(), command.render_long_help().to_string());
            // At 100 columns, the help texts have 42 to 57 lines.
            assert!(short.lines().count() <= 60, "{name}: {}\n{short}", short.lines().count());
            assert!(short.contains("Examples:") && long.contains("Examples:"), "{name}");
            assert!(long.contains("--adapter") && !short.contains("--adapter"), "{name}");
            seen.extend(command.get_arguments().map(|arg| arg.get_id().to_string()));
        }
        for id in COMMON {
            assert!(*id == "help" || seen.iter().any(|seen| seen == id), "no command has {id}");
        }
    }

    #[test]
    fn examples_are_command_lines() {
        let lines = EXAMPLES.iter().flat_map(|(_, lines)| *lines);
        let lines = lines.copied().chain(super::super::AFTER.lines().map(str::trim));
        let mut count = 0;
        for line in lines.filter(|line| line.starts_with("stereotrace ")) {
            // Several spaces separate the example from a remark.
            let line = line.split("    ").next().unwrap();
            let words = line.split(" cost and").next().unwrap().split_whitespace();
            if let Err(error) = command().try_get_matches_from(words) {
                panic!("{line}: {error}");
            }
            count += 1;
        }
        assert!(count > 20, "{count}");
    }

    #[test]
    fn the_manual_describes_every_option() {
        let mut page = Vec::new();
        crate::manual(&mut page).unwrap();
        let page = String::from_utf8(page).unwrap();
        for text in ["filter that weights the samples", "Graphics adapter", "Exposure in stops"] {
            assert!(page.contains(text), "{text}");
        }
    }

    #[test]
    fn help_has_the_words_that_people_search_for() {
        let mut whole = command();
        whole.build();
        let help = whole.find_subcommand_mut("render").unwrap().render_long_help().to_string().to_lowercase();
        let flat = help.split_whitespace().collect::<Vec<_>>().join(" ");
        for word in [
            "antialiasing",
            "convergence",
            "interpupillary distance, ipd",
            "baseline",
            "hdri",
            "environment map",
            "ambient occlusion",
            "soft shadows",
            "tone mapping",
            "exposure",
            "ground truth",
            "side by side",
            "image-based lighting",
            "reflections",
        ] {
            assert!(flat.contains(word), "{word}");
        }
    }
}
