//! Optical flow in the formats of data sets.

use std::path::Path;

use super::{Batch, Picture, file::check_count};
use crate::{Error, EyeFlow, EyeMatches, FlowClass};

/// First four bytes of a .flo file: the number 202021.25 as f32.
const FLO: f32 = 202_021.25;
/// Components of unknown flow in .flo files. Readers take values over 1e9 as unknown.
const UNKNOWN: f32 = 1e10;

impl Batch {
    /// Adds flow as a .flo file, as Middlebury's and Sintel's: little-endian f32, to the right and down, top row first.
    /// Flow of points without a place ([`FlowClass::Behind`]) is 1e10, which means unknown.
    ///
    /// # Errors
    /// [`Error::Io`] as [`Batch::add`].
    pub fn add_flo(&mut self, path: impl AsRef<Path>, flow: &EyeFlow) -> Result<(), Error> {
        self.add_steps(path.as_ref(), [flow.width, flow.height], &flow.flow)
    }

    /// Adds the matches of a view as a .flo file: the place in the other eye's picture minus the pixel's centre, to the
    /// right and down, as if the other eye's picture were the next one. Places that are NaN are 1e10, which means
    /// unknown.
    ///
    /// # Errors
    /// [`Error::Io`] as [`Batch::add`].
    pub fn add_matches_flo(&mut self, path: impl AsRef<Path>, matches: &EyeMatches) -> Result<(), Error> {
        let width = (matches.width as usize).max(1);
        let step = |(index, &[x, y]): (usize, &[f32; 2])| {
            let center = [index % width, index / width].map(|at| at as f64 + 0.5);
            [f64::from(x) - center[0], f64::from(y) - center[1]].map(|step| step as f32)
        };
        let steps: Vec<[f32; 2]> = matches.place.iter().enumerate().map(step).collect();
        self.add_steps(path.as_ref(), [matches.width, matches.height], &steps)
    }

    fn add_steps(&mut self, path: &Path, [width, height]: [u32; 2], steps: &[[f32; 2]]) -> Result<(), Error> {
        check_count(path, width, height, steps.len())?;
        let mut bytes = Vec::with_capacity(12 + 8 * steps.len());
        bytes.extend(FLO.to_le_bytes());
        bytes.extend([width, height].map(u32::to_le_bytes).as_flattened());
        for step in steps.as_flattened() {
            bytes.extend(if step.is_nan() { UNKNOWN } else { *step }.to_le_bytes());
        }
        self.add(path, &bytes)
    }

    /// Adds flow as Scene Flow's colour PFM files: right, down, 0; bottom row first. Flow of points without a place is
    /// NaN.
    ///
    /// # Errors
    /// [`Error::Io`] as [`Batch::add`].
    pub fn add_flow_pfm(&mut self, path: impl AsRef<Path>, flow: &EyeFlow) -> Result<(), Error> {
        let values: Vec<[f32; 3]> = flow.flow.iter().map(|&[right, down]| [right, down, 0.0]).collect();
        self.add_pfm_color(path, flow.width, flow.height, &values)
    }

    /// Adds flow as a 16-bit colour PNG file in KITTI's format: `round(64 u + 32768)` to the right and down, and 1
    /// where the flow is valid. Use [`EyeFlow::known`] for `flow_occ` and [`EyeFlow::visible`] for `flow_noc`, without
    /// sky, as in KITTI.
    ///
    /// The format holds flow from -512 to below 512 pixels. Larger flow of points that the eye does not see at the
    /// other time is not valid.
    ///
    /// # Errors
    /// [`Error::Io`], naming the pixel, for larger flow of a visible point; for a list that is not `width * height`
    /// long; and as [`Batch::add`].
    #[cfg(feature = "png")]
    pub fn add_kitti_flow(&mut self, path: impl AsRef<Path>, flow: &EyeFlow, is_valid: &[bool]) -> Result<(), Error> {
        let path = path.as_ref();
        check_count(path, flow.width, flow.height, flow.flow.len())?;
        check_count(path, flow.width, flow.height, is_valid.len())?;
        let pixels = flow.flow.iter().zip(&flow.class).zip(is_valid).enumerate();
        let samples = pixels.map(|(index, ((step, class), &valid))| {
            let [u, v] = step.map(|value| (64.0 * f64::from(value) + 32_768.0).round());
            let fits = [u, v].iter().all(|value| (0.0..65_536.0).contains(value));
            match (valid, fits, class) {
                (true, true, _) => Ok([u as u16, v as u16, 1]),
                (true, false, FlowClass::Visible) => {
                    let (column, row) = (index % flow.width as usize, index / flow.width as usize);
                    let reason = "512 px or more, which KITTI's PNG file can't hold: use smaller pictures or motions";
                    let text = format!("flow {step:?} px at column {column}, row {row} is {reason}");
                    Err(Error::unwritable(path, text))
                }
                _ => Ok([0; 3]),
            }
        });
        let samples = samples.collect::<Result<Vec<[u16; 3]>, _>>()?;
        self.add_rgb16(path, [flow.width, flow.height], &samples)
    }

    /// Adds the classes of flow as an 8-bit grey PNG file. 0: the eye sees the point at the other time. 255: the point
    /// is hidden. 128: it is outside the picture. 64: it is behind the eye.
    ///
    /// # Errors
    /// [`Error::Io`] as [`Batch::add`].
    #[cfg(feature = "png")]
    pub fn add_flow_classes(&mut self, path: impl AsRef<Path>, flow: &EyeFlow) -> Result<(), Error> {
        let grey = |class: &FlowClass| match class {
            FlowClass::Visible => 0,
            FlowClass::Hidden => 255,
            FlowClass::OutOfFrame => 128,
            FlowClass::Behind => 64,
        };
        let samples = Vec::from_iter(flow.class.iter().map(grey));
        self.add_grey8(path.as_ref(), [flow.width, flow.height], &samples)
    }
}

/// Number of hues between red and yellow, yellow and green, and so on, in Middlebury's colour wheel.
const HUES: [usize; 6] = [15, 6, 4, 11, 13, 6];

impl EyeFlow {
    /// Returns the flow as a picture, by the colour wheel of Baker et al. 2007 (`flow_to_image` of torchvision). The
    /// hue shows the direction, and the saturation the length, up to `longest` pixels. `None` takes the longest flow of
    /// the points that the eye sees at both times. Unknown flow is black. Longer flow is darker than the wheel.
    pub fn picture(&self, longest: Option<f32>) -> Picture {
        let lengths = self.flow.iter().zip(&self.class).filter(|(_, class)| **class == FlowClass::Visible);
        let longest = longest.unwrap_or_else(|| lengths.map(|(step, _)| step[0].hypot(step[1])).fold(0.0, f32::max));
        let wheel = wheel();
        let color = |&[u, v]: &[f32; 2]| match [u, v].iter().all(|value| value.is_finite()) {
            true => color(&wheel, [u, v].map(|value| value / longest.max(f32::MIN_POSITIVE))),
            false => [0, 0, 0, 255],
        };
        Picture::new(self.width, self.height, self.flow.iter().map(color).collect())
    }
}

/// Returns the colours of the wheel, 0 to 1.
fn wheel() -> Vec<[f32; 3]> {
    // Each part raises or lowers one channel: red to yellow, to green, to cyan, to blue, to magenta, to red.
    let parts = [(0, 1, true), (1, 0, false), (1, 2, true), (2, 1, false), (2, 0, true), (0, 2, false)];
    let part = |(&(full, changing, rises), &hues): (&(usize, usize, bool), &usize)| {
        (0..hues).map(move |hue| {
            let mut color = [0.0; 3];
            let level = (255.0 * hue as f32 / hues as f32).floor() / 255.0;
            color[full] = 1.0;
            color[changing] = if rises { level } else { 1.0 - level };
            color
        })
    };
    parts.iter().zip(&HUES).flat_map(part).collect()
}

/// Returns the colour of a flow of at most length 1.
fn color(wheel: &[[f32; 3]], [u, v]: [f32; 2]) -> [u8; 4] {
    let length = u.hypot(v);
    let place = ((-v).atan2(-u) / std::f32::consts::PI + 1.0) / 2.0 * (wheel.len() - 1) as f32;
    let (low, share) = (place.floor() as usize, place.fract());
    let next = wheel[(low + 1) % wheel.len()];
    let channel = |channel: usize| {
        let hue = (1.0 - share) * wheel[low][channel] + share * next[channel];
        let value = if length <= 1.0 { 1.0 - length * (1.0 - hue) } else { 0.75 * hue };
        (255.0 * value).floor() as u8
    };
    [channel(0), channel(1), channel(2), 255]
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::folder::Folder;

    fn flow(flow: [[f32; 2]; 4], class: [FlowClass; 4]) -> EyeFlow {
        EyeFlow {
            width: 2,
            height: 2,
            flow: flow.to_vec(),
            disparity_change: vec![0.0; 4],
            displacement: vec![[0.0; 3]; 4],
            class: class.to_vec(),
        }
    }

    const CLASSES: [FlowClass; 4] = [FlowClass::Visible, FlowClass::Hidden, FlowClass::OutOfFrame, FlowClass::Behind];

    #[test]
    fn flo_and_pfm_files_have_the_bytes_of_their_formats() {
        let folder = Folder::new("flo");
        let flow = flow([[1.5, -2.0], [0.0, 3.0], [-600.0, 0.25], [f32::NAN; 2]], CLASSES);
        let mut batch = Batch::new();
        batch.add_flo(folder.file("a.flo"), &flow).unwrap();
        batch.add_flow_pfm(folder.file("a.pfm"), &flow).unwrap();
        batch.commit().unwrap();
        let mut expected = b"PIEH".to_vec();
        expected.extend([2_u32, 2].map(u32::to_le_bytes).as_flattened());
        let values = [1.5_f32, -2.0, 0.0, 3.0, -600.0, 0.25, 1e10, 1e10];
        expected.extend(values.map(f32::to_le_bytes).as_flattened());
        assert_eq!(fs::read(folder.file("a.flo")).unwrap(), expected);
        let pfm = fs::read(folder.file("a.pfm")).unwrap();
        let begin = b"PF\n2 2\n-1.0\n".len();
        // The bottom row comes first.
        assert_eq!(pfm[begin..begin + 12], [-600.0_f32, 0.25, 0.0].map(f32::to_le_bytes).concat());
    }

    #[test]
    #[cfg(feature = "png")]
    fn kitti_flow_has_64_steps_a_pixel_and_names_what_does_not_fit() {
        let folder = Folder::new("kitti_flow");
        let fits = flow([[1.0, -0.5], [511.0, -512.0], [-600.0, 0.25], [f32::NAN; 2]], CLASSES);
        let mut batch = Batch::new();
        batch.add_kitti_flow(folder.file("a.png"), &fits, &fits.known()).unwrap();
        batch.add_flow_classes(folder.file("b.png"), &fits).unwrap();
        batch.commit().unwrap();
        let image::DynamicImage::ImageRgb16(read) = image::open(folder.file("a.png")).unwrap() else { panic!() };
        assert_eq!(read.into_raw(), [32_832, 32_736, 1, 65_472, 0, 1, 0, 0, 0, 0, 0, 0]);
        let image::DynamicImage::ImageLuma8(read) = image::open(folder.file("b.png")).unwrap() else { panic!() };
        assert_eq!(read.into_raw(), [0, 255, 128, 64]);
        let large = flow([[0.0; 2], [0.0; 2], [512.0, 0.0], [0.0; 2]], [FlowClass::Visible; 4]);
        let message = Batch::new().add_kitti_flow(folder.file("c.png"), &large, &[true; 4]).unwrap_err().to_string();
        assert!(message.contains("c.png: flow [512.0, 0.0] px at column 0, row 1"), "{message}");
    }

    /// Colours of the Python package `flow_vis` 0.1 for the same flow.
    #[test]
    fn colours_are_those_of_the_wheel() {
        let steps = flow([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.3, -0.4]], [FlowClass::Visible; 4]);
        let expected = [[255, 0, 0, 255], [255, 229, 0, 255], [0, 209, 255, 255], [225, 127, 255, 255]];
        assert_eq!(steps.picture(None).rgba8, expected);
        let still = flow([[0.0; 2]; 4], [FlowClass::Visible; 4]).picture(None);
        assert_eq!(still.rgba8, [[255; 4]; 4]);
        let unknown = flow([[f32::NAN; 2]; 4], [FlowClass::Behind; 4]).picture(None);
        assert_eq!(unknown.rgba8, [[0, 0, 0, 255]; 4]);
    }
}
