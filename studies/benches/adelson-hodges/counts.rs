//! Rays, as the paper counts them.

use stereotrace::{Error, Finish, Method, Options, Renderer, Scene, StereoCamera, StereoPair, blocking::Wait};

/// Levels of rays, the paper's L: what it calls common.
pub(crate) const LEVELS: u32 = 5;

/// Counted, with as many levels.
pub(crate) fn options(method: Method) -> Options {
    Options::new(method).count(true).bounces(LEVELS - 1)
}

/// The same scene with dull surfaces in place of mirrors and glass.
pub(crate) fn dull(scene: &Scene) -> Scene {
    changed(scene, |finish, _| *finish = Finish::Matte)
}

/// The same scene with glass that reflects nothing: a ray goes through it, and no other one begins there.
pub(crate) fn clear(scene: &Scene) -> Scene {
    changed(scene, |finish, specular| {
        if let Finish::Glass { fresnel, .. } = finish {
            (*fresnel, *specular) = (false, 0.0);
        }
    })
}

/// With another finish, and another share that is reflected, of each material.
fn changed(scene: &Scene, change: impl Fn(&mut Finish, &mut f32)) -> Scene {
    let mut other = scene.clone();
    for (index, material) in scene.materials().iter().enumerate() {
        let (mut material, mut specular) = (material.clone(), material.specular.x);
        change(&mut material.finish, &mut specular);
        if specular != material.specular.x {
            material.specular = stereotrace::glam::Vec3::splat(specular);
        }
        let id = stereotrace::MaterialId(index as u32);
        other.set_material(id, material).expect("it reflects no more than before");
    }
    other
}

/// The rays of a pair's right view where a pixel that is carried over keeps its first hit's shadow rays too, as it does
/// in the paper. This library asks the lights anew where the first hit sends rays on, since what is seen there is made
/// anew as a whole. So the shadow rays of first hits are counted in the dull scene, where no pixel is made anew that is
/// carried over.
pub(crate) fn rays_as_in_the_paper(
    renderer: &mut Renderer,
    scene: &Scene,
    camera: &StereoCamera,
    pair: &StereoPair,
) -> Result<u64, Error> {
    let rays = pair.statistics.right.rays;
    if rays.secondary == 0 {
        return Ok(rays.total());
    }
    let mut of_first_hits = |scene: &Scene| {
        let uploaded = renderer.upload(scene).wait()?;
        let first_hits =
            renderer.pair(&uploaded, camera).options(&Options::new(pair.statistics.method).bounces(0)).read().wait()?;
        Ok::<_, Error>(first_hits.statistics.right.rays.shadow)
    };
    Ok(rays.total() - of_first_hits(scene)? + of_first_hits(&dull(scene))?)
}
