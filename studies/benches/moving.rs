//! Measures the cost of updates when an object moves: `cargo bench -p stereotrace-studies --bench moving` prints a
//! table.
//!
//! An object in the built-in hall is moved sideways. The scene is updated by a refit of its tree, by a rebuild of its
//! tree, and by a new upload. Nodes and primitive tests of a naive pair show the quality of the refitted tree. `cargo
//! bench --bench moving -- NAME…` selects other objects: built-in scenes, or folders of OBJ files.

#[path = "../../benches/common/mod.rs"]
mod common;

use std::{error::Error, time::Instant};

use stereotrace::{
    Builtin, BvhBuild, Gpu, MaterialId, Mesh, Method, Options, Renderer, Scene, StereoCamera, Update, UploadedScene,
    blocking::Wait,
    glam::{Affine3A, Vec3},
};

use crate::common::{
    options::is_quick,
    provenance::Provenance,
    rounds::{Spread, order},
    scenes,
};

/// Longest side of the object, in the hall's metres.
const SIZE: f32 = 2.0;

fn main() -> Result<(), Box<dyn Error>> {
    let quick = is_quick();
    let (size, rounds) = if quick { ([64, 64], 1) } else { ([600, 600], 7) };
    let named: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let names = match named.as_slice() {
        [] if quick => vec!["near".to_owned()],
        [] => ["near", "dragon"].map(str::to_owned).to_vec(),
        named => named.to_vec(),
    };
    let gpu = Gpu::new().wait()?;
    let provenance = Provenance::of(&gpu);
    println!("{provenance}\n");
    println!(
        "| object in the hall | primitives | moved by, of its size | refit ms | rebuild ms | upload anew ms | cost of \
        a refitted pair, rebuilt = 1 | nodes | tests |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut renderer = Renderer::new(gpu);
    for name in &names {
        let Some(object) = scenes::load(name, size, 15.0, Some(0))? else {
            println!("\n{}", scenes::skipped(name));
            continue;
        };
        let (scene, object) = in_the_hall(&object.scene)?;
        let camera = Builtin::Hall.camera(size[0], size[1]);
        for moved in [0.0, 0.1, 1.0, 10.0] {
            measure(&mut renderer, name, (&scene, object), &camera, moved, rounds)?;
        }
    }
    Ok(())
}

/// Returns the hall with all triangles of a scene as one object in its middle, and the object's index.
fn in_the_hall(of: &Scene) -> Result<(Scene, u32), Box<dyn Error>> {
    let (low, high) = of.bounds().ok_or("nothing in it")?;
    let low = (low - of.origin()).as_vec3();
    let high = (high - of.origin()).as_vec3();
    let scale = SIZE / (high - low).max_element();
    let corners = of.triangles().iter().flat_map(|triangle| triangle.corners);
    let positions: Vec<Vec3> = corners.map(|corner| (corner - low) * scale).collect();
    let triangles = (0..positions.len() as u32 / 3).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
    let mut scene = Builtin::Hall.scene();
    scene.add_mesh(&Mesh::new(positions, triangles).materials(vec![MaterialId(0)]).name("moving"))?;
    let last = scene.triangles().len() as u32 - 1;
    let object = scene.object_of(last);
    Ok((scene, object))
}

fn timed<T>(work: impl FnOnce() -> Result<T, stereotrace::Error>) -> Result<(f64, T), stereotrace::Error> {
    let start = Instant::now();
    let done = work()?;
    Ok((1e3 * start.elapsed().as_secs_f64(), done))
}

/// Prints one line. If `moved` is 0, the object stays and a light moves.
fn measure(
    renderer: &mut Renderer,
    name: &str,
    (still, object): (&Scene, u32),
    camera: &StereoCamera,
    moved: f32,
    rounds: usize,
) -> Result<(), Box<dyn Error>> {
    let mut scene = still.clone();
    match moved {
        0.0 => scene.lights[0].position.y -= 0.1,
        _ => scene.transform_object(object, &Affine3A::from_translation(moved * SIZE * Vec3::X))?,
    }
    let build = Update::Rebuild(BvhBuild::Balanced);
    let (mut refitted, mut rebuilt) = (renderer.upload(still).wait()?, renderer.upload(still).wait()?);
    let mut times = [const { Vec::new() }; 3];
    for round in 0..=rounds {
        for turn in order(round, times.len()) {
            let (time, ()) = match turn {
                0 => timed(|| renderer.update(&mut refitted, &scene, Update::Refit).wait())?,
                1 => timed(|| renderer.update(&mut rebuilt, &scene, build).wait())?,
                _ => timed(|| renderer.upload(&scene).wait().map(drop))?,
            };
            times[turn].extend((round > 0).then_some(time));
        }
        // The object is moved back, so that each round has the same work.
        renderer.update(&mut refitted, still, Update::Refit).wait()?;
        renderer.update(&mut rebuilt, still, build).wait()?;
    }
    renderer.update(&mut refitted, &scene, Update::Refit).wait()?;
    renderer.update(&mut rebuilt, &scene, build).wait()?;
    let mut cost = |uploaded: &UploadedScene| {
        let pair = renderer.pair(uploaded, camera).options(&Options::new(Method::Naive).count(true)).read().wait()?;
        let both = [pair.statistics.left, pair.statistics.right];
        Ok::<_, stereotrace::Error>([
            both.map(|work| work.cost()).iter().sum::<u64>() as f64,
            both.map(|work| work.nodes).iter().sum::<u64>() as f64,
            both.map(|work| work.primitive_tests).iter().sum::<u64>() as f64,
        ])
    };
    let (refit, build) = (cost(&refitted)?, cost(&rebuilt)?);
    let [a, b, c] = times.map(|times| Spread::of(times).median);
    let moved = if moved == 0.0 { "0, a light moves".to_owned() } else { moved.to_string() };
    println!(
        "| {} | {} | {moved} | {a:.0} | {b:.0} | {c:.0} | {:.2} | {:.2} | {:.2} |",
        scenes::title(name),
        scene.primitive_count(),
        refit[0] / build[0],
        refit[1] / build[1],
        refit[2] / build[2],
    );
    Ok(())
}
