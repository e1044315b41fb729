//! Arranges the views of a rig as a quilt, one picture for light-field displays.

use super::Picture;
use crate::{Error, Views};

/// Arranges all views in one picture for light-field displays: in the rig's order from left to right, bottom row first.
///
/// # Errors
/// [`Error::Rig`] if `columns * rows` is not the number of views.
pub fn quilt(views: &Views, columns: u32, rows: u32) -> Result<Picture, Error> {
    let count = views.views.len();
    if u64::from(columns) * u64::from(rows) != count as u64 {
        let views = crate::message::counted(count, "view", "views");
        return Err(Error::Rig { reason: format!("a quilt of {columns}x{rows} is not filled by {views}") });
    }
    let [width, height] = views.pose.size;
    let (across, tall) = (width as usize * columns as usize, height as usize * rows as usize);
    let mut rgba8 = vec![[0; 4]; across * tall];
    for (index, view) in views.views.iter().enumerate() {
        let (column, row) = (index % columns as usize, rows as usize - 1 - index / columns as usize);
        for (y, pixels) in view.view.rgba8.chunks_exact(width as usize).enumerate() {
            let begin = (row * height as usize + y) * across + column * width as usize;
            rgba8[begin..begin + pixels.len()].copy_from_slice(pixels);
        }
    }
    Ok(Picture { width: across as u32, height: tall as u32, rgba8 })
}

/// Returns the file name that tells players a quilt's layout: `NAME_qsCxRaA.png`, where A is the width of a view
/// divided by its height on the display. Its pixels need not be square.
pub fn quilt_name(name: &str, views: &Views, columns: u32, rows: u32) -> String {
    let [width, height] = views.pose.size.map(f64::from);
    let [fx, fy] = views.pose.focal_px().unwrap_or([1.0; 2]);
    // The ratio has as few digits as needed: 1.5, 0.75, 1.7778.
    let aspect = format!("{:.4}", (width / fx) / (height / fy));
    format!("{name}_qs{columns}x{rows}a{}.png", aspect.trim_end_matches('0').trim_end_matches('.'))
}
