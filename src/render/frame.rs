//! Renders a frame: runs the plan of its method for each band. Several bands are in flight.

use std::{collections::VecDeque, sync::Arc};

use super::tally::Tally;
use crate::{
    Choice, Error, Filter, Method, OnProgress, OnRows, Options, PassTimes, Penumbra, RaysPerLane, Renderer, Rows,
    ShadowBufferWork, ShadowReuse, Tone, UploadedScene, Visibility,
    frame::{
        Band, Bands, RAYS_PER_PIXEL,
        driver::{Driver, Engine, Setting},
        history::{History, Lit, Recall},
        lanes::Steps,
        plan::{Made, Plan, Search},
        read::{Counts, Ids, ReadBack},
        targets::{Shape, Targets, Used},
        uniforms::{Part, Uniforms},
        wanted::Wanted,
    },
    gpu::{Filling, Staging, Timestamps, add_times},
    kernel::{Resource, layout, variant::Variant},
    message::counted,
    methods::{self, auto::CostModel},
    sampling::Jitter,
    scene::shadowing::Kept,
    steps::{mirrors::Mirrors, paths::Paths},
    t_buffer::Drawn,
    view::rig::{CameraModel, Eyes},
};

/// Maximum number of bands in flight. A frame that is stopped ends after these.
const MOST_IN_FLIGHT: u64 = 8;

/// Result of a frame: how its views were made, and their cost.
#[derive(Clone, Debug)]
pub(crate) struct Done {
    pub(crate) eyes: Eyes,
    /// The requested method, or its replacement.
    pub(super) method: Method,
    /// Cost counters, one per view.
    pub(crate) tallies: Vec<Tally>,
    /// Choice of `Auto` for each view, if any.
    pub(crate) choices: Vec<Option<Choice>>,
    pub(crate) in_steps: bool,
    pub(crate) buffer_depth: u32,
    pub(crate) times: Option<PassTimes>,
    pub(crate) intermediate_bytes: u64,
    /// Cost of filling the shadow-buffers.
    pub(crate) shadow_buffer: ShadowBufferWork,
}

impl Done {
    /// Returns the method that made a view.
    pub(crate) fn method_of(&self, view: usize) -> Method {
        match self.choices[view] {
            _ if self.eyes.sources[view] == view => Method::Naive,
            Some(choice) => choice.method,
            None => self.method,
        }
    }
}

/// The plan of a frame, and the buffers and textures that its kernels write.
struct Prepared {
    method: Method,
    /// The choice of `Auto`, if it can be made before the first step.
    early: Option<Choice>,
    plan: Plan,
    variant: Variant,
    used: Used,
    targets: Arc<Targets>,
}

/// A frame in progress.
struct Frame<'a> {
    driver: Driver<'a>,
    ids: Ids<'a>,
    eyes: &'a Eyes,
    targets: &'a Targets,
    /// The cost model of `Auto`.
    model: CostModel,
    plan: Plan,
    used: &'a Used,
    wanted: Wanted<'a>,
    read_back: ReadBack,
    /// Free staging buffers, as many as more bands can be in flight.
    stagings: Vec<Staging>,
    steps: Steps,
    tallies: Vec<Tally>,
    times: PassTimes,
    /// Number of bands that were traced in steps.
    in_steps: u32,
    on_rows: &'a mut OnRows<'a>,
}

/// A band whose commands are submitted and not yet read back.
struct Flight {
    band: Band,
    filling: Filling,
    /// Names of the timed passes.
    names: Vec<&'static str>,
    in_steps: bool,
}

/// Result of reading back a band.
enum Landed {
    Rows(Option<Rows>),
    /// Number of threads whose loops the adapter ended early.
    CutShort(u64),
}

impl Renderer {
    /// Renders all bands of a frame. If pictures are wanted, their rows are passed to `on_rows`.
    pub(crate) async fn frame<'a>(
        &'a mut self,
        scene: &'a UploadedScene,
        eyes: &'a Eyes,
        options: &Options,
        wanted: Wanted<'a>,
        progress: &'a mut OnProgress<'a>,
        on_rows: &'a mut OnRows<'a>,
    ) -> Result<Done, Error> {
        scene.belongs_to(&self.gpu)?;
        options.check()?;
        eyes.check(options)?;
        if options.samples_sky() {
            scene.weigh_sky().await?;
        }
        let tables = scene.shadow_tables(&self.kernels, options).await?;
        let drawn = if wanted.masks().is_some() { None } else { self.drawn(scene, options) };
        let lit = Lit::of(&scene.shadowing, options);
        let (recall, kept) = self.recall(scene, eyes, options, &wanted, &lit);
        let prepared = match self.prepared(scene, eyes, options, &wanted, drawn, (recall, kept.as_ref())).await {
            // A history only saves time, so the frame does without it.
            Err(Error::OutOfMemory(_)) if recall != Recall::Nothing => {
                self.forget();
                self.prepared(scene, eyes, options, &wanted, drawn, (Recall::Nothing, None)).await?
            }
            other => other?,
        };
        let Prepared { method, early, plan, variant, used, targets } = prepared;
        let parts = used.places.iter().any(|(resource, _)| *resource == Resource::LightParts);
        let read_back = ReadBack::new(targets.shape, [options.linear, parts], wanted.pictures);
        let bytes = read_back.times_offset() + Timestamps::BYTES;
        // The staging buffers leave the cache while the frame is in progress. If a cancelled frame leaves a buffer
        // mapped, that buffer is not reused.
        let mut stagings = self.cache.staging_of(bytes);
        let most = (self.read_back_bytes / bytes).clamp(2, MOST_IN_FLIGHT);
        let in_flight = u64::from(targets.shape.bands.count()).min(most) as usize;
        let make = || Ok((stagings.len()..in_flight).map(|_| Staging::new(&self.gpu, bytes)).collect::<Vec<_>>());
        stagings.extend(self.gpu.checked(make).await?);
        let (tables, shadow_buffer) = tables.unzip();
        let shared = scene.resources_for(&self.gpu, &used, tables.as_deref()).await?;
        let history = self.cache.history.as_ref().filter(|_| plan.remembers());
        // Paths of later frames differ, so that their means become better.
        let earlier = history.filter(|_| self.keeps_light(options, eyes.pose.size));
        let earlier_paths = earlier.map_or(0, History::paths);
        let recalls_bits = matches!(recall, Recall::Read { bits: true, .. });
        let asked = history.filter(|_| recalls_bits).map_or(0.0, History::asked);
        let model = CostModel { asked, ..scene.cost_model(&self.gpu, self.calibration, options) };
        let history = history.map(History::remembered);
        let uniforms = self.uniforms(scene, eyes, options, (&model, &targets.shape, earlier_paths));
        let setting = Setting { eyes, variant, targets: &targets, uniforms, shared, history };
        let mut frame = Frame {
            ids: Ids { of_slots: &scene.ids, objects: &scene.objects },
            eyes,
            targets: &targets,
            model,
            plan,
            used: &used,
            wanted,
            read_back,
            stagings,
            steps: self.steps,
            tallies: vec![Tally::default(); eyes.sources.len()],
            times: PassTimes::default(),
            in_steps: 0,
            on_rows,
            driver: Driver::new(self.engine(true), setting, progress),
        };
        frame.run().await?;
        let done = Done { shadow_buffer: shadow_buffer.unwrap_or_default(), ..frame.done(method, early) };
        let (stagings, plan) = (frame.stagings, frame.plan);
        self.cache.staging.extend(stagings);
        if let Some(history) = self.cache.history.as_mut().filter(|_| plan.remembers() && !done.in_steps) {
            let source = eyes.sources[0];
            let asked = done.tallies[source].asked(model);
            history.turn(&eyes.uniform(source, 0.0), lit, asked, paths_per_sample(options));
        }
        Ok(done)
    }

    /// Plans a frame and makes room for it.
    async fn prepared(
        &mut self,
        scene: &UploadedScene,
        eyes: &Eyes,
        options: &Options,
        wanted: &Wanted<'_>,
        drawn: Option<Drawn>,
        (recall, kept): (Recall, Option<&Kept>),
    ) -> Result<Prepared, Error> {
        let size = eyes.pose.size;
        let (method, early, plan) = self.planned(scene, eyes, options, drawn, recall);
        if plan.remembers() {
            self.ready_history(scene, size, options, kept).await?;
        }
        let variant = Variant { masked: wanted.masks().is_some(), ..self.variant(scene, eyes, options, &plan) };
        let mut used = plan.uses(&self.kernels, &variant);
        used.places.extend(wanted.pictures.then_some((Resource::Packed, 0)));
        let rows = wanted.rows(size).len() as u32;
        let targets = self.targets(self.shape(scene, eyes, options, (&plan, rows, drawn, &used)), &used).await?;
        Ok(Prepared { method, early, plan, variant, used, targets })
    }

    /// Returns the renderer's parts that a driver uses.
    pub(super) fn engine(&mut self, timed: bool) -> Engine<'_> {
        Engine {
            gpu: &self.gpu,
            kernels: &self.kernels,
            slots: &mut self.cache.slots,
            timestamps: self.timestamps.as_mut().filter(|_| timed),
            band_pixels: self.band_pixels,
        }
    }

    /// Returns the uniforms of a frame's views.
    pub(super) fn uniforms(
        &self,
        scene: &UploadedScene,
        eyes: &Eyes,
        options: &Options,
        (model, shape, earlier_paths): (&CostModel, &Shape, u32),
    ) -> Uniforms {
        let jitter = Jitter::of(options);
        let paths = Paths::of(options, 0);
        let view = |view| layout::Frame {
            eyes: eyes.uniform(view, jitter.reach()),
            band: layout::Band {
                size: eyes.pose.size,
                row_end: eyes.pose.size[1],
                runs: self.runs,
                jitter_seed: jitter.seed(),
                ..Default::default()
            },
            lighting: layout::Lighting {
                bounces: options.bounces,
                sources: shape.soft_sources,
                seed: options.light_seed(view),
                occlusion_radius: options.surroundings().map_or(0.0, |occlusion| occlusion.radius),
                share_tolerance: options.penumbra.tolerance(),
                ..Default::default()
            },
            display: layout::Display {
                exposure: options.exposure.exp2(),
                filmic: u32::from(options.tone == Tone::Filmic),
                words_read: shape.words_read(),
                filter_kind: match options.filter {
                    Filter::Box => 0,
                    Filter::Tent => 1,
                    Filter::Gauss => 2,
                },
            },
            costs: layout::Costs {
                least_spared: model.least_spared(),
                listed: model.listed,
                disagreed: model.disagreed,
                asked: model.asked,
            },
            paths: layout::PathRay {
                bounces: paths.map_or(0, |paths| paths.rays - 1),
                tolerance: options.penumbra.tolerance(),
                first: options.pass.first_path.wrapping_add(earlier_paths),
                ..Default::default()
            },
        };
        Uniforms::new((0..eyes.sources.len()).map(view).collect(), self.parts_of(scene, eyes, options))
    }

    /// Returns how a frame may use the history, and which of its bits hold. Frames of several traced views, of parts of
    /// a picture, and those whose samples exceed [`Options::history`] have no history.
    fn recall(
        &self,
        scene: &UploadedScene,
        eyes: &Eyes,
        options: &Options,
        wanted: &Wanted<'_>,
        lit: &Lit,
    ) -> (Recall, Option<Kept>) {
        let size = eyes.pose.size;
        let is_whole = wanted.masks().is_none() && wanted.rows(size).len() as u32 == size[1];
        let traced = eyes.sources.iter().enumerate().filter(|(view, source)| view == *source).count();
        let light = self.keeps_light(options, size);
        let fits = History::bytes(&self.gpu, size, light).is_some_and(|bytes| bytes <= history_bytes(options));
        match &self.cache.history {
            _ if !is_whole || traced > 1 || !fits || eyes.model() != CameraModel::Planar => (Recall::Nothing, None),
            Some(history) if history.is_of(scene.id(), size, light) => history.recall(lit),
            _ => (Recall::Keep, None),
        }
    }

    /// Returns whether a history also keeps the light that paths brought. Without room for it, the light is not kept.
    fn keeps_light(&self, options: &Options, size: [u32; 2]) -> bool {
        let fits = History::bytes(&self.gpu, size, true).is_some_and(|bytes| bytes <= history_bytes(options));
        fits && methods::shares_light(options.method, Paths::of(options, 0))
    }

    /// Makes room for a frame's samples, or tells its kernels what holds of the earlier frame's.
    async fn ready_history(
        &mut self,
        scene: &UploadedScene,
        size: [u32; 2],
        options: &Options,
        kept: Option<&Kept>,
    ) -> Result<(), Error> {
        let light = self.keeps_light(options, size);
        if let Some(history) = self.cache.history.as_ref().filter(|history| history.is_of(scene.id(), size, light)) {
            return history.tell(&self.gpu, kept, paths_per_sample(options)).await;
        }
        self.cache.history = None; // its memory is freed first
        self.cache.history = Some(History::new(&self.gpu, scene.id(), size, light).await?);
        Ok(())
    }

    /// Returns how secondary rays are followed, if there are any. Paths follow them themselves.
    fn mirrors(&self, scene: &UploadedScene, eyes: &Eyes, options: &Options) -> Option<Mirrors> {
        let first_part = scene.soft.parts(options).len();
        let are_followed = scene.variant.mirrors && !options.follows_paths();
        are_followed.then(|| Mirrors::of(&self.gpu, self.shades_apart, eyes.pose.size, options.bounces, first_part))
    }

    /// Returns the paths of a frame, if light follows them.
    fn paths(&self, scene: &UploadedScene, eyes: &Eyes, options: &Options) -> Option<Paths> {
        let paths = Paths::of(options, scene.soft.parts(options).len())?;
        Some(paths.apart(&self.gpu, self.shades_apart, eyes.pose.size))
    }

    /// Returns the parts of soft light, and of paths or secondary rays, whether or not a step uses them.
    fn parts_of(&self, scene: &UploadedScene, eyes: &Eyes, options: &Options) -> Vec<Part> {
        let soft = scene.soft.parts(options);
        let paths = self.paths(scene, eyes, options).into_iter().flat_map(Paths::parts);
        let mirrors = self.mirrors(scene, eyes, options).into_iter().flat_map(Mirrors::parts);
        soft.into_iter().chain(paths).chain(mirrors).collect()
    }

    /// Returns a frame's method, the early choice of `Auto` if it can be made before the first step, and the plan.
    pub(super) fn planned(
        &self,
        scene: &UploadedScene,
        eyes: &Eyes,
        options: &Options,
        drawn: Option<Drawn>,
        recall: Recall,
    ) -> (Method, Option<Choice>, Plan) {
        let method = if self.steps.always { Method::Naive } else { self.effective(options, eyes, scene) };
        let model = scene.cost_model(&self.gpu, self.calibration, options);
        let early = if method == Method::Auto { scene.choose_early(model, &eyes.pose, options) } else { None };
        let is_soft = !scene.ids.is_empty() && scene.soft.count(options) > 0;
        let soft = is_soft.then(|| scene.soft.parts(options).len());
        let chosen = early.map_or(method, |choice| choice.method);
        let views = methods::Views {
            sources: &eyes.sources,
            mirrors: self.mirrors(scene, eyes, options),
            paths: self.paths(scene, eyes, options).filter(|_| scene.variant.has_tree() || scene.variant.planes > 0),
            soft,
            search: Search::of(self.searches_together, options.samples),
            drawn,
            recall,
            keeps_light: self.keeps_light(options, eyes.pose.size),
        };
        let plan = methods::plan(chosen, &views);
        (method, early, plan)
    }

    /// Returns the method that makes the views. With interaxial 0 all views are equal, unless each has its own noise.
    /// In a scene without a BVH, `bracket` has nothing to search. `Auto` falls back to `Naive` if the picture is wider
    /// than the texture of `bracket`'s samples allows.
    pub(super) fn effective(&self, options: &Options, eyes: &Eyes, scene: &UploadedScene) -> Method {
        let width = eyes.pose.size[0];
        match options.method {
            Method::Naive => Method::Naive,
            _ if eyes.pose.interaxial == 0.0 && options.noise_by_view => Method::Naive,
            _ if eyes.pose.interaxial == 0.0 => Method::Ideal,
            Method::Auto | Method::Bracket(_) if !scene.variant.has_tree() => Method::Naive,
            Method::Auto if width > self.gpu.limits.max_texture_dimension_2d => Method::Naive,
            method => method,
        }
    }

    /// Returns the primitives to draw into a T-buffer, or `None` if the frame uses no T-buffer.
    pub(super) fn drawn(&self, scene: &UploadedScene, options: &Options) -> Option<Drawn> {
        let is_asked = options.visibility == Visibility::TBuffer && !self.steps.always;
        if is_asked { scene.drawn() } else { None }
    }

    /// Returns the shape of a frame with this number of rows. Bands have fewer rows than usual if their buffers would
    /// exceed the device's limits.
    pub(super) fn shape(
        &self,
        scene: &UploadedScene,
        eyes: &Eyes,
        options: &Options,
        (plan, rows, drawn, used): (&Plan, u32, Option<Drawn>, &Used),
    ) -> Shape {
        let rays = 1 + scene.lights.len() as u32 + scene.soft.rays(options);
        let views = eyes.sources.len();
        let width = eyes.pose.size[0];
        let shape = |band_pixels: u32| Shape {
            size: eyes.pose.size,
            bands: Bands::new([width, rows], band_pixels, views, plan.reaches),
            views,
            cost_map: options.cost_map,
            g_buffer: options.g_buffer,
            soft_sources: scene.soft.count(options),
            drawing_bytes: drawn.map_or(0, Drawn::list_bytes),
            parts: (self.parts_of(scene, eyes, options).len() as u32).max(1),
        };
        let mut fitting = shape(self.band_pixels / rays.div_ceil(RAYS_PER_PIXEL));
        while let Some(fewer) = fitting.bands.fewer_rows() {
            let read_back = ReadBack::new(fitting, [options.linear, options.keeps_parts()], true).times_offset();
            if fitting.can_be_bound(&self.gpu, used) && read_back <= self.gpu.limits.max_buffer_size {
                break;
            }
            fitting = shape(fewer * width);
        }
        fitting
    }

    /// Returns the variant that specialises a frame's kernels.
    pub(super) fn variant(&self, scene: &UploadedScene, eyes: &Eyes, options: &Options, plan: &Plan) -> Variant {
        let counting = scene.variant.counting(options.count, options.cost_map);
        let (bits, samples) = (plan.bits, plan.samples);
        let second = samples && eyes.has_seconds();
        let shadow_rays = if counting.soft_lights { options.shadow_rays } else { 0 };
        let occlusion_rays = options.surroundings().map_or(0, |occlusion| occlusion.rays);
        let soft = shadow_rays + occlusion_rays > 0;
        let rays = match eyes.model() {
            CameraModel::Planar | CameraModel::Lens(_) => counting.traversal.rays,
            // Rays of different pixels have different origins.
            CameraModel::Around => RaysPerLane::One,
        };
        Variant {
            traversal: counting.traversal.rays(rays),
            camera: eyes.model(),
            linear: options.linear || options.follows_paths(),
            jitter: Jitter::of(options).side(),
            close: scene.close_to(&eyes.positions()),
            bits,
            samples,
            second,
            shadow_rays,
            occlusion_rays,
            sky_light: options.sky_rays.is_some(),
            paths: options.follows_paths(),
            parts: options.keeps_parts(),
            shares: soft && bits == ShadowReuse::Two && options.penumbra != Penumbra::Exact,
            casts: counting.casts || !(soft || options.follows_paths()),
            shadow_buffer: scene.casters().reading(options),
            ..counting
        }
    }

    pub(super) async fn targets(&mut self, shape: Shape, used: &Used) -> Result<Arc<Targets>, Error> {
        if let Some(targets) = self.cache.fitting(shape, used) {
            return Ok(targets);
        }
        self.cache.make_room(self.cache.others());
        let make = || Targets::new(&self.gpu, shape, used);
        let targets = Arc::new(self.gpu.checked(make).await?);
        self.cache.targets.push(targets.clone());
        Ok(targets)
    }
}

/// Returns the number of paths that each sample of a pixel follows, 0 for direct light.
fn paths_per_sample(options: &Options) -> u32 {
    Paths::of(options, 0).map_or(0, |paths| paths.each)
}

/// Returns the memory that a history may take.
fn history_bytes(options: &Options) -> u64 {
    u64::from(options.history.unwrap_or(0)) << 20
}

impl Frame<'_> {
    /// Runs all bands. As many are in flight as have a staging buffer.
    async fn run(&mut self) -> Result<(), Error> {
        self.driver.begin(&self.plan).await?;
        let bands = self.targets.shape.bands;
        let mut flights = VecDeque::new();
        let top = self.wanted.rows(self.targets.shape.size).start;
        for band in (0..bands.count()).map(|index| bands.get(index).moved_down(top)) {
            if self.stagings.is_empty()
                && let Some(first) = flights.pop_front()
            {
                self.land(first).await?;
            }
            flights.push_back(if self.steps.always { self.in_steps(band).await? } else { self.at_once(band).await? });
        }
        for flight in flights {
            self.land(flight).await?;
        }
        Ok(())
    }

    /// Runs all passes of a band by the frame's plan.
    async fn at_once(&mut self, band: Band) -> Result<Flight, Error> {
        if let Some(masks) = self.wanted.masks() {
            self.driver.upload_masks(masks, &band).await?;
        }
        let commands = self.driver.band(&self.plan, &band).await?;
        self.take_off(band, commands, false).await
    }

    /// Runs a band by `Naive` in steps, so that no limit on a thread's loop iterations can end it early.
    async fn in_steps(&mut self, band: Band) -> Result<Flight, Error> {
        self.in_steps += 1;
        self.driver.band_in_steps(&self.plan, &band, self.steps).await?;
        let commands = self.driver.encoder();
        self.take_off(band, commands, true).await
    }

    /// Submits the last commands of a band, including its read-back.
    async fn take_off(
        &mut self,
        band: Band,
        mut commands: wgpu::CommandEncoder,
        in_steps: bool,
    ) -> Result<Flight, Error> {
        let (driver, targets, read_back) = (&mut self.driver, self.targets, self.read_back);
        let top = self.wanted.rows(targets.shape.size).start;
        let staging = self.stagings.pop().expect("as many as are in flight");
        let gpu = driver.gpu();
        let submit = || {
            read_back.encode(driver, targets, &mut commands, &band, staging.buffer());
            let offset = read_back.times_offset();
            let is_last = band.rows.end == top + targets.shape.bands.height();
            let names = driver.timestamps().and_then(|times| {
                let due = times.end_band() || is_last || in_steps;
                due.then(|| times.resolve(gpu, &mut commands, staging.buffer(), offset))
            });
            let filling = staging.fill(gpu, commands.finish());
            Ok(Flight { band, filling, names: names.unwrap_or_default(), in_steps })
        };
        gpu.checked(submit).await
    }

    /// Waits for a band to be read back, and passes on its rows.
    async fn land(&mut self, flight: Flight) -> Result<(), Error> {
        let mut flight = flight;
        loop {
            let Flight { band, filling, names, in_steps } = flight;
            let gpu = self.driver.gpu();
            let (landed, staging) = filling.read(gpu, |bytes| self.landed(bytes, &band, &names, in_steps)).await?;
            self.stagings.push(staging);
            match landed {
                Landed::Rows(rows) => {
                    rows.map_or(Ok(()), |rows| (self.on_rows)(rows))?;
                    return self.driver.band_done(&self.plan, &band);
                }
                Landed::CutShort(threads) if in_steps => return Err(Error::cut_short(threads)),
                Landed::CutShort(threads) => {
                    let threads = counted(threads, "thread", "threads");
                    log::warn!(
                        "rows {} to {}: the adapter ended the loops of {threads} before their work was done; \
                         continuing with naive in steps",
                        band.rows.start,
                        band.rows.end
                    );
                    flight = self.in_steps(band).await?;
                }
            }
        }
    }

    fn landed(&mut self, bytes: &[u8], band: &Band, names: &[&'static str], in_steps: bool) -> Landed {
        let views = 0..self.tallies.len();
        let counts = Vec::from_iter(views.map(|view| self.read_back.counts(bytes, band, view)));
        add_times(&mut self.times, names, &bytes[self.read_back.times_offset() as usize..], self.driver.gpu());
        let threads = counts.iter().map(|counts| counts.cut_short).sum();
        if threads > 0 {
            return Landed::CutShort(threads);
        }
        let width = self.targets.shape.size[0];
        let rows_of = |(view, counts): (usize, &Counts)| {
            let made = if in_steps { Made::Traced } else { counts.made(self.plan.made[view]) };
            let masks = self.wanted.masks().filter(|_| !in_steps);
            let all = u64::from(width) * u64::from(band.count());
            let pixels = masks.map_or(all, |masks| masks[view].count(band.rows.clone()));
            self.tallies[view].add(counts, pixels, made);
            self.read_back.rows(bytes, band, view, made, self.ids)
        };
        let views: Vec<_> = counts.iter().enumerate().filter_map(rows_of).collect();
        Landed::Rows((!views.is_empty()).then_some(Rows { first: band.rows.start, views }))
    }

    fn done(&mut self, method: Method, early: Option<Choice>) -> Done {
        let (eyes, targets) = (self.eyes, self.targets);
        let all_in_steps = self.in_steps == targets.shape.bands.count();
        let choice = |view: usize| {
            let source = eyes.sources[view];
            let chosen = || self.tallies[view].choice(&self.tallies[source], self.model, &eyes.pose);
            (method == Method::Auto && source != view && !all_in_steps).then(|| early.unwrap_or_else(chosen))
        };
        let choices = (0..eyes.sources.len()).map(choice).collect();
        let timed = self.driver.timestamps().is_some_and(|timestamps| !timestamps.is_full());
        let on_host = self.driver.time_on_host();
        if !on_host.is_zero() {
            self.times.passes.insert(1.min(self.times.passes.len()), ("reproject_on_the_host", on_host));
        }
        Done {
            eyes: eyes.clone(),
            method: if all_in_steps { Method::Naive } else { method },
            choices,
            tallies: std::mem::take(&mut self.tallies),
            in_steps: self.in_steps > 0,
            buffer_depth: self.driver.buffer_depth(),
            times: timed.then(|| std::mem::take(&mut self.times)),
            intermediate_bytes: targets.intermediate_bytes(self.used) + self.driver.bytes_beside_targets(),
            shadow_buffer: ShadowBufferWork::default(),
        }
    }
}
