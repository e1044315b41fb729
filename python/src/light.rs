//! Lights.

use pyo3::prelude::*;
use stereotrace::LightShape;

use crate::{
    pickled::{Reduced, bytes, reduced},
    values::{Color, Point, Position, tuple},
};

/// A light without falloff: all of it that is seen from a place is as bright there as from any other.
///
/// ``Light.point``, ``Light.sphere``, ``Light.rectangle`` and ``Light.directional`` make one. ``intensity`` is the
/// radiance that all of it together adds to a white surface that faces it: linear RGB, 0 or more, or one number for all
/// three. Lights are not seen themselves. All but points light by as many rays as the option ``shadow_rays`` says, so
/// that their shadows have a penumbra; a scene may have 16 such.
///
/// Lights don't change: ``replace`` makes others. Equal ones are ``==``, and they can be pickled. Their values are
/// checked when a scene is rendered, with a ``ValueError`` for what is out of range.
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
    /// A point of light at a world position. Its shadows are sharp.
    #[staticmethod]
    fn point(position: Position, intensity: Color) -> Self {
        Self(stereotrace::Light::point(position.0, intensity.0))
    }

    /// A ball of light about a world position; the radius is in world units, above 0.
    #[staticmethod]
    fn sphere(position: Position, radius: f32, intensity: Color) -> Self {
        Self(stereotrace::Light::sphere(position.0, radius, intensity.0))
    }

    /// A rectangle or parallelogram of light about a world position, which shines to both sides. ``half_width`` and
    /// ``half_height`` are the ways from there to the middles of two sides, in world units.
    #[staticmethod]
    fn rectangle(position: Position, half_width: Point, half_height: Point, intensity: Color) -> Self {
        Self(stereotrace::Light::rectangle(position.0, half_width.0, half_height.0, intensity.0))
    }

    /// Light from infinitely far off, such as a sun's. ``towards`` is the direction that leads to it, of any length but
    /// 0; ``radius`` is the angle from the middle of its disc to the rim, in radians, 0 to 1.5: the sun's is
    /// 0.0047, and by 0 shadows are sharp.
    #[staticmethod]
    fn directional(towards: Position, radius: f32, intensity: Color) -> Self {
        Self(stereotrace::Light::directional(towards.0, radius, intensity.0))
    }

    /// The world position of its middle; of a directional light the direction that leads to it. A tuple of three.
    #[getter]
    fn position(&self) -> (f64, f64, f64) {
        self.0.position.into()
    }

    /// The radiance that it adds to a white surface that faces it, linear RGB: a tuple of three.
    #[getter]
    fn intensity(&self) -> (f32, f32, f32) {
        tuple(self.0.intensity)
    }

    /// What throws the light: ``"point"``, ``"sphere"``, ``"rectangle"`` or ``"directional"``.
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

    /// The radius: of a sphere in world units, of a directional light an angle in radians; ``None`` of other lights.
    #[getter]
    fn radius(&self) -> Option<f32> {
        match self.0.shape {
            LightShape::Sphere { radius } | LightShape::Directional { radius } => Some(radius),
            _ => None,
        }
    }

    /// The light at another position, or with another intensity; of a directional light ``position`` is its direction.
    /// All else stays.
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
