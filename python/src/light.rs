//! Lights.

use pyo3::prelude::*;
use stereotrace::LightShape;

use crate::values::{Color, Point, tuple};

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
    #[staticmethod]
    fn point(position: Point, intensity: Color) -> Self {
        Self(stereotrace::Light::point(position.0, intensity.0))
    }

    #[staticmethod]
    fn sphere(position: Point, radius: f32, intensity: Color) -> Self {
        Self(stereotrace::Light::sphere(position.0, radius, intensity.0))
    }

    #[staticmethod]
    fn rectangle(position: Point, half_width: Point, half_height: Point, intensity: Color) -> Self {
        Self(stereotrace::Light::rectangle(position.0, half_width.0, half_height.0, intensity.0))
    }

    #[staticmethod]
    fn directional(towards: Point, radius: f32, intensity: Color) -> Self {
        Self(stereotrace::Light::directional(towards.0, radius, intensity.0))
    }

    #[getter]
    fn position(&self) -> (f32, f32, f32) {
        tuple(self.0.position)
    }

    #[getter]
    fn intensity(&self) -> (f32, f32, f32) {
        tuple(self.0.intensity)
    }

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

    #[getter]
    fn radius(&self) -> Option<f32> {
        match self.0.shape {
            LightShape::Sphere { radius } | LightShape::Directional { radius } => Some(radius),
            _ => None,
        }
    }

    #[pyo3(signature = (*, position = None, intensity = None))]
    fn replace(&self, position: Option<Point>, intensity: Option<Color>) -> Self {
        let mut light = self.0;
        light.position = position.map_or(light.position, |point| point.0);
        light.intensity = intensity.map_or(light.intensity, |color| color.0);
        Self(light)
    }

    fn __repr__(&self) -> String {
        let (position, intensity) = (self.0.position, self.0.intensity);
        format!("Light.{}(position={position}, intensity={intensity})", self.shape())
    }
}
