//! The chart: accuracy against cost, one point a method and scene.

use std::error::Error;

use crate::measure::Measured;

pub(crate) fn svg(_measured: &[Measured]) -> Result<String, Box<dyn Error>> {
    Ok(String::new())
}
