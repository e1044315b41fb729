//! A frame that no bound on a thread's loops can end: both views traced in steps.

use std::{ops::ControlFlow, sync::Arc};

use super::{Need, Options, Passes, Picture, Progress, Renderer, UploadedScene};
use crate::{
    Error, Method, Pose, RaysPerLane, Statistics,
    kernels::{self, Kept, RightView, Shadows},
    layout::WORKGROUP,
    steps::{DISPATCHES, Lanes, Steps},
};

impl Renderer {
    /// A frame by `Naive` in steps; the picture's buffers then hold the pair.
    pub(super) async fn trace_in_steps(
        &mut self,
        scene: &UploadedScene,
        pose: &Pose,
        options: &Options,
        progress: &mut (dyn FnMut(Progress) -> ControlFlow<()> + Send),
    ) -> Result<(Statistics, Arc<Picture>), Error> {
        let (size, kept) = (pose.size, Kept::of(options.g_buffer, Method::Naive));
        let picture = self.picture_of(Need { size, kept, reuse: false, cost_map: options.cost_map }).await?;
        let steps = self.steps;
        let mut passes = self.passes(scene, pose, options, &picture, progress);
        passes.rows_total = 3 * size[1];
        if passes.specialisation.shadows == Shadows::FromSurface {
            // Its shadow rays are traced one by one, and a lane keeps where one traversal stands.
            passes.specialisation.traversal.rays = RaysPerLane::One;
        }
        let lane_bytes = passes.frame_in_steps(steps).await?;
        passes.finish().await?;
        let statistics = self.statistics(&picture, Method::Naive).await?;
        let mut statistics = statistics.map_err(|threads| Error::cut_short(threads, "threads"))?;
        statistics.in_steps = true;
        statistics.intermediate_bytes += lane_bytes;
        if let Some(timestamps) = &self.timestamps {
            statistics.times = timestamps.read(&self.gpu).await?;
        }
        Ok((statistics, picture))
    }
}

impl Passes<'_> {
    /// Its passes. Returns the bytes that threads keep from step to step.
    async fn frame_in_steps(&mut self, steps: Steps) -> Result<u64, Error> {
        let p = self.picture;
        let compose_rows = self.rows;
        let block = WORKGROUP * self.specialisation.traversal.rays.block();
        let threads_across = WORKGROUP * p.size[0].div_ceil(block);
        let workgroups = (steps.threads / WORKGROUP / threads_across).clamp(1, p.size[1].div_ceil(block));
        self.rows = workgroups * block;
        let lanes = Lanes::new(self.gpu, &self.specialisation, workgroups * WORKGROUP * threads_across).await?;
        self.lanes = Some(lanes.buffer.clone());
        self.clear(&[&p.counters]).await?;
        for (eye, name, color) in [(0, "trace_left", &p.left_color), (1, "trace_right", &p.right_color)] {
            self.frame.eye = eye;
            self.view_in_steps(name, &lanes, color, steps).await?;
        }
        self.rows = compose_rows;
        self.specialisation.right = RightView::Traced;
        let compose: &[_] = &[&p.left_color, &p.right_color, &p.right_source, &p.pictures];
        self.pass("compose", &kernels::COMPOSE, compose).await?;
        Ok(lanes.buffer.size())
    }

    /// One view, band by band, each in as many steps as it takes.
    async fn view_in_steps(
        &mut self,
        name: &'static str,
        lanes: &Lanes,
        color: &wgpu::Buffer,
        steps: Steps,
    ) -> Result<(), Error> {
        let (gpu, p) = (self.gpu, self.picture);
        let [width, height] = p.size;
        let block = self.specialisation.traversal.rays.block();
        for begin in (0..height).step_by(self.rows as usize) {
            (self.frame.row_begin, self.frame.row_end) = (begin, height.min(begin + self.rows));
            gpu.queue.write_buffer(&p.frame, 0, bytemuck::bytes_of(&self.frame));
            let rows = self.frame.row_end - begin;
            let threads = width.div_ceil(block) * rows.div_ceil(block);
            lanes.begin(gpu, threads, steps.rounds).await?;
            let mut unfinished = threads;
            while unfinished > 0 {
                let submit = || {
                    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                    for _ in 0..DISPATCHES {
                        let buffers = [color, &p.hits, &p.counters];
                        let kernel = &kernels::TRACE_IN_STEPS;
                        self.dispatch_as(name, &mut encoder, kernel, &buffers, super::Launch::Pixels);
                    }
                    gpu.queue.submit([encoder.finish()]);
                    Ok(())
                };
                gpu.checked(submit).await?;
                unfinished = lanes.unfinished(gpu).await?;
                let rows_done = self.rows_done as f32 + rows as f32 * (1.0 - unfinished as f32 / threads as f32);
                let done = (rows_done / self.rows_total as f32).min(1.0);
                if (self.progress)(Progress { pass: name, done }).is_break() {
                    return Err(Error::Cancelled);
                }
            }
            self.rows_done += rows;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        BvhBuild, GBuffer, Gpu, PointLight, Ray, Scene, StereoCamera, StereoPair, Traversal,
        glam::Vec3,
        kernels::Specialisation,
        random::Random,
        scene::builtin::Builtin,
        traversal::{Boxes, Fetch},
    };

    fn gpu() -> Gpu {
        Gpu::open(&std::env::var(crate::gpu::ADAPTER_VARIABLE).unwrap_or("software".into())).unwrap()
    }

    fn in_steps_of(rounds: u32) -> Steps {
        Steps { rounds, always: true, ..Steps::default() }
    }

    /// A hall by its own lights, spheres among triangles under a gradient, and lights so far off that rays start at surfaces.
    fn scenes() -> Vec<(&'static str, Scene, StereoCamera)> {
        let far = PointLight { position: Vec3::new(3e5, 8e5, 2e5), intensity: Vec3::splat(0.4) };
        let mut by_far_lights = Builtin::Near.scene();
        by_far_lights.lights.push(far);
        let (hall, near) = (Builtin::Hall, Builtin::Near);
        vec![
            ("hall", hall.scene(), hall.camera(37, 23)),
            ("near", near.scene(), near.camera(37, 23)),
            ("near by far lights", by_far_lights, near.camera(37, 23)),
            ("nothing", Scene::new(), hall.camera(9, 5)),
        ]
    }

    /// What a frame shows and counts.
    fn shown(mut pair: StereoPair) -> StereoPair {
        (pair.statistics.times, pair.statistics.intermediate_bytes) = (None, 0);
        pair.statistics.in_steps = false;
        pair
    }

    /// What is doubtful is looked at again at the end of a step at the latest, so that boxes behind it are not visited: counts may be a
    /// little lower, 0.1% as measured.
    fn assert_counts_alike(pair: &StereoPair, expected: &StereoPair, what: &str) {
        for (work, expected) in
            [(pair.statistics.left, expected.statistics.left), (pair.statistics.right, expected.statistics.right)]
        {
            assert_eq!(work.rays, expected.rays, "{what}");
            for (count, expected) in [(work.nodes, expected.nodes), (work.primitive_tests, expected.primitive_tests)] {
                assert!(count.abs_diff(expected) * 200 <= expected, "{what}: {count} for {expected}");
            }
        }
    }

    fn without_counts(mut pair: StereoPair) -> StereoPair {
        for work in [&mut pair.statistics.left, &mut pair.statistics.right] {
            (work.nodes, work.primitive_tests) = (0, 0);
        }
        (pair.left.cost, pair.right.cost) = (Vec::new(), Vec::new());
        pair
    }

    /// Compares a frame in steps of several sizes with one at once, by a method whose steps are `Naive`'s.
    fn assert_alike(name: &str, scene: &Scene, camera: &StereoCamera, renderer: &mut Renderer, costs: bool) {
        let options = |method| Options { cost_map: costs, ..Options::new(method) };
        let uploaded = renderer.upload(scene).unwrap();
        renderer.steps = Steps::default();
        let expected = shown(renderer.render(&uploaded, camera, &options(Method::Naive)).unwrap());
        for rounds in [1, 29, 1024] {
            renderer.steps = in_steps_of(rounds);
            let pair = renderer.render(&uploaded, camera, &options(Method::BRACKET)).unwrap();
            let what = format!("{name}, {:?}, {rounds} rounds a step", uploaded.info().traversal);
            assert!(pair.statistics.in_steps, "{what}");
            assert_counts_alike(&pair, &expected, &what);
            assert!(without_counts(shown(pair)) == without_counts(expected.clone()), "{what}");
        }
    }

    #[test]
    fn a_frame_in_steps_is_naives_bit_for_bit() {
        let mut renderer = Renderer::new(gpu());
        for (name, scene, camera) in scenes() {
            assert_alike(name, &scene, &camera, &mut renderer, false);
        }
        assert_alike("hall, counted", &Builtin::Hall.scene(), &Builtin::Hall.camera(37, 23), &mut renderer, true);
    }

    #[test]
    fn every_traversal_goes_on_where_it_stopped() {
        let gpu = gpu();
        let read = [(Fetch::Texture, Boxes::Grid16), (Fetch::Buffer, Boxes::F32)];
        for traversal in Traversal::ALL.into_iter().filter(|way| read.contains(&(way.fetch, way.boxes))) {
            let mut renderer = Renderer::with_traversal(gpu.clone(), traversal);
            assert_alike("near", &Builtin::Near.scene(), &Builtin::Near.camera(37, 23), &mut renderer, false);
        }
    }

    #[test]
    fn a_step_too_long_for_the_adapter_is_an_error_and_ends() {
        let (scene, camera) = (&mut Scene::new(), Builtin::Hall.camera(9, 5));
        scene.lights = vec![PointLight { position: Vec3::Y, intensity: Vec3::ONE }; 70_000];
        let mut renderer = Renderer::new(gpu());
        let uploaded = renderer.upload(scene).unwrap();
        let options = Options::new(Method::Naive);
        let pair = renderer.render(&uploaded, &camera, &options).unwrap();
        let info = renderer.gpu.adapter_info();
        if info.driver != "llvmpipe" {
            return; // nothing bounds its loops
        }
        assert!(pair.statistics.in_steps);
        renderer.steps = in_steps_of(1 << 30);
        let message = renderer.render(&uploaded, &camera, &options).unwrap_err().to_string();
        assert!(message.contains("threads needs more rounds of its loops"), "{message}");
    }

    #[test]
    fn bands_and_what_is_kept_of_pixels_change_no_frame_in_steps() {
        let camera = Builtin::Hall.camera(90, 61);
        let mut renderer = Renderer::new(gpu());
        let uploaded = renderer.upload(&Builtin::Hall.scene()).unwrap();
        for g_buffer in [GBuffer::Ids, GBuffer::Depth, GBuffer::None] {
            let options = Options::new(Method::Naive).keeping(g_buffer);
            renderer.steps = Steps::default();
            let expected = shown(renderer.render(&uploaded, &camera, &options).unwrap());
            renderer.steps = Steps { threads: 48 * 16, ..in_steps_of(1024) };
            let (mut last, mut calls) = (0.0, 0);
            let mut progress = |progress: Progress| {
                assert!(progress.done >= last && progress.done <= 1.0, "{progress:?} after {last}");
                (last, calls) = (progress.done, calls + 1);
                ControlFlow::Continue(())
            };
            let pair = renderer.render_with(&uploaded, &camera, &options, &mut progress).unwrap();
            assert!(shown(pair) == expected, "{g_buffer:?}");
            assert!((last, calls >= 5) == (1.0, true), "{last} after {calls} calls");
            let mut stop = |_| ControlFlow::Break(());
            let stopped = renderer.render_with(&uploaded, &camera, &options, &mut stop);
            assert!(matches!(stopped, Err(Error::Cancelled)), "{stopped:?}");
        }
    }

    #[test]
    fn ray_lists_in_steps_hit_what_they_hit_at_once() {
        let gpu = gpu();
        let mut random = Random::new(5);
        let rays: Vec<Ray> = (0..1501).map(|_| Ray { t_min: 0.1, t_max: 9.0, ..Ray::new(random.point(1.0)) }).collect();
        for traversal in [Traversal::ALL[0], Traversal::ALL[5]] {
            let mut renderer = Renderer::with_traversal(gpu.clone(), traversal);
            for (name, scene, camera) in scenes() {
                let uploaded = renderer.upload(&scene).unwrap();
                let eye = camera.pose().unwrap().eye;
                let mut hits = |steps| {
                    renderer.steps = steps;
                    let closest = renderer.closest_hits(&uploaded, eye, &rays).unwrap().hits;
                    (closest, renderer.any_hits(&uploaded, eye, &rays).unwrap().hits)
                };
                let expected = hits(Steps::default());
                assert!(name == "nothing" || expected.1.contains(&true) && expected.1.contains(&false), "{name}");
                for rounds in [1, 29, 1024] {
                    assert!(hits(in_steps_of(rounds)) == expected, "{name}, {traversal:?}, {rounds} rounds a step");
                }
            }
        }
    }

    #[test]
    fn lanes_are_as_large_as_their_shader_says() {
        let scene = Builtin::Hall.scene();
        for (traversal, stack_size) in Traversal::ALL.into_iter().flat_map(|t| [8, 40, 256].map(|size| (t, size))) {
            let packed = crate::bvh::build(&scene, BvhBuild::Balanced, traversal.boxes).unwrap();
            let with = Specialisation { stack_size, ..Specialisation::of(&scene, traversal, &packed) };
            let module = naga::front::wgsl::parse_str(&kernels::TRACE_IN_STEPS.text(&with)).unwrap();
            let lane = module.types.iter().find_map(|(_, kind)| match kind.inner {
                naga::TypeInner::Struct { span, .. } if kind.name.as_deref() == Some("Lane") => Some(span),
                _ => None,
            });
            assert_eq!(lane.map(u64::from), Some(crate::steps::lane_bytes(&with)), "{traversal:?} {stack_size}");
        }
    }
}
