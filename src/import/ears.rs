//! Clips the ears of plane polygons.
//! Every corner is kept, so that neighbouring faces have no gaps and corners keep their normals. The crate `earcut`
//! (0.4) leaves the tests' comb uncovered, and takes over a minute for 100,000 corners.

use std::collections::VecDeque;

use glam::DVec2;

/// Largest number of steps per corner. 100,000 spikes of random length take 340 steps per corner. Only polygons with
/// thousands of coincident corners take more.
const STEPS_PER_CORNER: usize = 500;

/// Cuts off the ears of a polygon one by one. An ear is the triangle of a corner and its neighbours if no other part of
/// the polygon reaches into it. Returns `None` if it fails.
pub(crate) fn cut_ears(points: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    let mut ring = Ring::new(points);
    let mut ears = Vec::with_capacity(points.len() - 2);
    // Ears that the polygon touches, and those without area, are only cut if there are no others. They occur where a
    // doubled edge joins a hole to the outline.
    for touched in [false, true] {
        let mut queue: VecDeque<usize> = (0..points.len()).filter(|&corner| !ring.is_cut[corner]).collect();
        while let Some(corner) = queue.pop_front() {
            if ring.steps > STEPS_PER_CORNER * points.len() {
                return None;
            }
            if ring.is_cut[corner] || !ring.is_ear(corner, touched) {
                continue;
            }
            let [before, after] = ring.neighbours[corner];
            ears.push([before, corner, after]);
            if ears.len() == points.len() - 2 {
                return Some(ears);
            }
            ring.cut(corner);
            // No other corner's triangle changes.
            queue.extend([before, after]);
        }
    }
    None
}

/// Returns twice the signed area of a triangle, positive if it turns to the left.
fn area([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - a)
}

/// The remaining corners, and a tree of those that must not lie in an ear.
struct Ring<'a> {
    points: &'a [DVec2],
    /// The previous and the next corner of each corner.
    neighbours: Vec<[usize; 2]>,
    is_cut: Vec<bool>,
    /// Boxes around the corners at which the polygon doesn't turn left. If anything reaches into an ear, one of these
    /// does. The root is 1, children are 2n and 2n + 1, and the leaves start at `points.len()`. Neighbouring leaves are
    /// close to each other.
    boxes: Vec<[DVec2; 2]>,
    /// The corner of each leaf, and the leaf of each corner.
    corner_of: Vec<usize>,
    leaf_of: Vec<usize>,
    /// Number of visited nodes.
    steps: usize,
}

const EMPTY: [DVec2; 2] = [DVec2::INFINITY, DVec2::NEG_INFINITY];

impl<'a> Ring<'a> {
    fn new(points: &'a [DVec2]) -> Self {
        let count = points.len();
        let neighbours: Vec<_> =
            (0..count).map(|corner| [(corner + count - 1) % count, (corner + 1) % count]).collect();
        let (corner_of, leaf_of) = in_squares(points);
        let (is_cut, boxes) = (vec![false; count], vec![EMPTY; 2 * count]);
        let mut ring = Self { points, neighbours, is_cut, boxes, corner_of, leaf_of, steps: 0 };
        for corner in 0..count {
            ring.boxes[count + ring.leaf_of[corner]] = ring.leaf(corner);
        }
        for node in (1..count).rev() {
            ring.boxes[node] = ring.joined(node);
        }
        ring
    }

    fn triangle(&self, corner: usize) -> [DVec2; 3] {
        let [before, after] = self.neighbours[corner];
        [before, corner, after].map(|corner| self.points[corner])
    }

    fn leaf(&self, corner: usize) -> [DVec2; 2] {
        let turns_left = area(self.triangle(corner)) > 0.0;
        if turns_left || self.is_cut[corner] { EMPTY } else { [self.points[corner]; 2] }
    }

    fn joined(&self, node: usize) -> [DVec2; 2] {
        let [a, b] = [self.boxes[2 * node], self.boxes[2 * node + 1]];
        [a[0].min(b[0]), a[1].max(b[1])]
    }

    fn cut(&mut self, corner: usize) {
        let [before, after] = self.neighbours[corner];
        self.neighbours[before][1] = after;
        self.neighbours[after][0] = before;
        self.is_cut[corner] = true;
        for changed in [before, corner, after] {
            let mut node = self.points.len() + self.leaf_of[changed];
            self.boxes[node] = self.leaf(changed);
            while node > 1 {
                node /= 2;
                self.boxes[node] = self.joined(node);
            }
        }
    }

    fn is_ear(&mut self, corner: usize, touched: bool) -> bool {
        let ear = self.triangle(corner);
        let turn = area(ear);
        if turn <= 0.0 {
            return turn == 0.0 && touched;
        }
        let [before, after] = self.neighbours[corner];
        let mut stack = vec![1];
        while let Some(node) = stack.pop() {
            self.steps += 1;
            if !meets(self.boxes[node], ear) {
                continue;
            }
            match node.checked_sub(self.points.len()).map(|leaf| self.corner_of[leaf]) {
                None => stack.extend([2 * node, 2 * node + 1]),
                Some(other) if [before, corner, after].contains(&other) => {}
                Some(other) if touched && !self.reaches_in(other, ear) => {}
                Some(_) => return false,
            }
        }
        true
    }

    /// Returns whether the polygon continues into the ear from a corner within the ear or on its rim.
    fn reaches_in(&self, corner: usize, ear: [DVec2; 3]) -> bool {
        let sides = [0, 1, 2].map(|side| [ear[side], ear[(side + 1) % 3]]);
        let inside = |neighbour: usize| {
            let beyond = |&[a, b]: &[DVec2; 2]| area([a, b, self.points[neighbour]]) > 0.0;
            sides.iter().filter(|[a, b]| area([*a, *b, self.points[corner]]) == 0.0).all(beyond)
        };
        self.neighbours[corner].into_iter().any(inside)
    }
}

/// Returns the points' order along the Morton curve, and the position of each point in this order.
fn in_squares(points: &[DVec2]) -> (Vec<usize>, Vec<usize>) {
    let low = points.iter().copied().reduce(DVec2::min).unwrap_or_default();
    let size = points.iter().fold(0.0, |size: f64, &point| size.max((point - low).max_element()));
    let spread = |value: f64| (0..32).fold(0, |bits, bit| bits | ((value as u64 >> bit & 1) << (2 * bit)));
    let key = |corner: &usize| {
        let at = (points[*corner] - low) / size * f64::from(u32::MAX);
        spread(at.x) | spread(at.y) << 1
    };
    let mut along: Vec<usize> = (0..points.len()).collect();
    along.sort_by_cached_key(key);
    let mut place = vec![0; points.len()];
    along.iter().enumerate().for_each(|(index, &corner)| place[corner] = index);
    (along, place)
}

/// Returns whether a box and a triangle that turns left have a point in common. A box may be a single point.
fn meets([low, high]: [DVec2; 2], triangle: [DVec2; 3]) -> bool {
    let [a, b, c] = triangle;
    if low.cmpgt(a.max(b).max(c)).any() || high.cmplt(a.min(b).min(c)).any() {
        return false;
    }
    // For each edge, test the box's corner that is farthest on the inner side.
    [[a, b], [b, c], [c, a]].iter().all(|&[from, to]| {
        let along = to - from;
        let x = if along.y > 0.0 { low.x } else { high.x };
        let y = if along.x > 0.0 { high.y } else { low.y };
        area([from, to, DVec2::new(x, y)]) >= 0.0
    })
}
