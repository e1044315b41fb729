//! Lights.

use pyo3::prelude::*;
use stereotrace::{Falloff, LightShape, TextureId};

use crate::{
    pickled::{Reduced, bytes, reduced},
    values::{Color, Point, Position, tuple},
};

/// A light. Without falloff, its distance does not change its brightness.
///
/// ``Light.point``, ``Light.sphere``, ``Light.rectangle`` and ``Light.directional`` make one. ``intensity`` is the
/// radiance that the whole light adds to a white surface that faces it. It is linear RGB, 0 or more, or one number for
/// all three channels. Lights are invisible themselves. All lights but points are sampled by the option
/// ``shadow_rays``, so that shadows have a penumbra. A scene may have at most 16 of these.
///
/// ``with_quadratic_falloff`` returns a light whose brightness falls with the square of the distance. ``intensity`` is
/// then the radiance of a white surface at a distance of 1 world unit. A sphere of radiance L and radius r has the
/// intensity L r². A rectangle of radiance L and area A has the intensity L A / π. It emits on one side, the one that
/// the cross product of ``half_width`` and ``half_height`` points to. ``with_cone`` returns a spot light, and
/// ``with_projector`` a light that projects a picture.
///
/// Lights are immutable: ``replace`` makes changed copies. They compare by value and can be pickled. Rendering checks
/// their values, and raises ``ValueError`` for values out of range.
#[pyclass(frozen, eq, module = "stereotrace")]
#[derive(Clone, PartialEq)]
pub(crate) struct Light(pub(crate) stereotrace::Light);

impl<'a, 'py> FromPyObject<'a, 'py> for Light {
    type Error = PyErr;

    fn extract(value: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        Ok(value.cast::<Self>()?.get().clone())
    }
}

#[pymethods]
impl Light {
    /// Makes a point light at a world position. Its shadows are sharp.
    #[staticmethod]
    fn point(position: Position, intensity: Color) -> Self {
        Self(stereotrace::Light::point(position.0, intensity.0))
    }

    /// Makes a spherical light about a world position. The radius is in world units, above 0.
    #[staticmethod]
    fn sphere(position: Position, radius: f32, intensity: Color) -> Self {
        Self(stereotrace::Light::sphere(position.0, radius, intensity.0))
    }

    /// Makes a rectangular light, or a parallelogram, about a world position. It shines to both sides. ``half_width``
    /// and ``half_height`` are the vectors from its middle to the middles of two sides, in world units.
    #[staticmethod]
    fn rectangle(position: Position, half_width: Point, half_height: Point, intensity: Color) -> Self {
        Self(stereotrace::Light::rectangle(position.0, half_width.0, half_height.0, intensity.0))
    }

    /// Makes a light at infinity, such as the sun. ``towards`` is the direction to it, of any length but 0. ``radius``
    /// is the angle from the middle of its disc to the rim, in radians, 0 to 1.5. The sun's is 0.0047. With 0 shadows
    /// are sharp.
    #[staticmethod]
    fn directional(towards: Position, radius: f32, intensity: Color) -> Self {
        Self(stereotrace::Light::directional(towards.0, radius, intensity.0))
    }

    /// Returns a copy whose brightness falls with the square of the distance. With a ``range`` in world units, above 0,
    /// it is multiplied by ``1 - (distance / range)**4``. Directional lights have no falloff.
    #[pyo3(signature = (*, range = None))]
    fn with_quadratic_falloff(&self, range: Option<f32>) -> Self {
        let mut light = self.0;
        light.falloff = Falloff::Quadratic { range };
        Self(light)
    }

    /// Returns a copy of a point or spherical light that shines in a cone only. ``direction`` is the axis, of any
    /// length but 0. Brightness is full up to the angle ``inner`` from the axis and 0 from ``outer`` on. The angles are
    /// in radians: ``inner`` is less than ``outer``, and ``outer`` at most π/2.
    fn with_cone(&self, direction: Point, inner: f32, outer: f32) -> Self {
        Self(self.0.with_cone(direction.0, inner, outer))
    }

    /// Returns a copy of a point light that projects a picture: a slide, or a pattern such as ``Scene.add_dots`` adds.
    /// ``texture`` is an id of the scene's ``add_texture``; its linear colour multiplies the intensity. There is no
    /// light outside the picture. ``direction`` leads to the picture's middle and ``up`` is up in the picture, both
    /// world directions of any length but 0. ``fov`` is the full horizontal field of view in radians, at least 0.001
    /// and less than π. Pixels are square.
    fn with_projector(&self, texture: u32, direction: Point, up: Point, fov: f32) -> Self {
        Self(self.0.with_projector(TextureId(texture), direction.0, up.0, fov))
    }

    /// World position of the middle, or the direction to a directional light: a tuple of three.
    #[getter]
    fn position(&self) -> (f64, f64, f64) {
        self.0.position.into()
    }

    /// Radiance that the light adds to a white surface that faces it, linear RGB: a tuple of three.
    #[getter]
    fn intensity(&self) -> (f32, f32, f32) {
        tuple(self.0.intensity)
    }

    /// Shape of the light: ``"point"``, ``"sphere"``, ``"rectangle"`` or ``"directional"``.
    #[getter]
    fn shape(&self) -> &'static str {
        match self.0.shape {
            LightShape::Point => "point",
            LightShape::Sphere { .. } => "sphere",
            LightShape::Rectangle { .. } => "rectangle",
            LightShape::Directional { .. } => "directional",
            _ => "other",
        }
    }

    /// Radius of a sphere in world units, or of a directional light in radians; ``None`` for other lights.
    #[getter]
    fn radius(&self) -> Option<f32> {
        match self.0.shape {
            LightShape::Sphere { radius } | LightShape::Directional { radius } => Some(radius),
            _ => None,
        }
    }

    /// Returns a copy with another position or intensity. The ``position`` of a directional light is its direction.
    #[pyo3(signature = (*, position = None, intensity = None))]
    fn replace(&self, position: Option<Position>, intensity: Option<Color>) -> Self {
        let mut light = self.0;
        light.position = position.map_or(light.position, |point| point.0);
        light.intensity = intensity.map_or(light.intensity, |color| color.0);
        Self(light)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "Light", &bytes(&self.0)?)
    }

    fn __repr__(&self) -> String {
        let (position, intensity) = (self.0.position, self.0.intensity);
        format!("Light.{}(position={position}, intensity={intensity})", self.shape())
    }
}
