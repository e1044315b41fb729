//! `compare`: measures the cost and the errors of each method on a scene.

use std::{
    error::Error,
    fmt::Write,
    time::{Duration, Instant},
};

use clap::Args;
use serde_json::json;
use stereotrace::{
    Method, StereoPair,
    blocking::Wait,
    message::counted,
    metrics::{Difference, compare},
};

use super::report::{difference_json, scene_line};
use crate::{
    arguments::{Global, Purpose, Subject},
    progress::Progress,
    summary::Summary,
};

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// Methods that are compared with naive, separated by commas
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        default_value = "bracket,verified,atomic,buffer-2e,es-isler"
    )]
    methods: Vec<Method>,
    /// Number of timed pictures per method; the table has their median. Methods take turns, after one untimed picture
    /// each that compiles the kernels
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    #[command(flatten)]
    pub(crate) subject: Subject,
}

/// Figures of one method.
struct Row {
    method: Method,
    times: Vec<Duration>,
    /// Cost of the second eye divided by the first eye's cost, in counted box and primitive tests.
    cost: f64,
    retraced: f64,
    difference: Difference,
}

impl Row {
    fn median(&self) -> f64 {
        let mut times = self.times.clone();
        times.sort_unstable();
        times.get(times.len() / 2).map_or(f64::NAN, Duration::as_secs_f64)
    }
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let mut stage = arguments.subject.open(Purpose::Data, global)?;
    let mut methods = vec![Method::Naive];
    methods.extend(arguments.methods.iter().filter(|&&method| method != Method::Naive));
    let pictures = methods.len() as u32 * (arguments.rounds + 1);
    let mut progress = Progress::new(global, pictures);

    let mut naive: Option<StereoPair> = None;
    let mut rows = Vec::new();
    for &method in &methods {
        let options = stage.options.clone().method(method).count(true);
        let pair = stage.render(stage.camera, options, &mut progress)?;
        progress.next();
        let difference = compare(&pair.right, &naive.as_ref().unwrap_or(&pair).right, &pair.pose)?;
        let (cost, retraced) = (pair.statistics.second_eye(), pair.statistics.retraced_share());
        rows.push(Row { method, times: Vec::new(), cost, retraced, difference });
        naive.get_or_insert(pair);
    }
    for round in 0..=arguments.rounds {
        for row in &mut rows {
            let options = stage.options.clone().method(row.method).count(false);
            let begin = Instant::now();
            stage.renderer.pair(&stage.uploaded, &stage.camera).options(&options).trace().wait()?;
            // The first round compiles the pipelines without counters.
            if round > 0 {
                row.times.push(begin.elapsed());
                progress.next();
            }
        }
    }
    progress.clear();

    let [width, height] = stage.camera.pose()?.size;
    let adapter = stage.renderer.gpu().adapter_name();
    let mut text = format!("adapter    {adapter}\nscene      {}, {width}x{height}\n\n", scene_line(&stage));
    let heading = ["method", "pair, ms", "of naive", "2nd eye", "traced", "identical", "wrong", "PSNR"];
    let [name, ms, share, cost, traced, identical, wrong, psnr] = heading;
    writeln!(text, "{name:<15}{ms:>10}{share:>10}{cost:>9}{traced:>9}{identical:>11}{wrong:>9}{psnr:>9}")?;
    let of_naive = rows[0].median();
    for row in &rows {
        let Difference { identical_percent, wrong_surface_percent, psnr, .. } = row.difference;
        // The percentage is rounded down, so that 100.00% means that all pixels are identical.
        let identical = (100.0 * identical_percent).floor() / 100.0;
        writeln!(
            text,
            "{:<15}{:>10.1}{:>10.3}{:>9.3}{:>8.1}%{identical:>10.2}%{wrong_surface_percent:>8.3}%{psnr:>6.1} dB",
            row.method.to_string(),
            1e3 * row.median(),
            row.median() / of_naive,
            row.cost,
            100.0 * row.retraced,
        )?;
    }
    let rounds = counted(arguments.rounds, "picture", "pictures");
    writeln!(
        text,
        "\nTimes are medians of {rounds}; the methods take turns. 2nd eye: its cost divided by the first eye's, by \
         counters (nodes and primitive tests).\ntraced: share of its pixels that were traced. identical, wrong \
         (another surface) and PSNR: compared with naive."
    )?;
    let listed = rows.iter().map(|row| {
        json!({
            "method": row.method.to_string(),
            "ms": 1e3 * row.median(),
            "of_naive": row.median() / of_naive,
            "second_eye": row.cost,
            "retraced_share": row.retraced,
            "to_naive": difference_json(&row.difference),
        })
    });
    let json = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "adapter": adapter,
        "scene": stage.name,
        "size": [width, height],
        "rounds": arguments.rounds,
        "methods": Vec::from_iter(listed),
    });
    Ok(Summary { text, json, ..Summary::default() })
}
