//! Built-in scenes that need no download. Two are for viewing, four are hard for stereo methods, five consist of
//! ellipsoids, and three show spheres on an infinite ground.

pub(crate) mod hall;
pub(crate) mod marble;
#[cfg_attr(not(any(test, feature = "testing")), allow(unreachable_pub, reason = "tests make other scenes of the kind"))]
pub(crate) mod random;
pub(crate) mod shapes;
pub(crate) mod spheres;
#[cfg(any(test, feature = "testing"))]
pub(crate) mod stacked;
pub(crate) mod stage;

use glam::Vec3;

#[cfg(not(any(test, feature = "testing")))]
use self::random::RandomObjects;
#[cfg(any(test, feature = "testing"))]
pub use self::{
    random::RandomObjects,
    spheres::spheres_turned,
    stacked::{StackedKind, StackedObjects},
};
use self::{
    shapes::Shape,
    spheres::{CLOUD_SCREEN, spheres, three_camera, three_spheres},
};
use super::{Light, Material, MaterialId, Scene};
use crate::{StereoCamera, error::by_name};

/// Interaxial as a share of the picture's width: 15 pixels of 600, as in the thesis.
pub(crate) const INTERAXIAL_SHARE: f32 = 15.0 / 600.0;

/// Seed of the random scenes.
const SEED: u32 = 1993;

/// A built-in scene with lights, sky and a camera.
///
/// ```
/// use stereotrace::scene::builtin::Builtin;
///
/// let hall: Builtin = "hall".parse()?;
/// assert!(hall.scene().triangles().len() > 100_000);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Builtin {
    /// A thousand coloured spheres under a sky, none nearer than half the screen's distance.
    Spheres,
    /// A vaulted hall with columns, arches, banners and a tiled floor.
    Hall,
    /// The hall with a floor of polished marble, shining metal, spheres of glass and chrome, and lamps with soft
    /// shadows.
    HallFinished,
    /// A picket fence in front of a wall: every slat uncovers a strip of wall.
    Fence,
    /// A pillar that only the right eye sees; a board hides it from the left eye.
    Hidden,
    /// A sphere at a seventh of the screen's distance, nearer than the thesis allows.
    Near,
    /// Sheets that point at the left eye. They are edges to the left eye and surfaces to the right one.
    Grazing,
    /// Twelve ellipsoids and eight spheres at random positions over a checkerboard, after Adelson
    /// and Hodges 1993.
    Random20,
    /// A hundred ellipsoids over a checkerboard.
    Random100,
    /// 125 ellipsoids over a checkerboard.
    Random125,
    /// 125 ellipsoids over a checkerboard. A tenth of them are mirrors, a tenth glass.
    Random125Both,
    /// A thousand ellipsoids over a checkerboard.
    Random1000,
    /// Three stacked spheres on an infinite plane under one lamp, with shadows and highlights, after Raghuvanshi and
    /// Dhande.
    ThreeSpheres,
    /// The three spheres as mirrors.
    ThreeSpheresMirrors,
    /// The three mirror spheres with checkerboards on spheres and ground.
    ThreeSpheresTextured,
}

impl Builtin {
    /// All built-in scenes.
    pub const ALL: &'static [Self] = &[
        Self::Spheres,
        Self::Hall,
        Self::HallFinished,
        Self::Fence,
        Self::Hidden,
        Self::Near,
        Self::Grazing,
        Self::Random20,
        Self::Random100,
        Self::Random125,
        Self::Random125Both,
        Self::Random1000,
        Self::ThreeSpheres,
        Self::ThreeSpheresMirrors,
        Self::ThreeSpheresTextured,
    ];

    /// Returns the name for the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Spheres => "spheres",
            Self::Hall => "hall",
            Self::HallFinished => "hall-finished",
            Self::Fence => "fence",
            Self::Hidden => "hidden",
            Self::Near => "near",
            Self::Grazing => "grazing",
            Self::Random20 => "random-20",
            Self::Random100 => "random-100",
            Self::Random125 => "random-125",
            Self::Random125Both => "random-125-both",
            Self::Random1000 => "random-1000",
            Self::ThreeSpheres => "three-spheres",
            Self::ThreeSpheresMirrors => "three-spheres-mirrors",
            Self::ThreeSpheresTextured => "three-spheres-textured",
        }
    }

    /// Builds the scene. Each call gives the same scene.
    pub fn scene(self) -> Scene {
        match self {
            Self::Spheres => spheres(),
            Self::Hall => hall::scene(),
            Self::HallFinished => marble::hall(),
            Self::Fence => stage::fence(),
            Self::Hidden => stage::hidden(),
            Self::Near => stage::near(),
            Self::Grazing => stage::grazing(),
            Self::Random20 => RandomObjects::new(20, SEED).sphere_share(0.4).scene(),
            Self::Random100 => RandomObjects::new(100, SEED).scene(),
            Self::Random125 => RandomObjects::new(125, SEED).scene(),
            Self::Random125Both => RandomObjects::new(125, SEED).shares(0.1, 0.1).scene(),
            Self::Random1000 => RandomObjects::new(1000, SEED).scene(),
            Self::ThreeSpheres => three_spheres(false, false),
            Self::ThreeSpheresMirrors => three_spheres(true, false),
            Self::ThreeSpheresTextured => three_spheres(true, true),
        }
    }

    /// Returns the scene's camera. The interaxial is 15 pixels in a picture 600 pixels wide, and in proportion
    /// otherwise.
    pub fn camera(self, width: u32, height: u32) -> StereoCamera {
        let camera = match self {
            Self::Spheres => StereoCamera::look_at(Vec3::new(0.0, 0.0, CLOUD_SCREEN), Vec3::ZERO)
                .screen_distance(CLOUD_SCREEN)
                .vertical_fov_degrees(38.0),
            Self::Hall | Self::HallFinished => hall::camera(),
            Self::Near => stage::near_camera(),
            Self::Fence | Self::Hidden | Self::Grazing => stage::camera(),
            Self::Random20 | Self::Random100 | Self::Random125 | Self::Random125Both | Self::Random1000 => {
                random::camera()
            }
            Self::ThreeSpheres | Self::ThreeSpheresMirrors | Self::ThreeSpheresTextured => three_camera(),
        };
        camera.size(width, height).interaxial_pixels(INTERAXIAL_SHARE * width as f32)
    }
}

by_name!(Builtin, "built-in scene");

pub(crate) fn add(scene: &mut Scene, shape: Shape) {
    scene.add_mesh(&shape.into_mesh()).expect("a shape's lists fit each other and its points are finite");
}

/// Adds a material with a colour in approximate sRGB, 0 to 255.
pub(crate) fn paint(scene: &mut Scene, name: &str, srgb: [u8; 3]) -> MaterialId {
    let linear = srgb.map(|channel| (f32::from(channel) / 255.0).powf(2.2));
    scene.add_material(Material::new(Vec3::from_array(linear)).name(name))
}

pub(crate) fn lamp(position: [f32; 3], strength: f32, color: [f32; 3]) -> Light {
    Light::point(Vec3::from_array(position), Vec3::from_array(color) * strength)
}

#[cfg(test)]
mod tests;
