//! Tests every function that takes a device, an uploaded scene or a file, called by two threads at the same time. Both
//! share one device, one uploaded scene and one folder, and each has a renderer. The results must be those of a single
//! thread.
use crate::common;

use std::{
    fmt::Debug,
    fs,
    ops::ControlFlow,
    path::Path,
    sync::{Barrier, OnceLock},
    thread,
};

use common::{folder::Folder, gpu, gpu_with_limits, own_gpu, random_stage};
use stereotrace::{
    BvhBuild, Error, GBuffer, Gpu, Method, Options, Ray, Renderer, Scene, Sky, SkyMap, StereoCamera, StereoPair,
    Traversal, UploadedScene,
    blocking::Wait,
    glam::Vec3,
    metrics::compare,
    output::{Anaglyph, Packing, save_ids_pfm, save_pfm, write_whole},
    render_stereo, wgpu,
};

/// The objects that a thread works with. All except the renderer are shared with the other thread.
struct Worker<'a> {
    renderer: Renderer,
    scene: &'a Scene,
    uploaded: &'a UploadedScene,
    folder: &'a Folder,
}

/// Runs a function and returns its result as text.
type Step = fn(&mut Worker<'_>) -> String;

fn camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.0, 0.5, 5.0), Vec3::ZERO).screen_distance(5.0).size(50, 37).interaxial_pixels(6.0)
}

/// Returns everything except values that depend on the clock or on earlier work of the renderer.
fn text(pair: &StereoPair) -> String {
    let mut pair = pair.clone();
    (pair.statistics.times, pair.statistics.intermediate_bytes) = (None, 0);
    format!("{pair:?}")
}

fn debug(what: impl Debug) -> String {
    format!("{what:?}")
}

impl Worker<'_> {
    fn pair(&mut self, options: &Options) -> StereoPair {
        self.renderer.pair(self.uploaded, &camera()).options(options).read().wait().unwrap()
    }

    fn written(&self, name: &str, write: impl Fn(&Path) -> Result<(), Error>) -> String {
        let path = self.folder.file(name);
        write(&path).unwrap();
        debug(fs::read(path).unwrap())
    }
}

/// The pass that finds edges builds a table of the scene's objects on first use.
fn edges(worker: &mut Worker<'_>) -> String {
    text(&worker.pair(&"atomic-edges".parse().map(Options::new).unwrap()))
}

fn every_method(worker: &mut Worker<'_>) -> String {
    Method::ALL.iter().map(|&method| text(&worker.pair(&Options::new(method)))).collect()
}

fn every_option(worker: &mut Worker<'_>) -> String {
    let plain = Options::new(Method::BRACKET);
    let options = [
        plain.clone().count(true),
        plain.clone().cost_map(true),
        plain.clone().g_buffer(GBuffer::Depth),
        plain.g_buffer(GBuffer::None),
    ];
    options.map(|options| text(&worker.pair(&options))).concat()
}

fn progress_and_cancelling(worker: &mut Worker<'_>) -> String {
    let mut seen = Vec::new();
    let mut watch = |progress| {
        seen.push(progress);
        ControlFlow::Continue(())
    };
    let pair = worker.renderer.pair(worker.uploaded, &camera()).progress(&mut watch).read().wait().unwrap();
    let mut stop = |_| ControlFlow::Break(());
    let stopped = worker.renderer.pair(worker.uploaded, &camera()).progress(&mut stop).read().wait();
    assert!(matches!(stopped, Err(Error::Cancelled)));
    text(&pair) + &debug(seen)
}

fn tracing_alone(worker: &mut Worker<'_>) -> String {
    let statistics = worker.renderer.pair(worker.uploaded, &camera()).trace().wait().unwrap();
    debug((statistics.left, statistics.right, statistics.choice))
}

fn rays_of_the_caller_s_own(worker: &mut Worker<'_>) -> String {
    let direction = |i: u32| Vec3::new(0.01 * (i % 20) as f32 - 0.1, 0.0, -1.0);
    let rays: Vec<Ray> = (0..300).map(|i| Ray::new(5.0 * Vec3::Z, direction(i))).collect();
    let closest = worker.renderer.closest_hits(worker.uploaded, &rays).wait().unwrap().hits;
    debug((closest, worker.renderer.any_hits(worker.uploaded, &rays).wait().unwrap().hits))
}

/// An error of one thread must not reach the other thread, and the success of the other thread must not hide it.
fn errors(worker: &mut Worker<'_>) -> String {
    let mut of =
        |camera: StereoCamera| worker.renderer.pair(worker.uploaded, &camera).read().wait().unwrap_err().to_string();
    [of(camera().size(60_000, 60_000)), of(camera().size(0, 3))].concat()
}

fn uploads(worker: &mut Worker<'_>) -> String {
    let uploaded = |build| worker.renderer.upload_with(worker.scene, build).wait().unwrap();
    let mut all: Vec<UploadedScene> = BvhBuild::ALL.iter().copied().map(uploaded).collect();
    all.push(worker.renderer.upload(worker.scene).wait().unwrap());
    let pairs = all.iter().map(|scene| {
        worker.renderer.pair(scene, &camera()).options(&Options::new(Method::Naive)).read().wait().unwrap()
    });
    let pairs: Vec<StereoPair> = pairs.collect();
    debug(all.iter().map(|scene| scene.info().node_bytes).collect::<Vec<_>>()) + &text(&pairs[0]) + &text(&pairs[3])
}

fn another_traversal(worker: &mut Worker<'_>) -> String {
    let mut renderer = Renderer::with_traversal(worker.renderer.gpu().clone(), Traversal::ALL[5]);
    let uploaded = renderer.upload(worker.scene).wait().unwrap();
    text(&renderer.pair(&uploaded, &camera()).read().wait().unwrap())
}

fn devices_of_their_own(worker: &mut Worker<'_>) -> String {
    let mut text = text(&render_stereo(worker.scene, &camera()).unwrap());
    for gpu in [own_gpu(), gpu_with_limits(wgpu::Limits::default())] {
        text += &(gpu.adapter_name() + &gpu.driver());
        let mut renderer = Renderer::new(gpu);
        let uploaded = renderer.upload(worker.scene).wait().unwrap();
        text += &debug(
            renderer.pair(&uploaded, &camera()).options(&Options::new(Method::Naive)).read().wait().unwrap().right,
        );
        // A scene of another device is refused.
        text += &renderer.pair(worker.uploaded, &camera()).read().wait().unwrap_err().to_string();
    }
    text
}

fn files_that_are_read(worker: &mut Worker<'_>) -> String {
    let scenes = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes"));
    let mut scene = Scene::from_obj(scenes.join("still_life.obj")).unwrap();
    let cameras = scenes.join("thesis.json");
    let camera = StereoCamera::from_json(&cameras, "spheres", 40, 30).unwrap();
    assert!(scene.light_from_json(&cameras, "spheres").unwrap());
    let sky = SkyMap::open(worker.folder.file("sky.png")).unwrap();
    scene.sky = Sky::Map(sky);
    let uploaded = worker.renderer.upload(&scene).wait().unwrap();
    text(&worker.renderer.pair(&uploaded, &camera).read().wait().unwrap())
}

/// Both threads write the same files, which are complete whichever thread is last.
fn files_that_are_written(worker: &mut Worker<'_>) -> String {
    let pair = worker.pair(&Options::new(Method::BRACKET));
    let view = &pair.right;
    let written = [
        worker.written("picture.png", |path| view.picture().save_png(path)),
        worker.written("depth.pfm", |path| view.save_depth(path)),
        worker.written("primitives.pfm", |path| view.save_primitive_ids(path)),
        worker.written("objects.pfm", |path| view.save_object_ids(path)),
        worker.written("values.pfm", |path| save_pfm(path, 50, 37, &view.depth)),
        worker.written("ids.pfm", |path| save_ids_pfm(path, 50, 37, &view.object)),
        worker.written("bytes", |path| write_whole(path, view.rgba8.as_flattened())),
    ];
    written.concat()
}

fn pictures_and_figures(worker: &mut Worker<'_>) -> String {
    let (naive, pair) = (worker.pair(&Options::new(Method::Naive)), worker.pair(&Options::new(Method::BRACKET)));
    let anaglyphs = Anaglyph::ALL.iter().map(|kind| (pair.anaglyph(*kind), pair.anaglyph_encoded(*kind)));
    let packed = Packing::ALL.iter().map(|packing| pair.packed(*packing));
    let maps =
        (pair.retrace_picture(), pair.shadow_picture(), pair.right.cost_picture(9), pair.statistics.retraced_share());
    let difference = compare(&pair.right, &naive.right, &naive.pose).unwrap();
    debug((anaglyphs.collect::<Vec<_>>(), packed.collect::<Vec<_>>(), maps, difference))
}

const STEPS: [(&str, Step); 13] = [
    ("edges", edges),
    ("every method", every_method),
    ("every option", every_option),
    ("progress and cancelling", progress_and_cancelling),
    ("tracing alone", tracing_alone),
    ("rays of the caller's own", rays_of_the_caller_s_own),
    ("errors", errors),
    ("uploads", uploads),
    ("another traversal", another_traversal),
    ("devices of their own", devices_of_their_own),
    ("files that are read", files_that_are_read),
    ("files that are written", files_that_are_written),
    ("pictures and figures", pictures_and_figures),
];

#[test]
fn what_two_threads_do_at_once_is_what_each_does_alone() {
    let (gpu, scene, folder) = (gpu(), random_stage(4), Folder::new("threads"));
    let sky: Vec<u8> = (0..8 * 4 * 3).collect();
    image::RgbImage::from_raw(8, 4, sky).unwrap().save(folder.file("sky.png")).unwrap();
    let upload = |gpu: &Gpu| Renderer::new(gpu.clone()).upload(&scene).wait().unwrap();
    // The threads' uploaded scene has not been rendered yet. So both threads build its first-use data at the same time.
    let (lone, shared) = (upload(&gpu), upload(&gpu));
    let worker = |uploaded| Worker { renderer: Renderer::new(gpu.clone()), scene: &scene, uploaded, folder: &folder };
    let mut alone = worker(&lone);
    let expected = STEPS.map(|(_, step)| step(&mut alone));

    let mut workers = [worker(&shared), worker(&shared)];
    // The threads run the same function first, then different ones.
    let same = (0..STEPS.len()).map(|step| [step, step]);
    let different = (0..STEPS.len()).map(|step| [step, (step + 5) % STEPS.len()]);
    for steps in same.chain(different) {
        let start = Barrier::new(2);
        let found: [OnceLock<String>; 2] = Default::default();
        thread::scope(|scope| {
            for ((worker, step), found) in workers.iter_mut().zip(steps).zip(&found) {
                let start = &start;
                scope.spawn(move || {
                    start.wait();
                    let _ = found.set(STEPS[step].1(worker));
                });
            }
        });
        for (step, found) in steps.into_iter().zip(found) {
            let names = steps.map(|step| STEPS[step].0);
            assert!(found.into_inner().as_ref() == Some(&expected[step]), "{} while {names:?}", STEPS[step].0);
        }
    }
}
