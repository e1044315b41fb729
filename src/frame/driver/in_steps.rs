//! Tracing of a band in steps, so that no adapter's limit on a thread's loop rounds ends the work early.

use super::Driver;
use crate::{
    Error, RaysPerLane,
    frame::{
        bands::Band,
        lanes::{DISPATCHES, Lanes, Steps},
        plan::{InSteps, Plan},
    },
    kernel::{Resource, layout::WORKGROUP, variant::Shadows},
};

impl Driver<'_> {
    /// Renders all views of a band in steps, with the method `Naive`.
    pub(crate) async fn band_in_steps(&mut self, plan: &Plan, band: &Band, steps: Steps) -> Result<(), Error> {
        let usual = self.variant;
        if self.variant.shadows == Shadows::FromSurface {
            // Shadow rays from surfaces are traced one by one, and a lane saves the state of only one traversal.
            self.variant.traversal.rays = RaysPerLane::One;
        }
        // All pixels are traced, including unwanted ones. Otherwise threads without work would also have to be counted
        // as finished.
        (self.variant.samples, self.variant.second, self.variant.masked) = (false, false, false);
        let rows = self.rows_in_steps(steps);
        if self.lanes.is_none() {
            let block = self.variant.traversal.rays.block();
            let lanes = Lanes::new(self.gpu, &self.variant, rows / block * self.threads_across()).await?;
            self.resources.iter_mut().for_each(|all| all.set(Resource::Steps, &lanes.buffer));
            self.lanes = Some(lanes);
        }
        self.uniforms.set_rows(&self.eyes.sources, band); // the next band, if in flight, has set its rows
        let gpu = self.gpu;
        let clear = || {
            let mut encoder = self.encoder();
            self.clear(&mut encoder, false);
            gpu.submit([encoder.finish()]);
            Ok(())
        };
        gpu.checked(clear).await?;
        for view in 0..self.eyes.sources.len() {
            self.view_in_steps(band, view, (&plan.in_steps[view], rows), steps).await?;
        }
        self.uniforms.set_rows(&self.eyes.sources, band);
        let follow = || {
            self.upload_uniforms();
            let mut encoder = self.encoder();
            for InSteps { after, .. } in &plan.in_steps {
                self.encode_all(&mut encoder, after);
            }
            gpu.submit([encoder.finish()]);
            Ok(())
        };
        gpu.checked(follow).await?;
        self.variant = usual;
        Ok(())
    }

    fn threads_across(&self) -> u32 {
        WORKGROUP * self.targets.shape.size[0].div_ceil(WORKGROUP * self.variant.traversal.rays.block())
    }

    /// Returns the number of rows per dispatch, which limits the number of its threads.
    fn rows_in_steps(&self, steps: Steps) -> u32 {
        let block = WORKGROUP * self.variant.traversal.rays.block();
        let most = self.targets.shape.bands.rows.div_ceil(block);
        (steps.threads / WORKGROUP / self.threads_across()).clamp(1, most) * block
    }

    /// Traces one view, some rows at a time. Each group of rows takes as many steps as it needs.
    async fn view_in_steps(
        &mut self,
        band: &Band,
        view: usize,
        (of_view, rows): (&InSteps, u32),
        steps: Steps,
    ) -> Result<(), Error> {
        let gpu = self.gpu;
        let name = of_view.trace.name().unwrap_or_default();
        let block = self.variant.traversal.rays.block();
        let views = self.eyes.sources.len() as f32;
        for begin in band.place().step_by(rows as usize) {
            let end = band.place().end.min(begin + rows);
            let at_work = self.uniforms.band_mut(view);
            (at_work.row_begin, at_work.row_end) = (begin, end);
            self.upload_uniforms();
            let threads = self.targets.shape.size[0].div_ceil(block) * (end - begin).div_ceil(block);
            self.lanes().begin(gpu, threads, steps.rounds).await?;
            let mut unfinished = threads;
            while unfinished > 0 {
                let submit = || {
                    let mut encoder = self.encoder();
                    for _ in 0..DISPATCHES {
                        self.encode(&mut encoder, of_view.trace);
                    }
                    gpu.submit([encoder.finish()]);
                    Ok(())
                };
                gpu.checked(submit).await?;
                unfinished = self.lanes().unfinished(gpu).await?;
                let rows = (end - begin) as f32 * (1.0 - unfinished as f32 / threads as f32);
                let done = (begin - band.place().start) as f32 + rows;
                self.tell(name, (view as f32 * band.count() as f32 + done) / views)?;
            }
        }
        Ok(())
    }

    fn lanes(&self) -> &Lanes {
        self.lanes.as_ref().expect("made before the first step")
    }
}

#[cfg(test)]
mod tests {
    use crate::blocking::Wait;
    use std::ops::ControlFlow;

    use super::*;
    use crate::{
        AmbientOcclusion, BvhBuild, Finish, GBuffer, Gpu, Light, Material, MaterialId, Mesh, Method, Options, Plane,
        Progress, Ray, Renderer, Scene, Sky, SkyMap, Sphere, StereoCamera, StereoPair, Texture, Traversal,
        glam::{Vec2, Vec3},
        kernel::traversal::{Boxes, Fetch},
        kernel::variant::Variant,
        random::Random,
        scene::builtin::Builtin,
    };

    fn in_steps_of(rounds: u32) -> Steps {
        Steps { rounds, always: true, ..Steps::default() }
    }

    /// Returns spheres and triangles behind a fence, a checkerboard with every other square cut out.
    fn behind_a_fence(camera: &StereoCamera) -> Scene {
        let mut scene = Builtin::Near.scene();
        let board = scene.add_texture(Texture::checkerboard(Vec3::ONE, Vec3::ZERO, 9).unwrap());
        let fence = scene.add_material(Material::new(Vec3::splat(0.4)).cutout(board));
        let pose = camera.pose().unwrap();
        let middle = pose.eye.as_vec3() + 0.4 * pose.screen_distance * pose.forward;
        let [right, up] = [pose.right, pose.up].map(|axis| 0.15 * pose.screen_size[0] * axis);
        let corners = [-right - up, right - up, right + up, up - right].map(|corner| middle + corner);
        let uv = [[Vec2::ZERO, Vec2::X, Vec2::ONE], [Vec2::ZERO, Vec2::ONE, Vec2::Y]];
        let fence = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).uv(uv.to_vec()).materials(vec![fence]);
        scene.add_mesh(&fence).unwrap();
        scene
    }

    /// Returns a ground plane and a second plane as a wall, lit by a point light.
    fn planes_alone() -> Scene {
        let mut scene = Scene::new();
        for (point, normal) in [(Vec3::ZERO, Vec3::Y), (-5.0 * Vec3::Z, Vec3::new(0.3, 0.1, 1.0))] {
            scene.add_plane(Plane::new(point, normal, MaterialId(0))).unwrap();
        }
        scene.lights = vec![Light::point(Vec3::new(1.0, 4.0, 2.0), Vec3::ONE)];
        scene
    }

    /// Returns scenes with different primitives, lights, skies and materials. They include lights so far away that
    /// shadow rays start at surfaces, planes only, and an empty scene.
    fn scenes() -> Vec<(&'static str, Scene, StereoCamera)> {
        let far = Light::point(Vec3::new(3e5, 8e5, 2e5), Vec3::splat(0.4));
        let mut by_far_lights = Builtin::Near.scene();
        by_far_lights.lights.push(far);
        let (hall, near, three) = (Builtin::Hall, Builtin::Near, Builtin::ThreeSpheresTextured);
        let mut by_a_ball = Builtin::Near.scene();
        by_a_ball
            .lights
            .iter_mut()
            .skip(1)
            .for_each(|light| *light = Light::sphere(light.position, 0.2, light.intensity));
        let mut under_a_sun = near.scene();
        under_a_sun.sky = Sky::Map(SkyMap::procedural(64).unwrap());
        let mut with_glass = near.scene();
        let glass = Finish::Glass { index: 1.5, transmission: Vec3::ONE, fresnel: true };
        let glass = with_glass.add_material(Material::new(Vec3::ZERO).specular(Vec3::ONE).finish(glass));
        with_glass.add_sphere(Sphere::new(Vec3::new(0.0, 1.0, 0.0), 0.8, glass)).unwrap();
        vec![
            ("near with glass", with_glass, near.camera(37, 23)),
            ("hall", hall.scene(), hall.camera(37, 23)),
            ("near", near.scene(), near.camera(37, 23)),
            ("near by a ball, occluded", by_a_ball, near.camera(37, 23)),
            ("near under a sun", under_a_sun, near.camera(37, 23)),
            ("near by far lights", by_far_lights, near.camera(37, 23)),
            ("near behind a fence", behind_a_fence(&near.camera(37, 23)), near.camera(37, 23)),
            ("three spheres on a plane", three.scene(), three.camera(37, 23)),
            ("planes alone", planes_alone(), three.camera(37, 23)),
            ("nothing", Scene::new(), hall.camera(9, 5)),
        ]
    }

    /// Returns a frame without its times, its memory size and the flag `in_steps`.
    fn shown(mut pair: StereoPair) -> StereoPair {
        (pair.statistics.times, pair.statistics.intermediate_bytes) = (None, 0);
        pair.statistics.in_steps = false;
        pair
    }

    /// Compares the counters of two frames. Uncertain hits are resolved at the end of a step at the latest, so that
    /// boxes behind them are not visited. Counters may therefore be slightly lower, by 0.1% as measured.
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

    /// Compares frames in steps of several sizes with a frame of `Naive` in single dispatches. In steps, `bracket`
    /// renders by the steps of `Naive`.
    fn assert_alike(name: &str, scene: &Scene, camera: &StereoCamera, renderer: &mut Renderer, costs: bool) {
        let occlusion = name.ends_with("occluded").then(|| AmbientOcclusion::new(5, 1.0));
        let sky_rays = name.ends_with("sun").then_some(5);
        let options = |method| {
            let options = Options::new(method).linear(true).ambient_occlusion(occlusion).sky_rays(sky_rays);
            Options { cost_map: costs, ..options }
        };
        let uploaded = renderer.upload(scene).wait().unwrap();
        renderer.steps = Steps::default();
        let expected = shown(renderer.pair(&uploaded, camera).options(&options(Method::Naive)).read().wait().unwrap());
        for rounds in [1, 29, 1024] {
            renderer.steps = in_steps_of(rounds);
            let pair = renderer.pair(&uploaded, camera).options(&options(Method::BRACKET)).read().wait().unwrap();
            let what = format!("{name}, {:?}, {rounds} rounds a step", uploaded.traversal());
            assert!(pair.statistics.in_steps, "{what}");
            assert_counts_alike(&pair, &expected, &what);
            assert!(without_counts(shown(pair)) == without_counts(expected.clone()), "{what}");
        }
    }

    #[test]
    fn a_frame_in_steps_is_naives_bit_for_bit() {
        let mut renderer = Renderer::new(Gpu::under_test());
        for (name, scene, camera) in scenes() {
            assert_alike(name, &scene, &camera, &mut renderer, false);
        }
        for builtin in [Builtin::Hall, Builtin::ThreeSpheresTextured] {
            assert_alike("counted", &builtin.scene(), &builtin.camera(37, 23), &mut renderer, true);
        }
    }

    #[test]
    fn every_traversal_goes_on_where_it_stopped() {
        let gpu = Gpu::under_test();
        let read = [(Fetch::Texture, Boxes::Grid16), (Fetch::Buffer, Boxes::F32)];
        for traversal in Traversal::ALL.iter().copied().filter(|way| read.contains(&(way.fetch, way.boxes))) {
            let mut renderer = Renderer::with_traversal(gpu.clone(), traversal);
            assert_alike("near", &Builtin::Near.scene(), &Builtin::Near.camera(37, 23), &mut renderer, false);
        }
    }

    #[test]
    fn a_step_too_long_for_the_adapter_is_an_error_and_ends() {
        let (scene, camera) = (&mut Scene::new(), Builtin::Hall.camera(9, 5));
        scene.lights = vec![Light::point(Vec3::Y, Vec3::ONE); 70_000];
        let mut renderer = Renderer::new(Gpu::under_test());
        let uploaded = renderer.upload(scene).wait().unwrap();
        let options = Options::new(Method::Naive);
        let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
        let info = renderer.gpu.adapter_info();
        if info.driver != "llvmpipe" {
            return; // only llvmpipe limits loop rounds
        }
        assert!(pair.statistics.in_steps);
        renderer.steps = in_steps_of(1 << 30);
        let message = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap_err().to_string();
        assert!(message.contains("threads needs more loop iterations"), "{message}");
    }

    #[test]
    fn bands_and_what_is_kept_of_pixels_change_no_frame_in_steps() {
        let camera = Builtin::Hall.camera(90, 61);
        let mut renderer = Renderer::new(Gpu::under_test());
        let uploaded = renderer.upload(&Builtin::Hall.scene()).wait().unwrap();
        for g_buffer in [GBuffer::Ids, GBuffer::Depth, GBuffer::None] {
            let options = Options::new(Method::Naive).g_buffer(g_buffer);
            renderer.steps = Steps::default();
            let expected = shown(renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap());
            renderer.steps = Steps { threads: 48 * 16, ..in_steps_of(1024) };
            let (mut last, mut calls) = (0.0, 0);
            let mut progress = |progress: Progress| {
                assert!(progress.done >= last && progress.done <= 1.0, "{progress:?} after {last}");
                (last, calls) = (progress.done, calls + 1);
                ControlFlow::Continue(())
            };
            let pair =
                renderer.pair(&uploaded, &camera).options(&options).progress(&mut progress).read().wait().unwrap();
            assert!(shown(pair) == expected, "{g_buffer:?}");
            assert!((last, calls >= 4) == (1.0, true), "{last} after {calls} calls");
            let mut stop = |_| ControlFlow::Break(());
            let stopped = renderer.pair(&uploaded, &camera).options(&options).progress(&mut stop).read().wait();
            assert!(matches!(stopped, Err(Error::Cancelled)), "{stopped:?}");
        }
    }

    #[test]
    fn ray_lists_in_steps_hit_what_they_hit_at_once() {
        let gpu = Gpu::under_test();
        let mut random = Random::new(5);
        let directions: Vec<Vec3> = (0..1501).map(|_| random.point(1.0)).collect();
        for traversal in [Traversal::ALL[0], Traversal::ALL[5]] {
            let mut renderer = Renderer::with_traversal(gpu.clone(), traversal);
            for (name, scene, camera) in scenes() {
                let uploaded = renderer.upload(&scene).wait().unwrap();
                let eye = camera.pose().unwrap().eye;
                let rays: Vec<_> = directions.iter().map(|&way| Ray::new(eye, way).t_min(0.1).t_max(9.0)).collect();
                let mut hits = |steps| {
                    renderer.steps = steps;
                    let closest = renderer.closest_hits(&uploaded, &rays).wait().unwrap().hits;
                    (closest, renderer.any_hits(&uploaded, &rays).wait().unwrap().hits)
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
        for (traversal, stack_size) in Traversal::ALL.iter().flat_map(|&t| [8, 40, 256].map(|size| (t, size))) {
            let packed = crate::accel::bvh::build(&scene, BvhBuild::Balanced, traversal.boxes).unwrap();
            let with =
                Variant { stack_size, ..Variant::over_tree(&scene, traversal, packed.world_boxes, packed.stack_size) };
            let module = naga::front::wgsl::parse_str(&crate::steps::trace::TRACE_IN_STEPS.linked(&with).text).unwrap();
            let lane = module.types.iter().find_map(|(_, kind)| match kind.inner {
                naga::TypeInner::Struct { span, .. } if kind.name.as_deref() == Some("Lane") => Some(span),
                _ => None,
            });
            assert_eq!(lane.map(u64::from), Some(crate::frame::lanes::lane_bytes(&with)), "{traversal:?} {stack_size}");
        }
    }
}
