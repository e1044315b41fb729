//! Adaptive sampling of some rows of a view: decides which cells are divided, and computes the colours of pixels
//! (Whitted 1980; Adelson & Hodges 1993, "Reflection and Refraction with Multiple Rays Per Pixel").
//!
//! Samples of level l lie on a lattice with spacing 2^-l pixels, from the picture's top left corner to its right and
//! lower borders. A cell of level 0 is a pixel with a sample in each corner, shared with its neighbours. A cell whose
//! corners differ is divided into four cells of the next level.

use crate::{View, frame::wanted::Mask, view::camera::Parallax};

/// The cells of one view, in some rows of pixels.
pub(crate) struct Cells {
    /// Columns and rows of pixels.
    size: [u32; 2],
    levels: Vec<Level>,
}

/// The samples of a level. Samples that were not requested carry no mark; callers know which are valid.
#[derive(Default)]
struct Level {
    linear: Vec<[f32; 3]>,
    shown: Vec<[u8; 4]>,
    depth: Vec<f32>,
    cost: Vec<u32>,
    /// Whether each cell of the level is divided.
    divided: Vec<bool>,
}

/// A surface has nearly the same depth at neighbouring samples of both views. A depth below this share of the surface's
/// depth belongs to another surface in front.
const HIDDEN: f32 = 0.98;

impl Cells {
    /// Creates cells of `levels` levels without samples, for a size in pixels.
    pub(crate) fn new(size: [u32; 2], levels: u32) -> Self {
        Self { size, levels: (0..levels).map(|_| Level::default()).collect() }
    }

    /// Returns the numbers of samples of a level in x and y.
    fn samples(&self, level: u32) -> [u32; 2] {
        self.size.map(|pixels| (pixels << level) + 1)
    }

    fn cells(&self, level: u32) -> [u32; 2] {
        self.size.map(|pixels| pixels << level)
    }

    /// Adds the next rows of a level's samples.
    pub(crate) fn add(&mut self, level: u32, rows: View) {
        let level = &mut self.levels[level as usize];
        level.linear.extend(rows.linear.iter().map(|&[red, green, blue, _]| [red, green, blue]));
        level.shown.extend(rows.rgba8);
        level.depth.extend(rows.depth);
        level.cost.extend(rows.cost);
    }

    /// Returns the first level that has a sample, and the sample's index there.
    fn sample(&self, mut level: u32, mut at: [u32; 2]) -> (&Level, usize) {
        while level > 0 && at[0].is_multiple_of(2) && at[1].is_multiple_of(2) {
            at = at.map(|place| place / 2);
            level -= 1;
        }
        (&self.levels[level as usize], (at[1] * self.samples(level)[0] + at[0]) as usize)
    }

    fn corners(&self, level: u32, [x, y]: [u32; 2]) -> [(&Level, usize); 4] {
        [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]].map(|at| self.sample(level, at))
    }

    /// Returns whether a cell exists, that is, whether its parent is divided.
    fn is_there(&self, level: u32, [x, y]: [u32; 2]) -> bool {
        level == 0 || self.is_divided(level - 1, [x / 2, y / 2])
    }

    fn is_divided(&self, level: u32, [x, y]: [u32; 2]) -> bool {
        let divided = &self.levels[level as usize].divided;
        !divided.is_empty() && divided[(y * self.cells(level)[0] + x) as usize]
    }

    /// Returns whether the displayed corners of a cell differ by more than the tolerance in some channel.
    fn differs(&self, level: u32, at: [u32; 2], tolerance: f32) -> bool {
        let corners = self.corners(level, at).map(|(level, place)| level.shown[place]);
        (0..3).any(|channel| {
            let values = corners.map(|corner| corner[channel]);
            let spread =
                |values: [u8; 4]| values.iter().max().zip(values.iter().min()).map(|(most, least)| most - least);
            spread(values).is_some_and(|spread| f32::from(spread) > tolerance)
        })
    }

    /// Returns, for each cell of a level, whether its corners differ.
    pub(crate) fn differing(&self, level: u32, tolerance: f32) -> Vec<bool> {
        let [across, down] = self.cells(level);
        let cells = (0..down).flat_map(|y| (0..across).map(move |x| [x, y]));
        cells.map(|at| self.is_there(level, at) && self.differs(level, at, tolerance)).collect()
    }

    /// Marks cells of another view as divided if they show the points of this view's differing cells, since they may
    /// differ too.
    pub(crate) fn seen_by(
        &self,
        other: &Self,
        level: u32,
        differing: &[bool],
        parallax: Parallax,
        divided: &mut [bool],
    ) {
        let across = self.cells(level)[0];
        let scale = (1u32 << level) as f32;
        for (place, _) in differing.iter().enumerate().filter(|(_, differs)| **differs) {
            let [x, y] = [place as u32 % across, place as u32 / across];
            let nearest = |cells: &Self, at| {
                let depths = cells.corners(level, at).map(|(level, place)| level.depth[place]);
                depths.into_iter().fold(f32::INFINITY, f32::min)
            };
            // Edges of the nearer surface appear in both views.
            let depth = nearest(self, [x, y]);
            let landed = x as f32 + parallax.times(scale).px(depth);
            for column in [landed.floor(), landed.ceil()] {
                if column < 0.0 || column >= across as f32 {
                    continue;
                }
                let at = [column as u32, y];
                if other.is_there(level, at) && nearest(other, at) >= HIDDEN * depth.min(f32::MAX) {
                    divided[(at[1] * across + at[0]) as usize] = true;
                }
            }
        }
    }

    /// Divides the marked cells of a level, if they exist.
    pub(crate) fn divide(&mut self, level: u32, mut divided: Vec<bool>) {
        let across = self.cells(level)[0];
        for (place, divided) in divided.iter_mut().enumerate() {
            *divided &= self.is_there(level, [place as u32 % across, place as u32 / across]);
        }
        self.levels[level as usize].divided = divided;
    }

    /// Returns a mask of the samples of a level that the divided cells of the previous level need. Its rows begin at
    /// row `first` of the picture's lattice. Each divided cell needs five new samples; with `again`, its four corners
    /// too.
    pub(crate) fn wanted(&self, level: u32, first: u32, again: bool) -> Mask {
        let [samples_across, samples_down] = self.samples(level);
        let mut mask = Mask::new(samples_across, first..first + samples_down);
        let [across, _] = self.cells(level - 1);
        let divided = self.levels[level as usize - 1].divided.iter().enumerate().filter(|(_, divided)| **divided);
        for (place, _) in divided {
            let [x, y] = [place as u32 % across, place as u32 / across].map(|place| 2 * place);
            for [dx, dy] in (0..3).flat_map(|dy| (0..3).map(move |dx| [dx, dy])) {
                if again || (dx == 1 || dy == 1) {
                    mask.want(x + dx, first + y + dy);
                }
            }
        }
        mask
    }

    /// Returns the linear colour of a cell: the mean of its corners, or of the four cells that it is divided into.
    fn color(&self, level: u32, [x, y]: [u32; 2]) -> [f64; 3] {
        let four = if self.is_divided(level, [x, y]) {
            let [x, y] = [2 * x, 2 * y];
            [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]].map(|at| self.color(level + 1, at))
        } else {
            self.corners(level, [x, y]).map(|(level, place)| level.linear[place].map(f64::from))
        };
        std::array::from_fn(|channel| 0.25 * four.iter().map(|color| color[channel]).sum::<f64>())
    }

    /// Returns the linear colours of a row of pixels.
    pub(crate) fn row(&self, row: u32) -> impl Iterator<Item = [f32; 3]> + '_ {
        (0..self.size[0]).map(move |column| self.color(0, [column, row]).map(|value| value as f32))
    }

    /// Returns the cost of each pixel's samples, row by row. Samples on a border count for the pixel to its right or
    /// below it. The list is empty if samples have no costs.
    pub(crate) fn costs(&self) -> Vec<u32> {
        let mut costs = Vec::new();
        for (level, samples) in (0..).zip(&self.levels) {
            let across = self.samples(level)[0] as usize;
            for (place, cost) in samples.cost.iter().enumerate() {
                costs.resize((self.size[0] * self.size[1]) as usize, 0);
                let [x, y] = [place % across, place / across].map(|place| place as u32 >> level);
                let [x, y] = [x.min(self.size[0] - 1), y.min(self.size[1] - 1)];
                costs[(y * self.size[0] + x) as usize] += cost;
            }
        }
        costs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::View;

    const LEVELS: u32 = 4;

    /// Samples a function of the position in pixels, with values 0 to 1, at all places of a level.
    fn level(size: [u32; 2], level: u32, color: impl Fn([f64; 2]) -> f64) -> View {
        let [width, height] = size.map(|pixels| (pixels << level) + 1);
        let scale = 1.0 / f64::from(1 << level);
        let places = (0..height).flat_map(|y| (0..width).map(move |x| [x, y].map(|place| f64::from(place) * scale)));
        let values: Vec<f32> = places.map(|at| color(at) as f32).collect();
        View {
            width,
            height,
            rgba8: values.iter().map(|value| [(255.0 * value) as u8, 0, 0, 255]).collect(),
            linear: values.iter().map(|value| [*value, 0.0, 0.0, 1.0]).collect(),
            depth: vec![2.0; values.len()],
            primitive: Vec::new(),
            object: Vec::new(),
            albedo: Vec::new(),
            cost: vec![1; values.len()],
        }
    }

    fn divided(size: [u32; 2], color: impl Fn([f64; 2]) -> f64, tolerance: f32) -> Cells {
        let mut cells = Cells::new(size, LEVELS);
        for l in 0..LEVELS {
            cells.add(l, level(size, l, &color));
            if l + 1 < LEVELS {
                let differing = cells.differing(l, tolerance);
                cells.divide(l, differing);
            }
        }
        cells
    }

    /// Computes the value of a cell by Whitted's recursion, without lattices.
    fn by_recursion(color: &impl Fn([f64; 2]) -> f64, [x, y]: [f64; 2], side: f64, level: u32, tolerance: f64) -> f64 {
        let corners = [[x, y], [x + side, y], [x, y + side], [x + side, y + side]];
        let values = corners.map(|at| f64::from(color(at) as f32));
        let shown = values.map(|value| (255.0 * value as f32).floor());
        let spread = shown.into_iter().fold(0.0, f32::max) - shown.into_iter().fold(255.0, f32::min);
        if level + 1 < LEVELS && f64::from(spread) > tolerance {
            let half = 0.5 * side;
            let parts = [[x, y], [x + half, y], [x, y + half], [x + half, y + half]];
            return parts.map(|at| by_recursion(color, at, half, level + 1, tolerance)).iter().sum::<f64>() / 4.0;
        }
        values.iter().sum::<f64>() / 4.0
    }

    #[test]
    fn pixels_are_what_the_recursion_makes_of_them() {
        let disc = |[x, y]: [f64; 2]| f64::from(u8::from((x - 3.3).hypot(y - 2.1) < 1.7)) * 0.8 + 0.01 * x;
        let wave = |[x, y]: [f64; 2]| 0.5 + 0.5 * (7.0 * x).sin() * (3.0 * y).cos();
        let both: [&dyn Fn([f64; 2]) -> f64; 2] = [&disc, &wave];
        for color in both {
            for tolerance in [0.0, 12.0, 300.0] {
                let cells = divided([7, 5], color, tolerance);
                for row in 0..5 {
                    for (column, found) in (0..).zip(cells.row(row)) {
                        let at = [f64::from(column), f64::from(row)];
                        let expected = by_recursion(&color, at, 1.0, 0, tolerance.into());
                        assert!((f64::from(found[0]) - expected).abs() < 1e-6, "{at:?}: {found:?} {expected}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_wanted_is_what_divided_cells_lack() {
        let edge = |[x, _]: [f64; 2]| f64::from(u8::from(x > 2.4));
        let cells = divided([5, 3], edge, 0.0);
        // One column of pixels is divided: each lattice row there has three samples, two of which may exist already.
        let first = cells.wanted(1, 10, false);
        assert_eq!(first.count(10..17), 4 + 3 * 3, "in rows of corners one between, in others three");
        assert!(first.wants(5, 10) && !first.wants(4, 10) && first.wants(4, 11));
        assert_eq!(cells.wanted(1, 10, true).count(10..17), 7 * 3);
        // The half with the edge is divided again: two cells of the next level per pixel.
        assert_eq!(cells.wanted(2, 20, true).count(20..33), 13 * 3);
        let still = divided([5, 3], edge, 255.0);
        assert_eq!(still.wanted(1, 0, true).count(0..7), 0);
        assert_eq!(cells.costs().iter().sum::<u32>(), 6 * 4 + 11 * 7 + 21 * 13 + 41 * 25);
    }

    #[test]
    fn an_edge_is_divided_where_the_other_view_shows_it() {
        let left = divided([8, 2], |[x, _]| f64::from(u8::from(x > 2.4)), 0.0);
        let mut right = divided([8, 2], |_| 0.0, 0.0);
        // 3 pixels at a depth of 2.
        let between = Parallax::Circle { px_per_radian: -1.5 / 0.25_f32.atan(), radius: 0.5 };
        let mut found = vec![false; 16];
        left.seen_by(&right, 0, &left.differing(0, 0.0), between, &mut found);
        assert_eq!(
            found.iter().enumerate().filter(|(_, found)| **found).map(|(at, _)| at).collect::<Vec<_>>(),
            [5, 13]
        );
        // A nearer surface now hides the edge.
        right.levels[0].depth.iter_mut().for_each(|depth| *depth = 1.9);
        let mut hidden = vec![false; 16];
        left.seen_by(&right, 0, &left.differing(0, 0.0), between, &mut hidden);
        assert!(!hidden.contains(&true));
    }
}
