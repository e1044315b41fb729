//! Renders the film. Its spheres turn once, and every method renders each frame.

use std::f32::consts::TAU;

use stereotrace::{
    Error, Method, Options, Renderer,
    blocking::Wait,
    scene::builtin::{Builtin, spheres_turned},
};

use crate::{common::flicker::Flicker, options::Plan};

/// A method's result for the film.
pub(crate) struct Film {
    pub(crate) method: Method,
    /// Percentage of pixels that flicker, averaged over all frames but the first, or the method's error.
    pub(crate) flicker: Result<f64, String>,
}

/// Renders the film by each method.
pub(crate) fn measure(renderer: &mut Renderer, plan: &Plan) -> Result<Vec<Film>, Error> {
    let camera = Builtin::Spheres.camera(plan.size[0], plan.size[1]);
    let mut flickers: Vec<_> = plan.methods.iter().map(|_| Ok(Flicker::default())).collect();
    for frame in 0..plan.frames {
        let scene = renderer.upload(&spheres_turned(TAU * frame as f32 / plan.frames as f32)?).wait()?;
        let truth = renderer.pair(&scene, &camera).options(&Options::new(Method::Naive)).read().wait()?.right;
        for (&method, state) in plan.methods.iter().zip(&mut flickers) {
            let Ok(flicker) = state else { continue };
            match renderer.pair(&scene, &camera).options(&Options::new(method)).read().wait() {
                Ok(pair) => flicker.add(&pair.right.rgba8, &truth.rgba8),
                Err(error) => *state = Err(error.to_string()),
            }
        }
    }
    let percent = |flicker: Flicker| flicker.percent().ok_or_else(|| "needs two frames".to_owned());
    let films = plan.methods.iter().zip(flickers);
    Ok(films.map(|(&method, flicker)| Film { method, flicker: flicker.and_then(percent) }).collect())
}
