//! Quilts: the grid of views, the display that it is for, and the cone that the views cover.

use std::error::Error;

use clap::{Args, ValueEnum};
use stereotrace::{GBuffer, Method, Options, Rig, StereoCamera, blocking::Wait};

use crate::{
    arguments::{PREVIEW, Stage, Subject},
    usage::Usage,
};

/// Degrees between the outermost views of a quilt, unless an option sets them.
const CONE: f32 = 40.0;
/// Most views of a quilt.
const MOST: u32 = 1024;
/// Shares of the middle's surfaces that are nearer than the nearest and than the farthest one that the focus counts.
/// Single pixels at silhouettes do not move it.
const COUNTED: [f32; 2] = [0.05, 0.95];

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "For light-field displays")]
pub(super) struct QuiltArguments {
    /// Make quilts: pictures of C columns and R rows of views
    ///
    /// The first, leftmost view is at the bottom left. The screen is at the surfaces in the picture's middle, unless an
    /// option, a file of cameras or a built-in scene sets it.
    #[arg(long, value_name = "CxR", value_parser = grid, allow_hyphen_values = true)]
    quilt: Option<[u32; 2]>,
    /// Make quilts for this display
    ///
    /// Columns, rows and pixels are those that its maker recommends.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["quilt", "size_said", "calib"])]
    display: Option<Display>,
    /// Angle in degrees between the outermost views, seen from the middle of the screen [default: 40 for a quilt]
    ///
    /// It has no default if --interaxial, --interaxial-px, --comfort or --calib sets the distance of neighbours.
    #[arg(
        long,
        value_name = "DEGREES",
        value_parser = cone,
        allow_hyphen_values = true,
        conflicts_with_all = ["interaxial", "interaxial_px", "comfort", "calib"]
    )]
    cone: Option<f32>,
}

/// Light-field displays whose quilts are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Display {
    /// Looking Glass Go: 11x6 views, 4092x4092 pixels
    LookingGlassGo,
    /// Looking Glass Portrait: 8x6 views, 3360x3360 pixels
    LookingGlassPortrait,
    /// Looking Glass 16" Landscape: 7x7 views, 5999x5999 pixels
    #[value(name = "looking-glass-16")]
    LookingGlass16,
}

impl Display {
    /// Returns the number of columns and of rows.
    fn grid(self) -> [u32; 2] {
        match self {
            Self::LookingGlassGo => [11, 6],
            Self::LookingGlassPortrait => [8, 6],
            Self::LookingGlass16 => [7, 7],
        }
    }

    /// Returns the size of a view in pixels.
    fn view(self) -> [u32; 2] {
        let side = match self {
            Self::LookingGlassGo => 4092,
            Self::LookingGlassPortrait => 3360,
            Self::LookingGlass16 => 5999,
        };
        self.grid().map(|count| side / count)
    }

    /// Returns the display's width divided by its height.
    fn aspect(self) -> f64 {
        match self {
            Self::LookingGlassGo => 9.0 / 16.0,
            Self::LookingGlassPortrait => 3.0 / 4.0,
            Self::LookingGlass16 => 16.0 / 9.0,
        }
    }

    /// Returns the size of a view with square pixels and the display's shape. A quilt's pixels need not be square.
    fn square(self) -> [u32; 2] {
        let [_, height] = self.view();
        [(self.aspect() * f64::from(height)).round() as u32, height]
    }
}

/// Parses the columns and rows of a quilt.
fn grid(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').map(|(columns, rows)| [columns, rows].map(str::parse::<u32>));
    let Some([Ok(columns), Ok(rows)]) = sides else { return Err("it must be like 8x6".into()) };
    match columns.checked_mul(rows) {
        Some(1..=MOST) => Ok([columns, rows]),
        _ => Err(format!("it must have 1 to {MOST} views")),
    }
}

fn cone(text: &str) -> Result<f32, String> {
    let degrees = text.parse().ok().filter(|&degrees: &f32| degrees > 0.0 && degrees <= 150.0);
    degrees.ok_or_else(|| "it must be an angle above 0, and at most 150 degrees".into())
}

impl QuiltArguments {
    /// Returns the columns and rows of the quilt, or `None` if no option asks for one.
    pub(super) fn grid(&self) -> Option<[u32; 2]> {
        self.quilt.or(self.display.map(Display::grid))
    }

    /// Returns the option that asks for a quilt or a cone, if there is one.
    fn name(&self) -> Option<&'static str> {
        let options =
            [("--quilt", self.quilt.is_some()), ("--display", self.display.is_some()), ("--cone", self.cone.is_some())];
        options.into_iter().find(|(_, given)| *given).map(|(name, _)| name)
    }

    /// Checks that a quilt's views look through one screen.
    pub(super) fn check(&self, subject: &Subject) -> Result<(), Usage> {
        match (self.name(), subject.other_projection()) {
            (Some(name), Some(other)) => {
                Err(Usage(format!("{name} and {other} exclude each other: the views look through one screen")))
            }
            _ => Ok(()),
        }
    }

    /// Returns the subject with the size of the display's views, if a display is given.
    pub(super) fn sized(&self, subject: &Subject) -> Subject {
        self.display.map_or_else(|| subject.clone(), |display| subject.sized(display.square()))
    }

    /// Returns the eyes of `count` views, and moves a quilt's screen to the subject unless an option sets it. The
    /// cameras of a path have screens of their own.
    ///
    /// # Errors
    /// Fails if eyes on a cone would look at a screen at infinity.
    pub(super) fn fan(
        &self,
        count: u32,
        subject: &Subject,
        stage: &mut Stage,
        has_path: bool,
    ) -> Result<Fan, Box<dyn Error>> {
        let is_quilt = self.grid().is_some();
        if is_quilt
            && !has_path
            && !(subject.screen_is_said() || subject.comfort_is_said() || subject.is_builtin())
            && let Some(distance) = subject_distance(stage)?
        {
            let pose = stage.camera.pose()?;
            let camera = stage.camera.interaxial(pose.interaxial);
            // The field of view stays, also where the screen's width sets it.
            let intrinsics = pose.intrinsics();
            let camera = intrinsics.map_or(camera, |intrinsics| camera.intrinsics(intrinsics));
            stage.camera = camera.screen_distance(distance);
        }
        let usual = (is_quilt && !subject.interaxial_is_said()).then_some(CONE);
        let fan = Fan { count, cone: self.cone.or(usual), display: self.display };
        if fan.cone.is_some() && stage.camera.pose()?.screen_distance.is_infinite() {
            let name = self.name().unwrap_or("--cone");
            return Err(Usage(format!("{name}: the cone of views needs a --screen at a finite distance")).into());
        }
        Ok(fan)
    }
}

/// Eyes from left to right that look through one screen.
#[derive(Clone, Debug)]
pub(super) struct Fan {
    count: u32,
    /// Degrees between the outermost eyes, or `None` for neighbours that are an interaxial apart.
    pub(super) cone: Option<f32>,
    /// Display whose views have other pixels than the camera.
    display: Option<Display>,
}

impl Fan {
    /// Returns the camera, whose interaxial is the mean distance of neighbours, and its eyes.
    ///
    /// Seen from the middle of the screen, neighbours differ by equal angles, as the views of a display do.
    pub(super) fn rig(&self, camera: StereoCamera) -> Result<(StereoCamera, Rig), stereotrace::Error> {
        let mut camera = camera;
        let pose = camera.pose()?;
        if let (Some(display), Some(intrinsics)) = (self.display, pose.intrinsics()) {
            let size = display.view();
            let [x, y] = [0, 1].map(|axis| f64::from(size[axis]) / f64::from(pose.size[axis]));
            let mut intrinsics = intrinsics.scaled([x, y]);
            intrinsics.fx = intrinsics.fy * f64::from(size[0]) / (f64::from(size[1]) * display.aspect());
            camera = camera.interaxial(pose.interaxial).size(size[0], size[1]).intrinsics(intrinsics);
            camera = camera.screen_distance(pose.screen_distance);
        }
        let (Some(cone), 2..) = (self.cone, self.count) else {
            return Ok((camera, Rig::row(camera, self.count as usize)));
        };
        let last = f64::from(self.count - 1);
        let angle = |eye: u32| (f64::from(eye) / last - 0.5) * f64::from(cone).to_radians();
        // In screen distances. The outermost eyes' distance is that of a row with the mean distance of neighbours.
        let gap = 2.0 * angle(self.count - 1).tan() / last;
        let camera = camera.interaxial((gap * f64::from(pose.screen_distance)) as f32);
        let offsets = (0..self.count).map(|eye| (angle(eye).tan() / gap) as f32);
        Ok((camera, Rig::at(camera, offsets.collect())))
    }
}

/// Returns the distance of the subject: the surfaces in the picture's middle have as much parallax before it as behind
/// it. Returns `None` if there are none.
fn subject_distance(stage: &mut Stage) -> Result<Option<f32>, stereotrace::Error> {
    let camera = stage.camera.resized(PREVIEW)?;
    let options = Options::new(Method::Naive).g_buffer(GBuffer::Depth);
    let preview = stage.renderer.views(&stage.uploaded, &Rig::mono(camera)).options(&options).read().wait()?;
    let Some(view) = preview.views.first().map(|view| &view.view) else { return Ok(None) };
    let (width, height) = (view.width as usize, view.height as usize);
    let middle = |side: usize| side / 4..side - side / 4;
    let rows = view.depth.chunks_exact(width).skip(middle(height).start).take(middle(height).len());
    let depths = rows.flat_map(|row| &row[middle(width)]).copied().filter(|depth| depth.is_finite());
    let mut nearness = Vec::from_iter(depths.map(f32::recip));
    nearness.sort_unstable_by(f32::total_cmp);
    let at = |share: f32| nearness.get((share * nearness.len() as f32) as usize);
    Ok(match COUNTED.map(at) {
        [Some(far), Some(near)] => Some(2.0 / (far + near)),
        _ => None,
    })
}

/// Returns the number of views that fill a quilt, or `asked` or `usual` without one.
///
/// # Errors
/// Fails if the number that is asked for does not fill the quilt.
pub(super) fn count_of(grid: Option<[u32; 2]>, asked: Option<u32>, usual: u32) -> Result<u32, Usage> {
    let Some([columns, rows]) = grid else { return Ok(asked.unwrap_or(usual)) };
    match asked {
        Some(count) if count != columns * rows => {
            Err(Usage(format!("--views {count}: a quilt of {columns}x{rows} has {} views", columns * rows)))
        }
        _ => Ok(columns * rows),
    }
}

#[cfg(test)]
mod tests {
    use stereotrace::glam::Vec3;

    use super::*;

    #[test]
    fn a_grid_has_columns_and_rows_of_at_most_1024_views() {
        assert_eq!(grid("8x6"), Ok([8, 6]));
        for (text, expected) in [
            ("9", "it must be like 8x6"),
            ("-1x3", "it must be like 8x6"),
            ("8x", "it must be like 8x6"),
            ("0x3", "it must have 1 to 1024 views"),
            ("1025x1", "it must have 1 to 1024 views"),
            ("65536x65536", "it must have 1 to 1024 views"),
        ] {
            assert_eq!(grid(text), Err(expected.into()), "{text}");
        }
    }

    #[test]
    fn views_of_displays_have_their_shape_and_their_pixels() {
        for (display, size, aspect) in [
            (Display::LookingGlassGo, [372, 682], 0.5625),
            (Display::LookingGlassPortrait, [420, 560], 0.75),
            (Display::LookingGlass16, [857, 857], 16.0 / 9.0),
        ] {
            let [width, height] = display.square();
            let camera = StereoCamera::look_at(4.0 * Vec3::Z, Vec3::ZERO).size(width, height);
            let [columns, rows] = display.grid();
            let fan = Fan { count: columns * rows, cone: Some(40.0), display: Some(display) };
            let (camera, rig) = fan.rig(camera).unwrap();
            let pose = camera.pose().unwrap();
            assert_eq!(pose.size, size, "{display:?}");
            let [fx, fy] = pose.focal_px().unwrap();
            let shape = (f64::from(size[0]) / fx) / (f64::from(size[1]) / fy);
            assert!((shape - aspect).abs() < 1e-6, "{display:?}: {shape}");
            assert!((pose.screen_distance - 4.0).abs() < 1e-6);
            let reach = 4.0 * 20_f32.to_radians().tan();
            let (first, last) = (rig.offsets()[0], rig.offsets()[rig.offsets().len() - 1]);
            assert!((first * pose.interaxial + reach).abs() < 1e-4 && (last * pose.interaxial - reach).abs() < 1e-4);
        }
    }
}
