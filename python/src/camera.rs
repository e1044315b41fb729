//! Cameras.

use std::path::PathBuf;

use pyo3::{prelude::*, types::PyDict};
use stereotrace::{Convergence, Pose, StereoCamera, camera::Intrinsics};

use crate::{
    errors::{raised, refused},
    pickled::{Reduced, reduced},
    scene::Scene,
    values::{Position, Size, shown, tuple},
};

/// The fields that the constructor and `replace` take beside eye and target.
const FIELDS: &str =
    "eye, target, up, size, fov, screen_width, intrinsics, screen_distance, interaxial, interaxial_px and toe_in";

/// A stereo camera: two eyes that look through one screen rectangle (off-axis projection), or side by side as parallel
/// cameras.
///
/// ``Camera(eye, target)`` stands with the midpoint between its eyes at ``eye`` and looks at ``target``, both world
/// positions (right-handed, y up). What lies on the screen has no disparity; what is nearer has more, what is farther
/// less. The other fields are keywords:
///
/// - ``up``: the direction that is up in the picture, +y where nothing is said. It must not be parallel to the view.
/// - ``size``: a tuple of width and height in pixels, ``(640, 480)`` where nothing is said, 1 to 131072 each.
/// - ``fov``: the vertical field of view in degrees, between 0 and 180; 45 where nothing is said.
/// - ``screen_width``: the width of the screen rectangle in world units, in place of ``fov``.
/// - ``intrinsics``: what a calibration says, in place of ``fov``: a dict of focal lengths ``fx`` and ``fy``, the
///   columns ``cx0`` and ``cx1`` of the left and the right eye's principal point, and their row ``cy``, in pixels,
///   pixel centres at halves. ``fy`` is ``fx`` and ``cx1`` is ``cx0`` where they are left out. The screen then stands
///   at ``fx * interaxial / (cx1 - cx0)``, infinitely far where both columns are equal, unless ``screen_distance`` is
///   given too.
/// - ``screen_distance``: from the eyes to the screen, world units; that of the target where nothing is said.
///   ``math.inf`` makes parallel cameras.
/// - ``interaxial``: the distance between the eyes in world units; a thirtieth of the target's distance where nothing
///   is said.
/// - ``interaxial_px``: the same in pixels of the picture, as the disparity between the screen and infinity; not for
///   parallel cameras.
/// - ``toe_in``: whether the eyes are turned towards each other, so that their axes meet at the screen's distance.
///   Points then don't stay in their rows, and both views are traced whatever method is asked for. ``False`` where
///   nothing is said.
///
/// Cameras don't change: ``replace`` makes others. Equal ones are ``==``, and they can be pickled. Raises
/// ``ValueError``, naming the field, for what lies out of range or contradicts itself, such as both ``fov`` and
/// ``screen_width``, a target that is the eye, or an unknown field.
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

    /// The camera that was pickled.
    pub(crate) fn restored(state: &[u8]) -> PyResult<Self> {
        StereoCamera::from_json_str(&String::from_utf8_lossy(state)).map(Self).map_err(raised)
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
    fn new(eye: Position, target: Position, fields: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        with(StereoCamera::look_at(eye.0, target.0), fields)
    }

    /// A camera that holds all of a scene: from the front (+z), a little to the right and above, the screen through the
    /// middle of the scene's bounds, the eyes a thirtieth of the nearest distance apart.
    ///
    /// The vertical field of view is 35 degrees, less where a picture is ten times as wide as high and more. ``size``
    /// is a tuple of width and height in pixels. Raises ``ValueError`` for a scene that is empty or has only
    /// infinite planes, and for a size that no camera can have.
    #[staticmethod]
    #[pyo3(signature = (scene, size = Size(640, 480)))]
    pub(crate) fn fitting(scene: &Scene, size: Size) -> PyResult<Self> {
        let bounds = scene.inner.bounds().ok_or_else(|| refused("the scene is empty, or has only infinite planes"))?;
        Self::checked(StereoCamera::fitting(bounds, size.0, size.1))
    }

    /// Reads a camera from JSON: what ``to_json`` wrote, as text or as a file, or the camera ``name`` of a file of
    /// several, an object of cameras by name.
    ///
    /// Text is what begins with a brace. From what ``to_json`` wrote, without a ``name``, comes an equal camera;
    /// ``size`` gives it another picture. Cameras of a file of several are 640 x 480 where no ``size`` is given. Each
    /// has ``eye`` (the midpoint between the eyes), ``target`` and ``up``, three numbers each; ``vfov_deg`` in degrees;
    /// ``screen_distance`` in world units, or ``"inf"`` for parallel cameras; and ``eye_separation`` in world units.
    /// Calibrations may stand in the place of ``vfov_deg`` (``fx``, ``fy``, ``cy``, and ``cx`` or ``cx0`` and ``cx1``,
    /// pixel centres at halves), a matrix ``pose`` of the left eye in that of the first three, and ``baseline`` in that
    /// of ``eye_separation``. ``size`` is a tuple of width and height in pixels.
    ///
    /// Raises ``OSError`` if the file can't be read, and ``ValueError``, naming the line or the camera and its field,
    /// if it is no JSON, has no such camera, or the camera is invalid.
    #[staticmethod]
    #[pyo3(signature = (source, name = None, size = None))]
    fn from_json(source: &Bound<'_, PyAny>, name: Option<&str>, size: Option<Size>) -> PyResult<Self> {
        let text = source.extract::<String>().ok().filter(|text| text.trim_start().starts_with('{'));
        if let Some(name) = name {
            if text.is_some() {
                return Err(refused(format!(
                    "name: '{name}' is of a file of several cameras, and this is a text of one"
                )));
            }
            let Size(width, height) = size.unwrap_or(Size(640, 480));
            let path: PathBuf = source.extract()?;
            return StereoCamera::from_json(path, name, width, height).map(Self).map_err(raised);
        }
        let camera = match text {
            Some(text) => StereoCamera::from_json_str(&text).map_err(raised)?,
            None => StereoCamera::from_json_file(source.extract::<PathBuf>()?).map_err(raised)?,
        };
        Self::checked(size.map_or(camera, |Size(width, height)| camera.size(width, height)))
    }

    /// The camera with other fields: the keywords of ``Camera``, ``eye`` and ``target`` among them; all else stays.
    ///
    /// With another ``eye`` or ``target`` the screen's distance and the interaxial stay what they are. With another
    /// ``screen_distance`` the interaxial stays as it was given: in world units, or in pixels, but in world units
    /// for a screen at infinity. Raises ``ValueError`` as ``Camera`` does.
    #[pyo3(signature = (**fields))]
    fn replace(&self, fields: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        with(self.0, fields)
    }

    /// The camera turned about its target by an angle in degrees, around its ``up_direction``: at positive angles the
    /// eye moves to its own right. All else stays. Raises ``ValueError`` for an angle that makes no camera.
    fn orbited(&self, degrees: f32) -> PyResult<Self> {
        Self::checked(self.0.orbited(degrees.to_radians()))
    }

    /// The midpoint between the eyes, a world position: a tuple of three.
    #[getter]
    fn eye(&self) -> PyResult<(f64, f64, f64)> {
        Ok(self.pose()?.eye.into())
    }

    /// The view direction in the world, of unit length: a tuple of three.
    #[getter]
    fn forward(&self) -> PyResult<(f32, f32, f32)> {
        Ok(tuple(self.pose()?.forward))
    }

    /// The picture's right in the world, of unit length: a tuple of three. The eyes stand half the interaxial to either
    /// side of ``eye`` along it.
    #[getter]
    fn right(&self) -> PyResult<(f32, f32, f32)> {
        Ok(tuple(self.pose()?.right))
    }

    /// The picture's up in the world, of unit length and at right angles to the view: a tuple of three.
    #[getter]
    fn up(&self) -> PyResult<(f32, f32, f32)> {
        Ok(tuple(self.pose()?.up))
    }

    /// The point that is looked at, as it was given, a world position: a tuple of three.
    #[getter]
    fn target(&self) -> (f64, f64, f64) {
        self.0.target_position().into()
    }

    /// The direction that is up, as it was given: a tuple of three, of any length, and mostly not at right angles to
    /// the view.
    #[getter]
    fn up_direction(&self) -> (f32, f32, f32) {
        tuple(self.0.up_direction())
    }

    /// The picture's size in pixels: a tuple of width and height. Arrays of views are ``(height, width)``.
    #[getter]
    fn size(&self) -> PyResult<(u32, u32)> {
        Ok(self.pose()?.size.into())
    }

    /// The distance from the eyes to the screen, where disparity is 0, in world units; infinite for parallel cameras.
    #[getter]
    fn screen_distance(&self) -> PyResult<f32> {
        Ok(self.pose()?.screen_distance)
    }

    /// The distance between the eyes in world units.
    #[getter]
    fn interaxial(&self) -> PyResult<f32> {
        Ok(self.pose()?.interaxial)
    }

    /// The distance between the eyes in pixels of the picture: sky has the disparity ``-interaxial_px``. 0 for parallel
    /// cameras.
    #[getter]
    fn interaxial_px(&self) -> PyResult<f32> {
        Ok(self.pose()?.interaxial_px)
    }

    /// The camera as calibrations have it, in pixels: a dict of the focal lengths ``fx`` and ``fy``, the columns
    /// ``cx0`` and ``cx1`` of the left and the right eye's principal point, and their row ``cy``.
    ///
    /// A point ``X`` to the right of an eye's axis, ``Y`` below it and ``Z`` along it stands at ``fx X / Z + cx`` and
    /// ``fy Y / Z + cy``, from the picture's top left corner with pixel centres at halves. Programs that count
    /// pixel centres at whole numbers, such as ``OpenCV``, take half a pixel less of each ``cx`` and ``cy``.
    #[getter]
    fn intrinsics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let Intrinsics { fx, fy, cx0, cx1, cy, .. } = self.pose()?.intrinsics();
        let dict = PyDict::new(py);
        for (name, value) in [("fx", fx), ("fy", fy), ("cx0", cx0), ("cx1", cx1), ("cy", cy)] {
            dict.set_item(name, value)?;
        }
        Ok(dict)
    }

    /// The disparity ``x_left - x_right`` in pixels of a point at a depth along the view direction, in world units:
    /// above 0 before the screen, 0 on it, below 0 behind it, ``-interaxial_px`` at infinity. Of parallel cameras
    /// it is 0 at infinity and above 0 before it.
    ///
    /// It is infinite at depth 0. Of eyes that are toed in it is that of points on the axis between them.
    fn disparity(&self, depth: f32) -> PyResult<f64> {
        Ok(self.pose()?.disparity_px(depth))
    }

    /// Where a world position stands in the picture of an ``eye``, ``"left"``, ``"middle"`` or ``"right"``: a tuple of
    /// x, y and depth.
    ///
    /// x and y are in pixels from the picture's top left corner, with pixel centres at halves: the pixel in row j and
    /// column i has its centre at (i + 0.5, j + 0.5). The depth is along the eye's view direction, in world units.
    /// Raises ``ValueError`` for another eye.
    #[pyo3(signature = (point, eye = "left"))]
    fn project(&self, point: Position, eye: &str) -> PyResult<(f32, f32, f32)> {
        let side = match eye {
            "left" => -1.0,
            "middle" => 0.0,
            "right" => 1.0,
            _ => return Err(refused(format!("eye: '{eye}' is none; there are left, middle and right"))),
        };
        let [x, y, z] = self.pose()?.project(point.0, side);
        Ok((x, y, z))
    }

    /// The camera as JSON text, which ``from_json`` reads back: of ``left`` and ``right`` the intrinsics in pixels and
    /// the matrices ``world_to_camera`` and ``camera_to_world``, row by row; ``baseline`` and ``doffs``; and the
    /// numbers of the camera itself. Its ``conventions`` say what frames and units are.
    #[pyo3(name = "to_json")]
    fn json(&self) -> PyResult<String> {
        self.0.to_json().map_err(raised)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "Camera", self.json()?.as_bytes())
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
    // Parallel cameras have no parallax at infinity and no screen width: both are converted, so that the view stays.
    if let Some(distance) = fields.get_item("screen_distance")?
        && distance.extract::<f32>().is_ok_and(f32::is_infinite)
        && !has("interaxial_px")?
        && let Ok(parallel) = camera.parallel()
    {
        camera = parallel;
    }
    for (name, value) in fields {
        let name: String = name.extract()?;
        let of = |error: PyErr| refused(format!("camera: {name}: {}", error.value(value.py())));
        let point = || value.extract::<Position>().map(|point| point.0).map_err(of);
        let number = || {
            value.extract::<f32>().map_err(|_| refused(format!("camera: {name}: {} must be a number", shown(&value))))
        };
        camera = match &*name {
            "eye" => camera.eye(point()?),
            "target" => camera.target(point()?),
            "up" => camera.up(point()?.as_vec3()),
            "size" => {
                let size = value.extract::<Size>();
                let Size(width, height) =
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

/// A calibration: a dict of `fx`, `fy` (else `fx` again), `cx0`, `cx1` (else `cx0` again) and `cy`, pixel centres at
/// halves.
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
