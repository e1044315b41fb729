//! Filters rows of samples into rows of pixels.

use std::collections::VecDeque;

use super::{Filter, Jitter, Window, parts::PartSums};
use crate::{
    Options, Tone, View,
    frame::{Rows, ViewRows},
};

/// Filters a picture's samples row by row as they arrive. It holds only the rows of pixels that a row of samples
/// contributes to, at most three.
pub(crate) struct Gather {
    side: u32,
    /// Size of the picture in pixels.
    size: [u32; 2],
    filter: Filter,
    /// Whether linear colour is output too.
    linear: bool,
    /// Factor by which displayed light is multiplied.
    exposure: f32,
    tone: Tone,
    jitter: Jitter,
    /// Windows of the pixel columns, one list for each stratum of sample rows.
    columns: Vec<Vec<Window>>,
    /// A row of samples, filtered along the row.
    across: Vec<[f64; 3]>,
    /// Unfinished rows of pixels that already have samples.
    begun: VecDeque<Begun>,
    centres: Centres,
    /// Whether `centres` is taken from the samples; otherwise it was given.
    from_samples: bool,
    /// The first unfinished row.
    first: u32,
}

/// Data at pixel centres, without colour, of each view's rows that are not yet output.
#[derive(Default)]
pub(crate) struct Centres(VecDeque<Vec<ViewRows>>);

/// A row of pixels in progress.
struct Begun {
    window: Window,
    /// Sums of each view.
    views: Vec<Sums>,
}

/// Sums of a view's row of pixels so far.
#[derive(Clone)]
struct Sums {
    colors: Vec<[f64; 3]>,
    costs: Vec<u32>,
    /// Light in parts, if it is denoised.
    parts: Vec<PartSums>,
}

impl Gather {
    /// Creates the filter of a picture of this size in pixels. `centres` holds the data at pixel centres from the top
    /// down. Without it, the data are taken from each pixel's middle sample. For an even `side` that is the sample to
    /// the right of and below the middle.
    pub(crate) fn new(size: [u32; 2], side: u32, options: &Options, centres: Option<Centres>) -> Self {
        let jitter = Jitter::of(options);
        let columns_of = |stratum: u32| {
            let window = |column| Window::new(options.filter, side, [column, size[0]], jitter.aside(stratum));
            (0..size[0]).map(window).collect()
        };
        Self {
            side,
            size,
            filter: options.filter,
            linear: options.linear,
            exposure: options.exposure.exp2(),
            tone: options.tone,
            jitter,
            columns: (0..jitter.side()).map(columns_of).collect(),
            across: vec![[0.0; 3]; size[0] as usize],
            begun: VecDeque::new(),
            from_samples: centres.is_none(),
            centres: centres.unwrap_or_default(),
            first: 0,
        }
    }

    /// Adds the next rows of samples. Returns the rows of pixels that they complete, if any.
    pub(crate) fn add(&mut self, samples: &Rows) -> Option<Rows> {
        if self.from_samples {
            let picked = samples.views.iter().map(|view| self.picked(samples.first, view)).collect();
            self.centres.add(picked);
        }
        let mut done: Vec<Begun> = Vec::new();
        for row in 0..samples.views[0].view.height {
            let sample = samples.first + row;
            self.begin(sample, samples.views.len());
            for (view, samples) in samples.views.iter().enumerate() {
                self.add_row(sample, view, &samples.view, row);
                self.add_parts(sample, view, samples, row);
            }
            // Usually one row is complete. At the picture's last row of samples several rows are.
            while self.begun.front().is_some_and(|begun| begun.window.end() == sample + 1) {
                done.extend(self.begun.pop_front());
                self.first += 1;
            }
        }
        (!done.is_empty()).then(|| self.hand_on(done))
    }

    /// Begins the rows of pixels whose first samples are in this row.
    fn begin(&mut self, sample: u32, views: usize) {
        let [width, height] = self.size;
        for row in self.first + self.begun.len() as u32..height {
            let window = Window::new(self.filter, self.side, [row, height], 0.0);
            if window.first > sample {
                return;
            }
            let sums = Sums { colors: vec![[0.0; 3]; width as usize], costs: Vec::new(), parts: Vec::new() };
            self.begun.push_back(Begun { window, views: vec![sums; views] });
        }
    }

    /// Adds a row of a view's samples to the rows of pixels that it contributes to.
    fn add_row(&mut self, sample: u32, view: usize, samples: &View, row: u32) {
        let width = samples.width as usize;
        let begin = row as usize * width;
        let colors = &samples.linear[begin..begin + width];
        let columns = &self.columns[self.jitter.stratum(sample) as usize];
        for (sum, window) in self.across.iter_mut().zip(columns) {
            *sum = [0.0; 3];
            for (color, weight) in colors[window.first as usize..].iter().zip(&window.weights) {
                (0..3).for_each(|channel| sum[channel] += weight * f64::from(color[channel]));
            }
        }
        for begun in &mut self.begun {
            // The windows of all begun rows contain this row of samples. A begun row leaves the queue once its last
            // samples were added.
            let weight = begun.window.weights[(sample - begun.window.first) as usize];
            for (color, sum) in begun.views[view].colors.iter_mut().zip(&self.across) {
                (0..3).for_each(|channel| color[channel] += weight * sum[channel]);
            }
        }
        if !samples.cost.is_empty() {
            let costs = samples.cost[begin..begin + width].chunks_exact(self.side as usize);
            let own = &mut self.begun[(sample / self.side - self.first) as usize].views[view].costs;
            own.resize(self.size[0] as usize, 0);
            own.iter_mut().zip(costs).for_each(|(sum, costs)| *sum += costs.iter().sum::<u32>());
        }
    }

    /// Adds the light in parts of a row of a view's samples.
    fn add_parts(&mut self, sample: u32, view: usize, samples: &ViewRows, row: u32) {
        if samples.parts.is_empty() {
            return;
        }
        let width = samples.view.width as usize;
        let parts = &samples.parts[row as usize * width..][..width];
        let columns = &self.columns[self.jitter.stratum(sample) as usize];
        for begun in &mut self.begun {
            let down = begun.window.weights[(sample - begun.window.first) as usize];
            let sums = &mut begun.views[view].parts;
            sums.resize(columns.len(), PartSums::default());
            for (sum, window) in sums.iter_mut().zip(columns) {
                let samples = parts[window.first as usize..].iter().zip(&window.weights);
                samples.for_each(|(parts, across)| sum.add(parts, (down * across) as f32));
            }
        }
    }

    /// Returns the data of the samples at pixel centres, or next to them, without colour and cost.
    fn picked(&self, first: u32, samples: &ViewRows) -> ViewRows {
        let (side, middle) = (self.side, self.side / 2);
        let mut picked = ViewRows::new(self.size[0]);
        let mut places = Vec::new();
        for row in (0..samples.view.height).filter(|row| (first + row) % side == middle) {
            picked.view.height += 1;
            let columns = (0..self.size[0]).map(|column| column * side + middle);
            places.extend(columns.map(|column| row as usize * samples.view.width as usize + column as usize));
        }
        picked.view.depth = at(&places, &samples.view.depth);
        picked.view.primitive = at(&places, &samples.view.primitive);
        picked.view.object = at(&places, &samples.view.object);
        picked.source = at(&places, &samples.source);
        picked.shadow_source = at(&places, &samples.shadow_source);
        picked
    }

    fn hand_on(&mut self, done: Vec<Begun>) -> Rows {
        let rows = done.len() as u32;
        let mut views = self.centres.take(rows, done[0].views.len(), self.size[0]);
        let centre_costs: Vec<_> = views.iter_mut().map(|rows| std::mem::take(&mut rows.view.cost)).collect();
        for sums in done.into_iter().map(|begun| begun.views) {
            for (rows, sums) in views.iter_mut().zip(sums) {
                rows.parts.extend(sums.parts.iter().map(PartSums::means));
                let view = &mut rows.view;
                let linear = sums.colors.iter().map(|color| color.map(|value| value as f32));
                view.rgba8.extend(linear.clone().map(|color| self.tone.rgba8(color, self.exposure)));
                if self.linear {
                    view.linear.extend(linear.map(|[red, green, blue]| [red, green, blue, 1.0]));
                }
                view.cost.extend(sums.costs);
            }
        }
        for (view, costs) in views.iter_mut().zip(centre_costs) {
            view.view.cost.iter_mut().zip(costs).for_each(|(sum, cost)| *sum += cost);
        }
        Rows { first: self.first - rows, views }
    }
}

impl Centres {
    /// Adds the next rows of each view.
    pub(crate) fn add(&mut self, mut rows: Vec<ViewRows>) {
        rows.iter_mut().for_each(|rows| (rows.view.rgba8, rows.view.linear) = (Vec::new(), Vec::new()));
        self.0.push_back(rows);
    }

    /// Takes the next `rows` rows of `views` views of this width.
    pub(crate) fn take(&mut self, rows: u32, views: usize, width: u32) -> Vec<ViewRows> {
        let mut taken: Vec<_> = (0..views).map(|_| ViewRows::new(width)).collect();
        let mut missing = rows;
        while missing > 0 {
            let mut next = self.0.pop_front().expect("a pixel's centre is among its samples");
            let height = next[0].view.height;
            if height > missing {
                let below = next.iter_mut().map(|rows| rows.split_off(missing)).collect();
                self.0.push_front(below);
            }
            missing -= height.min(missing);
            taken.iter_mut().zip(next).for_each(|(taken, next)| taken.append(next));
        }
        taken
    }
}

/// Returns the list's entries at these indices, or nothing if the list is empty.
fn at<T: Copy>(places: &[usize], list: &[T]) -> Vec<T> {
    let places = if list.is_empty() { &[] } else { places };
    places.iter().map(|&place| list[place]).collect()
}
