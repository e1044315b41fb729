//! Writes a checked camera as a JSON file, which other programs can read, and reads it back exactly.

use std::{fmt::Display, path::Path};

use glam::{DMat4, DVec3, Vec3};
use serde_json::{Map, Value, json};

use super::calibration::world_to_camera;
use crate::{
    Error, Lens, Limits, Pose, Projection,
    import::input,
    view::camera::{Field, Frustum, Intrinsics, Sphere},
};

impl Pose {
    /// Returns the camera as JSON text. `left` and `right` have the intrinsics `fx`, `fy`, `cx` and `cy` in pixels (not
    /// for equirectangular pictures; eyes with lenses have an entry `lens`), and the matrices `world_to_camera` and
    /// `camera_to_world`, row by row. `pose` has the fields of this struct, which [`Pose::from_json`] reads back to the
    /// bit. `conventions` describes frames and units.
    pub fn to_json(&self) -> String {
        let vector = |v: Vec3| json!(v.to_array().map(f64::from));
        let field = match self.field {
            Field::Screen(Frustum { distance, size, center, shift }) => {
                ("frustum", json!({ "distance": distance, "size": size, "center": center, "shift": shift }))
            }
            Field::Sphere(Sphere { angles, .. }) => ("angles", json!(angles)),
            Field::Lenses(lenses) => ("lenses", json!(lenses.map(Lens::to_value))),
        };
        let mut text = json!({
            "format": "stereotrace pose 1",
            "conventions": {
                "length": "world units",
                "pixels": "from the picture's top left corner, x right, y down; pixel centres are at halves",
                "camera_frame": "x right, y down, z along the view, origin at the eye",
                "world_frame": "right-handed, y up",
                "matrices": "rows; a point is a column (x, y, z, 1)",
                "disparity": "x_left - x_right = fx * baseline / Z - doffs",
            },
            "width": self.size[0],
            "height": self.size[1],
            "baseline": self.baseline(),
            "left": eye(self, -1.0),
            "right": eye(self, 1.0),
            "pose": {
                "eye": self.eye.to_array(),
                "forward": vector(self.forward),
                "right": vector(self.right),
                "up": vector(self.up),
                "screen_distance": length(self.screen_distance),
                "screen_size": self.screen_size.map(length),
                "interaxial": f64::from(self.interaxial),
                "interaxial_px": f64::from(self.interaxial_px),
                "size": self.size,
                "projection": self.projection.to_value(),
                "subject_distance": f64::from(self.subject_distance),
                field.0: field.1,
            },
        });
        match self.intrinsics() {
            None if matches!(self.field, Field::Lenses(_)) => {
                text["conventions"]["disparity"] = json!("none: lens distortion moves points out of their rows");
            }
            Some(intrinsics) => {
                text["doffs"] = json!(intrinsics.doffs());
                for (name, cx) in [("left", intrinsics.cx0), ("right", intrinsics.cx1)] {
                    let Intrinsics { fx, fy, cy, .. } = intrinsics;
                    text[name]["fx"] = json!(fx);
                    text[name]["fy"] = json!(fy);
                    text[name]["cx"] = json!(cx);
                    text[name]["cy"] = json!(cy);
                }
            }
            None => {
                text["conventions"]["camera_frame"] = json!("x right, y down, z ahead, origin in the circle's centre");
                text["conventions"]["disparity"] =
                    json!("x_left - x_right = width / angle * 2 atan(baseline / (2 s)); s is the horizontal distance");
            }
        }
        format!("{text:#}\n")
    }

    /// Reads the entry `pose` of a file written by [`Pose::to_json`]. The entry is not compared with the file's other
    /// entries.
    ///
    /// # Errors
    /// [`Error::Io`] if the file can't be read or is not a regular file; [`Error::TooLarge`] if it is over 16 MiB;
    /// [`Error::Parse`], naming the line or the field, if it is not JSON or not a pose.
    pub fn from_json(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let limits = Limits::default();
        let bytes = input::read(path, limits.json_bytes, limits.option_names[0])?;
        let file: Value = serde_json::from_slice(&bytes).map_err(|error| {
            let line = Some(error.line()).filter(|&line| line > 0);
            Error::parse_from(path, line, format!("invalid JSON: {error}"), error)
        })?;
        let fault = |reason| Error::parse(path, None, reason);
        let pose =
            file.get("pose").and_then(Value::as_object).ok_or_else(|| fault("it has no object 'pose'".into()))?;
        read(pose).map_err(fault)
    }
}

/// Writes a length. Infinity, the screen distance of parallel cameras, becomes a string, since JSON has no infinity.
fn length(value: f32) -> Value {
    if value == f32::INFINITY { json!("inf") } else { json!(f64::from(value)) }
}

fn eye(pose: &Pose, side: f64) -> Value {
    let to_camera = world_to_camera(pose, side);
    // The axes are orthonormal only up to rounding, so the inverse is computed from the written matrix. glam's columns
    // hold our rows, for input and output.
    let to_world = DMat4::from_cols_array_2d(&to_camera).inverse();
    let mut eye = json!({ "world_to_camera": to_camera, "camera_to_world": to_world.to_cols_array_2d() });
    if let Some(lens) = pose.lens(side as f32) {
        eye["lens"] = lens.to_value();
    }
    eye
}

fn read(pose: &Map<String, Value>) -> Result<Pose, String> {
    let projection = Projection::from_value(field(pose, "projection")?).map_err(|reason| format!("pose: {reason}"))?;
    let read = Pose {
        eye: DVec3::from_array(list(pose, "eye", Value::as_f64, "numbers")?),
        forward: Vec3::from_array(numbers(pose, "forward")?),
        right: Vec3::from_array(numbers(pose, "right")?),
        up: Vec3::from_array(numbers(pose, "up")?),
        screen_distance: positive(pose, "screen_distance", extent)?,
        screen_size: list(pose, "screen_size", extent, "lengths, or \"inf\"")?,
        interaxial: number(pose, "interaxial", finite)?,
        interaxial_px: number(pose, "interaxial_px", finite)?,
        size: size(pose)?,
        projection,
        subject_distance: positive(pose, "subject_distance", finite)?,
        field: match projection {
            Projection::OffAxis | Projection::ToeIn => Field::Screen(frustum(pose)?),
            Projection::Lenses(lenses) => {
                let size = size(pose)?;
                Lens::check_both(&lenses, size).map_err(|error| format!("pose: {error}"))?;
                Field::Lenses(lenses)
            }
            Projection::Equirectangular(projection) => {
                Field::Sphere(Sphere { projection, angles: list(pose, "angles", Value::as_f64, "numbers")? })
            }
        },
        scene_origin: None,
    };
    Ok(read)
}

fn frustum(pose: &Map<String, Value>) -> Result<Frustum, String> {
    let frustum = field(pose, "frustum")?;
    let fields = frustum.as_object().ok_or_else(|| format!("pose: frustum is {frustum}; it must be an object"))?;
    Ok(Frustum {
        distance: positive(fields, "distance", Value::as_f64)?,
        size: list(fields, "size", Value::as_f64, "numbers")?,
        center: list(fields, "center", Value::as_f64, "numbers")?,
        shift: number(fields, "shift", Value::as_f64)?,
    })
}

fn field<'a>(pose: &'a Map<String, Value>, name: &str) -> Result<&'a Value, String> {
    pose.get(name).ok_or_else(|| format!("pose: {name} is missing"))
}

/// Reads a number that fits f32.
fn finite(value: &Value) -> Option<f32> {
    value.as_f64().map(|number| number as f32).filter(|number| number.is_finite())
}

/// Reads a number that fits f32, or infinity as written by [`length`].
fn extent(value: &Value) -> Option<f32> {
    if value.as_str() == Some("inf") { Some(f32::INFINITY) } else { finite(value) }
}

fn number<T>(pose: &Map<String, Value>, name: &str, read: fn(&Value) -> Option<T>) -> Result<T, String> {
    let value = field(pose, name)?;
    read(value).ok_or_else(|| format!("pose: {name} is {value}; it must be a number that fits f32"))
}

fn positive<T: Copy + Display + PartialOrd + Default>(
    pose: &Map<String, Value>,
    name: &str,
    read: fn(&Value) -> Option<T>,
) -> Result<T, String> {
    number(pose, name, read).and_then(|found| match found > T::default() {
        true => Ok(found),
        false => Err(format!("pose: {name} is {found}; it must be above 0")),
    })
}

fn numbers(pose: &Map<String, Value>, name: &str) -> Result<[f32; 3], String> {
    list(pose, name, finite, "numbers that fit f32")
}

fn list<T, const N: usize>(
    pose: &Map<String, Value>,
    name: &str,
    read: fn(&Value) -> Option<T>,
    what: &str,
) -> Result<[T; N], String> {
    let value = field(pose, name)?;
    let found: Option<Vec<T>> = value.as_array().and_then(|list| list.iter().map(read).collect());
    let found = found.and_then(|list| list.try_into().ok());
    found.ok_or_else(|| format!("pose: {name} is {value}; it must be {N} {what}"))
}

fn size(pose: &Map<String, Value>) -> Result<[u32; 2], String> {
    let side = |value: &Value| value.as_u64().and_then(|side| u32::try_from(side).ok()).filter(|side| *side > 0);
    list(pose, "size", side, "sides of a picture in pixels")
}

#[cfg(test)]
mod tests {
    use super::super::Batch;
    use super::*;
    use crate::{StereoCamera, folder::Folder, random::Random};

    #[test]
    fn a_pose_reads_back_to_the_bit() {
        let folder = Folder::new("pose");
        let path = folder.file("camera.json");
        let mut random = Random::new(7);
        for scale in [1e-5, 1.0, 1e7] {
            for round in 0..100 {
                let (eye, target) = (random.point(scale), random.point(scale));
                let camera = StereoCamera::look_at(eye, target).up(random.point(1.0)).size(2 + round, 1 + 3 * round);
                let camera = match round % 3 {
                    0 => camera.screen_width(scale * 0.37).screen_distance(scale / 3.0),
                    1 => camera.screen_distance(f32::INFINITY),
                    _ => camera.projection(Projection::ToeIn),
                };
                let Ok(pose) = camera.pose() else { continue };
                let mut batch = Batch::new();
                batch.add_camera_json(&path, &pose).unwrap();
                batch.commit().unwrap();
                let read = Pose::from_json(&path).unwrap();
                assert_eq!(read, pose);
                // Equality does not distinguish the signs of zeros.
                assert_eq!(read.eye.to_array().map(f64::to_bits), pose.eye.to_array().map(f64::to_bits));
            }
        }
    }

    #[test]
    fn its_matrices_are_each_others_inverse() {
        let pose = StereoCamera::look_at(Vec3::new(3.0, -1.0, 2.0), Vec3::ZERO).pose().unwrap();
        let file: Value = serde_json::from_str(&pose.to_json()).unwrap();
        for side in ["left", "right"] {
            let matrix = |name: &str| {
                let rows: Vec<Vec<f64>> = serde_json::from_value(file[side][name].clone()).unwrap();
                DMat4::from_cols_slice(&rows.concat()).transpose()
            };
            let both = matrix("camera_to_world") * matrix("world_to_camera");
            assert!(both.abs_diff_eq(DMat4::IDENTITY, 1e-12), "{both}");
        }
        assert_eq!(file["width"], 640);
    }

    #[test]
    fn what_is_no_pose_is_refused_by_its_field() {
        let folder = Folder::new("pose_fault");
        let text = StereoCamera::look_at(Vec3::Z, Vec3::ZERO).pose().unwrap().to_json();
        for (index, (from, to, expected)) in [
            ("\"pose\"", "\"rose\"", "it has no object 'pose'"),
            ("\"forward\"", "\"backward\"", "pose: forward is missing"),
            ("\"screen_distance\": 1.0", "\"screen_distance\": -1", "pose: screen_distance is -1; it must be above 0"),
            ("\"screen_distance\": 1.0", "\"screen_distance\": 1e99", "must be a number that fits f32"),
            ("640,\n      480", "640", "size is [640]; it must be 2 sides"),
            ("640,\n      480", "640, 0", "size is [640,0]; it must be 2 sides"),
            ("{", "{,", "json:1: invalid JSON"),
        ]
        .into_iter()
        .enumerate()
        {
            let broken = text.replacen(from, to, 1);
            assert_ne!(broken, text, "{from}\n{text}");
            let path = folder.write(&format!("{index}.json"), broken);
            let message = Pose::from_json(path).unwrap_err().to_string();
            assert!(message.contains(&format!("{index}.json")) && message.contains(expected), "{message}");
        }
        assert!(matches!(Pose::from_json("no/such/file.json"), Err(Error::Io { .. })));
    }
}
