//! Reads calibrated pairs from the text files of stereo benchmarks.

use std::{collections::HashMap, path::Path};

use glam::Vec3;

use crate::{Error, Limits, StereoCamera, import::input, view::camera::Intrinsics};

/// Largest offset between a pair's cameras off the x axis, as a share of the baseline.
const MOST_ASKEW: f64 = 0.01;

/// Names of lens distortion fields in such files.
pub(super) const DISTORTION: [&str; 11] =
    ["k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "distortion", "dist0", "dist1"];

impl StereoCamera {
    /// Reads a pair from a Middlebury `calib.txt` (2014, 2021; ETH3D's two-view files are alike). The fields are `cam0`
    /// and `cam1` as `[f 0 cx; 0 f cy; 0 0 1]`, `baseline` in millimetres, `width` and `height`. An optional `doffs`
    /// must be `cx1 - cx0` within a hundredth. Other lines are ignored.
    ///
    /// World units are millimetres times `scale`: 1 keeps them, 0.001 makes them metres. The left eye stands at the
    /// origin and looks along -z with y up. So a point (x, y, z) of the left camera (x right, y down, z ahead) is (x,
    /// -y, -z) times `scale` here. [`StereoCamera::eye`], `target` and `up` move the pair.
    ///
    /// Pixel centres are at integers in the file and at halves here: a half is added to `cx` and `cy`. With `doffs` 0
    /// the eyes are parallel cameras, else their screen is at `f baseline / doffs`.
    ///
    /// ```no_run
    /// let camera = stereotrace::StereoCamera::from_middlebury("Motorcycle/calib.txt", 0.001)?; // in metres
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// - [`Error::Io`] and [`Error::TooLarge`] as [`StereoCamera::from_json`].
    /// - [`Error::Parse`], naming line and field, for values that are missing, given twice or not numbers, and for
    ///   cameras whose `fx`, `fy` or `cy` differ. It is also returned for skew, lens distortion, a negative `doffs` and
    ///   a baseline that is not above 0.
    pub fn from_middlebury(path: impl AsRef<Path>, scale: f32) -> Result<Self, Error> {
        Self::from_middlebury_within(path, scale, &Limits::default())
    }

    /// Does the same as [`StereoCamera::from_middlebury`], with the given limits. The limit on JSON files applies.
    ///
    /// # Errors
    /// Returns the errors of [`StereoCamera::from_middlebury`].
    pub fn from_middlebury_within(path: impl AsRef<Path>, scale: f32, limits: &Limits) -> Result<Self, Error> {
        let file = File::read(path.as_ref(), '=', limits)?;
        file.without_distortion()?;
        let [cam0, cam1] =
            ["cam0", "cam1"].map(|name| file.numbers::<9>(name).and_then(|found| file.lens(name, found)));
        let (cam0, cam1) = (cam0?, cam1?);
        let shared = [("fx", cam0[0], cam1[0]), ("fy", cam0[1], cam1[1]), ("cy", cam0[3], cam1[3])];
        file.check_shared(["cam0", "cam1"], shared)?;
        let doffs = cam1[2] - cam0[2];
        if file.values.contains_key("doffs") {
            let [stated] = file.numbers("doffs")?;
            if (stated - doffs).abs() > 0.01 {
                return Err(file.fault("doffs", format!("is {stated}, but cx of cam1 minus cx of cam0 is {doffs}")));
            }
        }
        let [baseline] = file.numbers("baseline")?;
        let size = ["width", "height"].map(|name| {
            let [side] = file.numbers::<1>(name)?;
            let is_whole = side >= 1.0 && side.fract() == 0.0 && side <= f64::from(u32::MAX);
            if is_whole {
                Ok(side as u32)
            } else {
                Err(file.fault(name, format!("is {side}; it must be a whole number above 0")))
            }
        });
        let [width, height] = size;
        file.camera(cam0, cam1[2], baseline, [width?, height?], scale)
    }

    /// Reads a pair from a KITTI calibration. The file has the projection matrices `P0` to `P3` (object, odometry and
    /// scene flow), or `P_rect_00` to `P_rect_03` (`calib_cam_to_cam.txt`), 12 numbers each.
    ///
    /// `cameras` are the left and the right camera: `[2, 3]` are the colour cameras. `size` is the size of the picture,
    /// `[width, height]`. It must agree with `S_rect` if the file has it.
    ///
    /// World units are metres times `scale`. Eye positions and pixel centres follow [`StereoCamera::from_middlebury`].
    /// `P = K [I | t]` puts a camera at `-t`, so the baseline is the cameras' distance along x. The colour cameras also
    /// have an offset from this axis of up to 0.5% of the baseline, so rows are not exact epipolar lines. An offset of
    /// up to 1% is ignored, with a warning.
    ///
    /// # Errors
    /// Returns the errors of [`StereoCamera::from_middlebury`].
    pub fn from_kitti(path: impl AsRef<Path>, cameras: [u32; 2], size: [u32; 2], scale: f32) -> Result<Self, Error> {
        Self::from_kitti_within(path, cameras, size, scale, &Limits::default())
    }

    /// Does the same as [`StereoCamera::from_kitti`], with the given limits. The limit on JSON files applies.
    ///
    /// # Errors
    /// Returns the errors of [`StereoCamera::from_middlebury`].
    pub fn from_kitti_within(
        path: impl AsRef<Path>,
        cameras: [u32; 2],
        size: [u32; 2],
        scale: f32,
        limits: &Limits,
    ) -> Result<Self, Error> {
        let file = File::read(path.as_ref(), ':', limits)?;
        let names = cameras.map(|camera| {
            let [short, rectified] = [format!("P{camera}"), format!("P_rect_{camera:02}")];
            if file.values.contains_key(short.as_str()) { short } else { rectified }
        });
        let [left, right] = [0, 1].map(|eye| file.projection(&names[eye]));
        let ((left, from), (right, to)) = (left?, right?);
        let [a, b] = [names[0].as_str(), names[1].as_str()];
        file.check_shared([a, b], [("fx", left[0], right[0]), ("fy", left[1], right[1]), ("cy", left[3], right[3])])?;
        for camera in cameras {
            let name = format!("S_rect_{camera:02}");
            if file.values.contains_key(name.as_str()) {
                let [w, h] = file.numbers::<2>(&name)?;
                if [w, h] != size.map(f64::from) {
                    return Err(
                        file.fault(&name, format!("is {w}x{h}, but the requested picture is {}x{}", size[0], size[1]))
                    );
                }
            }
        }
        let baseline = to[0] - from[0];
        let askew = (to[1] - from[1]).hypot(to[2] - from[2]);
        if askew > MOST_ASKEW * baseline.abs() {
            let reason = format!(
                "is {askew} m off the x axis of {a}, over 1% of the baseline of {baseline} m: rows would not be \
                 epipolar lines"
            );
            return Err(file.fault(b, reason));
        }
        if askew > 0.0 {
            let path = file.path.display();
            log::warn!("{path}: {b} is {askew:.2e} m off the x axis of {a}; this offset is ignored");
        }
        file.camera(left, right[2], baseline, size, scale)
    }
}

/// `fx`, `fy`, `cx`, `cy`.
type Lens = [f64; 4];

/// A file with a name and a value in each line.
struct File<'a> {
    path: &'a Path,
    /// Line number and value by name.
    values: HashMap<String, (usize, String)>,
}

impl<'a> File<'a> {
    fn read(path: &'a Path, between: char, limits: &Limits) -> Result<Self, Error> {
        let bytes = input::read(path, limits.json_bytes, limits.option_names[0])?;
        let text =
            String::from_utf8(bytes).map_err(|error| Error::parse_from(path, None, "it is not UTF-8 text", error))?;
        let mut values = HashMap::new();
        for (line, text) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
            let text = text.trim();
            if text.is_empty() || text.starts_with('#') {
                continue;
            }
            let Some((name, value)) = text.split_once(between) else {
                return Err(Error::parse(path, Some(line), format!("'{text}' is not a name, {between} and a value")));
            };
            let name = name.trim().to_owned();
            if let Some((before, _)) = values.get(&name) {
                return Err(Error::parse(path, Some(line), format!("{name} is already given on line {before}")));
            }
            values.insert(name, (line, value.trim().to_owned()));
        }
        Ok(Self { path, values })
    }

    fn fault(&self, name: &str, reason: String) -> Error {
        Error::parse(self.path, self.values.get(name).map(|(line, _)| *line), format!("{name} {reason}"))
    }

    /// Reads `N` finite numbers, with or without brackets.
    fn numbers<const N: usize>(&self, name: &str) -> Result<[f64; N], Error> {
        let Some((_, text)) = self.values.get(name) else {
            return Err(self.fault(name, "is missing".into()));
        };
        let words = text.split(|c: char| c.is_whitespace() || "[],;".contains(c)).filter(|word| !word.is_empty());
        let numbers: Option<Vec<f64>> =
            words.map(|word| word.parse().ok().filter(|number: &f64| number.is_finite())).collect();
        let found = numbers.and_then(|numbers| <[f64; N]>::try_from(numbers).ok());
        found.ok_or_else(|| {
            self.fault(name, format!("is '{text}'; it must be {N} number{}", if N == 1 { "" } else { "s" }))
        })
    }

    fn without_distortion(&self) -> Result<(), Error> {
        for name in DISTORTION.iter().filter(|name| self.values.contains_key(**name)) {
            let (_, text) = &self.values[*name];
            let words = text.split(|c: char| c.is_whitespace() || "[],;".contains(c)).filter(|word| !word.is_empty());
            if words.map(str::parse).any(|number| number != Ok(0.0)) {
                return Err(self
                    .fault(name, format!("is '{text}'; this format is for rectified pairs: give a lens, or rectify")));
            }
        }
        Ok(())
    }

    /// Reads the intrinsics of a 3 x 3 matrix.
    fn lens(&self, name: &str, [fx, skew, cx, low, fy, cy, a, b, c]: [f64; 9]) -> Result<Lens, Error> {
        if skew != 0.0 || low != 0.0 {
            return Err(
                self.fault(name, format!("has a skew of {}; it must be 0", if skew == 0.0 { low } else { skew }))
            );
        }
        if [a, b, c] != [0.0, 0.0, 1.0] {
            return Err(self.fault(name, format!("ends in {a} {b} {c}; its last row must be 0 0 1")));
        }
        Ok([fx, fy, cx, cy])
    }

    /// Reads a KITTI camera and its position in metres: x to the right, y down, z ahead.
    fn projection(&self, name: &str) -> Result<(Lens, [f64; 3]), Error> {
        let [fx, skew, cx, x, low, fy, cy, y, a, b, c, z] = self.numbers::<12>(name)?;
        let lens = self.lens(name, [fx, skew, cx, low, fy, cy, a, b, c])?;
        Ok((lens, [-(x - cx * z) / fx, -(y - cy * z) / fy, -z]))
    }

    fn check_shared(&self, names: [&str; 2], fields: [(&str, f64, f64); 3]) -> Result<(), Error> {
        match fields.into_iter().find(|(_, a, b)| a != b) {
            Some((field, a, b)) => {
                let reason = format!("has {field} {b}, but {} has {a}; both eyes must have the same", names[0]);
                Err(self.fault(names[1], reason))
            }
            None => Ok(()),
        }
    }

    fn camera(
        &self,
        left: Lens,
        right_cx: f64,
        baseline: f64,
        size: [u32; 2],
        scale: f32,
    ) -> Result<StereoCamera, Error> {
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(Error::Options { option: "scale", reason: format!("it is {scale}; it must be above 0") });
        }
        if baseline.is_nan() || baseline <= 0.0 {
            let reason = format!("the baseline is {baseline}; it must be above 0, so give the left camera first");
            return Err(Error::parse(self.path, None, reason));
        }
        let [fx, fy, cx, cy] = left;
        let intrinsics = Intrinsics::new([fx, fy], [cx + 0.5, cy + 0.5]).right_cx(right_cx + 0.5);
        let e = baseline * f64::from(scale);
        let ahead = if intrinsics.doffs() > 0.0 { fx * e / intrinsics.doffs() } else { 30.0 * e };
        let eye = Vec3::new((0.5 * e) as f32, 0.0, 0.0);
        let camera = StereoCamera::look_at(eye, eye - Vec3::Z * ahead as f32)
            .size(size[0], size[1])
            .intrinsics(intrinsics)
            .interaxial(e as f32);
        match camera.pose() {
            Ok(_) => Ok(camera),
            Err(error) => Err(Error::parse_from(self.path, None, error.to_string(), error)),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::folder::Folder;

    /// Middlebury 2014, Motorcycle.
    const MOTORCYCLE: &str = "cam0=[3979.911 0 1244.772; 0 3979.911 1019.507; 0 0 1]\n\
        cam1=[3979.911 0 1369.115; 0 3979.911 1019.507; 0 0 1]\n\
        doffs=124.343\nbaseline=193.001\nwidth=2964\nheight=1988\nndisp=270\nisint=0\nvmin=23\nvmax=245\ndyavg=0\ndymax=0\n";
    /// KITTI 2012, object 000000, without P1.
    const KITTI: &str = "P0: 7.215377e+02 0 6.095593e+02 0 0 7.215377e+02 1.728540e+02 0 0 0 1 0\n\
        P1: 7.215377e+02 0 6.095593e+02 -3.875744e+02 0 7.215377e+02 1.728540e+02 0 0 0 1 0\n\
        P2: 7.215377e+02 0 6.095593e+02 4.485728e+01 0 7.215377e+02 1.728540e+02 2.163791e-01 0 0 1 2.745884e-03\n\
        P3: 7.215377e+02 0 6.095593e+02 -3.395242e+02 0 7.215377e+02 1.728540e+02 2.199936e+00 0 0 1 2.729905e-03\n\n\
        Tr: 1 0 0 0\n";

    fn middlebury(text: &str, scale: f32) -> Result<StereoCamera, Error> {
        let folder = Folder::new("calib");
        StereoCamera::from_middlebury(folder.write("calib.txt", text), scale)
    }

    fn kitti(text: &str, cameras: [u32; 2]) -> Result<StereoCamera, Error> {
        let folder = Folder::new("calib");
        StereoCamera::from_kitti(folder.write("calib.txt", text), cameras, [1242, 375], 1.0)
    }

    #[test]
    fn middlebury_s_points_land_where_its_matrices_put_them() {
        for scale in [1.0_f32, 0.001] {
            let pose = middlebury(MOTORCYCLE, scale).unwrap().pose().unwrap();
            assert_eq!(pose.size, [2964, 1988]);
            for point in [[100.0, -250.0, 2900.0], [-800.0, 300.0, 4000.0], [0.0, 0.0, 2500.0_f64]] {
                let [x, y, z] = point;
                let world = (DVec3::new(x, -y, -z) * f64::from(scale)).as_vec3();
                for (side, across, cx) in [(-1.0, x, 1244.772), (1.0, x - 193.001, 1369.115)] {
                    let expected = [3979.911 * across / z + cx, 3979.911 * y / z + 1019.507];
                    let [column, row, depth] = pose.project(world, side).map(f64::from);
                    let off = (column - 0.5 - expected[0]).abs().max((row - 0.5 - expected[1]).abs());
                    assert!(off < 2e-3, "{off} px");
                    assert!((depth / f64::from(scale) / z - 1.0).abs() < 1e-6);
                }
                // By the data set's documentation, Z = baseline f / (d + doffs).
                let disparity = pose.disparity_px((z * f64::from(scale)) as f32);
                assert!((193.001 * 3979.911 / (disparity + 124.343) - z).abs() < 1e-3 * z);
            }
            // Every number is reproduced.
            let back = pose.intrinsics().unwrap();
            let found = [back.fx, back.fy, back.cx0 - 0.5, back.cx1 - 0.5, back.cy - 0.5, back.doffs()];
            let given = [3979.911, 3979.911, 1244.772, 1369.115, 1019.507, 124.343];
            assert_eq!(found.map(|number| number as f32), given.map(|number: f64| number as f32));
            assert_eq!(pose.interaxial, (193.001 * f64::from(scale)) as f32);
        }
        let parallel = MOTORCYCLE.replace("1369.115", "1244.772").replace("doffs=124.343\n", "");
        let pose = middlebury(&parallel, 1.0).unwrap().pose().unwrap();
        assert_eq!((pose.screen_distance, pose.interaxial_px), (f32::INFINITY, 0.0));
    }

    #[test]
    fn kitti_s_matrices_say_where_cameras_stand() {
        let grey = kitti(KITTI, [0, 1]).unwrap().pose().unwrap();
        assert_eq!(grey.interaxial, (387.5744 / 721.5377) as f32);
        assert_eq!(grey.intrinsics().unwrap().cx0 as f32, 610.0593);
        assert!((grey.disparity_px(10.0) - 38.75744).abs() < 1e-5);
        let [from, to] =
            [(44.85728, 0.002745884), (-339.5242, 0.002729905)].map(|(x, z)| (x - 609.5593 * z) / 721.5377);
        let colour = kitti(KITTI, [2, 3]).unwrap().pose().unwrap();
        assert_eq!(colour.interaxial, (from - to) as f32);
        let rectified = KITTI.replace("P0:", "P_rect_00:").replace("P1:", "P_rect_01:") + "S_rect_00: 1242 375\n";
        assert_eq!(kitti(&rectified, [0, 1]).unwrap().pose().unwrap(), grey);
        for (from, to, cameras, expected) in [
            ("", "", [1, 0], "the baseline is -0.53715"),
            ("", "", [0, 7], "P_rect_07 is missing"),
            ("-3.875744e+02 0 7", "-3.875744e+02 0.1 7", [0, 1], ":2: P1 has a skew of 0.1"),
            ("2.199936e+00", "9.199936e+00", [2, 3], ":4: P3 is 0.0"),
            (
                "P1: 7.215377e+02",
                "P1: 7.3e+02",
                [0, 1],
                ":2: P1 has fx 730, but P0 has 721.5377; both eyes must have the same",
            ),
            (
                "Tr: ",
                "S_rect_00: 1224 370\nTr: ",
                [0, 1],
                ":6: S_rect_00 is 1224x370, but the requested picture is 1242x375",
            ),
        ] {
            let message = kitti(&KITTI.replacen(from, to, 1), cameras).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn what_can_t_be_rendered_is_refused_with_its_line() {
        for (from, to, expected) in [
            (
                "cam1=[3979.911",
                "cam1=[3980",
                ":2: cam1 has fx 3980, but cam0 has 3979.911; both eyes must have the same",
            ),
            (
                "3979.911 1019.507; 0 0 1]\ndoffs",
                "3979.911 1020; 0 0 1]\ndoffs",
                ":2: cam1 has cy 1020, but cam0 has 1019.507",
            ),
            ("3979.911 0 1244", "3979.911 0.5 1244", ":1: cam0 has a skew of 0.5; it must be 0"),
            ("1019.507; 0 0 1]\ncam1", "1019.507; 0 1 1]\ncam1", ":1: cam0 ends in 0 1 1; its last row"),
            ("[3979.911 0 1244", "[NaN 0 1244", ":1: cam0 is '[NaN"),
            ("[3979.911 0 1244.772;", "[3979.911 0;", ":1: cam0 is '[3979.911 0; 0"),
            ("doffs=124.343", "doffs=124", ":3: doffs is 124, but cx of cam1 minus cx of cam0 is 124.34"),
            ("1369.115", "1000", ":3: doffs is 124.343, but"),
            ("baseline=193.001", "baseline=0", "the baseline is 0; it must be above 0"),
            ("baseline=193.001\n", "", "baseline is missing"),
            ("width=2964", "width=29.5", ":5: width is 29.5; it must be a whole number"),
            ("width=2964", "width=296400", "calib.txt: invalid camera: size is 296400x1988"),
            ("isint=0", "k1=-0.1", ":8: k1 is '-0.1'; this format is for rectified pairs"),
            ("isint=0", "distortion=[0 0 1e-3 0]", ":8: distortion is '[0 0 1e-3 0]'"),
            ("isint=0", "doffs=124.343", ":8: doffs is already given on line 3"),
            ("isint=0", "isint", ":8: 'isint' is not a name, = and a value"),
        ] {
            let message = middlebury(&MOTORCYCLE.replacen(from, to, 1), 1.0).unwrap_err().to_string();
            assert!(message.contains(expected), "{message} should say {expected}");
        }
        let backwards = MOTORCYCLE.replace("1369.115", "1000").replace("doffs=124.343", "doffs=-244.772");
        let message = middlebury(&backwards, 1.0).unwrap_err().to_string();
        assert!(message.contains("doffs is -244.77"), "{message}");
        assert!(middlebury(&(MOTORCYCLE.to_owned() + "k1=0\np1=0.0\n"), 1.0).is_ok());
        for scale in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(middlebury(MOTORCYCLE, scale).unwrap_err().to_string().contains("scale"));
        }
        for text in ["", "\u{0}", "cam0", "=", "\u{feff}\r\n"] {
            assert!(matches!(middlebury(text, 1.0), Err(Error::Parse { .. })));
        }
        assert!(matches!(StereoCamera::from_middlebury("no/such/calib.txt", 1.0), Err(Error::Io { .. })));
    }
}
