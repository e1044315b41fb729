//! Computes axes: their ranges, ticks, and the mapping from values to pixels.

/// Scale of a plot's y axis.
#[derive(Clone, Copy)]
pub(super) enum Rule {
    /// A linear scale that includes zero.
    Even,
    /// A linear scale, or a logarithmic one if the values differ too much.
    Amount,
    /// A logarithmic scale, with zero in a row of its own.
    Decades,
}

/// A range of values. On a logarithmic axis, zero and negative values have a row of their own below the lowest decade.
pub(super) struct Axis {
    pub(super) is_log: bool,
    /// Ends of the range; decimal logarithms on a logarithmic axis.
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) zero: bool,
    pub(super) ticks: Vec<f64>,
}

impl Axis {
    /// Height in pixels of the row of zero, with the break above it.
    pub(super) const ZERO_ROW: i32 = 52;

    pub(super) fn of(rule: Rule, values: &[f64]) -> Self {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        match rule {
            Rule::Decades => Self::log(values),
            Rule::Amount if least > 0.0 && most / least > 15.0 => Self::log(values),
            Rule::Amount | Rule::Even => Self::even(least.min(0.0), most.max(0.0), 7.0),
        }
    }

    /// Makes a linear axis with about this number of round steps, whose ends lie on steps.
    pub(super) fn even(low: f64, high: f64, steps: f64) -> Self {
        let rough = if high > low { (high - low) / steps } else { 1.0 };
        let decade = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0].map(|digit| digit * decade).into_iter().find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * decade);
        let (first, last) =
            ((low / step).floor() as i64, ((high / step).ceil() as i64).max((low / step).floor() as i64 + 1));
        let ticks = (first..=last).map(|index| index as f64 * step).collect();
        Self { is_log: false, low: first as f64 * step, high: last as f64 * step, zero: false, ticks }
    }

    /// Makes a linear axis with a tick at each value and a margin at the ends.
    pub(super) fn through(values: impl Iterator<Item = f64>) -> Self {
        let mut ticks: Vec<f64> = values.collect();
        ticks.sort_by(f64::total_cmp);
        ticks.dedup();
        let (low, high) = (ticks.first().copied().unwrap_or(0.0), ticks.last().copied().unwrap_or(0.0));
        let room = if high > low { 0.04 * (high - low) } else { 1.0 };
        Self { is_log: false, low: low - room, high: high + room, zero: false, ticks }
    }

    /// Makes a logarithmic axis with round ends. Ticks are at 1, 2 and 5 of each decade if there are few decades.
    pub(super) fn log(values: &[f64]) -> Self {
        let logs = || values.iter().filter(|value| **value > 0.0).map(|value| value.log10());
        let zero = values.iter().any(|value| *value <= 0.0);
        let (least, most) = (logs().fold(f64::INFINITY, f64::min), logs().fold(f64::NEG_INFINITY, f64::max));
        let (least, most) = if least > most { (0.0, 1.0) } else { (least, most) };
        let digits: &[f64] = if most - least > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let decades = least.floor() as i32..=most.ceil() as i32 + 1;
        let round: Vec<f64> =
            decades.flat_map(|d| digits.iter().map(move |digit| f64::from(d) + digit.log10())).collect();
        let slack = 1e-9; // tolerance for values that are round numbers
        let low = round.iter().copied().filter(|log| *log <= least + slack).fold(least.floor(), f64::max);
        let high = round.iter().copied().find(|log| *log >= most - slack && *log > low).unwrap_or(most.ceil());
        let inside = round.into_iter().filter(|log| (low - slack..=high + slack).contains(log));
        let ticks = zero.then_some(0.0).into_iter().chain(inside.map(|log| 10_f64.powf(log))).collect();
        Self { is_log: true, low, high, zero, ticks }
    }

    /// Returns the pixel of a value between two pixels; `from` is the pixel of the lowest value.
    pub(super) fn place(&self, value: f64, from: i32, to: i32) -> i32 {
        let (start, end) = (f64::from(from), f64::from(to));
        let row = self.zero_row() * (end - start).signum();
        if self.is_log && value <= 0.0 {
            return (start + 0.5 * row).round() as i32;
        }
        let value = if self.is_log { value.log10() } else { value };
        let share = (value - self.low) / (self.high - self.low);
        (start + row + share * (end - start - row)).round() as i32
    }

    /// Returns the height of the row of zero in pixels, or 0 without one.
    pub(super) fn zero_row(&self) -> f64 {
        if self.zero { f64::from(Self::ZERO_ROW) } else { 0.0 }
    }
}

/// Formats a number without trailing zeros.
pub(super) fn label(value: f64) -> String {
    if value != 0.0 && value.abs() < 0.99e-5 {
        return format!("{:.0e}", value);
    }
    let text = format!("{value:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
