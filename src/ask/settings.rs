//! Options by name. The command, the Python package and the page take names, values and defaults from this table.

use std::str::FromStr;

use crate::{Adaptive, AmbientOcclusion, Error, Lighting, Options, Penumbra, ShadowBuffer, ShadowRule, Tone};

/// An option of rendering that users set by name.
///
/// ```
/// use stereotrace::{Options, Setting};
///
/// let options = Options::default().set("samples", "9")?.set("adaptive", "off")?;
/// assert_eq!((options.samples, options.get("tone")?.as_str()), (9, "clamp"));
/// assert!(Setting::ALL.iter().all(|setting| options.get(setting.name).is_ok()));
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Setting {
    /// Name, in lower case with underscores.
    pub name: &'static str,
    /// Form of the value, such as `N` or `clamp|filmic`. Forms with `off` accept `off`, which disables the option.
    pub form: &'static str,
    /// Description with the values that are accepted. Details follow after an empty line.
    pub about: &'static str,
    set: fn(&mut Options, &str) -> Result<(), String>,
    get: fn(&Options) -> String,
}

/// Number of levels of adaptive antialiasing if only a tolerance is given. 4 levels have up to 9 samples along a side.
const LEVELS: u32 = 4;

/// Number of paths per pixel if none is given.
const PATHS: u32 = 64;

impl Setting {
    /// All settings, the most common first.
    pub const ALL: &'static [Self] = &[
        Self {
            name: "method",
            form: "METHOD",
            about: "Method that renders the second eye: auto (the cheaper of bracket and naive), naive, bracket or \
                    another method\n\n\
                    auto predicts the cheaper method; naive traces both eyes; bracket reuses the left eye's shadows \
                    and shows the same surfaces as naive. Other methods are ideal, atomic, buffer, buffer-2e, \
                    buffer-N (N slots per pixel), es-isler, adelson-hodges, atomic-edges, buffer-edges, verified and \
                    bracket-rays.",
            set: |options, text| put(&mut options.method, named(text)),
            get: |options| options.method.to_string(),
        },
        Self {
            name: "samples",
            form: "N",
            about: "Samples per pixel, for antialiasing: 1, 4, 9, 16, 25, 36, 49 or 64",
            set: |options, text| put(&mut options.samples, count(text)),
            get: |options| options.samples.to_string(),
        },
        Self {
            name: "adaptive",
            form: "TOL[:LEVELS]|off",
            about: "Adaptive antialiasing in place of samples: divide a pixel if samples in its corners differ by \
                    more than TOL of 255. LEVELS is 2 to 5, by default 4",
            set: |options, text| put(&mut options.adaptive, off(text, adaptive)),
            get: |options| optional(options.adaptive, |Adaptive { levels, tolerance }| format!("{tolerance}:{levels}")),
        },
        Self {
            name: "filter",
            form: "KIND",
            about: "Reconstruction filter that weights the samples of a pixel: box, tent or gauss",
            set: |options, text| put(&mut options.filter, named(text)),
            get: |options| options.filter.to_string(),
        },
        Self {
            name: "jitter",
            form: "BOOL",
            about: "Jitter the sample grid, so that near-vertical edges get more levels: true or false",
            set: |options, text| put(&mut options.jitter, flag(text)),
            get: |options| options.jitter.to_string(),
        },
        Self {
            name: "lighting",
            form: "direct|paths[=SAMPLES[:BOUNCES]]",
            about: "Light that reaches surfaces by other surfaces: direct (none but in mirrors and glass), or paths \
                    (global illumination by path tracing). SAMPLES paths per pixel, 1 to 4096, by default 64; at most \
                    BOUNCES scattering surfaces after the first, 0 to 32, by default 8",
            set: |options, text| put(&mut options.lighting, lighting(text)),
            get: |options| match options.lighting {
                Lighting::Direct => "direct".into(),
                Lighting::Paths { bounces, samples } => format!("paths={samples}:{bounces}"),
            },
        },
        Self {
            name: "denoise",
            form: "BOOL",
            about: "Remove noise from the light of paths (--lighting paths), for pictures to look at: true or false",
            set: |options, text| put(&mut options.denoise, flag(text)),
            get: |options| options.denoise.to_string(),
        },
        Self {
            name: "bounces",
            form: "N",
            about: "Maximum number of reflections and refractions along a ray: 0 to 8",
            set: |options, text| put(&mut options.bounces, count(text)),
            get: |options| options.bounces.to_string(),
        },
        Self {
            name: "exposure",
            form: "EV",
            about: "Exposure in stops, -64 to 64: each stop doubles the brightness",
            set: |options, text| put(&mut options.exposure, number(text)),
            get: |options| options.exposure.to_string(),
        },
        Self {
            name: "tone",
            form: "clamp|filmic",
            about: "Tone mapping: clamp values above 1, or filmic, a curve for all values",
            set: |options, text| put(&mut options.tone, tone(text)),
            get: |options| match options.tone {
                Tone::Clamp => "clamp".into(),
                Tone::Filmic => "filmic".into(),
            },
        },
        Self {
            name: "seed",
            form: "N",
            about: "Seed of the random numbers for soft light and jitter. Equal seeds give equal pictures",
            set: |options, text| put(&mut options.seed, count(text)),
            get: |options| options.seed.to_string(),
        },
        Self {
            name: "shadow_rays",
            form: "N",
            about: "Shadow rays per sample to each light that is not a point, 1 to 32",
            set: |options, text| put(&mut options.shadow_rays, count(text)),
            get: |options| options.shadow_rays.to_string(),
        },
        Self {
            name: "ambient_occlusion",
            form: "N:RADIUS|off",
            about: "Ambient occlusion by N rays per sample, 1 to 32, with occluders up to RADIUS world units away",
            set: |options, text| put(&mut options.ambient_occlusion, off(text, ambient_occlusion)),
            get: |options| {
                optional(options.ambient_occlusion, |AmbientOcclusion { rays, radius }| format!("{rays}:{radius}"))
            },
        },
        Self {
            name: "sky_rays",
            form: "N|off",
            about: "Light surfaces by the sky (image-based lighting) in place of ambient light, by N rays per sample, \
                    1 to 32. Occluders block the sky's light",
            set: |options, text| put(&mut options.sky_rays, off(text, count)),
            get: |options| optional(options.sky_rays, |rays| rays.to_string()),
        },
        Self {
            name: "penumbra",
            form: "exact|shared[=DEVIATIONS]",
            about: "Soft light that the second eye reuses: exact reuses it where a light is wholly visible or hidden; \
                    shared (the default) also in penumbrae, where samples differ by at most DEVIATIONS standard \
                    deviations",
            set: |options, text| put(&mut options.penumbra, penumbra(text)),
            get: |options| match options.penumbra {
                Penumbra::Exact => "exact".into(),
                Penumbra::Shared { deviations } => format!("shared={deviations}"),
            },
        },
        Self {
            name: "noise_by_view",
            form: "BOOL",
            about: "Use different random numbers in each view: true or false",
            set: |options, text| put(&mut options.noise_by_view, flag(text)),
            get: |options| options.noise_by_view.to_string(),
        },
        Self {
            name: "visibility",
            form: "KIND",
            about: "Algorithm that finds the closest hits of traced views: rays, or t-buffer, which draws each \
                    primitive over the pixels that it may cover",
            set: |options, text| put(&mut options.visibility, named(text)),
            get: |options| options.visibility.to_string(),
        },
        Self {
            name: "shadow_buffer",
            form: "ROWS[:object|depth[=BIAS]|hybrid[=MARGIN]]|off",
            about: "Use shadow buffers in place of shadow rays: tables of ROWS rows of directions around each point \
                    light. The rule compares objects, compares depths with a BIAS, or traces rays where the buffer is \
                    uncertain (hybrid, the default). BIAS and MARGIN are in texel widths",
            set: |options, text| put(&mut options.shadow_buffer, off(text, shadow_buffer)),
            get: |options| {
                optional(options.shadow_buffer, |ShadowBuffer { rows, rule }| match rule {
                    ShadowRule::Object => format!("{rows}:object"),
                    ShadowRule::Depth { bias } => format!("{rows}:depth={bias}"),
                    ShadowRule::Hybrid { margin } => format!("{rows}:hybrid={margin}"),
                })
            },
        },
        Self {
            name: "history",
            form: "MIB|off",
            about: "Memory for samples of earlier frames in MiB, at least 1, or off. The next frame finds the same \
                    first hits by them, and visible lights, with fewer rays. `sequence` has 1024 by default",
            set: |options, text| put(&mut options.history, off(text, count)),
            get: |options| optional(options.history, |mebibytes| mebibytes.to_string()),
        },
        Self {
            name: "count",
            form: "BOOL",
            about: "Count BVH nodes and primitive tests (slower): true or false",
            set: |options, text| put(&mut options.count, flag(text)),
            get: |options| options.count.to_string(),
        },
    ];

    /// Returns the setting of this name.
    ///
    /// # Errors
    /// [`Error::UnknownName`] with all names.
    pub fn named(name: &str) -> Result<&'static Self, Error> {
        let found = Self::ALL.iter().find(|setting| setting.name == name);
        found
            .ok_or_else(|| Error::unknown_name("option", name, &Self::ALL.iter().map(|it| it.name).collect::<Vec<_>>()))
    }
}

impl Options {
    /// Sets an option by name, from a text such as a user writes. [`Setting::form`] describes the text.
    /// [`Options::check`] checks ranges.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for an unknown name; [`Error::Options`] for a text that is not of the option's form.
    pub fn set(mut self, name: &str, value: &str) -> Result<Self, Error> {
        let setting = Setting::named(name)?;
        (setting.set)(&mut self, value).map_err(|reason| Error::Options { option: setting.name, reason })?;
        Ok(self)
    }

    /// Returns an option's value as a text that [`Options::set`] accepts.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for an unknown name.
    pub fn get(&self, name: &str) -> Result<String, Error> {
        Setting::named(name).map(|setting| (setting.get)(self))
    }
}

/// Sets a field to a parsed value.
fn put<T>(field: &mut T, value: Result<T, String>) -> Result<(), String> {
    *field = value?;
    Ok(())
}

fn adaptive(text: &str) -> Result<Adaptive, String> {
    let (tolerance, levels) = split(text);
    let wrong = |_| "it must be a tolerance like 8, or with a number of levels like 8:3".to_owned();
    let levels = levels.map_or(Ok(LEVELS), |levels| count(levels).map_err(wrong))?;
    Ok(Adaptive::new(levels, number(tolerance).map_err(wrong)?))
}

fn ambient_occlusion(text: &str) -> Result<AmbientOcclusion, String> {
    let (rays, radius) = split(text);
    let wrong = |_| "it must be a number of rays and a radius, like 16:0.5".to_owned();
    let radius = radius.map_or_else(|| Err(wrong(String::new())), |text| number(text).map_err(wrong))?;
    Ok(AmbientOcclusion::new(count(rays).map_err(wrong)?, radius))
}

fn lighting(text: &str) -> Result<Lighting, String> {
    let wrong = || "it must be direct, paths, paths=SAMPLES or paths=SAMPLES:BOUNCES".to_owned();
    let Some(numbers) = text.strip_prefix("paths") else {
        return if text == "direct" { Ok(Lighting::Direct) } else { Err(wrong()) };
    };
    let mut light = Lighting::paths(PATHS);
    if let Some((samples, bounces)) = numbers.strip_prefix('=').map(split) {
        light = Lighting::paths(count(samples).map_err(|_| wrong())?);
        if let (Some(text), Lighting::Paths { bounces, .. }) = (bounces, &mut light) {
            *bounces = count(text).map_err(|_| wrong())?;
        }
    } else if !numbers.is_empty() {
        return Err(wrong());
    }
    Ok(light)
}

fn tone(text: &str) -> Result<Tone, String> {
    match text {
        "clamp" => Ok(Tone::Clamp),
        "filmic" => Ok(Tone::Filmic),
        _ => Err("it must be clamp or filmic".into()),
    }
}

fn penumbra(text: &str) -> Result<Penumbra, String> {
    match setting(text)? {
        ("exact", None) => Ok(Penumbra::Exact),
        ("shared", None) => Ok(Penumbra::default()),
        ("shared", Some(deviations)) => Ok(Penumbra::Shared { deviations }),
        _ => Err("it must be exact, shared or shared=DEVIATIONS".into()),
    }
}

fn named<T: FromStr<Err = Error>>(text: &str) -> Result<T, String> {
    text.parse().map_err(|error: Error| error.to_string())
}

fn count(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| format!("{text} must be a whole number, 0 or more"))
}

fn number(text: &str) -> Result<f32, String> {
    text.parse().map_err(|_| format!("{text} must be a number"))
}

fn flag(text: &str) -> Result<bool, String> {
    text.parse().map_err(|_| format!("{text} must be true or false"))
}

/// Parses a value, or `off`.
fn off<T>(text: &str, parse: impl FnOnce(&str) -> Result<T, String>) -> Result<Option<T>, String> {
    if text == "off" { Ok(None) } else { parse(text).map(Some) }
}

fn optional<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "off".into(), text)
}

/// Splits `a:b`.
fn split(text: &str) -> (&str, Option<&str>) {
    text.split_once(':').map_or((text, None), |(first, second)| (first, Some(second)))
}

/// Splits a name from the number after it, as in `depth=2`.
fn setting(text: &str) -> Result<(&str, Option<f32>), String> {
    match text.split_once('=') {
        Some((name, value)) => Ok((name, Some(number(value)?))),
        None => Ok((text, None)),
    }
}

fn shadow_buffer(text: &str) -> Result<ShadowBuffer, String> {
    let (rows, rule) = split(text);
    let rows = count(rows).map_err(|_| "it must be a number of rows like 400, or with a rule like 400:object")?;
    let rule = match setting(rule.unwrap_or("hybrid"))? {
        ("object", None) => ShadowRule::Object,
        ("depth", bias) => bias.map_or(ShadowRule::DEPTH, |bias| ShadowRule::Depth { bias }),
        ("hybrid", margin) => margin.map_or(ShadowRule::HYBRID, |margin| ShadowRule::Hybrid { margin }),
        _ => return Err("its rule must be object, depth or depth=BIAS, hybrid or hybrid=MARGIN".into()),
    };
    Ok(ShadowBuffer::new(rows).rule(rule))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two values of each setting: the default and another one.
    const VALUES: [(&str, &str, &str); 20] = [
        ("method", "auto", "buffer-8-edges"),
        ("samples", "1", "64"),
        ("adaptive", "off", "8.5:3"),
        ("filter", "box", "gauss"),
        ("jitter", "true", "false"),
        ("lighting", "direct", "paths=16:3"),
        ("denoise", "false", "true"),
        ("bounces", "5", "0"),
        ("exposure", "0", "-1.5"),
        ("tone", "clamp", "filmic"),
        ("seed", "0", "4294967295"),
        ("shadow_rays", "16", "32"),
        ("ambient_occlusion", "off", "16:0.5"),
        ("sky_rays", "off", "32"),
        ("penumbra", "shared=1.5", "exact"),
        ("noise_by_view", "false", "true"),
        ("visibility", "rays", "t-buffer"),
        ("shadow_buffer", "off", "400:depth=2"),
        ("history", "off", "256"),
        ("count", "false", "true"),
    ];

    #[test]
    fn every_setting_reads_back_and_changes_its_option_alone() {
        assert_eq!(Setting::ALL.iter().map(|setting| setting.name).collect::<Vec<_>>(), VALUES.map(|(name, ..)| name));
        for (name, default, other) in VALUES {
            let options = Options::default();
            assert_eq!(options.get(name).unwrap(), default);
            assert_eq!(options.clone().set(name, default).unwrap(), options);
            let changed = options.clone().set(name, other).unwrap();
            for (every, default, other) in VALUES {
                assert_eq!(changed.get(every).unwrap(), if every == name { other } else { default }, "{name} {every}");
            }
        }
    }

    /// All fields are options by name, except those that select outputs, and the number of a pass.
    #[test]
    fn every_field_is_a_setting_or_an_output() {
        let fields = format!("{:?}", Options::default());
        let mut depth = 0;
        let top: String = fields
            .chars()
            .filter(|letter| {
                depth += i32::from("{([".contains(*letter)) - i32::from("})]".contains(*letter));
                depth == 1
            })
            .collect();
        let mut names: Vec<&str> =
            top.split(&['{', ','][..]).filter_map(|part| Some(part.split_once(':')?.0.trim())).collect();
        names.retain(|name| !["albedo", "cost_map", "g_buffer", "linear", "pass"].contains(name));
        let mut settings: Vec<&str> = Setting::ALL.iter().map(|setting| setting.name).collect();
        names.sort_unstable();
        settings.sort_unstable();
        assert_eq!(names, settings);
    }

    #[test]
    fn what_is_wrong_names_the_option_and_the_form() {
        let refused = |name: &str, value: &str| Options::default().set(name, value).unwrap_err().to_string();
        assert!(refused("sampels", "4").contains("samples"), "{}", refused("sampels", "4"));
        for (name, value, expected) in [
            ("samples", "four", "samples: four must be a whole number"),
            ("samples", "-1", "samples: -1 must be a whole number"),
            ("method", "fast", "naive"),
            ("adaptive", "8:x", "like 8:3"),
            ("ambient_occlusion", "16", "like 16:0.5"),
            ("jitter", "yes", "true or false"),
            ("tone", "soft", "clamp or filmic"),
            ("penumbra", "exact=2", "shared=DEVIATIONS"),
            ("shadow_buffer", "400:object=1", "hybrid=MARGIN"),
        ] {
            let message = refused(name, value);
            assert!(message.contains(expected), "{name} {value}: {message}");
        }
    }
}
