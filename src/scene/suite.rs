//! Scenes that are hard on methods which reuse one eye's picture for the other: each is a [`Trial`].

mod scales;
mod space;
mod surfaces;
mod thin;

use std::{f32::consts::TAU, fmt, str::FromStr};

use glam::Vec3;

use super::{
    Finish, Light, MaterialId, Scene,
    builtin::{Builtin, INTERAXIAL_SHARE, stage},
};
use crate::{Error, StereoCamera};

/// A scene that is hard on methods which reuse one eye's picture for the other.
///
/// ```
/// use stereotrace::scene::suite::Trial;
///
/// let wires: Trial = "wires".parse()?;
/// println!("{wires}: {}", wires.reason());
/// assert!(wires.scene().primitive_count() > 1000);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Trial {
    /// [`Builtin::Fence`]: every slat uncovers a strip of wall, so that many short gaps must be found and traced.
    Fence,
    /// [`Builtin::Hidden`]: a pillar that only the right eye sees. No left sample knows of it, and a method that
    /// trusts what lands in its place shows the wall through it.
    Hidden,
    /// [`Builtin::Near`]: a ball so near that its parallax is six times the distance between the eyes, beyond the
    /// buffers that are made for half the screen's distance.
    Near,
    /// [`Builtin::Grazing`]: sheets that are edges to the left eye. What the right eye sees on them lies between two
    /// left samples.
    Grazing,
    /// Ribbons, slivers and chains of spheres 0.2 to 0.9 pixels wide (of 600) before a wall. One eye's samples meet a
    /// wire where the other's pass it by, and the sample on the wall beside it passes every check.
    Wires,
    /// Thousands of curved strands, 0.1 to 0.5 pixels wide, on a ball: nearly every pixel is an edge, and the two
    /// eyes' samples seldom meet the same strand.
    Hair,
    /// Crowns of squares that masks cut leaves out of: their shadows are dapples, many of them narrower than the
    /// distance between the left eye's samples.
    Foliage,
    /// Cables over a street, far from what they throw their shadows on.
    Cables,
    /// A plate with fins and bars that are narrower than a pixel or little wider, close to what they throw their
    /// shadows on.
    Strips,
    /// A thin wall between the eyes, from their plane into the depth. Each eye sees one side of it and one half of
    /// the scene, so that the left view holds next to nothing of the right one.
    Septum,
    /// A floor of 40,000 raised tiles to the horizon. It is smooth in depth, so that samples are reused, but colours
    /// change within a pixel.
    Checkerboard,
    /// Spheres with windows, one in the other: a pixel looks through several windows at once, and the eyes look
    /// through different ones.
    Shells,
    /// Pairs of plates a thousandth and a hundred-thousandth of their distance apart, the front ones with holes.
    /// Verification rays that end short of their point, or parallax, can't tell one plate from the other.
    Plates,
    /// Surfaces in the same place in two colours: a mesh twice, a sphere twice, quads that overlap in a plane. Only the
    /// rule for equal distances says which one is seen, and both eyes and all kernels must keep to it.
    Coincident,
    /// Walls of large panels beside finely divided ones, whose vertices lie on (or just off) the large panels' edges:
    /// rays slip through cracks that one eye sees and the other does not.
    TJunctions,
    /// Triangles of 10,000 units and of 0.0001 in one picture. Tolerances that are fixed numbers, or shares of the
    /// scene's size, are too large for the one or too small for the other.
    MixedSizes,
    /// Floor, wall, ball, spheres and box at a thousandth of their size: tolerances in world units are too large here.
    ScaleSmall,
    /// The same at a million times their size: tolerances in world units are too small here, and products of
    /// coordinates are large.
    ScaleLarge,
    /// The same 100,000 units away from the origin along each axis, where f32 places vertices and rays half a pixel
    /// apart: a point that is computed twice is not in the same place twice.
    FarOff,
    /// Things near and far from eyes half a picture apart: half of the left view lands outside the right one, and
    /// many left samples compete for one pixel.
    HalfWidth,
    /// The left eye within a ball with a window, the right eye outside it, and both within a sphere around it all.
    /// Parallax reaches the width of many pictures, and the right view's surroundings are hidden from the left eye.
    Inside,
    /// A post nearer than the screen, just beside the left eye's picture and within the right eye's. What the left eye
    /// sees behind it lands where it stands, without a gap, so that a method which traces gaps alone shows the wall
    /// through it: figure 14 of Adelson and Hodges 1993, the one case in which they say that theirs fails.
    Wings,
}

impl Trial {
    /// All of them.
    pub const ALL: &'static [Self] = &[
        Self::Fence,
        Self::Hidden,
        Self::Near,
        Self::Grazing,
        Self::Wires,
        Self::Hair,
        Self::Foliage,
        Self::Cables,
        Self::Strips,
        Self::Septum,
        Self::Checkerboard,
        Self::Shells,
        Self::Plates,
        Self::Coincident,
        Self::TJunctions,
        Self::MixedSizes,
        Self::ScaleSmall,
        Self::ScaleLarge,
        Self::FarOff,
        Self::HalfWidth,
        Self::Inside,
        Self::Wings,
    ];

    /// The name it has on a command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fence => "fence",
            Self::Hidden => "hidden",
            Self::Near => "near",
            Self::Grazing => "grazing",
            Self::Wires => "wires",
            Self::Hair => "hair",
            Self::Foliage => "foliage",
            Self::Cables => "cables",
            Self::Strips => "strips",
            Self::Septum => "septum",
            Self::Checkerboard => "checkerboard",
            Self::Shells => "shells",
            Self::Plates => "plates",
            Self::Coincident => "coincident",
            Self::TJunctions => "t-junctions",
            Self::MixedSizes => "mixed-sizes",
            Self::ScaleSmall => "scale-small",
            Self::ScaleLarge => "scale-large",
            Self::FarOff => "far-off",
            Self::HalfWidth => "half-width",
            Self::Inside => "inside",
            Self::Wings => "wings",
        }
    }

    /// Why methods fail here, in one line.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Fence => "every slat uncovers a strip of wall",
            Self::Hidden => "only the right eye sees the pillar",
            Self::Near => "parallax of six times the distance between the eyes",
            Self::Grazing => "what the right eye sees lies between two left samples",
            Self::Wires => "wires pass between one eye's samples and not the other's",
            Self::Hair => "nearly every pixel is an edge",
            Self::Foliage => "masks throw shadows narrower than a pixel",
            Self::Cables => "cables far above the street throw narrow shadows",
            Self::Strips => "fins and bars throw narrow shadows close by",
            Self::Septum => "the eyes see different sides and halves of the scene",
            Self::Checkerboard => "smooth in depth, but colours change within a pixel",
            Self::Shells => "the eyes look through different windows",
            Self::Plates => "two surfaces closer together than a check can tell",
            Self::Coincident => "two surfaces in one place: a rule must say which is seen",
            Self::TJunctions => "cracks that one eye sees and the other does not",
            Self::MixedSizes => "no fixed tolerance fits triangles of 10,000 and of 0.0001 units",
            Self::ScaleSmall => "tolerances in world units are too large",
            Self::ScaleLarge => "tolerances in world units are too small",
            Self::FarOff => "f32 places vertices and rays half a pixel apart",
            Self::HalfWidth => "half of the left view lands outside the right one",
            Self::Inside => "a ball hides the right view's surroundings from the left eye",
            Self::Wings => "a post beside the left eye's picture hides what both eyes see",
        }
    }

    /// Builds the scene, the same one each time.
    pub fn scene(self) -> Scene {
        match self {
            Self::Fence => Builtin::Fence.scene(),
            Self::Hidden => Builtin::Hidden.scene(),
            Self::Near => Builtin::Near.scene(),
            Self::Grazing => Builtin::Grazing.scene(),
            Self::Wires => thin::wires(),
            Self::Hair => thin::hair(),
            Self::Foliage => thin::foliage(),
            Self::Cables => thin::cables(),
            Self::Strips => thin::strips(),
            Self::Septum => space::septum(),
            Self::Checkerboard => space::checkerboard(),
            Self::Shells => surfaces::shells(),
            Self::Plates => surfaces::plates(),
            Self::Coincident => surfaces::coincident(),
            Self::TJunctions => surfaces::t_junctions(),
            Self::MixedSizes => scales::mixed_sizes(),
            Self::ScaleSmall => scales::SMALL.scene(),
            Self::ScaleLarge => scales::LARGE.scene(),
            Self::FarOff => scales::FAR_OFF.scene(),
            Self::HalfWidth => space::half_width(),
            Self::Inside => space::inside(),
            Self::Wings => space::wings(),
        }
    }

    /// The same with what makes a picture dear: every second of its materials is half a mirror, and its lights are
    /// balls of a 200th of its diagonal.
    pub fn rich_scene(self) -> Scene {
        let mut scene = self.scene();
        for index in (1..scene.materials().len() as u32).step_by(2) {
            let id = MaterialId(index);
            let mut mirror = scene.materials()[index as usize].clone();
            (mirror.albedo, mirror.specular) = (0.5 * mirror.albedo, Vec3::splat(0.5));
            mirror.finish = Finish::Mirror { fresnel: false };
            scene.set_material(id, mirror).expect("a material that is there");
        }
        let diagonal = scene.local_bounds().map_or(0.0, |(low, high)| low.distance(high));
        for light in &mut scene.lights {
            *light = Light::sphere(light.position, 0.005 * diagonal, light.intensity);
        }
        scene
    }

    /// The camera that goes with it; the eyes are 15 pixels apart in a picture 600 pixels wide, and so in proportion,
    /// but in [`Trial::HalfWidth`].
    pub fn camera(self, width: u32, height: u32) -> StereoCamera {
        let camera = match self {
            Self::Fence => Builtin::Fence.camera(width, height),
            Self::Hidden => Builtin::Hidden.camera(width, height),
            Self::Near => Builtin::Near.camera(width, height),
            Self::Grazing => Builtin::Grazing.camera(width, height),
            Self::MixedSizes => scales::mixed_sizes_camera(),
            Self::ScaleSmall => scales::SMALL.camera(),
            Self::ScaleLarge => scales::LARGE.camera(),
            Self::FarOff => scales::FAR_OFF.camera(),
            Self::Wires
            | Self::Hair
            | Self::Foliage
            | Self::Cables
            | Self::Strips
            | Self::Septum
            | Self::Checkerboard
            | Self::Shells
            | Self::Plates
            | Self::Coincident
            | Self::TJunctions
            | Self::HalfWidth
            | Self::Inside
            | Self::Wings => stage::camera(),
        };
        let share = if self == Self::HalfWidth { 0.5 } else { INTERAXIAL_SHARE };
        camera.size(width, height).interaxial_pixels(share * width as f32)
    }
}

impl fmt::Display for Trial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Trial {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        let found = Self::ALL.iter().copied().find(|trial| trial.name() == name);
        found.ok_or_else(|| Error::unknown_name("trial", name, Self::ALL))
    }
}

/// Width of a pixel (of 600 across the picture) at a distance of 1 on the stage.
const PIXEL: f32 = stage::WIDTH / 600.0;

/// The point of a sphere around the origin at `polar` radians from its top and `turn` (0 to 1) of the way around.
fn on_sphere(radius: f32, turn: f32, polar: f32) -> Vec3 {
    // Both ends of a circle are one point, to the last bit.
    let ((sin, cos), ring) = ((TAU * turn.fract()).sin_cos(), radius * polar.sin());
    Vec3::new(ring * cos, radius * polar.cos(), -ring * sin)
}
