//! Materials.

use pyo3::{prelude::*, types::PyDict};
use stereotrace::{Finish, Principled, TextureId, glam::Vec3};

use crate::{
    errors::refused,
    pickled::{Reduced, bytes, reduced},
    values::{Color, shown, tuple},
};

/// Fields that the constructor and `replace` take.
const FIELDS: [&str; 12] = [
    "albedo",
    "name",
    "texture",
    "cutout",
    "opacity",
    "alpha_blend",
    "specular",
    "exponent",
    "normalised",
    "emission",
    "finish",
    "index",
];
/// Fields that leave a physically based surface as it is.
const COMMON_FIELDS: [&str; 5] = ["name", "texture", "cutout", "opacity", "alpha_blend"];
/// Fields of mirrors and glass only.
const FINISH_FIELDS: [&str; 2] = ["transmission", "fresnel"];

/// A surface: diffuse reflectance, highlights, reflection, transmission and emission.
///
/// ``Material()`` is grey, matte and opaque, with albedo 0.7. Colours are linear RGB, 0 to 1; one number stands for
/// three equal channels. The fields are keywords; ``albedo`` may also be the first argument:
///
/// - ``albedo``: diffuse (Lambertian) reflectance. Default 0.7, or black for mirrors and glass.
/// - ``name``: name in messages. Default empty.
/// - ``texture``: id of a texture that multiplies the albedo. Default ``None``.
/// - ``cutout``: id of a texture that cuts the surface out where its alpha is below a half; triangles only. Default
///   ``None``.
/// - ``opacity``: share of the background that the surface hides, 0 to 1. Default 1.
/// - ``alpha_blend``: whether the alpha of ``texture`` multiplies the opacity. Default ``False``.
/// - ``specular``: colour of highlights, or reflectance of mirrors and glass. Default 0.95 for mirrors; for glass with
///   ``fresnel`` its reflectance at normal incidence by ``index`` (0.04 for 1.5); else black.
/// - ``exponent``: Phong's exponent, 0 to 10000; larger values make smaller highlights. Default 30.
/// - ``normalised``: whether highlights conserve energy, so that ``specular`` is the reflected share of a light.
///   Default ``False``.
/// - ``emission``: emitted radiance, 0 or more. It lights other surfaces only by paths. Default black.
/// - ``finish``: ``"matte"``, ``"mirror"``, which reflects the surroundings, or ``"glass"``, which refracts rays.
///   Default ``"matte"``.
/// - ``index``: refractive index of glass, relative to the surrounding medium, 0.1 to 10. Default 1.5.
/// - ``transmission``: share of light that glass transmits. Default white.
/// - ``fresnel``: whether the reflectance of a mirror or glass depends on the angle. Mirrors then reflect more at
///   grazing angles, and glass transmits what it does not reflect. Default ``False`` for mirrors, ``True`` for glass.
///
/// Materials are immutable: ``replace`` makes changed copies. They compare by value and can be pickled. Raises
/// ``ValueError`` for unknown fields, fields of another finish and values of another type. Rendering checks the ranges:
/// scattered, reflected and transmitted shares may add up to at most 1 in each channel.
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
        // Mirrors and glass return nearly all light. With the grey albedo they would return more than they receive.
        if albedo.is_none() && material.finish != Finish::Matte {
            material.albedo = Vec3::ZERO;
        }
        if !fields.is_some_and(|fields| fields.contains("specular").unwrap_or(false)) {
            material.specular = default_specular(&material.finish);
        }
        Ok(Self(material))
    }

    /// Makes a physically based surface (metallic-roughness, as glTF 2.0 has it), which paths of light show
    /// (``lighting="paths"``). Direct light shows Phong's approximation of it.
    ///
    /// - ``base``: diffuse reflectance of a dielectric, or reflectance of a metal, linear RGB, 0 to 1. Default 0.8.
    /// - ``metallic``: 0 for a dielectric, 1 for a metal. Default 0.
    /// - ``roughness``: 0, smooth, to 1. Default 0.5.
    /// - ``index``: refractive index of a dielectric, 0.1 to 10. Default 1.5.
    /// - ``specular``: factor of a dielectric's reflectance, 0 to 1. Default 1.
    /// - ``specular_color``: further factor at normal incidence, linear RGB, 0 to 1. Default 1.
    /// - ``transmission``: share of the light that enters a dielectric and is transmitted, 0 to 1. Default 0.
    /// - ``thin``: whether transmitted light is not refracted. Default ``False``.
    /// - ``absorption``: light that is absorbed inside per world unit, linear RGB. Default 0.
    /// - ``clearcoat`` and ``clearcoat_roughness``: share of the surface under a clear coat, and its roughness, 0 to 1.
    ///   Default 0.
    /// - ``emission``: emitted radiance, linear RGB. Default 0.
    /// - ``texture``, ``roughness_texture`` (green), ``metallic_texture`` (blue), ``normal_texture``,
    ///   ``emission_texture``, ``transmission_texture`` (red), ``clearcoat_texture`` (red) and
    ///   ``clearcoat_roughness_texture`` (green): ids of textures. They multiply the values of these names; ``texture``
    ///   multiplies ``base``. Default ``None``.
    /// - ``normal_scale``: factor of the normals' x and y. Default 1.
    /// - ``name``, ``cutout``, ``opacity``, ``alpha_blend``: as in ``Material``.
    ///
    /// Raises ``ValueError`` as ``Material`` does.
    #[staticmethod]
    #[pyo3(signature = (base = None, **fields))]
    fn principled(py: Python<'_>, base: Option<Color>, fields: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut surface = Principled::new(base.map_or(Vec3::splat(0.8), |base| base.0), 0.0, 0.5);
        // `grazing` holds the factor until the end, and `specular` its colour.
        let others = PyDict::new(py);
        for (name, value) in fields.into_iter().flatten() {
            if !set(&mut surface, &name.extract::<String>()?, &value)? {
                others.set_item(name, value)?;
            }
        }
        if let Some((name, _)) =
            others.iter().find(|(name, _)| !COMMON_FIELDS.iter().any(|known| name.eq(*known).unwrap_or(false)))
        {
            return Err(refused(format!("Material.principled: unknown field '{name}'")));
        }
        surface.specular *= surface.grazing;
        with(stereotrace::Material::new(Vec3::ZERO).principled(surface), Some(&others))
    }

    /// Returns a copy with other fields: the keywords of ``Material``. If ``finish`` is given, ``index``,
    /// ``transmission`` and ``fresnel`` get their defaults unless they are given too. Raises ``ValueError`` as
    /// ``Material`` does.
    #[pyo3(signature = (**fields))]
    fn replace(&self, fields: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        with(self.0.clone(), fields)
    }

    /// Name in messages; may be empty.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// Diffuse reflectance, linear RGB: a tuple of three.
    #[getter]
    fn albedo(&self) -> (f32, f32, f32) {
        tuple(self.0.albedo)
    }

    /// Id of the texture that multiplies the albedo, or ``None``.
    #[getter]
    fn texture(&self) -> Option<u32> {
        self.0.texture.map(|id| id.0)
    }

    /// Id of the texture that cuts the surface out where its alpha is below a half, or ``None``.
    #[getter]
    fn cutout(&self) -> Option<u32> {
        self.0.cutout.map(|id| id.0)
    }

    /// Share of the background that the surface hides, 0 to 1.
    #[getter]
    fn opacity(&self) -> f32 {
        self.0.opacity
    }

    /// Whether the alpha of ``texture`` multiplies the opacity.
    #[getter]
    fn alpha_blend(&self) -> bool {
        self.0.alpha_blend
    }

    /// Colour of highlights, or reflectance of mirrors and glass, linear RGB: a tuple of three.
    #[getter]
    fn specular(&self) -> (f32, f32, f32) {
        tuple(self.0.specular)
    }

    /// Phong's exponent; larger values make smaller highlights.
    #[getter]
    fn exponent(&self) -> f32 {
        self.0.exponent
    }

    /// Whether highlights conserve energy.
    #[getter]
    fn normalised(&self) -> bool {
        self.0.normalised
    }

    /// Emitted radiance, linear RGB: a tuple of three.
    #[getter]
    fn emission(&self) -> (f32, f32, f32) {
        tuple(self.0.emission)
    }

    /// Finish: ``"matte"``, ``"mirror"`` or ``"glass"``.
    #[getter]
    fn finish(&self) -> &'static str {
        match self.0.finish {
            Finish::Matte => "matte",
            Finish::Mirror { .. } => "mirror",
            Finish::Glass { .. } => "glass",
            _ => "other",
        }
    }

    /// Refractive index of glass, relative to the surrounding medium; ``None`` for other materials.
    #[getter]
    fn index(&self) -> Option<f32> {
        if let Finish::Glass { index, .. } = self.0.finish { Some(index) } else { None }
    }

    /// Share of light that glass transmits, linear RGB: a tuple of three; ``None`` for other materials.
    #[getter]
    fn transmission(&self) -> Option<(f32, f32, f32)> {
        if let Finish::Glass { transmission, .. } = self.0.finish { Some(tuple(transmission)) } else { None }
    }

    /// Whether the reflectance of a mirror or glass depends on the angle; ``None`` for matte materials.
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

/// Sets a field of a physically based surface. Returns whether there is one of this name.
fn set(surface: &mut Principled, name: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    let of = |error: PyErr| refused(format!("Material.principled: {name}: {}", error.value(value.py())));
    let color = || value.extract::<Color>().map(|color| color.0).map_err(of);
    let number = || value.extract::<f32>().map_err(|_| of(refused(format!("{} must be a number", shown(value)))));
    let texture = || value.extract::<Option<u32>>().map(|id| id.map(TextureId)).map_err(of);
    match name {
        "metallic" => surface.metallic = number()?,
        "roughness" => surface.roughness = number()?,
        "index" => surface.index = number()?,
        "specular" => surface.grazing = number()?,
        "specular_color" => surface.specular = color()?,
        "transmission" => surface.transmission = number()?,
        "thin" => surface.thin = value.extract().map_err(of)?,
        "absorption" => surface.absorption = color()?,
        "clearcoat" => surface.clearcoat = number()?,
        "clearcoat_roughness" => surface.clearcoat_roughness = number()?,
        "emission" => surface.emission = color()?,
        "normal_scale" => surface.normal_scale = number()?,
        "roughness_texture" => surface.roughness_texture = texture()?,
        "metallic_texture" => surface.metallic_texture = texture()?,
        "normal_texture" => surface.normal_texture = texture()?,
        "emission_texture" => surface.emission_texture = texture()?,
        "transmission_texture" => surface.transmission_texture = texture()?,
        "clearcoat_texture" => surface.clearcoat_texture = texture()?,
        "clearcoat_roughness_texture" => surface.clearcoat_roughness_texture = texture()?,
        _ => return Ok(false),
    }
    Ok(true)
}

/// Returns the material with other fields.
fn with(mut material: stereotrace::Material, fields: Option<&Bound<'_, PyDict>>) -> PyResult<Material> {
    let Some(fields) = fields else { return Ok(Material(material)) };
    for (name, value) in fields {
        let name: String = name.extract()?;
        // Paths would show the surface's earlier values.
        if !COMMON_FIELDS.contains(&&*name) {
            material.principled = None;
        }
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
            "alpha_blend" => material.alpha_blend = value.extract().map_err(of)?,
            "specular" => material.specular = color().map_err(of)?,
            "exponent" => material.exponent = number().map_err(of)?,
            "normalised" => material.normalised = value.extract().map_err(of)?,
            "emission" => material.emission = color().map_err(of)?,
            "finish" => material.finish = finish(&value.extract::<String>().map_err(of)?)?,
            "index" | "transmission" | "fresnel" => {} // read below, once the finish is known
            _ => {
                let known = FIELDS.iter().chain(&FINISH_FIELDS).copied().collect::<Vec<_>>().join(", ");
                return Err(refused(format!("material: unknown field '{name}'; the fields are {known}")));
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
                return Err(refused("material: fresnel applies to mirrors and glass: give finish='mirror' or 'glass'"));
            }
            _ => return Err(refused(format!("material: {name} applies to glass: give finish='glass'"))),
        }
    }
    Ok(Material(material))
}

/// Returns the default specular reflectance of a finish.
fn default_specular(finish: &Finish) -> Vec3 {
    match *finish {
        Finish::Mirror { .. } => Vec3::splat(0.95),
        // Fresnel reflectance at normal incidence.
        Finish::Glass { index, fresnel: true, .. } => Vec3::splat(((index - 1.0) / (index + 1.0)).powi(2)),
        _ => Vec3::ZERO,
    }
}

fn finish(name: &str) -> PyResult<Finish> {
    match name {
        "matte" => Ok(Finish::Matte),
        "mirror" => Ok(Finish::Mirror { fresnel: false }),
        "glass" => Ok(Finish::Glass { index: 1.5, transmission: Vec3::ONE, fresnel: true }),
        _ => Err(refused(format!("material: unknown finish '{name}'; use matte, mirror or glass"))),
    }
}
