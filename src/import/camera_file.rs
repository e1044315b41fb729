//! Reads cameras and lights from JSON files, and calibrated pairs (`camera_file/calib.rs`).

mod calib;

use std::path::Path;

use glam::{DMat4, DVec3, Vec3};
use serde_json::{Map, Value};

use crate::{
    CameraPath, Error, Lens, Light, Limits, Projection, Scene, StereoCamera, import::input, view::camera::Intrinsics,
};

impl StereoCamera {
    /// Reads the camera `name` from a JSON file. The file is an object of cameras by name. The picture is
    /// `width` x `height` pixels. Each camera has
    ///
    /// - `eye` (the midpoint between the eyes), `target` and `up`: three numbers each,
    /// - `vfov_deg`: degrees,
    /// - `screen_distance`: world units, or `"inf"` for parallel cameras,
    /// - `eye_separation`: world units.
    ///
    /// Alternative fields:
    ///
    /// - `fx`, `fy` (default `fx`), `cy`, and `cx` or `cx0` and `cx1` replace `vfov_deg`. They are [`Intrinsics`] with
    ///   **pixel centres at halves**, for a picture of the entry's `width` x `height`, and are scaled to the requested
    ///   size. With `cx0` and `cx1` there is no `screen_distance`. With `cx` alone and no `screen_distance`, the eyes
    ///   are parallel cameras.
    /// - `pose` replaces `eye`, `target` and `up`. It has four rows of four numbers, camera to world, for the **left**
    ///   eye, with x to the right, y down and z ahead.
    /// - `baseline` replaces `eye_separation`, with the same meaning.
    ///
    /// `projection` may be `"off-axis"`, `"toe-in"`, or an object for an [`Equirectangular`](crate::Equirectangular)
    /// pair, which has no field of view and no screen: `span_deg` is 360 or 180, and `pole_merge_deg` is a list of two
    /// elevations or null. `lens` replaces `vfov_deg`, `screen_distance` and `projection`: a lens with distortion, or
    /// an object of two lenses, `left` and `right` ([`Lens::pair_from_json`]). Skew and distortion outside of a lens
    /// (`skew`, `k1`, `p1` and so on) other than 0 are refused. So are values of the right eye that differ from the
    /// left eye's (`fx1`, `fy1`, `cy1`). Other fields are ignored.
    ///
    /// ```no_run
    /// let camera = stereotrace::StereoCamera::from_json("cameras.json", "sponza", 1280, 720)?;
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// - [`Error::Io`] if the file can't be read or is no regular file.
    /// - [`Error::TooLarge`] if the file exceeds its limit in [`Limits`].
    /// - [`Error::Parse`], naming the line or the camera and its field, if the file is UTF-16 or not JSON. Also
    ///   if the camera is missing or invalid.
    /// - [`Error::Camera`] for a size of zero.
    pub fn from_json(path: impl AsRef<Path>, name: &str, width: u32, height: u32) -> Result<Self, Error> {
        Self::from_json_within(path, name, width, height, &Limits::default())
    }

    /// Does the same as [`StereoCamera::from_json`], with the given limits.
    ///
    /// # Errors
    /// Returns the errors of [`StereoCamera::from_json`].
    pub fn from_json_within(
        path: impl AsRef<Path>,
        name: &str,
        width: u32,
        height: u32,
        limits: &Limits,
    ) -> Result<Self, Error> {
        let path = path.as_ref();
        let entry = entry(path, name, limits)?;
        camera(path, &named(name), &entry, [width, height])
    }
}

impl Lens {
    /// Reads the lenses of the left and the right eye from a JSON file with the content of [`Lens::pair_from_json`].
    ///
    /// # Errors
    /// [`Error::Io`] and [`Error::TooLarge`] as [`StereoCamera::from_json_within`], and [`Error::Parse`] with the file
    /// and the key.
    pub fn pair_from_json_file(path: impl AsRef<Path>, limits: &Limits) -> Result<[Self; 2], Error> {
        let path = path.as_ref();
        let value: Value = read(path, limits, "lens")?;
        Self::pair_from_value(&value).map_err(|reason| Error::parse(path, None, reason))
    }
}

impl CameraPath {
    /// Reads a path from a JSON file: a list of cameras with the fields of [`StereoCamera::from_json`]. Each has the
    /// number of its key frame in `frame`. If no camera has one, each camera is a frame. The pictures are `width` x
    /// `height` pixels.
    ///
    /// # Errors
    /// Returns the errors of [`StereoCamera::from_json`], which name the camera by its index in the list, and the
    /// errors of [`CameraPath::new`].
    pub fn from_json_within(path: impl AsRef<Path>, width: u32, height: u32, limits: &Limits) -> Result<Self, Error> {
        let path = path.as_ref();
        let list: Vec<Value> = read(path, limits, "list of cameras")?;
        let counted = list.iter().filter(|item| item.get("frame").is_some()).count();
        if counted != 0 && counted != list.len() {
            let reason = format!("{counted} of {} cameras have a frame; give a frame to all or to none", list.len());
            return Err(Error::parse(path, None, reason));
        }
        let key = |(index, item): (usize, &Value)| {
            let label = format!("camera {index}");
            let fault = |reason: String| fault(path, &label, reason);
            let fields = item.as_object().ok_or_else(|| fault(format!("{item} is not an object")))?;
            let frame = if counted == 0 { index as f32 } else { number(fields, "frame").map_err(fault)? };
            Ok((frame, camera(path, &label, fields, [width, height])?))
        };
        let keys = list.iter().enumerate().map(key).collect::<Result<_, Error>>()?;
        Self::new(keys).map_err(|error| Error::parse_from(path, None, error.to_string(), error))
    }
}

/// Makes and checks the camera of an entry; `label` names the entry in messages.
fn camera(
    path: &Path,
    label: &str,
    entry: &Map<String, Value>,
    [width, height]: [u32; 2],
) -> Result<StereoCamera, Error> {
    let fault = |reason: String| fault(path, label, reason);
    let camera = camera_of(entry, [width, height]).map_err(fault)?;
    match camera.pose() {
        Ok(_) => Ok(camera),
        // The size does not come from the file. Other messages use the file's name of the field.
        Err(Error::Camera { field, value, reason }) if field != "size" => {
            let named = match field {
                "vertical_fov" => "vfov_deg",
                "interaxial" if entry.contains_key("baseline") => "baseline",
                "interaxial" => "eye_separation",
                "doffs" => "cx1 - cx0",
                other => other,
            };
            let text = format!("{label}: {named} is {value}; {reason}");
            Err(Error::parse_from(path, None, text, Error::Camera { field, value, reason }))
        }
        Err(error) => Err(error),
    }
}

impl Scene {
    /// Reads `ambient` and `lights` from the entry `name` of a JSON file of cameras ([`StereoCamera::from_json`]).
    /// `ambient` is three numbers (linear RGB, at least 0). `lights` is a list of objects with `position` and
    /// `intensity` (three numbers each, intensities at least 0). Spheres also have a `radius` (above 0). Missing fields
    /// leave the scene unchanged. Returns whether the entry has lights.
    ///
    /// # Errors
    /// Returns [`Error::Io`], [`Error::TooLarge`] and [`Error::Parse`] as [`StereoCamera::from_json`] does. The scene
    /// is unchanged then.
    pub fn light_from_json(&mut self, path: impl AsRef<Path>, name: &str) -> Result<bool, Error> {
        self.light_from_json_within(path, name, &Limits::default())
    }

    /// Does the same as [`Scene::light_from_json`], with the given limits.
    ///
    /// # Errors
    /// Returns the errors of [`Scene::light_from_json`].
    pub fn light_from_json_within(
        &mut self,
        path: impl AsRef<Path>,
        name: &str,
        limits: &Limits,
    ) -> Result<bool, Error> {
        let path = path.as_ref();
        let fault = |reason: String| fault(path, &named(name), reason);
        let entry = entry(path, name, limits)?;
        let ambient = entry.contains_key("ambient").then(|| checked_color(&entry, "ambient"));
        let ambient = ambient.transpose().map_err(fault)?.or(self.ambient);
        let Some(lights) = entry.get("lights") else {
            self.ambient = ambient;
            return Ok(false);
        };
        let list = lights.as_array().ok_or_else(|| fault(format!("lights is {lights}; it must be a list")))?;
        let light = |(index, light): (usize, &Value)| {
            let fields = light.as_object().ok_or_else(|| format!("it is {light}; it must be an object"));
            let read = fields.and_then(|fields| {
                let (position, intensity) = (vector(fields, "position")?, checked_color(fields, "intensity")?);
                match fields.contains_key("radius") {
                    false => Ok(Light::point(position, intensity)),
                    true => match number(fields, "radius")? {
                        radius if radius > 0.0 && radius.is_finite() => Ok(Light::sphere(position, radius, intensity)),
                        radius => Err(format!("radius is {radius}; it must be finite and above 0")),
                    },
                }
            });
            read.map_err(|reason| fault(format!("light {index}: {reason}")))
        };
        self.lights = list.iter().enumerate().map(light).collect::<Result<_, _>>()?;
        self.ambient = ambient;
        Ok(true)
    }
}

/// Returns the name of an entry for messages.
fn named(name: &str) -> String {
    format!("camera '{name}'")
}

/// Returns an error about an entry.
fn fault(path: &Path, label: &str, reason: String) -> Error {
    Error::parse(path, None, format!("{label}: {reason}"))
}

/// Makes the camera of an entry, for a picture of this size.
fn camera_of(entry: &Map<String, Value>, [width, height]: [u32; 2]) -> Result<StereoCamera, String> {
    let has = |name: &str| entry.contains_key(name);
    let zero = calib::DISTORTION.into_iter().chain(["skew"]).filter(|name| has(name));
    for name in zero {
        let is_zero = match &entry[name] {
            Value::Array(list) => list.iter().all(|item| item.as_f64() == Some(0.0)),
            value => value.as_f64() == Some(0.0),
        };
        if !is_zero {
            return Err(format!(
                "{name} is {}; these fields are not read: give a lens, or rectify the pair",
                entry[name]
            ));
        }
    }
    let separation = if has("baseline") { "baseline" } else { "eye_separation" };
    alone(entry, separation, &["eye_separation"])?;
    let interaxial = number(entry, separation)?;
    let camera = if has("pose") {
        alone(entry, "pose", &["eye", "target", "up"])?;
        from_matrix(entry, interaxial)?
    } else {
        StereoCamera::look_at(vector(entry, "eye")?, vector(entry, "target")?).up(vector(entry, "up")?.as_vec3())
    };
    let camera = camera.size(width, height).interaxial(interaxial);
    if has("convergence") {
        return Err("convergence is not read; the field is projection".into());
    }
    if let Some(lens) = entry.get("lens") {
        alone(entry, "lens", &["vfov_deg", "fx", "screen_distance", "projection"])?;
        let scales = scales(entry, [width, height])?;
        let [left, right] = Lens::pair_from_value(lens)?.map(|lens| lens.scaled(scales, 0.0));
        return Ok(camera.lenses(left, right));
    }
    let camera = match entry.get("projection") {
        None => camera,
        Some(projection) => camera.projection(Projection::from_value(projection)?),
    };
    if let Projection::Equirectangular(_) = camera.projection {
        return Ok(camera);
    }
    if !has("fx") {
        return Ok(camera.vertical_fov_degrees(number(entry, "vfov_deg")?).screen_distance(screen_distance(entry)?));
    }
    alone(entry, "fx", &["vfov_deg"])?;
    let camera = camera.intrinsics(intrinsics(entry, [width, height])?);
    if !has("screen_distance") {
        return Ok(camera);
    }
    alone(entry, "cx0", &["screen_distance"])?;
    Ok(camera.screen_distance(screen_distance(entry)?))
}

/// Checks that a field and the fields that it replaces are not both given.
fn alone(entry: &Map<String, Value>, name: &str, others: &[&str]) -> Result<(), String> {
    let found = others.iter().find(|other| **other != name && entry.contains_key(name) && entry.contains_key(**other));
    found.map_or(Ok(()), |other| Err(format!("{name} and {other} are both given; give one of them")))
}

/// Reads the screen distance: a number, or the name `inf` or `infinity`.
fn screen_distance(entry: &Map<String, Value>) -> Result<f32, String> {
    match field(entry, "screen_distance")?.as_str() {
        Some("inf" | "infinity") => Ok(f32::INFINITY),
        Some(text) => Err(format!("screen_distance is \"{text}\"; it must be a number or \"inf\"")),
        None => number(entry, "screen_distance"),
    }
}

/// Reads intrinsics and scales them from the entry's picture size to `size`.
fn intrinsics(entry: &Map<String, Value>, size: [u32; 2]) -> Result<Intrinsics, String> {
    let has = |name: &str| entry.contains_key(name);
    let fx = double(entry, "fx")?;
    let fy = if has("fy") { double(entry, "fy")? } else { fx };
    let cy = double(entry, if has("cy0") { "cy0" } else { "cy" })?;
    for (name, shared) in [("fx1", fx), ("fy1", fy), ("cy1", cy)] {
        if has(name) && double(entry, name)? != shared {
            return Err(format!(
                "{name} is {}, but {shared} for the other eye; both eyes must have the same",
                entry[name]
            ));
        }
    }
    let found = if has("cx0") || has("cx1") {
        alone(entry, "cx", &["cx0", "cx1"])?;
        Intrinsics::new([fx, fy], [double(entry, "cx0")?, cy]).right_cx(double(entry, "cx1")?)
    } else {
        Intrinsics::new([fx, fy], [double(entry, "cx")?, cy])
    };
    Ok(found.scaled(scales(entry, size)?))
}

/// Returns the factors from the entry's picture size to `size`.
fn scales(entry: &Map<String, Value>, size: [u32; 2]) -> Result<[f64; 2], String> {
    if !entry.contains_key("width") && !entry.contains_key("height") {
        return Ok([1.0; 2]);
    }
    let of = [double(entry, "width")?, double(entry, "height")?];
    if let Some(side) = of.into_iter().find(|side| *side < 1.0 || side.fract() != 0.0) {
        return Err(format!("width or height is {side}; they must be whole numbers above 0"));
    }
    Ok([0, 1].map(|axis| f64::from(size[axis]) / of[axis]))
}

/// Makes a camera from the left eye's matrix. The target is one unit ahead.
fn from_matrix(entry: &Map<String, Value>, interaxial: f32) -> Result<StereoCamera, String> {
    let value = field(entry, "pose")?;
    let row = |row: &Value| -> Option<[f64; 4]> {
        let numbers: Option<Vec<f64>> = row.as_array()?.iter().map(Value::as_f64).collect();
        numbers?.try_into().ok()
    };
    let rows: Option<Vec<[f64; 4]>> = value.as_array().and_then(|rows| rows.iter().map(row).collect());
    let rows = rows.and_then(|rows| <[[f64; 4]; 4]>::try_from(rows).ok());
    let rows = rows.ok_or_else(|| format!("pose is {value}; it must be four rows of four numbers"))?;
    let matrix = DMat4::from_cols_array_2d(&rows).transpose();
    let [right, down, ahead, at] =
        [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis].map(|axis| axis.truncate());
    let off = [right.dot(down), down.dot(ahead), ahead.dot(right), right.cross(down).dot(ahead) - 1.0];
    let off = off.into_iter().chain([right, down, ahead].map(|axis| axis.length() - 1.0)).map(f64::abs);
    if rows[3] != [0.0, 0.0, 0.0, 1.0] || !off.fold(0.0, f64::max).le(&1e-4) {
        return Err(
            "pose is not a rotation and translation: its columns must be orthonormal and right-handed, its last row 0 \
             0 0 1"
                .into(),
        );
    }
    let eye: DVec3 = at + right * (0.5 * f64::from(interaxial));
    Ok(StereoCamera::look_at(eye, eye + ahead).up((-down).as_vec3()))
}

/// Returns the fields of an entry.
fn entry(path: &Path, name: &str, limits: &Limits) -> Result<Map<String, Value>, Error> {
    let mut cameras: Map<String, Value> = read(path, limits, "object of cameras")?;
    match cameras.remove(name) {
        Some(Value::Object(entry)) => Ok(entry),
        Some(entry) => Err(fault(path, &named(name), format!("{entry} is not an object"))),
        None => {
            let names: Vec<&str> = cameras.keys().map(String::as_str).collect();
            Err(fault(path, &named(name), format!("not in this file, which has: {}", names.join(", "))))
        }
    }
}

/// Reads a JSON file; `what` describes its content in messages.
fn read<T: serde::de::DeserializeOwned>(path: &Path, limits: &Limits, what: &str) -> Result<T, Error> {
    let bytes = input::read(path, limits.json_bytes, limits.option_names[0])?;
    let text = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(&bytes);
    serde_json::from_slice(text).map_err(|error| {
        let line = Some(error.line()).filter(|&line| line > 0);
        Error::parse_from(path, line, format!("not a JSON {what}: {error}"), error)
    })
}

/// Reads a vector of finite numbers of at least 0.
fn checked_color(entry: &Map<String, Value>, name: &str) -> Result<Vec3, String> {
    let found = vector(entry, name)?.as_vec3();
    if !found.is_finite() {
        return Err(format!("{name} is {found}; its numbers must fit f32"));
    }
    if found.min_element() >= 0.0 { Ok(found) } else { Err(format!("{name} is {found}; it must not be negative")) }
}

fn field<'a>(entry: &'a Map<String, Value>, name: &str) -> Result<&'a Value, String> {
    entry.get(name).ok_or_else(|| format!("{name} is missing"))
}

fn number(entry: &Map<String, Value>, name: &str) -> Result<f32, String> {
    let value = field(entry, name)?;
    value.as_f64().map(|number| number as f32).ok_or_else(|| format!("{name} is {value}; it must be a number"))
}

fn double(entry: &Map<String, Value>, name: &str) -> Result<f64, String> {
    let value = field(entry, name)?;
    value.as_f64().ok_or_else(|| format!("{name} is {value}; it must be a number"))
}

fn vector(entry: &Map<String, Value>, name: &str) -> Result<DVec3, String> {
    let value = field(entry, name)?;
    let numbers: Option<Vec<f64>> = value.as_array().and_then(|list| list.iter().map(Value::as_f64).collect());
    let numbers = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    numbers.map(DVec3::from_array).ok_or_else(|| format!("{name} is {value}; it must be three numbers"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::Folder;

    const HALL: &str = r#"{ "eye": [-13.5, 2.2, -0.3], "target": [10, 3.2, 0.2], "up": [0, 1, 0], "vfov_deg": 60,
        "screen_distance": 6, "eye_separation": 0.065, "note": "ignored" }"#;

    /// Writes `text` to a new file and reads the camera `name` from it.
    fn read(test: &str, text: impl AsRef<[u8]>, name: &str) -> Result<StereoCamera, Error> {
        let folder = Folder::new("camera");
        StereoCamera::from_json(folder.write(&format!("{test}.json"), text), name, 640, 480)
    }

    fn message(test: &str, text: impl AsRef<[u8]>, name: &str) -> String {
        let error = read(test, text, name).unwrap_err();
        assert!(matches!(error, Error::Parse { .. }), "{error:?}");
        let message = error.to_string();
        assert!(message.contains(&format!("{test}.json")), "{message}");
        message
    }

    #[test]
    fn every_field_of_the_file_reaches_the_camera() {
        let expected = StereoCamera::look_at(DVec3::new(-13.5, 2.2, -0.3), DVec3::new(10.0, 3.2, 0.2))
            .up(Vec3::Y)
            .vertical_fov_degrees(60.0)
            .screen_distance(6.0)
            .interaxial(0.065)
            .size(640, 480);
        let text = format!(r#"{{ "other": {{}}, "hall": {HALL} }}"#);
        assert_eq!(read("fields", &text, "hall").unwrap(), expected);
        assert_eq!(read("mark", format!("\u{feff}{text}"), "hall").unwrap(), expected);
        let tilted = text.replace(r#""up": [0, 1, 0]"#, r#""up": [0, 1, 1]"#);
        assert_eq!(read("tilted", tilted, "hall").unwrap(), expected.up(Vec3::new(0.0, 1.0, 1.0)));
    }

    const CALIBRATED: &str = r#"{ "eye": [1, 2, 3], "target": [1, 2, -4], "up": [0, 1, 0], "fx": 500, "fy": 480.5,
        "cx": 330.25, "cy": 239, "baseline": 0.125, "k1": 0, "p1": 0.0, "skew": 0 }"#;

    #[test]
    fn intrinsics_and_matrices_are_the_cameras_they_stand_for() {
        let entry = |from: &str, to: &str| {
            let text = CALIBRATED.replace(from, to);
            assert!(from == to || text != CALIBRATED, "{from}");
            read("calibrated", format!(r#"{{ "it": {text} }}"#), "it").unwrap()
        };
        let placed = StereoCamera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.0, 2.0, -4.0)).size(640, 480);
        let (placed, lenses) = (placed.interaxial(0.125), Intrinsics::new([500.0, 480.5], [330.25, 239.0]));
        assert_eq!(entry("", ""), placed.intrinsics(lenses));
        let two = entry(r#""cx": 330.25"#, r#""cx0": 330.25, "cx1": 341"#);
        assert_eq!(two, placed.intrinsics(lenses.right_cx(341.0)));
        let at = entry(r#""skew""#, r#""screen_distance": 4, "skew""#);
        assert_eq!(at, placed.intrinsics(lenses).screen_distance(4.0));
        assert_eq!(at.pose().unwrap().screen_distance, 4.0);
        let at = entry(r#""skew""#, r#""screen_distance": "inf", "skew""#);
        assert_eq!(at.pose().unwrap(), entry("", "").pose().unwrap());
        let twice = entry(r#""skew""#, r#""width": 1280, "height": 960, "skew""#);
        assert_eq!(twice, placed.intrinsics(lenses.scaled([0.5; 2])));
        assert_eq!(entry(r#""fy": 480.5,"#, ""), placed.intrinsics(Intrinsics::new([500.0; 2], [330.25, 239.0])));
        let toed_in = entry(r#""skew""#, r#""screen_distance": 3, "projection": "toe-in", "skew""#);
        assert_eq!(toed_in.pose().unwrap().projection, Projection::ToeIn);
        // The matrix has x to the right, y down and z ahead, for an eye that looks along -z. The left eye is half the
        // baseline to the left.
        let matrix = r#""pose": [[1, 0, 0, 0.9375], [0, -1, 0, 2], [0, 0, -1, 3], [0, 0, 0, 1]]"#;
        let posed = entry(r#""eye": [1, 2, 3], "target": [1, 2, -4], "up": [0, 1, 0]"#, matrix).pose().unwrap();
        let expected = entry("", "").pose().unwrap();
        assert_eq!(
            (posed.eye, posed.forward, posed.right, posed.up),
            (expected.eye, expected.forward, expected.right, expected.up)
        );
        assert_eq!(posed.intrinsics(), expected.intrinsics());
        let parallel = HALL.replace(r#""screen_distance": 6"#, r#""screen_distance": "inf""#);
        let parallel = read("parallel", format!(r#"{{ "hall": {parallel} }}"#), "hall").unwrap().pose().unwrap();
        assert_eq!((parallel.screen_distance, parallel.interaxial), (f32::INFINITY, 0.065));
    }

    #[test]
    fn a_bad_calibration_is_named_by_its_field() {
        let turned = r#""pose": [[1, 0, 0, 0], [0, 1, 0.1, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"#;
        let left_handed = r#""pose": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]"#;
        let placed = r#""eye": [1, 2, 3], "target": [1, 2, -4], "up": [0, 1, 0]"#;
        for (index, (from, to, expected)) in [
            (r#""k1": 0"#, r#""k1": 0.1"#, "k1 is 0.1; these fields are not read: give a lens"),
            (r#""p1": 0.0"#, r#""distortion": [0, 0, 1]"#, "distortion is [0,0,1]; these fields are not read"),
            (r#""skew": 0"#, r#""skew": "a""#, "skew is \"a\"; these fields are not read"),
            (r#""skew": 0"#, r#""fx1": 501"#, "fx1 is 501, but 500 for the other eye; both eyes must have the same"),
            (r#""skew": 0"#, r#""cy1": 0"#, "cy1 is 0, but 239 for the other eye"),
            (r#""skew": 0"#, r#""cx1": 400"#, "cx and cx1 are both given; give one of them"),
            (r#""skew": 0"#, r#""vfov_deg": 40"#, "fx and vfov_deg are both given"),
            (r#""skew": 0"#, r#""eye_separation": 1"#, "baseline and eye_separation are both given"),
            (r#""skew": 0"#, r#""width": 1280"#, "height is missing"),
            (r#""skew": 0"#, r#""width": 0.5, "height": 1"#, "width or height is 0.5"),
            (r#""skew": 0"#, r#""projection": "parallel""#, "projection is \"parallel\"; it must be off-axis"),
            (r#""skew": 0"#, r#""convergence": "toe-in""#, "convergence is not read; the field is projection"),
            (r#""skew": 0"#, r#""screen_distance": "far""#, "screen_distance is \"far\"; it must be a number"),
            (
                r#""cx": 330.25"#,
                r#""cx0": 330, "cx1": 331, "screen_distance": 1"#,
                "cx0 and screen_distance are both given",
            ),
            (r#""cx": 330.25"#, r#""cx0": 330, "cx1": 329"#, "cx1 - cx0 is -1; cx1 must be at least cx0"),
            (r#""cx": 330.25, "#, "", "cx is missing"),
            (r#""cx": 330.25"#, r#""cx": null"#, "cx is null; it must be a number"),
            (r#""fx": 500"#, r#""fx": 0"#, "fx is 0; a focal length must be"),
            (r#""fy": 480.5"#, r#""fy": -1"#, "fy is -1; a focal length must be"),
            (r#""fx": 500"#, r#""fx": 1e9"#, "intrinsics is fx 1000000000, fy 480.5"),
            (r#""cx": 330.25"#, r#""cx": 1e9"#, "intrinsics is fx 500, fy 480.5, cx 1000000000"),
            (r#""baseline": 0.125"#, r#""baseline": -1"#, "baseline is -1; it must be a number of at least 0"),
            (r#""eye": [1, 2, 3]"#, turned, "pose and target are both given"),
            (placed, turned, "pose is not a rotation and translation"),
            (placed, left_handed, "pose is not a rotation and translation"),
            (placed, r#""pose": [1, 2, 3]"#, "pose is [1,2,3]; it must be four rows of four numbers"),
        ]
        .into_iter()
        .enumerate()
        {
            let text = CALIBRATED.replace(from, to);
            assert_ne!(text, CALIBRATED);
            let message = message(&format!("calibration{index}"), format!(r#"{{ "it": {text} }}"#), "it");
            assert!(message.contains(&format!("camera 'it': {expected}")), "{message} should say {expected}");
        }
    }

    #[test]
    fn lights_and_ambient_are_read_and_faults_named() {
        let light = |test: &str, extra: &str| {
            let folder = Folder::new("camera");
            let text = format!(r#"{{ "hall": {} }}"#, HALL.replace(r#""note": "ignored""#, extra));
            let mut scene = Scene::new();
            let read = scene.light_from_json(folder.write(&format!("{test}.json"), text), "hall");
            let read = read.map_err(|error| error.to_string());
            (read, scene)
        };
        let lamp = r#""lights": [{ "position": [1, 2, 3], "intensity": [0.5, 0.25, 0] }]"#;
        let (read, scene) = light("lights", &format!(r#""ambient": [0.1, 0.2, 0.3], {lamp}"#));
        assert!(read.unwrap());
        let expected = Light::point(Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.5, 0.25, 0.0));
        assert_eq!((scene.ambient, scene.lights), (Some(Vec3::new(0.1, 0.2, 0.3)), vec![expected]));
        let (read, scene) = light("no_ambient", lamp);
        assert!(read.unwrap());
        assert_eq!((scene.ambient, scene.lights), (None, vec![expected]));
        let (read, scene) = light("no_lights", r#""ambient": [1, 1, 1]"#);
        assert!(!read.unwrap() && scene.lights.is_empty());
        assert_eq!(scene.ambient, Some(Vec3::ONE));
        let (_, scene) =
            light("ball", r#""lights": [{ "position": [1, 2, 3], "intensity": [1, 1, 1], "radius": 0.5 }]"#);
        assert_eq!(scene.lights, [Light::sphere(Vec3::new(1.0, 2.0, 3.0), 0.5, Vec3::ONE)]);
        for (index, (extra, expected)) in [
            (
                r#""lights": [{ "position": [1, 2, 3], "intensity": [1, 1, 1], "radius": -1 }]"#.into(),
                "light 0: radius is -1; it must be finite and above 0",
            ),
            (r#""lights": 3"#.into(), "lights is 3; it must be a list"),
            (r#""ambient": [0, 0, 0], "lights": [4]"#.into(), "light 0: it is 4; it must be an object"),
            (r#""ambient": [0, 0, 0], "lights": [{}]"#.into(), "light 0: position is missing"),
            (format!(r#""ambient": [1e99, 0, 0], {lamp}"#), "ambient is [inf, 0, 0]; its numbers must fit"),
            (format!(r#""ambient": [0, -1, 0], {lamp}"#), "ambient is [0, -1, 0]; it must not be negative"),
            (
                r#""ambient": [0, 0, 0], "lights": [{ "position": [-1, 0, 0], "intensity": [0, 0, -0.1] }]"#.into(),
                "light 0: intensity is [0, 0, -0.1]; it must not be negative",
            ),
        ]
        .into_iter()
        .enumerate()
        {
            let message = light(&format!("lamp{index}"), &extra).0.unwrap_err();
            assert!(message.contains(&format!("camera 'hall': {expected}")), "{message}");
        }
    }

    #[test]
    fn an_unknown_name_is_answered_with_the_names_there_are() {
        let message = message("unknown", format!(r#"{{ "hall": {HALL}, "garden": {HALL} }}"#), "cellar");
        for part in ["camera 'cellar'", "garden, hall"] {
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn a_bad_field_is_named_with_its_value() {
        let broken = [
            (r#""vfov_deg": 60"#, r#""fov": 60"#, "vfov_deg is missing"),
            (r#""vfov_deg": 60"#, r#""vfov_deg": "60""#, r#"vfov_deg is "60"; it must be a number"#),
            (r#""vfov_deg": 60"#, r#""vfov_deg": 180"#, "vfov_deg is 180; it must lie between"),
            ("[10, 3.2, 0.2]", "[10, 3.2]", "target is [10,3.2]; it must be three numbers"),
            ("[10, 3.2, 0.2]", "[10, 3.2, null]", "target is [10,3.2,null]; it must be three numbers"),
            ("[-13.5, 2.2, -0.3]", "[1e300, 2.2, -0.3]", "eye is [1e300, 2.2, -0.3]; its coordinates"),
            ("[0, 1, 0]", "[0, 0, 0]", "up is [0, 0, 0]; it must not be zero"),
            (
                r#""screen_distance": 6"#,
                r#""screen_distance": 0"#,
                "screen_distance is 0.0; it must lie between 1e-6 and 1e9",
            ),
            ("0.065", "-1", "eye_separation is -1; it must be"),
        ];
        for (index, (from, to, expected)) in broken.into_iter().enumerate() {
            let entry = HALL.replace(from, to);
            assert_ne!(entry, HALL);
            let message = message(&format!("field{index}"), format!(r#"{{ "hall": {entry} }}"#), "hall");
            assert!(message.contains(&format!("camera 'hall': {expected}")), "{message}");
        }
    }

    #[test]
    fn broken_json_is_an_error_on_its_line() {
        let broken: [(&[u8], usize); 4] =
            [(b"{\n\"hall\": {\n\"eye\": [1,,2]", 3), (b"", 1), (b"[]", 1), (b"{\n\"\xff\": 1}", 2)];
        for (index, (text, line)) in broken.into_iter().enumerate() {
            let message = message(&format!("syntax{index}"), text, "hall");
            assert!(message.contains(&format!("syntax{index}.json:{line}: not a JSON object of cameras")), "{message}");
        }
        let message = message("shape", r#"{ "hall": 3 }"#, "hall");
        assert!(message.contains("camera 'hall': 3 is not an object"), "{message}");
    }

    #[test]
    fn a_missing_file_and_a_size_of_zero_are_no_fault_of_the_content() {
        assert!(matches!(StereoCamera::from_json("no/such/file.json", "hall", 1, 1), Err(Error::Io { .. })));
        let folder = Folder::new("camera");
        let path = folder.write("size.json", format!(r#"{{ "hall": {HALL} }}"#));
        let camera = StereoCamera::from_json(&path, "hall", 0, 480);
        assert!(matches!(camera, Err(Error::Camera { field: "size", .. })), "{camera:?}");
    }
}
