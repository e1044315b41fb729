//! Counts rays by the paper's rules.

use stereotrace::{Error, Finish, Method, Options, Renderer, Scene, StereoCamera, StereoPair, blocking::Wait};

/// Number of ray levels, the paper's L. The paper calls this value common.
pub(crate) const LEVELS: u32 = 5;

/// Returns options with counters and this number of levels.
pub(crate) fn options(method: Method) -> Options {
    Options::new(method).count(true).bounces(LEVELS - 1)
}

/// Returns the scene with matte surfaces in place of mirrors and glass.
pub(crate) fn dull(scene: &Scene) -> Scene {
    changed(scene, |finish, _| *finish = Finish::Matte)
}

/// Returns the scene with glass that does not reflect: each ray goes through it without branching.
pub(crate) fn clear(scene: &Scene) -> Scene {
    changed(scene, |finish, specular| {
        if let Finish::Glass { fresnel, .. } = finish {
            (*fresnel, *specular) = (false, 0.0);
        }
    })
}

/// Returns the scene with a changed finish and reflected share in each material.
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

/// Returns the rays of a pair's right view if reused pixels also kept the shadow rays of their first hits, as in the
/// paper. In this library, a reused pixel is shaded again if its first hit sends rays on, and its shadow rays are
/// traced again. So the shadow rays of first hits are taken from the matte scene, where no reused pixel is shaded
/// again.
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
