//! Writes and reads a camera's settings as JSON. Unlike [`Pose`](crate::Pose), the settings record, for example,
//! whether the interaxial was given in pixels.

use std::path::Path;

use glam::DVec3;
use serde_json::{Map, Value, json};

use super::input;
use crate::{
    Error, Limits, Projection, StereoCamera,
    view::camera::{Aperture, Interaxial, Lenses, Screen},
};

/// Name of the entry that [`StereoCamera::to_json`] writes and [`StereoCamera::from_json_str`] reads.
const ENTRY: &str = "camera";

impl StereoCamera {
    /// Returns the camera as JSON text. It is the text of [`Pose::to_json`](crate::Pose::to_json) with one more entry,
    /// `camera`, for the values given to the setters. [`StereoCamera::from_json_str`] reads an equal camera from it.
    ///
    /// # Errors
    /// Returns the errors of [`StereoCamera::pose`].
    pub fn to_json(&self) -> Result<String, Error> {
        let mut text: Value = serde_json::from_str(&self.pose()?.to_json()).unwrap_or_default();
        let aperture = match self.aperture {
            Aperture::VerticalFov(degrees) => json!({ "vfov_deg": f64::from(degrees) }),
            Aperture::ScreenWidth(width) => json!({ "screen_width": f64::from(width) }),
            Aperture::Lenses(Lenses { focal: [fx, fy], principal: [cx, cy] }) => {
                json!({ "fx": fx, "fy": fy, "cx": cx, "cy": cy })
            }
        };
        let screen = match self.screen {
            // JSON has no infinity.
            Screen::Distance(f32::INFINITY) => json!({ "distance": "inf" }),
            Screen::Distance(distance) => json!({ "distance": f64::from(distance) }),
            Screen::Offset(offset) => json!({ "doffs": offset }),
        };
        let interaxial = match self.interaxial {
            Interaxial::World(distance) => json!({ "world": f64::from(distance) }),
            Interaxial::Pixels(pixels) => json!({ "pixels": f64::from(pixels) }),
        };
        text[ENTRY] = json!({
            "eye": self.eye.to_array(),
            "target": self.target.to_array(),
            "up": self.up.to_array().map(f64::from),
            "aperture": aperture,
            "screen": screen,
            "interaxial": interaxial,
            "projection": self.projection.to_value(),
            "size": [self.width, self.height],
        });
        Ok(format!("{text:#}\n"))
    }

    /// Reads a camera that [`StereoCamera::to_json`] wrote. It uses the entry `camera` alone and does not compare it
    /// with the other entries.
    ///
    /// # Errors
    /// - [`Error::Parse`], naming the line or the field, if the text is not JSON or has no such camera.
    /// - [`Error::Camera`] for an invalid camera.
    pub fn from_json_str(text: &str) -> Result<Self, Error> {
        parse(Path::new("camera JSON"), text.as_bytes())
    }

    /// Does the same as [`StereoCamera::from_json_str`] for a file.
    ///
    /// # Errors
    /// - The errors of [`StereoCamera::from_json_str`], which name the file.
    /// - [`Error::Io`] if the file can't be read or is no regular file.
    /// - [`Error::TooLarge`] if the file exceeds its limit in [`Limits`].
    pub fn from_json_file(path: impl AsRef<Path>) -> Result<Self, Error> {
        let (path, limits) = (path.as_ref(), Limits::default());
        parse(path, &input::read(path, limits.json_bytes, limits.option_names[0])?)
    }
}

fn parse(name: &Path, text: &[u8]) -> Result<StereoCamera, Error> {
    let text: Value = serde_json::from_slice(text).map_err(|error| {
        let line = Some(error.line()).filter(|&line| line > 0);
        Error::parse_from(name, line, format!("invalid JSON: {error}"), error)
    })?;
    let camera = text.get(ENTRY).and_then(Value::as_object);
    let camera = camera.ok_or_else(|| format!("it has no object '{ENTRY}', which describes a camera"));
    let camera = camera.and_then(read).map_err(|reason| Error::parse(name, None, reason))?;
    camera.pose()?;
    Ok(camera)
}

fn read(entry: &Map<String, Value>) -> Result<StereoCamera, String> {
    let object = |name: &str| {
        let found = field(entry, name)?;
        found.as_object().ok_or_else(|| format!("{name} is {found}; it must be an object"))
    };
    let (aperture, screen, interaxial) = (object("aperture")?, object("screen")?, object("interaxial")?);
    let aperture = match () {
        () if aperture.contains_key("fx") => {
            let [fx, fy, cx, cy] = ["fx", "fy", "cx", "cy"].map(|name| number(aperture, name));
            Aperture::Lenses(Lenses { focal: [fx?, fy?], principal: [cx?, cy?] })
        }
        () if aperture.contains_key("screen_width") => Aperture::ScreenWidth(number(aperture, "screen_width")? as f32),
        () => Aperture::VerticalFov(number(aperture, "vfov_deg")? as f32),
    };
    let screen = match () {
        () if screen.contains_key("doffs") => Screen::Offset(number(screen, "doffs")?),
        () if field(screen, "distance")? == "inf" => Screen::Distance(f32::INFINITY),
        () => Screen::Distance(number(screen, "distance")? as f32),
    };
    let interaxial = match interaxial.contains_key("pixels") {
        true => Interaxial::Pixels(number(interaxial, "pixels")? as f32),
        false => Interaxial::World(number(interaxial, "world")? as f32),
    };
    let projection = Projection::from_value(field(entry, "projection")?)?;
    let [width, height]: [u32; 2] = list(entry, "size", |value| value.as_u64()?.try_into().ok())?;
    let point = |name| list(entry, name, Value::as_f64).map(DVec3::from_array);
    Ok(StereoCamera {
        eye: point("eye")?,
        target: point("target")?,
        up: point("up")?.as_vec3(),
        aperture,
        screen,
        interaxial,
        projection,
        width,
        height,
    })
}

fn field<'a>(entry: &'a Map<String, Value>, name: &str) -> Result<&'a Value, String> {
    entry.get(name).ok_or_else(|| format!("{name} is missing"))
}

fn number(entry: &Map<String, Value>, name: &str) -> Result<f64, String> {
    let value = field(entry, name)?;
    value.as_f64().ok_or_else(|| format!("{name} is {value}; it must be a number"))
}

fn list<T, const N: usize>(
    entry: &Map<String, Value>,
    name: &str,
    item: impl Fn(&Value) -> Option<T>,
) -> Result<[T; N], String> {
    let value = field(entry, name)?;
    let items = value.as_array().and_then(|items| items.iter().map(item).collect::<Option<Vec<T>>>());
    let items = items.and_then(|items| items.try_into().ok());
    items.ok_or_else(|| format!("{name} is {value}; it must be {N} numbers"))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::{Equirectangular, Span, random::Random, view::camera::Intrinsics};

    fn all() -> Vec<StereoCamera> {
        let mut random = Random::new(3);
        let mut cameras = Vec::new();
        for index in 0..200 {
            let camera = StereoCamera::look_at(random.point(30.0), random.point(5.0)).size(320 + index, 240);
            let camera = camera.up(Vec3::new(0.1, 1.0, random.unit())).interaxial(random.between(0.01, 0.5));
            let lens = Intrinsics::new([random.between(200.0, 400.0).into(), 0.1 + 300.0], [161.3, 120.7]);
            cameras.extend([
                camera,
                camera.vertical_fov_degrees(random.between(20.0, 90.0)).screen_distance(f32::INFINITY),
                camera.screen_width(random.between(1.0, 4.0)).interaxial_pixels(random.between(1.0, 9.0)),
                camera.intrinsics(lens),
                camera.intrinsics(lens.right_cx(lens.cx0 + f64::from(random.between(1.0, 9.0)))),
                camera.intrinsics(lens).screen_distance(random.between(2.0, 9.0)),
                camera.projection(Projection::ToeIn),
                camera.projection(Projection::Equirectangular(Equirectangular::new(Span::Full))),
                camera.projection(Projection::Equirectangular(Equirectangular { span: Span::Half, merge: None })),
            ]);
        }
        cameras
    }

    #[test]
    fn a_camera_is_read_back_equal_whatever_it_was_given_by() {
        for camera in all() {
            let text = camera.to_json().unwrap();
            assert_eq!(StereoCamera::from_json_str(&text).unwrap(), camera, "{text}");
        }
    }

    #[test]
    fn a_fault_is_named() {
        let text = all()[0].to_json().unwrap();
        let whole: Value = serde_json::from_str(&text).unwrap();
        let fault = |change: fn(&mut Value), expected: &str| {
            let mut changed = whole.clone();
            change(&mut changed["camera"]);
            let message = StereoCamera::from_json_str(&changed.to_string()).unwrap_err().to_string();
            assert!(message.contains(expected), "{message} should say {expected}");
        };
        fault(|camera| *camera = Value::Null, "it has no object 'camera'");
        fault(|camera| camera["eye"] = json!([1, 2]), "eye is [1,2]; it must be 3 numbers");
        fault(|camera| camera["size"] = json!([1, -2]), "size is [1,-2]; it must be 2 numbers");
        fault(|camera| camera["screen"] = json!(3), "screen is 3; it must be an object");
        fault(|camera| camera["screen"] = json!({}), "distance is missing");
        fault(|camera| camera["interaxial"] = json!({ "world": "x" }), "world is \"x\"; it must be a number");
        fault(
            |camera| camera["interaxial"] = json!({ "world": -1 }),
            "interaxial is -1; it must be a number of at least 0",
        );
        fault(|camera| camera["projection"] = json!("both"), "projection is \"both\"; it must be off-axis, toe-in");
        fault(|camera| camera["projection"] = json!({ "span_deg": 90 }), "span_deg is 90; it must be 360 or 180");
        assert!(
            StereoCamera::from_json_str("{\n\"camera\": ")
                .unwrap_err()
                .to_string()
                .contains("camera JSON:2: invalid JSON")
        );
    }
}
