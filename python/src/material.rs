//! Materials.

use pyo3::{prelude::*, types::PyDict};
use stereotrace::{Finish, TextureId, glam::Vec3};

use crate::{
    errors::refused,
    pickled::{Reduced, bytes, reduced},
    values::{Color, shown, tuple},
};

/// The fields that the constructor and `replace` take.
const FIELDS: [&str; 11] = [
    "albedo",
    "name",
    "texture",
    "cutout",
    "opacity",
    "specular",
    "exponent",
    "normalised",
    "emission",
    "finish",
    "index",
];
/// Those of mirrors and glass alone.
const FINISH_FIELDS: [&str; 2] = ["transmission", "fresnel"];

/// A surface: what it scatters, shines, reflects, lets through and gives off.
///
/// ``Material()`` is a grey, matte, opaque one of albedo 0.7. Colours are linear RGB, 0 to 1; one number stands for
/// three equal ones. The fields are keywords, of which ``albedo`` may come first without its name:
///
/// - ``albedo``: diffuse (Lambertian) reflectance; of mirrors and glass black where nothing is said.
/// - ``name``: for messages; empty where nothing is said.
/// - ``texture``: the id of a texture that the albedo is multiplied by; its alpha says nothing. ``None`` for none.
/// - ``cutout``: the id of a texture where whose alpha is below a half there is no surface; triangles only. ``None``
///   for none.
/// - ``opacity``: the share of what is behind the surface that it hides, 0 to 1; 1 where nothing is said.
/// - ``specular``: the colour of highlights; of mirrors and glass the share that they reflect. Where nothing is said it
///   is 0.95 for mirrors, what ``index`` gives straight on for glass with ``fresnel`` (0.04 for 1.5), and black for all
///   else.
/// - ``exponent``: Phong's exponent, 0 to 10000; the larger, the smaller a highlight. 30 where nothing is said.
/// - ``normalised``: whether highlights conserve energy, so that ``specular`` is the share of a light that they send
///   on. ``False`` where nothing is said.
/// - ``emission``: the radiance that it gives off by itself, 0 or more; it lights nothing else. Black where nothing is
///   said.
/// - ``finish``: ``"matte"``, ``"mirror"``, which reflects its surroundings, or ``"glass"``, which refracts what is
///   behind it. Matte where nothing is said.
/// - ``index``: of glass, its index of refraction over that of what surrounds it, 0.1 to 10; 1.5 where nothing is said.
/// - ``transmission``: of glass, the share of the light that comes through; white where nothing is said.
/// - ``fresnel``: of mirrors and glass, whether the angle of view says how much is reflected: mirrors reflect more the
///   more the view grazes them, and of glass what is not reflected comes through. ``False`` for mirrors and ``True``
///   for glass where nothing is said.
///
/// Materials don't change: ``replace`` makes others. Equal ones are ``==``, and they can be pickled. Raises
/// ``ValueError`` for unknown fields, fields of another finish and values of another type. Ranges are checked when a
/// scene is rendered: there what is scattered, reflected and let through may be at most 1 together in each channel.
#[pyclass(frozen, eq, module = "stereotrace")]
#[derive(Clone, PartialEq)]
pub(crate) struct Material(pub(crate) stereotrace::Material);

impl<'a, 'py> FromPyObject<'a, 'py> for Material {
    type Error = PyErr;

    fn extract(value: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        Ok(value.cast::<Self>()?.get().clone())
    }
}

#[pymethods]
impl Material {
    #[new]
    #[pyo3(signature = (albedo = None, **fields))]
    fn new(albedo: Option<Color>, fields: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut material = stereotrace::Material::new(Vec3::splat(0.7));
        if let Some(albedo) = albedo {
            material.albedo = albedo.0;
        }
        let Self(mut material) = with(material, fields)?;
        // Mirrors and glass return nearly all light: with the grey albedo they would return more than they get.
        if albedo.is_none() && material.finish != Finish::Matte {
            material.albedo = Vec3::ZERO;
        }
        if !fields.is_some_and(|fields| fields.contains("specular").unwrap_or(false)) {
            material.specular = default_specular(&material.finish);
        }
        Ok(Self(material))
    }

    /// The material with other fields, ``albedo`` and the other keywords of ``Material``; all else stays. With
    /// ``finish``, those of ``index``, ``transmission`` and ``fresnel`` that are not given too become what they are
    /// where nothing is said. Raises ``ValueError`` as ``Material`` does.
    #[pyo3(signature = (**fields))]
    fn replace(&self, fields: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        with(self.0.clone(), fields)
    }

    /// The name, or an empty text.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// Diffuse reflectance, linear RGB: a tuple of three.
    #[getter]
    fn albedo(&self) -> (f32, f32, f32) {
        tuple(self.0.albedo)
    }

    /// The id of the texture that the albedo is multiplied by, or ``None``.
    #[getter]
    fn texture(&self) -> Option<u32> {
        self.0.texture.map(|id| id.0)
    }

    /// The id of the texture where whose alpha is below a half there is no surface, or ``None``.
    #[getter]
    fn cutout(&self) -> Option<u32> {
        self.0.cutout.map(|id| id.0)
    }

    /// The share of what is behind the surface that it hides, 0 to 1.
    #[getter]
    fn opacity(&self) -> f32 {
        self.0.opacity
    }

    /// The colour of highlights, of mirrors and glass the share that they reflect, linear RGB: a tuple of three.
    #[getter]
    fn specular(&self) -> (f32, f32, f32) {
        tuple(self.0.specular)
    }

    /// Phong's exponent: the larger, the smaller a highlight.
    #[getter]
    fn exponent(&self) -> f32 {
        self.0.exponent
    }

    /// Whether highlights conserve energy.
    #[getter]
    fn normalised(&self) -> bool {
        self.0.normalised
    }

    /// The radiance that the surface gives off by itself, linear RGB: a tuple of three.
    #[getter]
    fn emission(&self) -> (f32, f32, f32) {
        tuple(self.0.emission)
    }

    /// ``"matte"``, ``"mirror"`` or ``"glass"``.
    #[getter]
    fn finish(&self) -> &'static str {
        match self.0.finish {
            Finish::Matte => "matte",
            Finish::Mirror { .. } => "mirror",
            Finish::Glass { .. } => "glass",
            _ => "other",
        }
    }

    /// The index of refraction of glass over that of what surrounds it; ``None`` of other materials.
    #[getter]
    fn index(&self) -> Option<f32> {
        if let Finish::Glass { index, .. } = self.0.finish { Some(index) } else { None }
    }

    /// The share of the light that comes through glass, linear RGB: a tuple of three; ``None`` of other materials.
    #[getter]
    fn transmission(&self) -> Option<(f32, f32, f32)> {
        if let Finish::Glass { transmission, .. } = self.0.finish { Some(tuple(transmission)) } else { None }
    }

    /// Of mirrors and glass, whether the angle of view says how much is reflected; ``None`` of matte materials.
    #[getter]
    fn fresnel(&self) -> Option<bool> {
        match self.0.finish {
            Finish::Mirror { fresnel } | Finish::Glass { fresnel, .. } => Some(fresnel),
            _ => None,
        }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "Material", &bytes(&self.0)?)
    }

    fn __repr__(&self) -> String {
        let name = if self.0.name.is_empty() { String::new() } else { format!(", name='{}'", self.0.name) };
        format!("Material(albedo={}, finish='{}'{name})", self.0.albedo, self.finish())
    }
}

/// A material with other fields.
fn with(mut material: stereotrace::Material, fields: Option<&Bound<'_, PyDict>>) -> PyResult<Material> {
    let Some(fields) = fields else { return Ok(Material(material)) };
    for (name, value) in fields {
        let name: String = name.extract()?;
        let of = |error: PyErr| refused(format!("material: {name}: {}", error.value(value.py())));
        let color = || value.extract::<Color>().map(|color| color.0);
        let number = || value.extract::<f32>().map_err(|_| refused(format!("{} must be a number", shown(&value))));
        let texture = || value.extract::<Option<u32>>().map(|id| id.map(TextureId));
        match &*name {
            "albedo" => material.albedo = color().map_err(of)?,
            "name" => material.name = value.extract().map_err(of)?,
            "texture" => material.texture = texture().map_err(of)?,
            "cutout" => material.cutout = texture().map_err(of)?,
            "opacity" => material.opacity = number().map_err(of)?,
            "specular" => material.specular = color().map_err(of)?,
            "exponent" => material.exponent = number().map_err(of)?,
            "normalised" => material.normalised = value.extract().map_err(of)?,
            "emission" => material.emission = color().map_err(of)?,
            "finish" => material.finish = finish(&value.extract::<String>().map_err(of)?)?,
            "index" | "transmission" | "fresnel" => {} // of the finish, which must be known first
            _ => {
                let known = FIELDS.iter().chain(&FINISH_FIELDS).copied().collect::<Vec<_>>().join(", ");
                return Err(refused(format!("material: unknown field '{name}'; there are {known}")));
            }
        }
    }
    for name in ["index", "transmission", "fresnel"] {
        let Some(value) = fields.get_item(name)? else { continue };
        let of = |error: PyErr| refused(format!("material: {name}: {}", error.value(value.py())));
        match (&mut material.finish, name) {
            (Finish::Glass { index, .. }, "index") => *index = value.extract().map_err(of)?,
            (Finish::Glass { transmission, .. }, "transmission") => {
                *transmission = value.extract::<Color>().map_err(of)?.0
            }
            (Finish::Glass { fresnel, .. } | Finish::Mirror { fresnel }, "fresnel") => {
                *fresnel = value.extract().map_err(of)?
            }
            (_, "fresnel") => {
                return Err(refused("material: fresnel is of mirrors and glass: give finish='mirror' or 'glass'"));
            }
            _ => return Err(refused(format!("material: {name} is of glass: give finish='glass'"))),
        }
    }
    Ok(Material(material))
}

/// Default specular reflectance of a finish.
fn default_specular(finish: &Finish) -> Vec3 {
    match *finish {
        Finish::Mirror { .. } => Vec3::splat(0.95),
        // Straight on (Fresnel).
        Finish::Glass { index, fresnel: true, .. } => Vec3::splat(((index - 1.0) / (index + 1.0)).powi(2)),
        _ => Vec3::ZERO,
    }
}

fn finish(name: &str) -> PyResult<Finish> {
    match name {
        "matte" => Ok(Finish::Matte),
        "mirror" => Ok(Finish::Mirror { fresnel: false }),
        "glass" => Ok(Finish::Glass { index: 1.5, transmission: Vec3::ONE, fresnel: true }),
        _ => Err(refused(format!("material: unknown finish '{name}'; there are matte, mirror and glass"))),
    }
}
