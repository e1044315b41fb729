//! Measures the methods on a trial.

use stereotrace::{
    Method, Options, Renderer, StereoPair, UploadedScene,
    blocking::Wait,
    metrics::{self, Difference},
    testing::suite::Trial,
};

use crate::options::Plan;

/// A method's result on a trial.
pub(crate) struct Row {
    pub(crate) trial: Trial,
    pub(crate) method: Method,
    /// The figures, or the method's error.
    pub(crate) figures: Result<Figures, String>,
}

/// Cost in counted box and primitive tests, and accuracy against naive.
pub(crate) struct Figures {
    /// Cost of the right view, relative to the left view.
    pub(crate) second_eye: f64,
    /// Cost of the pair, relative to naive's pair.
    pub(crate) of_naive: f64,
    /// Difference of the right view from naive's.
    pub(crate) difference: Difference,
}

/// Measures each method on a trial. Rendering errors are stored in the rows.
pub(crate) fn measure(renderer: &mut Renderer, trial: Trial, plan: &Plan) -> Vec<Row> {
    let camera = trial.camera(plan.size[0], plan.size[1]);
    let scene = if plan.rich { trial.rich_scene() } else { trial.scene() };
    let render = |renderer: &mut Renderer, scene: &UploadedScene, method| {
        renderer
            .pair(scene, &camera)
            .options(&Options::new(method).samples(if plan.rich { 4 } else { 1 }).count(true))
            .read()
            .wait()
    };
    let truth = renderer.upload(&scene).wait().and_then(|scene| {
        let naive = render(renderer, &scene, Method::Naive)?;
        Ok((scene, naive))
    });
    let figures = |method| {
        let (scene, naive) = truth.as_ref().map_err(|error| format!("naive: {error}"))?;
        let pair = render(renderer, scene, method).map_err(|error| error.to_string())?;
        let difference = metrics::compare(&pair.right, &naive.right, &pair.pose).map_err(|error| error.to_string())?;
        Ok(Figures { second_eye: pair.statistics.second_eye(), of_naive: cost(&pair) / cost(naive), difference })
    };
    let figures: Vec<_> = plan.methods.iter().copied().map(figures).collect();
    plan.methods.iter().zip(figures).map(|(&method, figures)| Row { trial, method, figures }).collect()
}

/// Returns the cost of both eyes, in counted box and primitive tests.
fn cost(pair: &StereoPair) -> f64 {
    (pair.statistics.left.cost() + pair.statistics.right.cost()) as f64
}
