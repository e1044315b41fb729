//! Reads and checks a spec.

use std::path::PathBuf;

use serde_json::{Map, Value};

use super::{
    AroundEntry, Array, CameraEntry, CameraMotion, Checks, ChecksEntry, Distance, DrawnOption, Eye, Format, Generate,
    LayersEntry, LightEntry, Lights, MergeEntry, Motion, ObjectMotion, OriginEntry, Output, Poses, RandomLights,
    RandomMaterials, Randomise, Rig, RollingShutter, SceneEntry, SceneKind, SensorEntry, Shutter, Size, SkyEntry,
    Source, Spec,
    array::{array as camera_array, check_together as check_array},
    fields::{
        Fields, Unique, above_zero, array, color, fault, finite, flag, from_zero, list, number, one_of, point, shown,
        text, whole, within,
    },
    lens,
    projector::projector,
};
use crate::{
    Builtin, CameraPath, Channel, Error, Layering, Lighting, Limits, Maker, Method, MotionBlur, Options, PoleMerge,
    dataset::{
        draws::{Drawn, Normal, PLACES, Span},
        generate::MOST_OBJECTS,
    },
};

/// Maximum number of pairs.
const MOST_PAIRS: u32 = i32::MAX as u32;
/// Maximum number of pairs in Scene Flow's layout, which numbers files with four digits.
const SCENE_FLOW_PAIRS: u32 = 10_000;
/// Maximum length of a side of the picture in pixels.
const LONGEST_SIDE: u32 = 1 << 17;
/// Maximum radius of a light at infinity in radians.
const LARGEST_ANGLE: f64 = 1.5;
/// Default choice of layers.
const LAYERS: LayersEntry = LayersEntry { surfaces: 4, refracted: false, mirrored: false };
/// Maximum length of a mesh in a generated scene, in metres.
const LARGEST_MESH: f64 = 100.0;
/// Maximum number of attempts after a rejected one.
const MOST_REDRAWS: u32 = 1000;
const NO_SOURCE: &str = "give a file, the name of a built-in scene, or the kind of a generated scene";
/// Default time from a pair to the next one in seconds.
const STEP: f64 = 1.0 / 24.0;
/// Default share of this time for which the shutter is open: half of it, as in films.
const OPEN: f64 = 0.5;
/// Default and maximum number of bands of a rolling shutter.
const BANDS: u32 = 24;
const MOST_BANDS: u32 = 4096;
/// Maximum number of electrons of a sensor. Sensors of cameras have 1,000 to 100,000.
const MOST_ELECTRONS: f64 = 1e7;

pub(super) fn spec(text: &str, folder: PathBuf) -> Result<Spec, Error> {
    let value = match serde_json::from_str(text) {
        Ok(Unique(value)) => value,
        Err(error) => return fault("", format!("invalid JSON: {error}")),
    };
    let fields = Fields::of(&value, "")?;
    let name = fields.get("name", name)?;
    let seed = fields.get("seed", whole(0, u32::MAX))?;
    let pairs = fields.get("pairs", whole(1, MOST_PAIRS))?;
    let shard_pairs = fields.get("shard_pairs", whole(1, 100_000))?;
    let scene_pairs = fields.get("scene_pairs", whole(1, MOST_PAIRS))?;
    let format = fields.get("format", one_of(Format::all()))?.unwrap_or(Format::WebDataset);
    let size = fields.get("size", size)?;
    let scenes = fields.get("scenes", scenes)?;
    let poses = fields.get("poses", poses)?;
    let rig = fields.get("rig", rig)?;
    let randomise = fields.get("randomise", randomise)?;
    let motion = fields.get("motion", motion)?;
    let layers = fields.get("layers", layers)?;
    let sensor = fields.get("sensor", sensor)?;
    let render = fields.get("render", render)?;
    let outputs = fields.get("outputs", outputs)?;
    let compress = fields.get("compress", flag)?;
    fields.end()?;
    if let Some(layout) = format.layout() {
        for (key, is_given) in [("outputs", outputs.is_some()), ("compress", compress.is_some())] {
            if is_given {
                return fault(key, format!("the layout {layout} sets the files; leave this key out"));
            }
        }
    }
    let is_layout = format.layout().is_some();
    let Render { given: render, options, drawn: drawn_options, ends } = render.unwrap_or_default();
    let usual = match rig.as_ref().is_some_and(|rig: &Rig| rig.lens.is_some()) {
        true => ["color", "match", "match_visibility"],
        false => ["color", "disparity", "occlusion"],
    };
    let (names, arrays) = outputs.unwrap_or_else(|| arrays(usual.map(String::from)));
    let has_layers = arrays.iter().any(|array| array.output.is_layer());
    let default_size = match rig.as_ref().and_then(|rig: &Rig| rig.around).map(|around| around.projection) {
        None => [640, 480],
        Some(crate::Span::Full) => [1024, 512],
        Some(crate::Span::Half) => [512, 512],
    };
    let mut spec = Spec {
        name: name.unwrap_or_else(|| "pairs".into()),
        seed: seed.unwrap_or(0),
        pairs: fields.needed("pairs", pairs)?,
        shard_pairs: shard_pairs.unwrap_or(64),
        scene_pairs: scene_pairs.unwrap_or(1),
        format,
        size: size.unwrap_or(Size::One(default_size)),
        scenes: fields.needed("scenes", scenes)?,
        poses: poses.unwrap_or(Poses::Free { clearance: None, max_disparity: None, min_surfaces: None }),
        rig: rig.unwrap_or_default(),
        randomise: randomise.unwrap_or_default(),
        motion,
        layers: layers.or(has_layers.then_some(LAYERS)),
        sensor,
        render,
        outputs: (!is_layout).then_some(names),
        compress: (!is_layout).then(|| compress.unwrap_or(false)),
        folder,
        options,
        drawn_options,
        arrays,
    };
    read_path(&mut spec)?;
    check_together(&spec)?;
    for options in ends {
        check_together(&Spec { options, ..spec.clone() })?;
    }
    Ok(spec)
}

/// Reads a size, or sizes to choose from.
fn size(value: &Value, at: &str) -> Result<Size, Error> {
    let one = array(whole(1, LONGEST_SIDE));
    let Value::Object(_) = value else { return one(value, at).map(Size::One) };
    let fields = Fields::of(value, at)?;
    let choice = fields.get("choice", list(one))?;
    fields.end()?;
    match fields.needed("choice", choice)? {
        choice if choice.is_empty() => fault(&fields.path("choice"), "there is nothing to choose from"),
        choice => Ok(Size::Several { choice }),
    }
}

/// Reads the cameras of [`Poses::Path`], and checks that there is one for each pair.
fn read_path(spec: &mut Spec) -> Result<(), Error> {
    let Poses::Path { file, path } = &mut spec.poses else { return Ok(()) };
    let [width, height] = spec.size.all()[0];
    let read = CameraPath::from_json_within(spec.folder.join(&*file), width, height, &Limits::default())?;
    let needed = u64::from(spec.pairs) + u64::from(spec.motion.is_some());
    if needed > u64::from(read.frames()) {
        let next = if spec.motion.is_some() { ", and motion needs one more" } else { "" };
        return fault("pairs", format!("{}, but '{file}' has {} frames{next}", spec.pairs, read.frames()));
    }
    *path = Some(read);
    Ok(())
}

/// Reads a value or a distribution of values. Both ends of a range must be valid values.
pub(super) fn drawn<T: Span>(
    of: impl Fn(&Value, &str) -> Result<T, Error>,
) -> impl Fn(&Value, &str) -> Result<Drawn<T>, Error> {
    move |value, at| {
        let Value::Object(map) = value else { return of(value, at).map(Drawn::Value) };
        let only = map.iter().next().filter(|_| map.len() == 1);
        let ends = |kind: &str, value: &Value| -> Result<[T; 2], Error> {
            let at = format!("{at}.{kind}");
            let [low, high] = array(finite)(value, &at)?;
            if low > high || (kind == "log_uniform" && low <= 0.0) {
                let positive = if kind == "log_uniform" { " above 0" } else { "" };
                return fault(&at, format!("{} must be a low and a high number{positive}", shown(value)));
            }
            array(&of)(value, &at)
        };
        match only.map(|(kind, value)| (kind.as_str(), value)) {
            Some((kind @ "uniform", value)) => ends(kind, value).map(Drawn::Uniform),
            Some((kind @ "log_uniform", value)) => ends(kind, value).map(Drawn::LogUniform),
            Some(("normal", value)) => normal(&of, value, &format!("{at}.normal")).map(Drawn::Normal),
            Some(("choice", value)) => match list(&of)(value, &format!("{at}.choice"))? {
                choices if choices.is_empty() => fault(&format!("{at}.choice"), "there is nothing to choose from"),
                choices => Ok(Drawn::Choice(choices)),
            },
            _ => {
                let kinds = "uniform, log_uniform, normal, choice";
                fault(at, format!("{} must be a value, or a mapping of one key: {kinds}", shown(value)))
            }
        }
    }
}

/// Reads `[mean, deviation]` or `[mean, deviation, low, high]`. Both limits must be valid values. By default they are
/// six deviations from the mean.
fn normal<T>(of: &impl Fn(&Value, &str) -> Result<T, Error>, value: &Value, at: &str) -> Result<Normal, Error> {
    let numbers = list(finite)(value, at)?;
    let (mean, deviation, limits) = match numbers[..] {
        [mean, deviation] => (mean, deviation, [mean - 6.0 * deviation, mean + 6.0 * deviation]),
        [mean, deviation, low, high] => (mean, deviation, [low, high]),
        _ => return fault(at, "it must be [mean, deviation] or [mean, deviation, low, high]"),
    };
    let found = Normal { mean, deviation, limits };
    if deviation <= 0.0 || limits[0] >= limits[1] {
        return fault(at, format!("{} must have a deviation above 0, and a low and a high limit", shown(value)));
    }
    for limit in limits {
        let whole = Value::from(limit as i64);
        let limit = if limit.fract() == 0.0 { whole } else { Value::from(limit) };
        of(&limit, at).map_err(|error| match error {
            Error::Spec { key, reason } => Error::Spec { key, reason: format!("its limit {reason}") },
            other => other,
        })?;
    }
    let [below, above] = found.shares();
    match above - below > 1e-9 {
        true => Ok(found),
        false => fault(at, format!("{} has hardly any values between its limits", shown(value))),
    }
}

fn name(value: &Value, at: &str) -> Result<String, Error> {
    let is_plain = |text: &str| {
        text.len() <= 64
            && text.starts_with(|first: char| first.is_ascii_alphanumeric())
            && text.chars().all(|letter| letter.is_ascii_alphanumeric() || "-_".contains(letter))
    };
    match value.as_str().filter(|text| is_plain(text)) {
        Some(text) => Ok(text.to_owned()),
        None => fault(at, format!("{} must be at most 64 letters, digits, - and _", shown(value))),
    }
}

/// Reads a length. Infinity is written as text, since JSON has no infinity.
fn distance(value: &Value, at: &str) -> Result<Distance, Error> {
    let is_infinite = value == ".inf" || number(value, at)? == f64::INFINITY;
    if is_infinite { Ok(Distance(f64::INFINITY)) } else { above_zero(f64::INFINITY)(value, at).map(Distance) }
}

fn scenes(value: &Value, at: &str) -> Result<Vec<SceneEntry>, Error> {
    let scenes = list(scene)(value, at)?;
    match scenes.iter().any(|scene| scene.weight > 0.0) {
        true => Ok(scenes),
        false => fault(at, "at least one scene must have a weight above 0"),
    }
}

fn scene(value: &Value, at: &str) -> Result<SceneEntry, Error> {
    let fields = Fields::of(value, at)?;
    let file = fields.get("file", text)?;
    let builtin = fields.get("builtin", one_of(Builtin::ALL.iter().map(|&one| (one.name(), one)).collect()))?;
    let generate = fields.get("generate", generate)?;
    let weight = fields.get("weight", from_zero())?.unwrap_or(1.0);
    let crease_angle = fields.get("crease_angle", within(0.0, 180.0))?;
    let missing_textures = fields.get("missing_textures", one_of(named(["error", "warn"])))?;
    let outside_files = fields.get("outside_files", one_of(named(["refuse", "allow"])))?;
    let origin = fields.get("origin", origin)?;
    let camera = fields.get("camera", camera)?;
    let lights = fields.get("lights", lights)?;
    let ambient = fields.get("ambient", color)?;
    let sky = fields.get("sky", sky)?;
    let checks = fields.get("checks", checks)?;
    fields.end()?;
    let checks = checks.or_else(|| generate.as_ref().map(|_| ChecksEntry::On(Checks::default())));
    let source = match (file, builtin, generate) {
        (Some(file), None, None) => Source::File { file, crease_angle, missing_textures, outside_files, origin },
        (None, builtin, generate) if builtin.is_some() != generate.is_some() => {
            for (key, is_given) in [
                ("crease_angle", crease_angle.is_some()),
                ("missing_textures", missing_textures.is_some()),
                ("origin", origin.is_some()),
                ("outside_files", outside_files.is_some()),
            ] {
                if is_given {
                    let kind = if builtin.is_some() { "built in" } else { "generated" };
                    return fault(at, format!("{key} is an option for files, but this scene is {kind}"));
                }
            }
            match (builtin, generate) {
                (Some(builtin), _) => Source::Builtin { builtin },
                (None, Some(generate)) => Source::Generate { generate: Box::new(generate) },
                (None, None) => return fault(at, NO_SOURCE),
            }
        }
        _ => return fault(at, NO_SOURCE),
    };
    if let (Source::Generate { .. }, Some(CameraEntry { name: Some(_), .. })) = (&source, &camera) {
        return fault(&fields.path("camera.name"), "generated scenes have no cameras with names");
    }
    Ok(SceneEntry { source, weight, camera, lights, ambient, sky, checks })
}

/// Reads the kind of a generated scene, or a mapping with its options.
fn generate(value: &Value, at: &str) -> Result<Generate, Error> {
    let alone = Value::from_iter([("kind", value.clone())]);
    let value = if value.is_string() { &alone } else { value };
    let usual = |high| Drawn::Uniform([0.0, high]);
    let fields = Fields::of(value, at)?;
    let kind = fields.get("kind", one_of(SceneKind::ALL.map(|kind| (kind.name(), kind)).to_vec()))?;
    let share = |key: &'static str| fields.get(key, drawn(within(0.0, 1.0)));
    let found = Generate {
        kind: fields.needed("kind", kind)?,
        textures: fields.get("textures", text)?,
        skies: fields.get("skies", text)?,
        meshes: fields.get("meshes", text)?,
        mesh_size: fields.get("mesh_size", drawn(above_zero(LARGEST_MESH)))?,
        objects: fields.get("objects", drawn(whole(0, MOST_OBJECTS)))?,
        metals: share("metals")?.unwrap_or(usual(0.2)),
        glass: share("glass")?.unwrap_or(usual(0.12)),
        mirrors: share("mirrors")?.unwrap_or(usual(0.06)),
        plain: share("plain")?,
    };
    fields.end()?;
    match found.mesh_size {
        Some(_) if found.meshes.is_none() => fault(&fields.path("mesh_size"), "it needs meshes"),
        _ => Ok(found),
    }
}

/// Reads the limits of pictures, `true` for the default ones, or `false` for none.
fn checks(value: &Value, at: &str) -> Result<ChecksEntry, Error> {
    if let Value::Bool(is_on) = value {
        return Ok(if *is_on { ChecksEntry::On(Checks::default()) } else { ChecksEntry::Off(false) });
    }
    let fields = Fields::of(value, at)?;
    let usual = Checks::default();
    let share = |key: &'static str| fields.get(key, within(0.0, 1.0));
    let found = Checks {
        max_sky: share("max_sky")?.unwrap_or(usual.max_sky),
        max_dark: share("max_dark")?.unwrap_or(usual.max_dark),
        max_bright: share("max_bright")?.unwrap_or(usual.max_bright),
        max_plain: share("max_plain")?.unwrap_or(usual.max_plain),
        max_near: share("max_near")?.unwrap_or(usual.max_near),
        redraws: fields.get("redraws", whole(0, MOST_REDRAWS))?.unwrap_or(usual.redraws),
    };
    fields.end()?;
    Ok(ChecksEntry::On(found))
}

/// Returns names as values of themselves.
fn named<const N: usize>(names: [&'static str; N]) -> Vec<(&'static str, &'static str)> {
    names.map(|name| (name, name)).to_vec()
}

fn origin(value: &Value, at: &str) -> Result<OriginEntry, Error> {
    match value {
        Value::String(_) => one_of(named(["auto", "none"]))(value, at).map(OriginEntry::Named),
        _ => point(value, at).map(OriginEntry::At),
    }
}

fn camera(value: &Value, at: &str) -> Result<CameraEntry, Error> {
    let fields = Fields::of(value, at)?;
    let found = CameraEntry {
        name: fields.get("name", text)?,
        eye: fields.get("eye", point)?,
        target: fields.get("target", point)?,
        up: fields.get("up", point)?,
    };
    fields.end()?;
    match (&found.eye, &found.target) {
        (Some(_), None) | (None, Some(_)) => return fault(at, "give both eye and target, or none of them"),
        (Some(_), _) if found.name.is_some() => {
            let reason = "name selects a camera of the file, which has its own eye and target; leave these out";
            return fault(at, reason);
        }
        (Some(eye), Some(target)) if eye == target => {
            let shown = shown(&Value::from(target.to_vec()));
            return fault(&fields.path("target"), format!("{shown} must differ from the eye"));
        }
        _ => {}
    }
    match found.up {
        Some([0.0, 0.0, 0.0]) => fault(&fields.path("up"), "it must not be 0"),
        _ => Ok(found),
    }
}

fn lights(value: &Value, at: &str) -> Result<Lights, Error> {
    match value {
        Value::Number(_) => whole(0, 1000)(value, at).map(Lights::Placed),
        _ => list(light)(value, at).map(Lights::Given),
    }
}

fn light(value: &Value, at: &str) -> Result<LightEntry, Error> {
    let fields = Fields::of(value, at)?;
    let (position, towards) = (fields.get("position", point)?, fields.get("towards", point)?);
    let (intensity, radius) = (fields.get("intensity", color)?, fields.get("radius", from_zero())?);
    fields.end()?;
    let found = LightEntry { position, towards, intensity: fields.needed("intensity", intensity)?, radius };
    if position.is_some() == towards.is_some() {
        return fault(at, "give a position, or towards for a light at infinity");
    }
    match (towards, radius) {
        (Some([0.0, 0.0, 0.0]), _) => fault(&fields.path("towards"), "it must not be 0"),
        (Some(_), Some(radius)) if radius > LARGEST_ANGLE => {
            fault(&fields.path("radius"), format!("{radius} must be an angle of 0 to {LARGEST_ANGLE} radians"))
        }
        _ => Ok(found),
    }
}

/// Reads a colour, the name of a picture's file, or `procedural`.
fn sky(value: &Value, at: &str) -> Result<SkyEntry, Error> {
    match (color(value, at), value) {
        (Ok(color), _) => Ok(SkyEntry::Color(color)),
        (Err(_), Value::String(name)) => Ok(SkyEntry::Named(name.clone())),
        (Err(error), _) => Err(error),
    }
}

fn poses(value: &Value, at: &str) -> Result<Poses, Error> {
    enum Kind {
        Free,
        Orbit,
        Fixed,
        Path,
    }
    let fields = Fields::of(value, at)?;
    let kinds = vec![("free", &Kind::Free), ("orbit", &Kind::Orbit), ("fixed", &Kind::Fixed), ("path", &Kind::Path)];
    let found = match fields.get("kind", one_of(kinds))?.unwrap_or(&Kind::Free) {
        Kind::Free => Poses::Free {
            clearance: fields.get("clearance", drawn(from_zero()))?,
            max_disparity: fields.get("max_disparity", above_zero(f64::INFINITY))?,
            min_surfaces: fields.get("min_surfaces", within(0.0, 1.0))?,
        },
        Kind::Orbit => Poses::Orbit {
            turn: fields.get("turn", drawn(finite))?.unwrap_or(Drawn::Uniform([0.0, 360.0])),
            rise: fields.get("rise", drawn(finite))?.unwrap_or(Drawn::Value(0.0)),
            distance: fields.get("distance", drawn(above_zero(f64::INFINITY)))?.unwrap_or(Drawn::Value(1.0)),
        },
        Kind::Fixed => Poses::Fixed,
        Kind::Path => {
            let file = fields.get("file", text)?;
            Poses::Path { file: fields.needed("file", file)?, path: None }
        }
    };
    fields.end()?;
    Ok(found)
}

fn rig(value: &Value, at: &str) -> Result<Rig, Error> {
    let fields = Fields::of(value, at)?;
    let projection = fields.get("projection", projection)?.flatten();
    let pole_merge = fields.get("pole_merge", pole_merge)?;
    if let (None, Some(_)) = (projection, pole_merge) {
        return fault(&fields.path("pole_merge"), "only equirectangular pictures have poles: set rig.projection");
    }
    let PoleMerge { from, to } = PoleMerge::default();
    let usual = MergeEntry::Angles([from.into(), to.into()]);
    let found = Rig {
        around: projection.map(|projection| AroundEntry { projection, pole_merge: pole_merge.unwrap_or(usual) }),
        interaxial: fields.get("interaxial", drawn(from_zero()))?,
        interaxial_px: fields.get("interaxial_px", drawn(from_zero()))?,
        baseline: fields.get("baseline", drawn(from_zero()))?,
        screen_distance: fields.get("screen_distance", drawn(distance))?,
        fov: fields.get("fov", drawn(above_zero(180.0)))?,
        fx: fields.get("fx", drawn(above_zero(f64::INFINITY)))?,
        fy: fields.get("fy", drawn(above_zero(f64::INFINITY)))?,
        cx: fields.get("cx", drawn(finite))?,
        cy: fields.get("cy", drawn(finite))?,
        lens: fields.get("lens", lens::lens)?,
        array: fields.get("array", camera_array)?,
        projector: fields.get("projector", projector)?,
    };
    fields.end()?;
    lens::check_alone(&found, &fields)?;
    let planar = [
        ("interaxial_px", found.interaxial_px.is_some()),
        ("screen_distance", found.screen_distance.is_some()),
        ("fov", found.fov.is_some()),
        ("fx", found.fx.is_some()),
    ];
    if let (Some(_), Some((key, _))) = (found.around, planar.iter().find(|(_, is_given)| *is_given)) {
        return fault(&fields.path(key), "it is for planar pictures; equirectangular ones have no screen");
    }
    let separations =
        [("interaxial", &found.interaxial), ("interaxial_px", &found.interaxial_px), ("baseline", &found.baseline)];
    for same in [&separations[..], &[("fov", &found.fov), ("fx", &found.fx)]] {
        let given: Vec<_> = same.iter().filter(|(_, value)| value.is_some()).map(|(key, _)| *key).collect();
        if given.len() > 1 {
            return fault(at, format!("{} set the same value; give one of them", given.join(" and ")));
        }
    }
    match [("fy", &found.fy), ("cx", &found.cx), ("cy", &found.cy)].iter().find(|(_, value)| value.is_some()) {
        Some((key, _)) if found.fx.is_none() => fault(&fields.path(key), "it needs fx"),
        _ => Ok(found),
    }
}

/// Reads the degrees of equirectangular pictures, or `planar`.
fn projection(value: &Value, at: &str) -> Result<Option<crate::Span>, Error> {
    match (value.as_str(), value.as_f64().and_then(crate::Span::from_degrees)) {
        (Some("planar"), _) => Ok(None),
        (_, Some(span)) => Ok(Some(span)),
        _ => fault(at, format!("unknown {}; use planar, 360 or 180", shown(value))),
    }
}

fn pole_merge(value: &Value, at: &str) -> Result<MergeEntry, Error> {
    if *value == Value::Bool(false) {
        return Ok(MergeEntry::Off(false));
    }
    let [from, to] = array(number)(value, at)?;
    match (PoleMerge { from: from as f32, to: to as f32 }).is_valid() {
        true => Ok(MergeEntry::Angles([from, to])),
        false => fault(at, "it must be false, or two elevations in degrees: 0 or more, and a larger one up to 90"),
    }
}

fn randomise(value: &Value, at: &str) -> Result<Randomise, Error> {
    let fields = Fields::of(value, at)?;
    let found = Randomise {
        lights: fields.get("lights", random_lights)?,
        materials: fields.get("materials", random_materials)?,
        ambient: fields.get("ambient", drawn(from_zero()))?,
        exposure: fields.get("exposure", drawn(within(-64.0, 64.0)))?,
    };
    fields.end()?;
    Ok(found)
}

fn random_lights(value: &Value, at: &str) -> Result<RandomLights, Error> {
    let fields = Fields::of(value, at)?;
    let found = RandomLights {
        count: fields.get("count", drawn(whole(1, PLACES)))?.unwrap_or(Drawn::Value(3)),
        strength: fields.get("strength", drawn(from_zero()))?.unwrap_or(Drawn::Value(0.85)),
        tint: fields.get("tint", drawn(from_zero()))?.unwrap_or(Drawn::Value(1.0)),
        radius: fields.get("radius", drawn(from_zero()))?,
    };
    fields.end()?;
    Ok(found)
}

fn random_materials(value: &Value, at: &str) -> Result<RandomMaterials, Error> {
    let fields = Fields::of(value, at)?;
    let found = RandomMaterials {
        share: fields.get("share", within(0.0, 1.0))?.unwrap_or(1.0),
        albedo: fields.get("albedo", drawn(within(0.0, 1.0)))?,
        tint: fields.get("tint", drawn(from_zero()))?,
        specular: fields.get("specular", drawn(within(0.0, 1.0)))?,
        exponent: fields.get("exponent", drawn(within(0.0, 10_000.0)))?,
    };
    fields.end()?;
    if found.albedo.is_some() && found.tint.is_some() {
        return fault(at, "albedo replaces the colour that tint multiplies; give one of them");
    }
    Ok(found)
}

/// Options of rendering as they are given and as they are read.
#[derive(Default)]
struct Render {
    given: Map<String, Value>,
    options: Options,
    drawn: Vec<(String, DrawnOption)>,
    /// The options with each end of each distribution.
    ends: Vec<Options>,
}

/// Reads options of rendering by name.
fn render(value: &Value, at: &str) -> Result<Render, Error> {
    let Value::Object(map) = value else {
        return fault(at, format!("{} must be a mapping of options to values", shown(value)));
    };
    let (mut options, mut drawn) = (Options::default(), Vec::new());
    for (name, value) in map {
        match name.as_str() {
            "outputs" => return fault(&format!("{at}.outputs"), "use the key outputs"),
            "exposure" => return fault(&format!("{at}.exposure"), "use the key randomise.exposure"),
            "count" => return fault(&format!("{at}.count"), "data sets have no counters"),
            _ => {}
        }
        let text = match value {
            Value::Object(_) => {
                let found = drawn_option(name, value, at)?;
                let first = found.ends().remove(0);
                drawn.push((name.clone(), found));
                first
            }
            _ => option_text(name, value, at)?,
        };
        options = options.set(name, &text).or_else(|error| fault(at, error.to_string()))?;
    }
    let each_end = drawn.iter().flat_map(|(name, drawn)| drawn.ends().into_iter().map(move |text| (name, text)));
    options.check().or_else(|error| fault(at, error.to_string()))?;
    let mut ends = Vec::new();
    for (name, text) in each_end {
        ends.push(options.clone().set(name, &text).or_else(|error| fault(at, error.to_string()))?);
    }
    ends.iter().try_for_each(Options::check).or_else(|error| fault(at, error.to_string()))?;
    Ok(Render { given: map.clone(), options, drawn, ends })
}

/// Reads a distribution of an option's values. The numbers of `uniform` and the like are whole if all are given so.
fn drawn_option(name: &str, value: &Value, at: &str) -> Result<DrawnOption, Error> {
    let path = format!("{at}.{name}");
    if let Some(choices) = value.get("choice").filter(|_| value.as_object().is_some_and(|map| map.len() == 1)) {
        let texts = list(|value: &Value, _: &str| option_text(name, value, at))(choices, &format!("{path}.choice"))?;
        return match texts.is_empty() {
            true => fault(&format!("{path}.choice"), "there is nothing to choose from"),
            false => Ok(DrawnOption::Choice(texts)),
        };
    }
    let numbers = value.as_object().and_then(|map| map.values().next()?.as_array());
    match numbers.is_some_and(|numbers| numbers.iter().all(Value::is_u64)) {
        true => drawn(whole(0, u32::MAX))(value, &path).map(DrawnOption::Whole),
        false => drawn(finite)(value, &path).map(DrawnOption::Number),
    }
}

/// Returns an option's value as [`Options::set`] reads it: `null` is `off`, and a list of two is joined by a colon.
fn option_text(name: &str, value: &Value, at: &str) -> Result<String, Error> {
    let one = |value: &Value| match value {
        Value::Null => Some("off".to_owned()),
        Value::String(text) => Some(text.clone()),
        Value::Bool(_) | Value::Number(_) => Some(value.to_string()),
        Value::Array(_) | Value::Object(_) => None,
    };
    let joined = || match value.as_array()?.as_slice() {
        // Adaptive antialiasing has its levels before its tolerance, as in Python.
        [levels, tolerance] if name == "adaptive" => Some(format!("{}:{}", one(tolerance)?, one(levels)?)),
        [first, second] => Some(format!("{}:{}", one(first)?, one(second)?)),
        _ => None,
    };
    match one(value).or_else(joined) {
        Some(text) => Ok(text),
        None => fault(at, format!("{name}: {} can't be its value", shown(value))),
    }
}

/// Reads the motion to an item's next pair.
fn motion(value: &Value, at: &str) -> Result<Motion, Error> {
    let fields = Fields::of(value, at)?;
    let found = Motion {
        animation: fields.get("animation", text)?,
        time: fields.get("time", drawn(finite))?,
        step: fields.get("step", drawn(above_zero(f64::INFINITY)))?.unwrap_or(Drawn::Value(STEP)),
        camera: fields.get("camera", camera_motion)?.unwrap_or_default(),
        objects: fields.get("objects", object_motion)?,
        shutter: fields.get("shutter", shutter)?,
        rolling: fields.get("rolling", rolling)?,
    };
    fields.end()?;
    Ok(found)
}

fn shutter(value: &Value, at: &str) -> Result<Shutter, Error> {
    let fields = Fields::of(value, at)?;
    let open = fields.get("open", drawn(within(0.0, 1.0)))?;
    let times = fields.get("times", whole(2, MotionBlur::MOST_TIMES))?;
    fields.end()?;
    Ok(Shutter { open: open.unwrap_or(Drawn::Value(OPEN)), times: times.unwrap_or(MotionBlur::TIMES) })
}

fn rolling(value: &Value, at: &str) -> Result<RollingShutter, Error> {
    let fields = Fields::of(value, at)?;
    let readout = fields.get("readout", drawn(within(0.0, 1.0)))?;
    let bands = fields.get("bands", whole(2, MOST_BANDS))?;
    fields.end()?;
    let readout = fields.needed("readout", readout)?;
    Ok(RollingShutter { readout, bands: bands.unwrap_or(BANDS) })
}

fn sensor(value: &Value, at: &str) -> Result<SensorEntry, Error> {
    let fields = Fields::of(value, at)?;
    let full_well = fields.get("full_well", drawn(within(1.0, MOST_ELECTRONS)))?;
    let read_noise = fields.get("read_noise", drawn(within(0.0, MOST_ELECTRONS)))?;
    fields.end()?;
    let full_well = fields.needed("full_well", full_well)?;
    Ok(SensorEntry { full_well, read_noise: read_noise.unwrap_or(Drawn::Value(0.0)) })
}

fn layers(value: &Value, at: &str) -> Result<LayersEntry, Error> {
    let fields = Fields::of(value, at)?;
    let found = LayersEntry {
        surfaces: fields.get("surfaces", whole(1, Layering::MOST_SURFACES))?.unwrap_or(LAYERS.surfaces),
        refracted: fields.get("refracted", flag)?.unwrap_or(LAYERS.refracted),
        mirrored: fields.get("mirrored", flag)?.unwrap_or(LAYERS.mirrored),
    };
    fields.end()?;
    Ok(found)
}

fn camera_motion(value: &Value, at: &str) -> Result<CameraMotion, Error> {
    let fields = Fields::of(value, at)?;
    let found = CameraMotion {
        right: fields.get("right", drawn(finite))?,
        up: fields.get("up", drawn(finite))?,
        forward: fields.get("forward", drawn(finite))?,
        turn: fields.get("turn", drawn(finite))?,
        rise: fields.get("rise", drawn(finite))?,
        roll: fields.get("roll", drawn(finite))?,
    };
    fields.end()?;
    Ok(found)
}

fn object_motion(value: &Value, at: &str) -> Result<ObjectMotion, Error> {
    let fields = Fields::of(value, at)?;
    let found = ObjectMotion {
        share: fields.get("share", within(0.0, 1.0))?.unwrap_or(1.0),
        distance: fields.get("distance", drawn(from_zero()))?.unwrap_or(Drawn::Value(0.0)),
        turn: fields.get("turn", drawn(finite))?.unwrap_or(Drawn::Value(0.0)),
    };
    fields.end()?;
    Ok(found)
}

/// Names of outputs as given, and the arrays that they stand for.
type Outputs = (Vec<String>, Vec<Array>);

fn outputs(value: &Value, at: &str) -> Result<Outputs, Error> {
    let names = list(text)(value, at)?;
    if names.is_empty() {
        return fault(at, "it must not be empty");
    }
    for (index, name) in names.iter().enumerate() {
        let at = format!("{at}[{index}]");
        match array_name(name) {
            None => {
                let channels = Channel::ALL.iter().map(|channel| channel.name());
                let known = Vec::from_iter(channels.chain(Output::not_channels().map(Output::name)));
                let prefixes = "for one eye with the prefix left. or right., of the next pair with next.";
                let name = shown(&Value::from(name.as_str()));
                return fault(&at, format!("unknown {name}; use one of {}, {prefixes}", known.join(", ")));
            }
            Some(ArrayName { eye: Some(Eye::Left), output: Output::Channel(channel), .. })
                if channel.maker() == Maker::OtherView =>
            {
                return fault(&at, format!("{channel} exists only for the right view"));
            }
            Some(_) => {}
        }
    }
    Ok(arrays(names))
}

/// The arrays that an output names. A name without an eye means both eyes.
struct ArrayName {
    next: bool,
    eye: Option<Eye>,
    output: Output,
}

fn array_name(name: &str) -> Option<ArrayName> {
    let (next, name) = name.strip_prefix("next.").map_or((false, name), |name| (true, name));
    let (eye, output) = match name.split_once('.') {
        Some((eye, output)) => (Some(Eye::ALL.into_iter().find(|known| known.name() == eye)?), output),
        None => (None, name),
    };
    Some(ArrayName { next, eye, output: Output::named(output)? })
}

/// Returns the arrays of output names, each once.
fn arrays(names: impl Into<Vec<String>>) -> Outputs {
    let names = names.into();
    let mut found = Vec::new();
    for ArrayName { next, eye, output } in names.iter().filter_map(|name| array_name(name)) {
        let is_of_right = output.channel().is_some_and(|channel| channel.maker() == Maker::OtherView);
        let eyes = match eye {
            Some(eye) => vec![eye],
            None if is_of_right => vec![Eye::Right],
            None => Eye::ALL.to_vec(),
        };
        for array in eyes.into_iter().map(|eye| Array { next, eye, output }) {
            if !found.contains(&array) {
                found.push(array);
            }
        }
    }
    (names, found)
}

/// Refuses a rolling shutter with values that need all rows at one time.
fn check_rolling(spec: &Spec) -> Result<(), Error> {
    if spec.rolling().is_none() {
        return Ok(());
    }
    if spec.rig.around.is_some() {
        return fault("motion.rolling", "it is for planar pictures; leave out rig.projection");
    }
    match spec.arrays.iter().find(|array| array.output.is_layer() || array.output.is_match()) {
        Some(array) => fault("outputs", format!("{} is for one time: leave out motion.rolling", array.output.name())),
        None => Ok(()),
    }
}

/// Refuses valid values that contradict each other.
fn check_together(spec: &Spec) -> Result<(), Error> {
    let method = spec.options.method;
    let is_bracket = matches!(method, Method::Auto | Method::Bracket(_));
    let channels = || spec.arrays.iter().filter_map(|array| array.output.channel());
    let needs_motion = |array: &&Array| array.next || array.output.is_motion();
    match (spec.has_next(), spec.arrays.iter().find(needs_motion)) {
        (false, Some(array)) => {
            let name = format!("{}.{}", array.view(), array.output.name());
            let advice = if spec.motion.is_some() { "leave out motion.rolling" } else { "set motion" };
            return fault("outputs", format!("{name} needs a next pair: {advice}"));
        }
        (true, _) if spec.format.layout().is_some_and(|layout| !layout.holds_motion()) => {
            let reason = format!("the layout {} holds no motion: use another format", spec.format.name());
            return fault("motion", reason);
        }
        _ => {}
    }
    let truths = channels().find(|channel| channel.maker() == Maker::GroundTruth).map(|channel| channel.name());
    let motions = spec.arrays.iter().map(|array| array.output).find(|output| output.channel().is_none());
    if let Some(truth) = truths.or(motions.map(Output::name)).or(spec.motion.as_ref().map(|_| "motion"))
        && !is_bracket
        && method != Method::Naive
    {
        let reason = format!("{method} shows points up to half a pixel off, but {truth} is for pixel centres");
        return fault("render.method", format!("{reason}; use naive, auto or a bracket method"));
    }
    if channels().any(|channel| channel == Channel::ShadowSource) && !is_bracket {
        return fault("outputs", format!("shadow_source needs a bracket method, not {method}"));
    }
    if channels().any(|channel| channel == Channel::Albedo) && spec.options.lighting == Lighting::Direct {
        return fault("outputs", "albedo needs light by paths; set render.lighting");
    }
    check_rolling(spec)?;
    lens::check_together(spec)?;
    check_array(spec)?;
    let layout = spec.format.layout();
    if let Some(layout) = layout.filter(|layout| layout.is_equirectangular() != spec.rig.around.is_some()) {
        let reason = match layout.is_equirectangular() {
            true => format!("the pictures of {layout} are equirectangular: set rig.projection to 360 or 180"),
            false => format!("the pictures of {layout} are planar: use panorama, webdataset or parquet"),
        };
        return fault("format", reason);
    }
    let shape_fault = |size: &[u32; 2]| spec.rig.around.and_then(|around| around.projection.shape_fault(*size));
    if let Some(reason) = spec.size.all().iter().find_map(shape_fault) {
        return fault("size", reason);
    }
    let moves = spec.motion.as_ref().is_some_and(|motion| motion.camera.is_given());
    if moves && spec.poses.path().is_some() {
        return fault("motion.camera", "the path of poses.file moves the camera: leave it out");
    }
    if spec.poses.path().is_some()
        && let Some(index) = spec.scenes.iter().position(|scene| scene.camera.is_some())
    {
        return fault(&format!("scenes[{index}].camera"), "poses.file gives the cameras: leave it out");
    }
    // Cameras with one cx for both eyes are parallel, unless a screen distance is given.
    let is_parallel = match &spec.rig.screen_distance {
        None => layout.is_some() || spec.rig.fx.is_some(),
        Some(Drawn::Choice(choices)) => choices.iter().any(|distance| distance.0.is_infinite()),
        Some(Drawn::Value(distance)) => distance.0.is_infinite(),
        Some(_) => false,
    };
    let converges = match &spec.rig.screen_distance {
        None => false,
        Some(Drawn::Choice(choices)) => choices.iter().any(|distance| distance.0.is_finite()),
        Some(Drawn::Value(distance)) => distance.0.is_finite(),
        Some(_) => true,
    };
    if let Some(layout) = layout.filter(|layout| layout.is_parallel())
        && converges
    {
        let reason = format!("the cameras of {layout} are parallel: leave it out, or set it to inf");
        return fault("rig.screen_distance", reason);
    }
    if spec.rig.interaxial_px.is_some() && is_parallel {
        let reason = "it is the parallax at infinity, which is 0 for parallel cameras; give interaxial";
        return fault("rig.interaxial_px", reason);
    }
    let most = if spec.has_next() { SCENE_FLOW_PAIRS / 2 } else { SCENE_FLOW_PAIRS };
    if layout == Some(crate::dataset::Layout::SceneFlow) && spec.pairs > most {
        return fault("pairs", format!("sceneflow numbers its files with four digits: at most {most}"));
    }
    Ok(())
}
