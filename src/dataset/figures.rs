//! Statistics of a view.

/// Percentages of surfaces whose disparities a record lists.
const PERCENTS: [f64; 7] = [1.0, 5.0, 25.0, 50.0, 75.0, 95.0, 99.0];
/// Step of depth at the edge of a thin structure, as a share of its depth.
const STEP: f32 = 0.05;
/// Largest width of a thin structure, as a share of the picture's width.
const THIN: usize = 64;

/// Returns the disparities that 1, 5, 25, 50, 75, 95 and 99 percent of the surfaces do not exceed, or `None` without
/// surfaces. A percentile is the value at the nearest rank.
pub(super) fn percentiles(mut values: Vec<f32>) -> Option<[f64; 7]> {
    if values.is_empty() {
        return None;
    }
    values.sort_unstable_by(f32::total_cmp);
    Some(PERCENTS.map(|percent| {
        let rank = (percent / 100.0 * values.len() as f64).ceil() as usize;
        f64::from(values[rank.clamp(1, values.len()) - 1])
    }))
}

/// Returns the number of pixels on thin structures. A thin structure is a run of pixels in a row, at most a 64th of the
/// width long. Neighbouring depths in the run differ by less than 5%, and the pixels on both sides of it are farther by
/// at least 5%.
pub(super) fn thin_count(depth: &[f32], width: usize) -> usize {
    let longest = (width / THIN).max(1);
    depth.chunks(width).map(|row| thin_in_row(row, longest)).sum()
}

fn thin_in_row(row: &[f32], longest: usize) -> usize {
    let is_farther = |other: f32, than: f32| other >= than * (1.0 + STEP);
    let (mut count, mut begin) = (0, 0);
    for end in 1..=row.len() {
        let continues = end < row.len() && !is_farther(row[end], row[end - 1]) && !is_farther(row[end - 1], row[end]);
        if continues {
            continue;
        }
        let is_inside = begin > 0 && end < row.len() && row[begin].is_finite();
        if is_inside
            && end - begin <= longest
            && is_farther(row[begin - 1], row[begin])
            && is_farther(row[end], row[end - 1])
        {
            count += end - begin;
        }
        begin = end;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_values_at_ranks() {
        let values = (1..=200).rev().map(|value| value as f32).collect();
        assert_eq!(percentiles(values), Some([2.0, 10.0, 50.0, 100.0, 150.0, 190.0, 198.0]));
        assert_eq!(percentiles(vec![3.0]), Some([3.0; 7]));
        assert_eq!(percentiles(Vec::new()), None);
    }

    #[test]
    fn thin_structures_are_short_runs_before_something_farther() {
        const FAR: f32 = f32::INFINITY;
        // Width 128: runs of at most two pixels count.
        let row = |pixels: &[(usize, f32)]| {
            let mut row = vec![9.0; 128];
            pixels.iter().for_each(|&(place, depth)| row[place] = depth);
            row
        };
        let count = |pixels: &[(usize, f32)]| thin_count(&row(pixels), 128);
        assert_eq!(count(&[]), 0);
        assert_eq!(count(&[(40, 3.0), (41, 3.1), (60, 5.0)]), 3, "two bars");
        assert_eq!(count(&[(40, 3.0), (41, 3.0), (42, 3.0)]), 0, "it is too wide");
        assert_eq!(count(&[(0, 3.0), (127, 3.0)]), 0, "their other sides are outside the picture");
        assert_eq!(count(&[(40, 12.0), (41, 12.0)]), 0, "a gap is behind its sides");
        assert_eq!(count(&[(40, 8.7)]), 0, "its step is below 5%");
        assert_eq!(count(&[(40, 4.0), (41, 3.0)]), 1, "a bar before another one, which hides its other side");
        assert_eq!(thin_count(&[FAR, 3.0, FAR, FAR], 4), 1, "a wire before the sky");
        assert_eq!(thin_count(&[FAR, 3.0, 9.0, FAR, 9.0, 9.0, 3.0, 9.0], 4), 2, "rows are apart");
    }
}
