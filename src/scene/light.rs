//! Lights.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{DVec3, Vec3};

use super::{
    Scene, TextureId,
    checks::{check_coordinate, check_texture},
};

/// Maximum number of lights in a scene that are not points. Their shadows are stored for each pixel.
pub const MAX_SOFT_LIGHTS: usize = 16;

/// Largest [`LightShape::Directional`] radius: nearly a hemisphere.
const MOST_ANGLE: f32 = 1.5;

/// Smallest [`Projector::fov`], in radians.
const LEAST_FOV: f32 = 1e-3;

/// Smallest sine of the angle between a projector's direction and its `up`.
const LEAST_TURN: f64 = 1e-4;

/// A light. Without [`Light::falloff`], it is equally bright at any distance (thesis, chapter 4).
///
/// ```
/// use stereotrace::{Light, glam::Vec3};
///
/// let bulb = Light::sphere(Vec3::new(0.0, 2.4, 0.0), 0.1, Vec3::splat(0.6));
/// let sides = [Vec3::new(0.0, 0.0, 0.8), Vec3::new(0.0, 0.6, 0.0)];
/// let window = Light::rectangle(Vec3::new(-2.0, 1.5, 0.0), sides[0], sides[1], Vec3::splat(0.4));
/// let sun = Light::directional(Vec3::new(1.0, 2.0, 0.5), 0.0047, Vec3::new(0.9, 0.85, 0.7));
/// let spot = Light::point(Vec3::Y, Vec3::splat(2.0)).with_quadratic_falloff().with_cone(-Vec3::Y, 0.3, 0.4);
/// # let _ = (bulb, window, sun, spot);
/// ```
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Light {
    /// World position of the centre. For a directional light it is the direction towards the light, of any length but
    /// 0.
    pub position: DVec3,
    /// Radiance that the whole light adds to a white surface facing it, linear RGB. With quadratic falloff, it is that
    /// radiance at a distance of 1 world unit: the radiant intensity divided by π.
    pub intensity: Vec3,
    /// Shape of the light.
    pub shape: LightShape,
    /// Change of the light's brightness with distance.
    #[cfg_attr(feature = "serde", serde(default))]
    pub falloff: Falloff,
    /// Cone outside which the light does not shine, for points and spheres.
    #[cfg_attr(feature = "serde", serde(default))]
    pub cone: Option<Cone>,
    /// Picture that a point light projects.
    #[cfg_attr(feature = "serde", serde(default))]
    pub projector: Option<Projector>,
}

/// Change of a light's brightness with distance.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Falloff {
    /// The light is equally bright at any distance.
    #[default]
    None,
    /// Brightness falls with the square of the distance, as in nature. A sphere of radiance `L` and radius `r` then has
    /// the intensity `L r²`. A rectangle emits as a diffuse surface, on the side that the cross product of its half
    /// width and half height points to. With radiance `L` and area `A` its intensity is `L A / π`.
    Quadratic {
        /// Distance in world units, above 0, at which the light ends. The light is multiplied by `1 - (distance /
        /// range)⁴`, as in `KHR_lights_punctual`.
        range: Option<f32>,
    },
}

/// Cone of a spot light. Brightness is full up to the inner angle and 0 from the outer angle on. In between it follows
/// `KHR_lights_punctual`: the square of a linear function of the angle's cosine.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// World direction of the cone's axis away from the light, of any length but 0.
    pub direction: Vec3,
    /// Angle from the axis in radians, 0 or more and less than `outer`.
    pub inner: f32,
    /// Angle from the axis in radians, at most π/2.
    pub outer: f32,
}

/// Picture that a point light projects: a slide, a light pattern for stereo matching, or structured light. Its linear
/// colour multiplies the light's intensity, and its alpha is ignored. There is no light outside the picture. Seen from
/// the light, the picture on a wall is upright and not mirrored.
///
/// Pixels are square, so the vertical field of view follows from the picture's sides. A checkerboard is a square. The
/// picture's full size is filtered bilinearly, at any distance: finer detail than a view's pixels needs
/// [`Options::samples`](crate::Options::samples). Falloff and a cone about any axis apply too.
///
/// ```
/// use stereotrace::{Builtin, Light, Texture, glam::Vec3};
///
/// let mut scene = Builtin::Hall.scene();
/// let dots = scene.add_texture(Texture::dots(1280, 800, 5000, 1)?);
/// let eye = Vec3::new(0.75, 1.75, -4.0);
/// scene.lights = vec![Light::point(eye, Vec3::splat(4.0)).with_projector(dots, Vec3::NEG_Z, Vec3::Y, 1.2)];
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projector {
    /// The picture, one of [`Scene::textures`]. Its wrap mode is ignored.
    pub texture: TextureId,
    /// World direction from the light to the middle of the picture, of any length but 0.
    pub direction: Vec3,
    /// World direction that is up in the picture, of any length but 0 and not parallel to `direction`. Only its part
    /// perpendicular to `direction` counts.
    pub up: Vec3,
    /// Full horizontal field of view in radians, at least 0.001 and less than π.
    pub fov: f32,
}

/// Shape of a light. Lights are invisible themselves. All shapes except points are sampled by
/// [`Options::shadow_rays`](crate::Options::shadow_rays) rays to places spread over them, so their shadows have a
/// penumbra.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum LightShape {
    /// A point. Shadows are sharp.
    #[default]
    Point,
    /// A sphere, sampled as the disc that faces the surface.
    Sphere {
        /// Radius in world units, above 0.
        radius: f32,
    },
    /// A rectangle or parallelogram that emits on both sides, equally in all directions.
    Rectangle {
        /// Vector from the centre to the middle of a side, world units.
        half_width: Vec3,
        /// Vector from the centre to the middle of the next side, world units.
        half_height: Vec3,
    },
    /// A disc at infinity, such as the sun.
    Directional {
        /// Angle from the disc's centre to its rim in radians, 0 to 1.5; the sun's is 0.0047. A radius of 0 gives sharp
        /// shadows.
        radius: f32,
    },
}

impl Light {
    /// Makes a point light from its world position and the radiance that it adds to a white surface facing it, linear
    /// RGB.
    pub fn point(position: impl Into<DVec3>, intensity: Vec3) -> Self {
        Self::of(LightShape::Point, position.into(), intensity)
    }

    /// Makes a spherical light from its centre in world coordinates and its radius in world units, above 0.
    pub fn sphere(position: impl Into<DVec3>, radius: f32, intensity: Vec3) -> Self {
        Self::of(LightShape::Sphere { radius }, position.into(), intensity)
    }

    /// Makes a rectangle or parallelogram from its centre in world coordinates and the vectors from there to the
    /// middles of two sides.
    pub fn rectangle(position: impl Into<DVec3>, half_width: Vec3, half_height: Vec3, intensity: Vec3) -> Self {
        Self::of(LightShape::Rectangle { half_width, half_height }, position.into(), intensity)
    }

    /// Makes a light at infinity from the direction towards it, of any length but 0. The radius is an angle in radians,
    /// 0 for sharp shadows.
    pub fn directional(towards: impl Into<DVec3>, radius: f32, intensity: Vec3) -> Self {
        Self::of(LightShape::Directional { radius }, towards.into(), intensity)
    }

    fn of(shape: LightShape, position: DVec3, intensity: Vec3) -> Self {
        Self { position, intensity, shape, falloff: Falloff::None, cone: None, projector: None }
    }

    /// Lets the brightness fall with the square of the distance. A directional light has no falloff.
    #[must_use]
    pub fn with_quadratic_falloff(mut self) -> Self {
        self.falloff = Falloff::Quadratic { range: None };
        self
    }

    /// Restricts a point or spherical light to a cone. `direction` is the world direction of its axis, of any length
    /// but 0. The angles from the axis are in radians: `inner` is less than `outer`, and `outer` is at most π/2.
    #[must_use]
    pub fn with_cone(mut self, direction: Vec3, inner: f32, outer: f32) -> Self {
        self.cone = Some(Cone { direction, inner, outer });
        self
    }

    /// Lets a point light project a picture, as [`Projector`] explains. `direction` leads from the light to the
    /// picture's middle and `up` is up in the picture, both world directions of any length but 0. `fov` is the full
    /// horizontal field of view in radians, at least 0.001 and less than π.
    #[must_use]
    pub fn with_projector(mut self, texture: TextureId, direction: Vec3, up: Vec3, fov: f32) -> Self {
        self.projector = Some(Projector { texture, direction, up, fov });
        self
    }

    /// Returns whether the light is not a point.
    pub(crate) fn is_soft(&self) -> bool {
        self.shape != LightShape::Point
    }

    /// Returns whether its shadows are sharp, so that one ray suffices.
    pub(crate) fn is_sharp(&self) -> bool {
        matches!(self.shape, LightShape::Point | LightShape::Directional { radius: 0.0 })
    }

    /// Returns whether its brightness depends on distance or direction.
    pub(crate) fn is_fading(&self) -> bool {
        self.falloff != Falloff::None || self.cone.is_some()
    }

    /// Checks position, shape, falloff, cone and projector, in a scene with this origin and number of textures.
    pub(crate) fn check(&self, origin: DVec3, textures: usize) -> Result<(), String> {
        let above_zero = |what: &str, length: f32| match length.is_finite() && length > 0.0 {
            true => Ok(()),
            false => Err(format!("{what} is {length}; it must be finite and above 0")),
        };
        match (self.falloff, self.shape) {
            (Falloff::None, _) => {}
            (_, LightShape::Directional { .. }) => return Err("a directional light has no falloff".to_owned()),
            (Falloff::Quadratic { range }, _) => range.map_or(Ok(()), |range| above_zero("range", range))?,
        }
        if let Some(Cone { direction, inner, outer }) = self.cone {
            if !matches!(self.shape, LightShape::Point | LightShape::Sphere { .. }) {
                return Err("only points and spheres have a cone".to_owned());
            }
            above_zero("the length of the cone's direction", direction.length())?;
            if !(inner >= 0.0 && inner < outer && outer <= FRAC_PI_2) {
                return Err(format!(
                    "the cone's angles are {inner} and {outer}; inner must be at least 0 and less than outer, and \
                     outer at most {FRAC_PI_2}"
                ));
            }
        }
        if let Some(Projector { texture, direction, up, fov }) = self.projector {
            if self.shape != LightShape::Point {
                return Err("only points have a projector".to_owned());
            }
            check_texture("the projector's texture", texture, textures)?;
            above_zero("the length of the projector's direction", direction.length())?;
            above_zero("the length of the projector's up", up.length())?;
            if direction.as_dvec3().normalize().cross(up.as_dvec3().normalize()).length() < LEAST_TURN {
                return Err(format!("the projector's up {up} is parallel to its direction {direction}"));
            }
            if !(LEAST_FOV..PI).contains(&fov) {
                return Err(format!(
                    "the projector's field of view is {fov}; it must be at least {LEAST_FOV} and less than π radians"
                ));
            }
        }
        match self.shape {
            LightShape::Directional { radius } => {
                above_zero("the direction's length", self.position.length() as f32)?;
                match (0.0..=MOST_ANGLE).contains(&radius) {
                    true => return Ok(()),
                    false => {
                        return Err(format!("radius is {radius}; it must be an angle of 0 to {MOST_ANGLE} radians"));
                    }
                }
            }
            LightShape::Point => {}
            LightShape::Sphere { radius } => {
                above_zero("radius", radius)?;
                check_coordinate(Vec3::splat(radius))?;
            }
            LightShape::Rectangle { half_width, half_height } => {
                check_coordinate(half_width)?;
                check_coordinate(half_height)?;
                let area = half_width.as_dvec3().cross(half_height.as_dvec3()).length() as f32;
                above_zero("the rectangle's area", area)?;
            }
        }
        check_coordinate((self.position - origin).as_vec3())
    }
}

impl Scene {
    /// Returns a light's position relative to the origin, or the unit direction towards a directional light.
    pub(crate) fn local_position(&self, light: &Light) -> Vec3 {
        match light.shape {
            LightShape::Directional { .. } => light.position.normalize_or_zero().as_vec3(),
            _ => self.local(light.position),
        }
    }

    /// Multiplies the emission of all materials.
    #[cfg(feature = "gltf")]
    pub(crate) fn dim_emission(&mut self, factor: f32) {
        for material in &mut self.materials {
            material.emission *= factor;
            if let Some(surface) = &mut material.principled {
                surface.emission *= factor;
            }
        }
    }

    /// Returns whether the brightness of some light depends on distance or direction.
    pub(crate) fn has_fading_lights(&self) -> bool {
        self.lights.iter().any(Light::is_fading)
    }

    /// Returns whether some light projects a picture.
    pub(crate) fn has_projectors(&self) -> bool {
        self.lights.iter().any(|light| light.projector.is_some())
    }

    /// Returns the lights that are not points, with their indices.
    pub(crate) fn soft_lights(&self) -> impl Iterator<Item = (usize, &Light)> {
        self.lights.iter().enumerate().filter(|(_, light)| light.is_soft())
    }
}
