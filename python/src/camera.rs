//! Cameras.

use std::path::PathBuf;

use numpy::{PyArray2, PyArrayMethods};
use pyo3::{prelude::*, types::PyDict};
use stereotrace::{
    Equirectangular, Lens, PoleMerge, Pose, Projection, Span, StereoCamera, camera::Intrinsics, output::Remap,
};

use crate::{
    errors::{raised, refused},
    pickled::{Reduced, reduced},
    scene::Scene,
    values::{Position, Size, shown, tuple},
};

/// Columns and rows.
type Maps<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<f32>>);

/// Fields that the constructor and `replace` take.
const FIELDS: &str = "eye, target, up, size, fov, screen_width, intrinsics, screen_distance, interaxial, \
                      interaxial_px, toe_in, projection, pole_merge and lens";

/// A stereo camera: two eyes that look through one screen rectangle (off-axis projection), or two parallel cameras.
///
/// In ``Camera(eye, target)``, ``eye`` is the midpoint between the eyes and ``target`` the point that they look at.
/// Both are world positions (right-handed, y up). Points on the screen have disparity 0, nearer points more, farther
/// points less. The other fields are keywords:
///
/// - ``up``: up direction of the picture, not parallel to the view. Default +y.
/// - ``size``: tuple of width and height in pixels, 1 to 131072 each. Default ``(640, 480)``.
/// - ``fov``: vertical field of view in degrees, between 0 and 180. Default 45.
/// - ``screen_width``: width of the screen rectangle in world units, in place of ``fov``.
/// - ``intrinsics``: a calibration in place of ``fov``: a dict in pixels, with pixel centres at halves. ``fx`` and
///   ``fy`` are the focal lengths. ``cx0`` and ``cx1`` are the columns of the left and right principal points, and
///   ``cy`` is their row. ``fy`` defaults to ``fx``, and ``cx1`` to ``cx0``. The screen is then at
///   ``fx * interaxial / (cx1 - cx0)``, or at infinity for equal columns, unless ``screen_distance`` is given too.
/// - ``screen_distance``: distance from the eyes to the screen (convergence distance) in world units. Default the
///   target's distance. ``math.inf`` makes parallel cameras.
/// - ``interaxial``: distance between the eyes (baseline) in world units. Default a thirtieth of the target's distance.
/// - ``interaxial_px``: the interaxial in pixels: the disparity between the screen and infinity. Not for parallel
///   cameras.
/// - ``toe_in``: whether the eyes turn towards each other, so that their axes meet at the screen distance. Points then
///   leave their rows, and both views are traced by every method. Default ``False``.
/// - ``projection``: ``"planar"``, or 360 or 180 for equirectangular pictures of so many degrees. Their eyes turn with
///   the direction of view (omnidirectional stereo). ``up`` is their vertical axis, and the picture's middle shows the
///   target's azimuth. They have no field of view and no screen, and a depth is a horizontal distance along a ray.
///   Default ``"planar"``.
/// - ``pole_merge``: tuple of two elevations in degrees between which the eyes of an equirectangular pair approach each
///   other, or ``None``. Default ``(60, 75)``.
/// - ``lens``: a lens with distortion, or a dict of two lenses, ``left`` and ``right``; ``None`` for no lens. A lens is
///   a dict: ``fx``, ``fy`` (default ``fx``), ``cx`` and ``cy`` in pixels, with pixel centres at halves; and
///   ``radial_tangential``, 4, 5 or 8 coefficients in ``OpenCV``'s order, or ``fisheye``, 4 coefficients. The eyes are
///   then parallel, and ``interaxial`` is in world units. Points leave their rows, and both views are traced by every
///   method. ``Renderer.correspondence`` finds points in the other picture.
///
/// Cameras are immutable: ``replace`` makes changed copies. They compare by value and can be pickled. Raises
/// ``ValueError``, which names the field, for values out of range, unknown fields and contradictions. Examples of
/// contradictions are both ``fov`` and ``screen_width``, or a target at the eye.
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

    /// Restores a pickled camera.
    pub(crate) fn restored(state: &[u8]) -> PyResult<Self> {
        StereoCamera::from_json_str(&String::from_utf8_lossy(state)).map(Self).map_err(raised)
    }

    /// Returns the camera if it is valid.
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

    /// Returns a camera that shows the whole scene: from the front (+z), a little from the right and above. The screen
    /// passes through the middle of the scene's bounds. The interaxial is a thirtieth of the nearest distance.
    ///
    /// The vertical field of view is 35 degrees, or less if the picture is at least ten times as wide as high. ``size``
    /// is a tuple of width and height in pixels. Raises ``ValueError`` for a scene that is empty or has only infinite
    /// planes, and for an invalid size.
    #[staticmethod]
    #[pyo3(signature = (scene, size = Size(640, 480)))]
    pub(crate) fn fitting(scene: &Scene, size: Size) -> PyResult<Self> {
        let bounds = scene.inner.bounds().ok_or_else(|| refused("the scene is empty, or has only infinite planes"))?;
        Self::checked(StereoCamera::fitting(bounds, size.0, size.1))
    }

    /// Reads a camera from JSON: the text or file that ``to_json`` wrote, or the camera ``name`` from a file of several
    /// cameras by name.
    ///
    /// A ``source`` that begins with a brace is text; otherwise it is a path. Without a ``name`` the camera equals the
    /// one that ``to_json`` wrote, and ``size`` changes its picture. ``size`` is a tuple of width and height in pixels.
    /// It defaults to ``(640, 480)`` for files of several cameras. Each of their cameras has
    ///
    /// - ``eye`` (the midpoint between the eyes), ``target`` and ``up``, three numbers each; or a matrix ``pose`` of
    ///   the left eye;
    /// - ``vfov_deg`` in degrees; or ``fx``, ``fy``, ``cy``, and ``cx`` or ``cx0`` and ``cx1``, with pixel centres at
    ///   halves;
    /// - ``screen_distance`` in world units, or ``"inf"`` for parallel cameras;
    /// - ``eye_separation`` or ``baseline`` in world units.
    ///
    /// Raises ``OSError`` if the file can't be read. Raises ``ValueError`` if the text is no JSON, has no such camera,
    /// or the camera is invalid. The message names the line, or the camera and its field.
    #[staticmethod]
    #[pyo3(signature = (source, name = None, size = None))]
    fn from_json(source: &Bound<'_, PyAny>, name: Option<&str>, size: Option<Size>) -> PyResult<Self> {
        let text = source.extract::<String>().ok().filter(|text| text.trim_start().starts_with('{'));
        if let Some(name) = name {
            if text.is_some() {
                return Err(refused(format!(
                    "name: '{name}' selects a camera from several in a file, but this text describes one"
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

    /// Returns a copy with other fields: the keywords of ``Camera``, and ``eye`` and ``target``.
    ///
    /// A new ``eye`` or ``target`` keeps the screen distance and the interaxial. A new ``screen_distance`` keeps the
    /// interaxial in the unit in which it was given; for a screen at infinity it keeps it in world units. Raises
    /// ``ValueError`` as ``Camera`` does.
    #[pyo3(signature = (**fields))]
    fn replace(&self, fields: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        with(self.0, fields)
    }

    /// Returns the camera moved up along the picture's up axis, by a distance in world units; down by a negative one.
    /// Raises ``ValueError`` as ``Camera`` does.
    fn raised(&self, distance: f64) -> PyResult<Self> {
        self.0.raised(distance).map(Self).map_err(raised)
    }

    /// Returns the camera moved about its target by an angle in degrees, around its ``up_direction``. For positive
    /// angles the eye moves to its own right. Raises ``ValueError`` if the moved camera is invalid.
    fn orbited(&self, degrees: f32) -> PyResult<Self> {
        Self::checked(self.0.orbited(degrees.to_radians()))
    }

    /// World position of the midpoint between the eyes: a tuple of three.
    #[getter]
    fn eye(&self) -> PyResult<(f64, f64, f64)> {
        Ok(self.pose()?.eye.into())
    }

    /// View direction in the world, of unit length: a tuple of three.
    #[getter]
    fn forward(&self) -> PyResult<(f32, f32, f32)> {
        Ok(tuple(self.pose()?.forward))
    }

    /// Right direction of the picture in the world, of unit length: a tuple of three. The eyes are half the interaxial
    /// from ``eye`` along it, to either side.
    #[getter]
    fn right(&self) -> PyResult<(f32, f32, f32)> {
        Ok(tuple(self.pose()?.right))
    }

    /// Up direction of the picture in the world, of unit length and perpendicular to the view: a tuple of three.
    #[getter]
    fn up(&self) -> PyResult<(f32, f32, f32)> {
        Ok(tuple(self.pose()?.up))
    }

    /// World position that the camera looks at, as given: a tuple of three.
    #[getter]
    fn target(&self) -> (f64, f64, f64) {
        self.0.target_position().into()
    }

    /// Up direction as given: a tuple of three, of any length, not necessarily perpendicular to the view.
    #[getter]
    fn up_direction(&self) -> (f32, f32, f32) {
        tuple(self.0.up_direction())
    }

    /// Size of the picture in pixels: a tuple of width and height. Arrays of views are ``(height, width)``.
    #[getter]
    fn size(&self) -> PyResult<(u32, u32)> {
        Ok(self.pose()?.size.into())
    }

    /// Distance from the eyes to the screen, where disparity is 0, in world units; infinite for parallel cameras.
    #[getter]
    fn screen_distance(&self) -> PyResult<f32> {
        Ok(self.pose()?.screen_distance)
    }

    /// Distance between the eyes (baseline) in world units.
    #[getter]
    fn interaxial(&self) -> PyResult<f32> {
        Ok(self.pose()?.interaxial)
    }

    /// Distance between the eyes in pixels of the picture; 0 for parallel cameras. Sky has the disparity
    /// ``-interaxial_px``.
    #[getter]
    fn interaxial_px(&self) -> PyResult<f32> {
        Ok(self.pose()?.interaxial_px)
    }

    /// Intrinsics in pixels: a dict. ``fx`` and ``fy`` are the focal lengths. ``cx0`` and ``cx1`` are the columns of
    /// the left and right principal points, and ``cy`` is their row.
    ///
    /// A point lies ``X`` to the right of an eye's axis, ``Y`` below it and ``Z`` along it. Its position in the picture
    /// is ``fx X / Z + cx`` and ``fy Y / Z + cy``. These count from the picture's top left corner, with pixel centres
    /// at halves. For programs with pixel centres at whole numbers, such as ``OpenCV``, subtract 0.5 from each ``cx``
    /// and ``cy``.
    #[getter]
    fn intrinsics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let Intrinsics { fx, fy, cx0, cx1, cy, .. } = self
            .pose()?
            .intrinsics()
            .ok_or_else(|| refused("equirectangular pictures and lenses have no intrinsics"))?;
        let dict = PyDict::new(py);
        for (name, value) in [("fx", fx), ("fy", fy), ("cx0", cx0), ("cx1", cx1), ("cy", cy)] {
            dict.set_item(name, value)?;
        }
        Ok(dict)
    }

    /// Lenses of the eyes: a dict of the lenses ``left`` and ``right``, as the keyword ``lens`` takes it, or ``None``.
    #[getter]
    fn lens<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Projection::Lenses([left, right]) = self.0.projection_kind() else { return Ok(None) };
        let text = format!(r#"{{"left": {}, "right": {}}}"#, left.to_json(), right.to_json());
        py.import("json")?.call_method1("loads", (text,)).map(Some)
    }

    /// Returns the rectified camera: the same eyes as parallel cameras without lenses. Its pictures and ground truth
    /// are those of the rectified pair. A camera without lenses is returned as it is.
    fn rectified(&self) -> PyResult<Self> {
        Self::checked(self.0.rectified())
    }

    /// Returns where the picture of an ``eye``, ``"left"`` or ``"right"``, shows the pixels of the rectified picture: a
    /// tuple of two arrays, x and y, float32, ``(height, width)``.
    ///
    /// These are the maps of ``cv2.initUndistortRectifyMap``: ``cv2.remap(picture, x, y, cv2.INTER_LINEAR)`` rectifies
    /// a picture. **Pixel centres are at integers**, as in ``OpenCV`` and unlike elsewhere here. Both are NaN where the
    /// lens does not show the direction. Raises ``ValueError`` for a camera without lenses, and for another eye.
    #[pyo3(signature = (eye = "left"))]
    fn rectify_map<'py>(&self, py: Python<'py>, eye: &str) -> PyResult<Maps<'py>> {
        let side = match eye {
            "left" => -1.0,
            "right" => 1.0,
            _ => return Err(refused(format!("eye: unknown '{eye}'; use left or right"))),
        };
        let Remap { width, height, x, y, .. } = Remap::new(&self.0, side).map_err(raised)?;
        let shaped = |list| numpy::PyArray1::from_vec(py, list).reshape([height as usize, width as usize]);
        Ok((shaped(x)?, shaped(y)?))
    }

    /// Angles in radians of a column and of a row of an equirectangular picture, or ``None`` for planar pictures. A
    /// disparity times the first one is in radians.
    #[getter]
    fn radians_per_pixel(&self) -> PyResult<Option<(f64, f64)>> {
        Ok(self.pose()?.radians_per_pixel().map(|[column, row]| (column, row)))
    }

    /// Returns the disparity ``x_left - x_right`` in pixels of a point at ``depth``, in world units along the view. It
    /// is positive before the screen, 0 on it, negative behind it, and ``-interaxial_px`` at infinity. For parallel
    /// cameras it is 0 at infinity and positive before it.
    ///
    /// At depth 0 it is infinite. For toed-in eyes it holds for points on the axis between them, and for lenses without
    /// their distortion.
    fn disparity(&self, depth: f32) -> PyResult<f64> {
        Ok(self.pose()?.disparity_px(depth))
    }

    /// Projects a world position into the picture of an ``eye``, ``"left"``, ``"middle"`` or ``"right"``. Returns a
    /// tuple of x, y and depth.
    ///
    /// x and y are in pixels from the picture's top left corner. The pixel in row j and column i has its centre at
    /// (i + 0.5, j + 0.5). The depth is along the eye's view direction, in world units. Raises ``ValueError`` for
    /// another eye.
    #[pyo3(signature = (point, eye = "left"))]
    fn project(&self, point: Position, eye: &str) -> PyResult<(f32, f32, f32)> {
        let side = match eye {
            "left" => -1.0,
            "middle" => 0.0,
            "right" => 1.0,
            _ => return Err(refused(format!("eye: unknown '{eye}'; use left, middle or right"))),
        };
        let [x, y, z] = self.pose()?.project(point.0, side);
        Ok((x, y, z))
    }

    /// Returns the camera as JSON text, which ``from_json`` reads. ``left`` and ``right`` have intrinsics in pixels and
    /// the matrices ``world_to_camera`` and ``camera_to_world``, by rows. ``baseline``, ``doffs`` and the fields of the
    /// camera follow. ``conventions`` describes frames and units.
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
            "Camera({width}x{height}, eye={eye}, forward={forward}, interaxial={interaxial}, \
             screen_distance={screen_distance})"
        ))
    }
}

/// Returns the camera with other fields.
fn with(mut camera: StereoCamera, fields: Option<&Bound<'_, PyDict>>) -> PyResult<Camera> {
    let Some(fields) = fields else { return Camera::checked(camera) };
    let has = |name: &str| fields.contains(name);
    for (one, other) in [
        ("fov", "screen_width"),
        ("fov", "intrinsics"),
        ("screen_width", "intrinsics"),
        ("interaxial", "interaxial_px"),
        ("lens", "fov"),
        ("lens", "screen_width"),
        ("lens", "intrinsics"),
        ("lens", "toe_in"),
        ("lens", "projection"),
    ] {
        if has(one)? && has(other)? {
            return Err(refused(format!("camera: {one} and {other} set the same value; give one of them")));
        }
    }
    // Parallel cameras have neither parallax at infinity nor a screen width. Both are converted, to keep the view.
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
            "toe_in" if value.extract().map_err(of)? => camera.projection(Projection::ToeIn),
            "toe_in" => camera.projection(Projection::OffAxis),
            "lens" if value.is_none() && matches!(camera.projection_kind(), Projection::Lenses(_)) => {
                camera.projection(Projection::OffAxis)
            }
            "lens" if value.is_none() => camera,
            "lens" => {
                let [left, right] = lenses(&value)?;
                camera.lenses(left, right)
            }
            "projection" | "pole_merge" => camera, // read together below
            _ => return Err(refused(format!("camera: unknown field '{name}'; the fields are {FIELDS}"))),
        };
    }
    camera = projected(camera, fields)?;
    // Intrinsics set the screen distance, and a given distance replaces it, independent of their order.
    if has("intrinsics")?
        && let Some(distance) = fields.get_item("screen_distance")?
    {
        camera = camera.screen_distance(distance.extract()?);
    }
    Camera::checked(camera)
}

/// Sets the fields `projection` and `pole_merge`.
fn projected(camera: StereoCamera, fields: &Bound<'_, PyDict>) -> PyResult<StereoCamera> {
    let fault = |name: &str, value: &Bound<'_, PyAny>, rule: &str| {
        Err(refused(format!("camera: {name}: {} must be {rule}", shown(value))))
    };
    let before = camera.projection_kind().equirectangular();
    let span = match fields.get_item("projection")? {
        None => before.map(|projection| projection.span),
        Some(value) if value.extract::<String>().is_ok_and(|name| name == "planar") => None,
        Some(value) => match value.extract::<u32>().ok().and_then(|degrees| Span::from_degrees(degrees.into())) {
            None => return fault("projection", &value, "'planar', 360 or 180"),
            span => span,
        },
    };
    let merge = match fields.get_item("pole_merge")? {
        None => before.map_or_else(|| Some(PoleMerge::default()), |projection| projection.merge),
        Some(value) if value.is_none() => None,
        Some(value) => match value.extract::<(f32, f32)>() {
            Ok((from, to)) => Some(PoleMerge { from, to }),
            Err(_) => return fault("pole_merge", &value, "None or two elevations in degrees"),
        },
    };
    if let (None, Some(value)) = (span, fields.get_item("pole_merge")?) {
        return fault("pole_merge", &value, "left out: only equirectangular pictures have poles");
    }
    Ok(match (span, before) {
        (Some(span), _) => camera.projection(Projection::Equirectangular(Equirectangular { span, merge })),
        (None, Some(_)) => camera.projection(Projection::OffAxis),
        (None, None) => camera,
    })
}

/// Reads the lenses of both eyes from a dict, by way of its JSON. Arrays of `NumPy` are lists there.
fn lenses(value: &Bound<'_, PyAny>) -> PyResult<[Lens; 2]> {
    let py = value.py();
    let options = PyDict::new(py);
    options.set_item("default", py.import("operator")?.call_method1("methodcaller", ("tolist",))?)?;
    options.set_item("allow_nan", false)?;
    let text = py.import("json")?.call_method("dumps", (value,), Some(&options));
    let text = text.map_err(|error| refused(format!("camera: lens: {}", error.value(py))))?;
    Lens::pair_from_json(&text.extract::<String>()?).map_err(|error| refused(format!("camera: lens: {error}")))
}

/// Reads intrinsics from a dict of `fx`, `fy` (default `fx`), `cx0`, `cx1` (default `cx0`) and `cy`, with pixel centres
/// at halves.
fn intrinsics(value: &Bound<'_, PyAny>) -> PyResult<Intrinsics> {
    let expected = "camera: intrinsics: it must be a dict of fx, fy, cx0, cx1 and cy, where fy and cx1 are optional";
    let dict = value.cast::<PyDict>().map_err(|_| refused(expected))?;
    if let Some(unknown) = dict
        .keys()
        .iter()
        .find(|key| key.extract::<String>().map_or(true, |key| !["fx", "fy", "cx0", "cx1", "cy"].contains(&&*key)))
    {
        return Err(refused(format!("{expected}, but has {}", shown(&unknown))));
    }
    let number = |name: &str| -> PyResult<Option<f64>> {
        let Some(value) = dict.get_item(name)? else { return Ok(None) };
        Ok(Some(
            value
                .extract()
                .map_err(|_| refused(format!("camera: intrinsics: {name}: {} must be a number", shown(&value))))?,
        ))
    };
    let needed = |name| number(name)?.ok_or_else(|| refused(format!("{expected}, but has no {name}")));
    let (fx, cx) = (needed("fx")?, needed("cx0")?);
    let intrinsics = Intrinsics::new([fx, number("fy")?.unwrap_or(fx)], [cx, needed("cy")?]);
    Ok(intrinsics.right_cx(number("cx1")?.unwrap_or(cx)))
}
