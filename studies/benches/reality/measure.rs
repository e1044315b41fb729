//! Measures the cost of ways of rendering. They take turns in each round, and each is rendered once with counters.

use std::time::Instant;

use serde_json::{Value, json};
use stereotrace::{
    Error, GBuffer, Options, Renderer, Rig, Scene, ShadowBufferWork, StereoCamera, UploadedScene, Work, blocking::Wait,
};

use crate::{
    common::{
        provenance::Provenance,
        records::Record,
        rounds::{Spread, order},
    },
    ways::Way,
};

/// Cost of a way of rendering.
#[derive(Clone, Copy)]
pub(crate) struct Measured {
    pub(crate) way: Way,
    /// Frame time by the host's clock in milliseconds, since filling a shadow-buffer belongs to no pass. `None` without
    /// timed rounds.
    pub(crate) ms: Option<Spread>,
    /// Time of its passes in milliseconds.
    passes_ms: Option<Spread>,
    /// Counts of the view.
    pub(crate) work: Work,
    /// Counts of filling a shadow-buffer.
    pub(crate) filling: ShadowBufferWork,
    /// Whether some frame did not fit in one dispatch.
    pub(crate) in_steps: bool,
}

/// A measurement for a figure, with its setting.
pub(crate) struct Sample {
    /// Number of the paper's figure.
    pub(crate) figure: &'static str,
    pub(crate) objects: usize,
    pub(crate) side: u32,
    pub(crate) measured: Measured,
}

impl Sample {
    /// Returns the record for results.csv.
    pub(crate) fn record(&self, provenance: &Provenance) -> Record {
        let Measured { way, ms, passes_ms, work, filling, in_steps } = self.measured;
        let number = |spread: Option<Spread>, of: fn(Spread) -> f64| spread.map_or(Value::Null, |one| json!(of(one)));
        vec![
            ("figure", json!(self.figure)),
            ("objects", json!(self.objects)),
            ("side", json!(self.side)),
            ("way", json!(way.to_string())),
            ("shadow_rows", way.table.map_or(Value::Null, |table| json!(table.rows))),
            ("shadow_kept", way.table.map_or(Value::Null, |table| json!(table.kept))),
            ("shadow_rule", way.table.map_or(Value::Null, |table| json!(table.rule.to_string()))),
            ("ms", number(ms, |one| one.median)),
            ("ms_min", number(ms, |one| one.min)),
            ("ms_max", number(ms, |one| one.max)),
            ("passes_ms", number(passes_ms, |one| one.median)),
            ("primary_rays", json!(work.rays.primary)),
            ("shadow_rays", json!(work.rays.shadow)),
            ("primitive_tests", json!(work.primitive_tests)),
            ("nodes", json!(work.nodes)),
            ("filled_texels", json!(filling.filled)),
            ("filling_tests", json!(filling.primitive_tests)),
            ("filling_nodes", json!(filling.nodes)),
            ("shadow_buffer_bytes", json!(filling.bytes)),
            ("in_steps", json!(in_steps)),
            ("adapter", json!(provenance.adapter)),
            ("driver", json!(provenance.driver)),
            ("commit", json!(provenance.commit)),
            ("date", json!(provenance.date)),
        ]
    }
}

/// A scene seen by one eye.
pub(crate) struct View<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) rig: Rig,
}

impl<'a> View<'a> {
    /// Makes a view from the camera's midpoint.
    pub(crate) fn of(scene: &'a Scene, camera: StereoCamera) -> Self {
        Self { scene, rig: Rig::at(camera, vec![0.0]) }
    }

    /// Measures the cost of each way, in the order of `ways`. Each way is timed in `rounds` rounds after a warm-up
    /// round. If `rounds` is 0, there are no times.
    pub(crate) fn measure(&self, renderer: &mut Renderer, ways: &[Way], rounds: usize) -> Result<Vec<Measured>, Error> {
        let options: Vec<Options> = ways.iter().map(|way| way.options()).collect();
        let mut scenes = Vec::new();
        for way in ways {
            scenes.push(renderer.upload_with(self.scene, way.build()).wait()?);
        }
        let mut times: Vec<Vec<([f64; 2], bool)>> = vec![Vec::new(); ways.len()];
        for round in 0..=rounds {
            if rounds == 0 {
                break;
            }
            let turns: Vec<usize> = if ways.len() > 1 { order(round, ways.len()).collect() } else { vec![0] };
            for index in turns {
                if ways[index].table.is_some_and(|table| !table.kept) {
                    // A scene keeps its shadow-buffers between frames. It is uploaded again, since the paper's times
                    // include filling them.
                    scenes[index] = renderer.upload_with(self.scene, ways[index].build()).wait()?;
                }
                let time = self.time(renderer, &scenes[index], &options[index])?;
                if round > 0 {
                    times[index].push(time);
                }
            }
        }
        let mut all = Vec::new();
        for (index, &way) in ways.iter().enumerate() {
            let scene = renderer.upload_with(self.scene, way.build()).wait()?;
            let mut count =
                || renderer.views(&scene, &self.rig).options(&options[index].clone().count(true)).read().wait();
            if way.table.is_some_and(|table| table.kept) {
                count()?;
            }
            let views = count()?;
            let spread =
                |place: usize| (rounds > 0).then(|| Spread::of(times[index].iter().map(|(time, _)| time[place])));
            all.push(Measured {
                way,
                ms: spread(0),
                passes_ms: spread(1),
                work: views.views[0].work,
                filling: views.shadow_buffer,
                in_steps: views.in_steps || times[index].iter().any(|&(_, in_steps)| in_steps),
            });
        }
        Ok(all)
    }

    /// Returns the milliseconds of a frame by the host's clock and by its passes, and whether the frame took several
    /// dispatches.
    fn time(
        &self,
        renderer: &mut Renderer,
        scene: &UploadedScene,
        options: &Options,
    ) -> Result<([f64; 2], bool), Error> {
        let start = Instant::now();
        let views = renderer.views(scene, &self.rig).options(&options.clone().g_buffer(GBuffer::None)).read().wait()?;
        let wall = 1e3 * start.elapsed().as_secs_f64();
        Ok(([wall, views.times.map_or(f64::NAN, |times| 1e3 * times.total().as_secs_f64())], views.in_steps))
    }
}

/// Measure of a way's cost: time or counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum By {
    Time,
    /// Primitive tests, by which the paper explains its gains. Tests that fill a shadow-buffer are included.
    Tests,
    /// Primitive tests and box tests of a tree, two per node.
    Counters,
}

impl By {
    /// Returns a way's cost, or `None` if it was not timed.
    pub(crate) fn cost(self, measured: &Measured) -> Option<f64> {
        match self {
            Self::Time => measured.ms.map(|ms| ms.median),
            Self::Tests => Some((measured.work.primitive_tests + measured.filling.primitive_tests) as f64),
            Self::Counters => {
                let filling = 2 * measured.filling.nodes + measured.filling.primitive_tests;
                Some((measured.work.cost() + filling) as f64)
            }
        }
    }

    /// Returns the minimum and maximum over the rounds, for times only.
    pub(crate) fn range(self, measured: &Measured) -> Option<[f64; 2]> {
        measured.ms.filter(|_| self == Self::Time).map(|ms| [ms.min, ms.max])
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Tests => "primitive tests",
            Self::Counters => "boxes and primitive tests",
        }
    }

    pub(crate) fn unit(self) -> &'static str {
        match self {
            Self::Time => "milliseconds",
            _ => self.name(),
        }
    }
}

/// Returns the measurement of a way.
pub(crate) fn of_way(all: &[Measured], way: Way) -> Option<&Measured> {
    all.iter().find(|one| one.way == way)
}

/// Returns the ratio of the first way's cost to the second way's.
pub(crate) fn gain(all: &[Measured], dear: Way, cheap: Way, by: By) -> Option<f64> {
    let [dear, cheap] = [dear, cheap].map(|way| of_way(all, way).and_then(|one| by.cost(one)));
    Some(dear? / cheap?).filter(|gain| gain.is_finite())
}
