//! What lights a scene.

use glam::{DVec3, Vec3};

use super::{Scene, checks::check_coordinate};

/// Of lights that are not points a scene may have so many: what is known of their shadows is kept for each pixel.
pub const MAX_SOFT_LIGHTS: usize = 16;

/// The largest [`LightShape::Directional`] radius: all of the sky but for a rim.
const MOST_ANGLE: f32 = 1.5;

/// A light without falloff: all of it that is seen from a place is as bright there as from any other (thesis, chapter
/// 4).
///
/// ```
/// use stereotrace::{Light, glam::Vec3};
///
/// let bulb = Light::sphere(Vec3::new(0.0, 2.4, 0.0), 0.1, Vec3::splat(0.6));
/// let window = Light::rectangle(Vec3::new(-2.0, 1.5, 0.0), Vec3::new(0.0, 0.0, 0.8), Vec3::new(0.0, 0.6, 0.0), Vec3::splat(0.4));
/// let sun = Light::directional(Vec3::new(1.0, 2.0, 0.5), 0.0047, Vec3::new(0.9, 0.85, 0.7));
/// # let _ = (bulb, window, sun);
/// ```
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Light {
    /// World position of its middle; of a directional light the direction that leads to it, of any length but 0.
    pub position: DVec3,
    /// Radiance that all of it together adds to a white surface that faces it, linear RGB.
    pub intensity: Vec3,
    /// What throws the light.
    pub shape: LightShape,
}

/// What throws light. Lights are not seen themselves. All but points light by as many rays as
/// [`Options::shadow_rays`](crate::Options::shadow_rays) says, which end at places spread over them, so that shadows
/// have a penumbra.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum LightShape {
    /// One point. Shadows are sharp.
    #[default]
    Point,
    /// A ball, as the disc that is seen of it.
    Sphere {
        /// In world units, above 0.
        radius: f32,
    },
    /// A rectangle or parallelogram that shines to both sides, from each of its points to everywhere alike.
    Rectangle {
        /// From its middle to the middle of a side, world units.
        half_width: Vec3,
        /// From its middle to the middle of the next side.
        half_height: Vec3,
    },
    /// Infinitely far off: a sun.
    Directional {
        /// Angle from the middle of its disc to the rim, radians, 0 to 1.5; the sun's is 0.0047. 0: shadows are sharp.
        radius: f32,
    },
}

impl Light {
    /// A point at a world position: the radiance that it adds to a white surface that faces it, linear RGB.
    pub fn point(position: impl Into<DVec3>, intensity: Vec3) -> Self {
        Self { position: position.into(), intensity, shape: LightShape::Point }
    }

    /// A ball about a world position; the radius is in world units, above 0.
    pub fn sphere(position: impl Into<DVec3>, radius: f32, intensity: Vec3) -> Self {
        Self { position: position.into(), intensity, shape: LightShape::Sphere { radius } }
    }

    /// A rectangle or parallelogram about a world position, by the ways from there to the middles of two sides.
    pub fn rectangle(position: impl Into<DVec3>, half_width: Vec3, half_height: Vec3, intensity: Vec3) -> Self {
        Self { position: position.into(), intensity, shape: LightShape::Rectangle { half_width, half_height } }
    }

    /// Infinitely far off in a direction, of any length but 0; the disc's radius is an angle in radians, 0 for sharp
    /// shadows.
    pub fn directional(towards: impl Into<DVec3>, radius: f32, intensity: Vec3) -> Self {
        Self { position: towards.into(), intensity, shape: LightShape::Directional { radius } }
    }

    /// Whether it is not a point.
    pub(crate) fn is_soft(&self) -> bool {
        self.shape != LightShape::Point
    }

    /// Whether it throws sharp shadows, so that a ray says all.
    pub(crate) fn is_sharp(&self) -> bool {
        matches!(self.shape, LightShape::Point | LightShape::Directional { radius: 0.0 })
    }

    /// What is wrong with its place or shape, in a scene with this origin.
    pub(super) fn check(&self, origin: DVec3) -> Result<(), String> {
        let above_zero = |what: &str, length: f32| match length.is_finite() && length > 0.0 {
            true => Ok(()),
            false => Err(format!("{what} is {length}; it must be finite and above 0")),
        };
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
    /// A light's position relative to the origin; of a directional light the unit direction that leads to it.
    pub(crate) fn local_position(&self, light: &Light) -> Vec3 {
        match light.shape {
            LightShape::Directional { .. } => light.position.normalize_or_zero().as_vec3(),
            _ => self.local(light.position),
        }
    }

    /// Lights that are not points.
    pub(crate) fn soft_lights(&self) -> impl Iterator<Item = (usize, &Light)> {
        self.lights.iter().enumerate().filter(|(_, light)| light.is_soft())
    }
}
