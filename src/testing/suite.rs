//! A suite of scenes that are hard for methods which reuse one eye's samples for the other: see [`Trial`].

mod scales;
mod space;
mod surfaces;
mod thin;

use std::f32::consts::TAU;

use glam::Vec3;

use crate::{
    Finish, Light, MaterialId, Scene, StereoCamera,
    error::by_name,
    scene::builtin::{Builtin, INTERAXIAL_SHARE, stage},
};

/// A scene that is hard for methods which reuse one eye's samples for the other.
///
/// ```
/// use stereotrace::testing::suite::Trial;
///
/// let wires: Trial = "wires".parse()?;
/// println!("{wires}: {}", wires.reason());
/// assert!(wires.scene().primitive_count() > 1000);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Trial {
    /// [`Builtin::Fence`]: every slat uncovers a strip of wall. Many short gaps must be found and traced.
    Fence,
    /// [`Builtin::Hidden`]: a pillar that only the right eye sees. It has no left sample, and a method that trusts all
    /// landed samples shows the wall through it.
    Hidden,
    /// [`Builtin::Near`]: a sphere so near that its parallax is six times the interaxial. This exceeds buffers made for
    /// half the screen's distance.
    Near,
    /// [`Builtin::Grazing`]: sheets that are edges to the left eye. Their points that the right eye sees lie between
    /// two left samples.
    Grazing,
    /// Ribbons, slivers and chains of spheres 0.2 to 0.9 pixels wide (of 600) in front of a wall. One eye's samples hit
    /// a wire that the other eye's samples miss. The sample on the wall beside it passes every check.
    Wires,
    /// Thousands of curved strands, 0.1 to 0.5 pixels wide, on a sphere. Nearly every pixel is an edge, and the two
    /// eyes' samples seldom hit the same strand.
    Hair,
    /// Tree crowns of squares with leaf-shaped cut-outs. Many spots of light in their shadows are narrower than the
    /// distance between left samples.
    Foliage,
    /// Cables over a street, far from the surfaces that receive their shadows.
    Cables,
    /// A plate with fins and bars about a pixel wide or narrower, close to the surfaces that receive their shadows.
    Strips,
    /// A thin wall between the eyes, from their plane into the depth. Each eye sees one side of it and one half of the
    /// scene, so the views share almost nothing.
    Septum,
    /// A floor of 40,000 raised tiles to the horizon. Its depth is smooth, so samples are reused, but colours change
    /// within a pixel.
    Checkerboard,
    /// Nested spheres with windows. A pixel looks through several windows at once, and the eyes look through different
    /// ones.
    Shells,
    /// Pairs of plates a thousandth and a hundred-thousandth of their distance apart, the front ones with holes.
    /// Verification rays that end short of their point can't distinguish the plates, nor can parallax.
    Plates,
    /// Coincident surfaces in two colours: a mesh twice, a sphere twice, overlapping quads in a plane. Only the rule
    /// for ties decides which one is seen, and both eyes and all kernels must follow it.
    Coincident,
    /// Walls of large panels beside finely divided ones, whose vertices lie on (or just off) the large panels' edges.
    /// Rays slip through cracks that only one eye sees.
    TJunctions,
    /// Triangles of 10,000 units and of 0.0001 in one picture. Absolute tolerances, or shares of the scene's size, are
    /// too large for some or too small for others.
    MixedSizes,
    /// Floor, wall, sphere, spheres and box at a thousandth of their size. Tolerances in world units are too large
    /// here.
    ScaleSmall,
    /// The same scene at a million times its size. Tolerances in world units are too small here, and products of
    /// coordinates are large.
    ScaleLarge,
    /// The same scene 100,000 units from the origin along each axis. At this distance f32 rounds vertices and rays to
    /// half a pixel, so a point computed twice has two positions.
    FarOff,
    /// Near and far objects, seen by eyes half a picture apart. Half of the left view lands outside the right one, and
    /// many left samples compete for one pixel.
    HalfWidth,
    /// The left eye is in a sphere with a window, the right eye outside it, and both are in a sphere around everything.
    /// Parallax reaches many picture widths, and the left eye can't see the right view's surroundings.
    Inside,
    /// A post nearer than the screen, just beside the left eye's picture and within the right eye's. Left samples
    /// behind it land on it without a gap, so a method that traces only gaps shows the wall through it. This is figure
    /// 14 of Adelson and Hodges 1993, the only case in which they say that their method fails.
    Wings,
}

impl Trial {
    /// All trials.
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

    /// Returns the name for the command line.
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

    /// Returns in one line why methods fail here.
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

    /// Builds the scene. Each call gives the same scene.
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

    /// Builds a more expensive version of the scene. Every second material is half a mirror, and lights are spheres
    /// with a radius of a 200th of the scene's diagonal.
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

    /// Returns the scene's camera. The interaxial is 15 pixels in a picture 600 pixels wide, and in proportion
    /// otherwise; for [`Trial::HalfWidth`] it is half the width.
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

by_name!(Trial, "trial");

/// Width of a pixel (of 600 across the picture) at distance 1 on the stage.
const PIXEL: f32 = stage::WIDTH / 600.0;

/// Returns the point of a sphere around the origin at `polar` radians from its top and `turn` (0 to 1) of the way
/// around.
fn on_sphere(radius: f32, turn: f32, polar: f32) -> Vec3 {
    // `fract` makes both ends of a circle equal to the last bit.
    let ((sin, cos), ring) = ((TAU * turn.fract()).sin_cos(), radius * polar.sin());
    Vec3::new(ring * cos, radius * polar.cos(), -ring * sin)
}
