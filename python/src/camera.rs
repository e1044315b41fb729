//! Cameras.

use std::path::PathBuf;

use pyo3::{prelude::*, types::PyDict};
use stereotrace::{Convergence, Pose, StereoCamera, camera::Intrinsics};

use crate::{
    errors::{raised, refused},
    scene::Scene,
    values::{Point, shown, tuple},
};

/// The fields that the constructor and `replace` take beside eye and target.
const FIELDS: &str =
    "eye, target, up, size, fov, screen_width, intrinsics, screen_distance, interaxial, interaxial_px and toe_in";

#[pyclass(frozen, eq, module = "stereotrace")]
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Camera(pub(crate) StereoCamera);

impl<'a, 'py> FromPyObject<'a, 'py> for Camera {
    type Error = PyErr;

    fn extract(value: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        Ok(*value.cast::<Self>()?.get())
    }
}

impl Camera {
    pub(crate) fn pose(&self) -> PyResult<Pose> {
        self.0.pose().map_err(raised)
    }

    /// A camera that has a picture.
    pub(crate) fn checked(camera: StereoCamera) -> PyResult<Self> {
        camera.pose().map_err(raised)?;
        Ok(Self(camera))
    }
}

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (eye, target, **fields))]
    fn new(eye: Point, target: Point, fields: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        with(StereoCamera::look_at(eye.0, target.0), fields)
    }

    #[staticmethod]
    #[pyo3(signature = (scene, size = (640, 480)))]
    fn fitting(scene: &Scene, size: (u32, u32)) -> PyResult<Self> {
        let bounds = scene.inner.bounds().ok_or_else(|| refused("the scene is empty, or has only infinite planes"))?;
        Self::checked(StereoCamera::fitting(bounds, size.0, size.1))
    }

    #[staticmethod]
    #[pyo3(signature = (path, name, size = (640, 480)))]
    fn from_json(path: PathBuf, name: &str, size: (u32, u32)) -> PyResult<Self> {
        StereoCamera::from_json(path, name, size.0, size.1).map(Self).map_err(raised)
    }

    #[pyo3(signature = (**fields))]
    fn replace(&self, fields: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        with(self.0, fields)
    }

    /// Turned about its target by an angle in degrees.
    fn orbited(&self, degrees: f32) -> PyResult<Self> {
        Self::checked(self.0.orbited(degrees.to_radians()))
    }

    #[getter]
    fn eye(&self) -> PyResult<(f32, f32, f32)> {
        Ok(tuple(self.pose()?.eye))
    }

    #[getter]
    fn forward(&self) -> PyResult<(f32, f32, f32)> {
        Ok(tuple(self.pose()?.forward))
    }

    #[getter]
    fn right(&self) -> PyResult<(f32, f32, f32)> {
        Ok(tuple(self.pose()?.right))
    }

    #[getter]
    fn up(&self) -> PyResult<(f32, f32, f32)> {
        Ok(tuple(self.pose()?.up))
    }

    #[getter]
    fn target(&self) -> (f32, f32, f32) {
        tuple(self.0.target_position())
    }

    #[getter]
    fn up_direction(&self) -> (f32, f32, f32) {
        tuple(self.0.up_direction())
    }

    #[getter]
    fn size(&self) -> PyResult<(u32, u32)> {
        Ok(self.pose()?.size.into())
    }

    #[getter]
    fn screen_distance(&self) -> PyResult<f32> {
        Ok(self.pose()?.screen_distance)
    }

    #[getter]
    fn interaxial(&self) -> PyResult<f32> {
        Ok(self.pose()?.interaxial)
    }

    #[getter]
    fn interaxial_px(&self) -> PyResult<f32> {
        Ok(self.pose()?.interaxial_px)
    }

    #[getter]
    fn intrinsics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let Intrinsics { fx, fy, cx0, cx1, cy, .. } = self.pose()?.intrinsics();
        let dict = PyDict::new(py);
        for (name, value) in [("fx", fx), ("fy", fy), ("cx0", cx0), ("cx1", cx1), ("cy", cy)] {
            dict.set_item(name, value)?;
        }
        Ok(dict)
    }

    fn disparity(&self, depth: f32) -> PyResult<f64> {
        Ok(self.pose()?.disparity_px(depth))
    }

    /// Column, row and depth of a world position in a view.
    #[pyo3(signature = (point, eye = "left"))]
    fn project(&self, point: Point, eye: &str) -> PyResult<(f32, f32, f32)> {
        let side = match eye {
            "left" => -1.0,
            "middle" => 0.0,
            "right" => 1.0,
            _ => return Err(refused(format!("eye: '{eye}' is none; there are left, middle and right"))),
        };
        let [x, y, z] = self.pose()?.project(point.0, side);
        Ok((x, y, z))
    }

    #[pyo3(name = "to_json")]
    fn json(&self) -> PyResult<String> {
        Ok(self.pose()?.to_json())
    }

    fn __repr__(&self) -> PyResult<String> {
        let Pose { eye, forward, size: [width, height], interaxial, screen_distance, .. } = self.pose()?;
        Ok(format!(
            "Camera({width}x{height}, eye={eye}, forward={forward}, interaxial={interaxial}, screen_distance={screen_distance})"
        ))
    }
}

/// A camera with other fields.
fn with(mut camera: StereoCamera, fields: Option<&Bound<'_, PyDict>>) -> PyResult<Camera> {
    let Some(fields) = fields else { return Camera::checked(camera) };
    let has = |name: &str| fields.contains(name);
    for (one, other) in [
        ("fov", "screen_width"),
        ("fov", "intrinsics"),
        ("screen_width", "intrinsics"),
        ("interaxial", "interaxial_px"),
    ] {
        if has(one)? && has(other)? {
            return Err(refused(format!("camera: {one} and {other} say the same; give one of them")));
        }
    }
    // By pixels it is a parallax at infinity, which parallel cameras have none of: what the camera had stays, in world units.
    if let Some(distance) = fields.get_item("screen_distance")?
        && distance.extract::<f32>().is_ok_and(f32::is_infinite)
        && !has("interaxial_px")?
        && let Ok(pose) = camera.pose()
    {
        camera = camera.interaxial(pose.interaxial);
    }
    for (name, value) in fields {
        let name: String = name.extract()?;
        let of = |error: PyErr| refused(format!("camera: {name}: {}", error.value(value.py())));
        let point = || value.extract::<Point>().map(|point| point.0).map_err(of);
        let number = || {
            value.extract::<f32>().map_err(|_| refused(format!("camera: {name}: {} must be a number", shown(&value))))
        };
        camera = match &*name {
            "eye" => camera.eye(point()?),
            "target" => camera.target(point()?),
            "up" => camera.up(point()?),
            "size" => {
                let size = value.extract::<(u32, u32)>();
                let (width, height) =
                    size.map_err(|_| refused(format!("camera: size: {} must be width and height", shown(&value))))?;
                camera.size(width, height)
            }
            "fov" => camera.vertical_fov_degrees(number()?),
            "screen_width" => camera.screen_width(number()?),
            "intrinsics" => camera.intrinsics(intrinsics(&value)?),
            "screen_distance" => camera.screen_distance(number()?),
            "interaxial" => camera.interaxial(number()?),
            "interaxial_px" => camera.interaxial_pixels(number()?),
            "toe_in" if value.extract().map_err(of)? => camera.convergence(Convergence::ToeIn),
            "toe_in" => camera.convergence(Convergence::OffAxis),
            _ => return Err(refused(format!("camera: unknown field '{name}'; there are {FIELDS}"))),
        };
    }
    // Intrinsics say where the screen is; a distance that is given besides holds in turn, whatever order they came in.
    if has("intrinsics")?
        && let Some(distance) = fields.get_item("screen_distance")?
    {
        camera = camera.screen_distance(distance.extract()?);
    }
    Camera::checked(camera)
}

/// A calibration: a dict of `fx`, `fy` (else `fx` again), `cx0`, `cx1` (else `cx0` again) and `cy`, pixel centres at halves.
fn intrinsics(value: &Bound<'_, PyAny>) -> PyResult<Intrinsics> {
    let expected =
        "camera: intrinsics: it must be a dict of fx, fy, cx0, cx1 and cy, of which fy and cx1 may be left out";
    let dict = value.cast::<PyDict>().map_err(|_| refused(expected))?;
    if let Some(unknown) = dict
        .keys()
        .iter()
        .find(|key| key.extract::<String>().map_or(true, |key| !["fx", "fy", "cx0", "cx1", "cy"].contains(&&*key)))
    {
        return Err(refused(format!("{expected}, and has {}", shown(&unknown))));
    }
    let number = |name: &str| -> PyResult<Option<f64>> {
        let Some(value) = dict.get_item(name)? else { return Ok(None) };
        Ok(Some(
            value
                .extract()
                .map_err(|_| refused(format!("camera: intrinsics: {name}: {} must be a number", shown(&value))))?,
        ))
    };
    let needed = |name| number(name)?.ok_or_else(|| refused(format!("{expected}, and has no {name}")));
    let (fx, cx) = (needed("fx")?, needed("cx0")?);
    let intrinsics = Intrinsics::new([fx, number("fy")?.unwrap_or(fx)], [cx, needed("cy")?]);
    Ok(intrinsics.right_cx(number("cx1")?.unwrap_or(cx)))
}
