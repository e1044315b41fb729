//! Parses option values.

use std::{ops::Range, path::PathBuf};

use stereotrace::{
    Lens, Light, Limits, MissingTextures, MotionBlur, Origin, OutsideFiles, PoleMerge, Span,
    camera::{Display, MAX_SIDE, SCREEN_DISTANCES},
    glam::{DVec3, Vec3},
};

/// Crease angle in degrees for objects without normals; `None` leaves them flat.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CreaseAngle(pub(crate) Option<f32>);

/// Count that the command line gives in millions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Millions(pub(crate) u64);

/// Number of rays, and optionally their length in world units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OcclusionArgument(pub(crate) u32, pub(crate) Option<f32>);

pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').map(|(width, height)| [width, height].map(str::parse));
    match sides {
        Some([Ok(width), Ok(height)]) if width > MAX_SIDE || height > MAX_SIDE => {
            Err(format!("a side has at most {MAX_SIDE} pixels"))
        }
        Some([Ok(width), Ok(height)]) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("it must be like 1280x720".into()),
    }
}

/// Range of azimuths of equirectangular pictures; `None` for planar ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ProjectionArgument(pub(crate) Option<Span>);

pub(crate) fn projection(text: &str) -> Result<ProjectionArgument, String> {
    match text {
        "planar" => Ok(ProjectionArgument(None)),
        "360" => Ok(ProjectionArgument(Some(Span::Full))),
        "180" => Ok(ProjectionArgument(Some(Span::Half))),
        _ => Err("it must be planar, 360 or 180".into()),
    }
}

/// Lenses of the left and the right eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LensArgument(pub(crate) [Lens; 2]);

/// Reads lenses from JSON, or from a file of it.
pub(crate) fn lens(text: &str) -> Result<LensArgument, String> {
    let lenses = match text.trim_start().starts_with('{') {
        true => Lens::pair_from_json(text),
        false => Lens::pair_from_json_file(text, &Limits::default()),
    };
    lenses.map(LensArgument).map_err(|error| error.to_string())
}

/// Merging of the eyes at the poles, if any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PoleMergeArgument(pub(crate) Option<PoleMerge>);

pub(crate) fn pole_merge(text: &str) -> Result<PoleMergeArgument, String> {
    if text == "off" {
        return Ok(PoleMergeArgument(None));
    }
    let angles = text.split_once(':').map(|(from, to)| [from, to].map(str::parse));
    match angles {
        Some([Ok(from), Ok(to)]) => Ok(PoleMergeArgument(Some(PoleMerge { from, to }))),
        _ => Err("it must be off, or two elevations in degrees like 60:75".into()),
    }
}

/// Shutter of a film: the share of the time between pictures for which it is open, and the number of pictures within
/// this time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ShutterArgument {
    pub(crate) open: f64,
    pub(crate) times: u32,
}

pub(crate) fn shutter(text: &str) -> Result<ShutterArgument, String> {
    let (open, times) = text.split_once(':').map_or((text, None), |(open, times)| (open, Some(times)));
    let times = times.map_or(Ok(MotionBlur::TIMES), str::parse);
    let most = MotionBlur::MOST_TIMES;
    match (open.parse(), times) {
        (Ok(open), Ok(times)) if (0.0..=1.0).contains(&open) && (2..=most).contains(&times) => {
            Ok(ShutterArgument { open, times })
        }
        _ => Err(format!("it must be a share from 0 to 1, optionally followed by : and 2 to {most} times")),
    }
}

pub(crate) fn point(text: &str) -> Result<DVec3, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    let numbers = numbers.ok().and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    numbers.map(DVec3::from_array).ok_or_else(|| "it must be three numbers like -1,0,2.5".into())
}

pub(crate) fn origin(text: &str) -> Result<Origin, String> {
    match text {
        "auto" => Ok(Origin::Auto),
        "none" => Ok(Origin::World),
        _ => point(text).map(Origin::At).map_err(|_| "it must be auto, none, or three numbers like 500000,0,0".into()),
    }
}

/// Default intensity of a light.
const INTENSITY: f32 = 0.85;

pub(crate) fn light(text: &str) -> Result<Light, String> {
    let mut parts = text.split(':');
    let (position, intensity, radius) = (parts.next().unwrap_or_default(), parts.next(), parts.next());
    if parts.next().is_some() {
        return Err("it must be a position like 1,4,2, optionally followed by :R,G,B and :RADIUS".into());
    }
    let position = point(position)?;
    let intensity = intensity.map_or(Ok(Vec3::splat(INTENSITY)), ambient)?;
    if !position.is_finite() {
        return Err("its position must be finite".into());
    }
    Ok(match radius {
        None => Light::point(position, intensity),
        Some(radius) => Light::sphere(position, above_zero(radius)?, intensity),
    })
}

/// Parses linear light: one number for all channels, or three.
pub(crate) fn ambient(text: &str) -> Result<Vec3, String> {
    let light = text.parse().map(Vec3::splat).or_else(|_| point(text).map(|light| light.as_vec3()));
    let light = light.ok().filter(|light| light.is_finite() && light.min_element() >= 0.0);
    light.ok_or_else(|| "light must be a number like 0.3, or three like 1,0.9,0.8, of at least 0".into())
}

/// The sky of --sky.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SkyArgument {
    /// Linear light of all directions.
    Color(Vec3),
    Procedural,
    File(PathBuf),
}

/// Parses a sky. Numbers between commas are linear light.
pub(crate) fn sky(text: PathBuf) -> Result<SkyArgument, String> {
    match text.to_str() {
        Some("procedural") => Ok(SkyArgument::Procedural),
        Some(light) if light.split(',').all(|part| part.parse::<f32>().is_ok()) => {
            ambient(light).map(SkyArgument::Color)
        }
        _ => Ok(SkyArgument::File(text)),
    }
}

pub(crate) fn display(text: &str) -> Result<Display, String> {
    let sides = text.split_once(':').ok_or("it must be width and distance in metres, like 1.2:2.5")?;
    Ok(Display::new(above_zero(sides.0)?, above_zero(sides.1)?))
}

/// Parses a half-open range of frames, such as 0..24.
pub(crate) fn frames(text: &str) -> Result<Range<u32>, String> {
    let ends = text.split_once("..").and_then(|(first, end)| Some((first.parse().ok()?, end.parse().ok()?)));
    let range = ends.map(|(first, end)| first..end).filter(|range| !range.is_empty());
    range.ok_or_else(|| "it must be like 0..24, which means frames 0 to 23".into())
}

pub(crate) fn crease_angle(text: &str) -> Result<CreaseAngle, String> {
    let degrees = text.parse().ok().filter(|degrees| (0.0..=180.0).contains(degrees));
    match (text, degrees) {
        ("off", _) => Ok(CreaseAngle(None)),
        (_, Some(degrees)) => Ok(CreaseAngle(Some(degrees))),
        _ => Err("it must be 0 to 180, or off".into()),
    }
}

pub(crate) fn occlusion(text: &str) -> Result<OcclusionArgument, String> {
    let (rays, radius) = text.split_once(':').map_or((text, None), |(rays, radius)| (rays, Some(radius)));
    let rays = rays.parse().map_err(|_| "it must be a number of rays like 16, or with a radius like 16:0.5")?;
    Ok(OcclusionArgument(rays, radius.map(above_zero).transpose()?))
}

/// The exposure of --exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ExposureArgument {
    /// Chosen by the scene.
    Auto,
    Stops(f32),
}

pub(crate) fn exposure(text: &str) -> Result<ExposureArgument, String> {
    if text == "auto" {
        return Ok(ExposureArgument::Auto);
    }
    let stops = text.parse().ok().filter(|stops| (-64.0..=64.0).contains(stops));
    stops.map(ExposureArgument::Stops).ok_or_else(|| "it must be auto, or -64 to 64 stops".into())
}

pub(crate) fn missing_textures(text: &str) -> Result<MissingTextures, String> {
    match text {
        "error" => Ok(MissingTextures::Error),
        "warn" => Ok(MissingTextures::Warn),
        _ => Err("it must be error or warn".into()),
    }
}

pub(crate) fn outside_files(text: &str) -> Result<OutsideFiles, String> {
    match text {
        "refuse" => Ok(OutsideFiles::Refuse),
        "allow" => Ok(OutsideFiles::Allow),
        _ => Err("it must be refuse or allow".into()),
    }
}

/// Parses a count in millions: 8.388608 is 8,388,608.
pub(crate) fn millions(text: &str) -> Result<Millions, String> {
    let count = text.parse().ok().filter(|millions: &f64| millions.is_finite() && *millions >= 0.0);
    let count = count.ok_or("it must be a number of millions like 100 or 8.4")?;
    Ok(Millions((1e6 * count).round() as u64))
}

pub(crate) fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "it must be a finite number".into())
}

/// Parses a field of view in degrees.
pub(crate) fn field_of_view(text: &str) -> Result<f32, String> {
    let degrees = text.parse().ok().filter(|&degrees: &f32| degrees > 0.0 && degrees < 180.0);
    degrees.ok_or_else(|| "it must be above 0 and below 180 degrees".into())
}

/// Parses the distance of the screen.
pub(crate) fn screen(text: &str) -> Result<f32, String> {
    let fits = |distance: &f32| SCREEN_DISTANCES.contains(distance) || *distance == f32::INFINITY;
    let distance = text.parse().ok().filter(fits);
    distance.ok_or_else(|| "it must lie between 1e-6 and 1e9, or be inf".into())
}

/// Parses the distance between the eyes.
pub(crate) fn interaxial(text: &str) -> Result<f32, String> {
    let distance = text.parse().ok().filter(|&distance: &f32| distance >= 0.0 && distance.is_finite());
    distance.ok_or_else(|| "it must be a number of at least 0".into())
}

pub(crate) fn above_zero(text: &str) -> Result<f32, String> {
    let number = text.parse().ok().filter(|&number: &f32| number > 0.0 && number.is_finite());
    number.ok_or_else(|| "it must be a number above 0".into())
}
