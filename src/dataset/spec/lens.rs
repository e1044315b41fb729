//! The lens of a spec's rig, `rig.lens`.

use serde::Serialize;
use serde_json::Value;

use super::{
    Drawn, Draws, Output, Rig, Spec,
    fields::{Fields, above_zero, fault, finite, list},
    read::drawn,
};
use crate::{Channel, Distortion, Error, Lens, Method, StereoCamera, glam::Vec3};

/// A lens of both eyes, with drawn numbers. Coefficients are in `OpenCV`'s order.
#[derive(Clone, Debug, Serialize)]
pub(in crate::dataset) struct LensEntry {
    fx: Drawn<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fy: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cx: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cy: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    radial_tangential: Option<Vec<Drawn<f64>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fisheye: Option<Vec<Drawn<f64>>>,
}

impl LensEntry {
    /// Returns the lens of a pair with pictures of this size.
    pub(in crate::dataset) fn drawn(&self, draws: &Draws, size: [u32; 2]) -> Result<Lens, Error> {
        let draw = |value: &Drawn<f64>, name: &str| draws.draw(value, &format!("rig.lens.{name}"));
        let [width, height] = size.map(f64::from);
        let fx = draw(&self.fx, "fx");
        let or = |value: &Option<_>, name: &str, usual: f64| value.as_ref().map_or(usual, |value| draw(value, name));
        let lens = Lens::new(
            [fx, or(&self.fy, "fy", fx)],
            [or(&self.cx, "cx", 0.5 * width), or(&self.cy, "cy", 0.5 * height)],
        );
        let numbers = |list: &[Drawn<f64>], name: &str| -> Vec<f64> {
            list.iter().enumerate().map(|(index, value)| draw(value, &format!("{name}.{index}"))).collect()
        };
        let distortion = match (&self.radial_tangential, &self.fisheye) {
            (Some(list), _) => Distortion::opencv(&numbers(list, "radial_tangential"))?,
            (None, Some(list)) => match numbers(list, "fisheye")[..] {
                [k1, k2, k3, k4] => Distortion::fisheye([k1, k2, k3, k4]),
                _ => return fault("rig.lens.fisheye", "it must have 4 coefficients"),
            },
            (None, None) => Distortion::NONE,
        };
        Ok(lens.distortion(distortion))
    }

    /// Returns whether no number is random.
    fn is_fixed(&self) -> bool {
        let Self { fx, fy, cx, cy, radial_tangential, fisheye } = self;
        let singles = [Some(fx), fy.as_ref(), cx.as_ref(), cy.as_ref()].into_iter().flatten();
        let lists = [radial_tangential, fisheye].into_iter().flatten().flatten();
        singles.chain(lists).all(|value| matches!(value, Drawn::Value(_)))
    }
}

pub(super) fn lens(value: &Value, at: &str) -> Result<LensEntry, Error> {
    let fields = Fields::of(value, at)?;
    let found = LensEntry {
        fx: fields.needed("fx", fields.get("fx", drawn(above_zero(f64::INFINITY)))?)?,
        fy: fields.get("fy", drawn(above_zero(f64::INFINITY)))?,
        cx: fields.get("cx", drawn(finite))?,
        cy: fields.get("cy", drawn(finite))?,
        radial_tangential: fields.get("radial_tangential", list(drawn(finite)))?,
        fisheye: fields.get("fisheye", list(drawn(finite)))?,
    };
    fields.end()?;
    match (&found.radial_tangential, &found.fisheye) {
        (Some(_), Some(_)) => fault(at, "a lens is radial_tangential or fisheye; give one of them"),
        (Some(list), _) if ![4, 5, 8].contains(&list.len()) => {
            fault(&fields.path("radial_tangential"), format!("{} coefficients must be 4, 5 or 8", list.len()))
        }
        (_, Some(list)) if list.len() != 4 => {
            fault(&fields.path("fisheye"), format!("{} coefficients must be 4", list.len()))
        }
        _ => Ok(found),
    }
}

/// Refuses fields of the rig that a lens replaces.
pub(super) fn check_alone(rig: &Rig, fields: &Fields<'_>) -> Result<(), Error> {
    let replaced = [
        ("interaxial_px", rig.interaxial_px.is_some()),
        ("screen_distance", rig.screen_distance.is_some()),
        ("fov", rig.fov.is_some()),
        ("fx", rig.fx.is_some()),
        ("projection", rig.around.is_some()),
    ];
    match replaced.iter().find(|(_, is_given)| *is_given && rig.lens.is_some()) {
        Some((key, _)) => {
            fault(&fields.path(key), "eyes with a lens are parallel, and the lens sets their focal length")
        }
        None => Ok(()),
    }
}

/// Refuses a lens with values that need rows.
pub(super) fn check_together(spec: &Spec) -> Result<(), Error> {
    let Some(lens) = &spec.rig.lens else { return Ok(()) };
    for &[width, height] in spec.size.all().iter().filter(|_| lens.is_fixed()) {
        let lens = lens.drawn(&Draws { seed: 0, item: 0, attempt: 0 }, [width, height])?;
        let camera = StereoCamera::look_at(Vec3::ZERO, -Vec3::Z).size(width, height).lens(lens);
        if let Err(error) = camera.pose() {
            return fault("rig.lens", error.to_string());
        }
    }
    if !matches!(spec.options.method, Method::Auto | Method::Naive) {
        let reason = format!("{} reuses rows, but a lens moves points out of them", spec.options.method);
        return fault("render.method", format!("{reason}; use naive or auto"));
    }
    if let Some(layout) = spec.format.layout() {
        let reason = format!("the pairs of {layout} are rectified: use webdataset or parquet, or leave out rig.lens");
        return fault("format", reason);
    }
    if spec.rolling().is_some() {
        return fault("motion.rolling", "its bands are for planar pictures: leave out rig.lens");
    }
    let of_rows = [Output::Channel(Channel::Disparity), Output::DisparityChange];
    let needs_rows = |output: Output| output.is_layer() || of_rows.contains(&output);
    match spec.arrays.iter().find(|array| needs_rows(array.output)) {
        Some(array) => {
            let reason = "a lens moves points out of their rows; use match and match_visibility";
            fault("outputs", format!("{}: {reason}", array.output.name()))
        }
        None => Ok(()),
    }
}
