//! A scene of a data set, from which pairs are rendered one after the other.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use sha2::{Digest as _, Sha256};

use super::{
    draws::{Drawn, Draws, PLACES, rounded},
    generate::{self, Assets, generate},
    motion::{move_objects, moved_camera},
    poses::{FreePoses, RandomPose},
    projector::{self, Projector},
    spec::{
        CameraEntry, LightEntry, Lights, Motion, OriginEntry, Poses, RandomLights, RandomMaterials, SkyEntry, Source,
        Spec,
    },
};
use crate::{
    Animation, Builtin, CameraPath, Error, Light, Material, MaterialId, MissingTextures, Origin, OutsideFiles,
    Projection, Renderer, Scene, SceneFile, SceneOptions, Sky, SkyMap, StereoCamera, TextureId, Update, UploadedScene,
    camera::{HUMAN_INTERAXIAL, Intrinsics},
    scene::content::hex,
};

/// Default limit of disparities, as a share of the width. Stereo matchers rarely search farther.
const DISPARITY_SHARE: f64 = 0.2;
/// Default minimum share of surfaces in views of a generated scene.
const VIEW_SURFACES: f64 = 0.25;
/// Number of lights that are placed in a scene without lights.
const DEFAULT_LIGHTS: usize = 3;
/// Largest turn of a generated scene's camera for several pairs, in degrees.
const TURN: f64 = 20.0;
/// Width of the procedural sky in pixels.
const SKY_WIDTH: u32 = 1024;

pub(super) struct Stage {
    /// The scene with the lights and materials of the last pair.
    pub(super) scene: Scene,
    cameras: Vec<(Arc<str>, StereoCamera)>,
    animations: Vec<Animation>,
    /// Time that the scene was moved to, in seconds.
    posed: Option<f64>,
    /// Hash of an animated scene at rest.
    digest: Option<String>,
    /// The scene at the time of the next pair, or at another time of its motion; `None` if only the camera moves.
    next: Option<(Scene, UploadedScene)>,
    builtin: Option<Builtin>,
    /// Camera from which poses are drawn, in place of the spec's camera and rig.
    given: Option<StereoCamera>,
    /// The scene's own materials, lights and ambient light.
    materials: Vec<Material>,
    lights: Vec<Light>,
    ambient: Option<Vec3>,
    uploaded: Option<UploadedScene>,
    /// Whether lights or materials have changed since the upload.
    has_changed: bool,
    /// Item and attempt that the scene was generated for.
    pub(super) made_for: Option<[u32; 2]>,
    /// Eye and target of the cameras that a generated scene proposes.
    views: Vec<[DVec3; 2]>,
    /// For each object of a generated scene, whether it can move.
    can_move: Vec<bool>,
    /// Picture of the rig's projector.
    picture: Option<TextureId>,
    /// The rig's projector, whose light is the scene's last one.
    projector: Option<Projector>,
}

impl Stage {
    /// Makes a stage of a scene on the device, with the camera from which poses are drawn.
    pub(super) fn given(scene: Scene, uploaded: UploadedScene, camera: StereoCamera) -> Self {
        Self { uploaded: Some(uploaded), given: Some(camera), ..Self::of(scene) }
    }

    fn of(scene: Scene) -> Self {
        Self {
            materials: scene.materials().to_vec(),
            lights: scene.lights.clone(),
            ambient: scene.ambient,
            scene,
            cameras: Vec::new(),
            animations: Vec::new(),
            posed: None,
            digest: None,
            next: None,
            builtin: None,
            given: None,
            uploaded: None,
            has_changed: false,
            made_for: None,
            views: Vec::new(),
            can_move: Vec::new(),
            picture: None,
            projector: None,
        }
    }

    /// Returns whether the scene was generated for another item or attempt.
    pub(super) fn is_for_another(&self, draws: &Draws) -> bool {
        self.made_for.is_some_and(|made_for| made_for != [draws.item, draws.attempt])
    }

    /// Generates the scene of an item.
    pub(super) fn generated(spec: &Spec, index: usize, assets: &Assets, draws: &Draws) -> Result<Self, Error> {
        let Some(options) = spec.generator(index) else {
            return Err(Error::Spec { key: "generate".into(), reason: "the scene is not generated".into() });
        };
        let made = generate(options, assets, draws)?;
        let mut stage = Self::of(made.scene);
        stage.cameras = vec![("generated".into(), made.camera)];
        stage.made_for = Some([draws.item, draws.attempt]);
        (stage.views, stage.can_move) = (made.views, made.can_move);
        stage.set_pictures(spec, index)?;
        Ok(stage)
    }

    /// Reads a scene of a spec.
    pub(super) fn open(spec: &Spec, index: usize) -> Result<Self, Error> {
        let entry = &spec.scenes[index];
        let mut stage = match &entry.source {
            Source::Generate { .. } => {
                return Err(Error::Spec { key: "generate".into(), reason: "the scene has no file".into() });
            }
            Source::Builtin { builtin } => Self { builtin: Some(*builtin), ..Self::of(builtin.scene()) },
            Source::File { file, crease_angle, missing_textures, outside_files, origin } => {
                let options = SceneOptions::default()
                    .crease_angle(crease_angle.map(|angle| angle as f32))
                    .missing_textures(match missing_textures {
                        Some("warn") => MissingTextures::Warn,
                        _ => MissingTextures::Error,
                    })
                    .outside_files(match outside_files {
                        Some("allow") => OutsideFiles::Allow,
                        _ => OutsideFiles::Refuse,
                    })
                    .outside_option_name("outside_files: allow")
                    .origin(match origin {
                        Some(OriginEntry::At(position)) => Origin::At(DVec3::from_array(*position)),
                        Some(OriginEntry::Named("none")) => Origin::World,
                        _ => Origin::Auto,
                    });
                let file = SceneFile::open(spec.path_of(file), &options)?;
                let SceneFile { scene, cameras, animations, .. } = file;
                Self { cameras, animations, ..Self::of(scene) }
            }
        };
        stage.set_pictures(spec, index)?;
        if !stage.animations.is_empty() {
            stage.digest = Some(stage.sha256(spec, index)?);
        }
        Ok(stage)
    }

    /// Sets the sky that the spec gives for the scene, and adds the picture of the rig's projector.
    fn set_pictures(&mut self, spec: &Spec, index: usize) -> Result<(), Error> {
        self.picture = projector::picture(spec)?.map(|picture| self.scene.add_texture(picture));
        match &spec.scenes[index].sky {
            Some(SkyEntry::Color(color)) => self.scene.sky = Sky::Constant(vector(*color)),
            Some(SkyEntry::Named(name)) if name == "procedural" => {
                self.scene.sky = Sky::Map(SkyMap::procedural(SKY_WIDTH)?);
            }
            Some(SkyEntry::Named(file)) => self.scene.sky = Sky::Map(SkyMap::open(spec.path_of(file))?),
            None => {}
        }
        Ok(())
    }

    /// Returns the animation of the spec, by default the first one.
    fn animation(&self, motion: &Motion) -> Result<Option<&Animation>, Error> {
        let Some(name) = &motion.animation else { return Ok(self.animations.first()) };
        let found = self.animations.iter().find(|animation| animation.name() == name);
        found.map(Some).ok_or_else(|| {
            let known = Vec::from_iter(self.animations.iter().take(20).map(Animation::name)).join(", ");
            let known = if known.is_empty() { "none".into() } else { known };
            let reason = format!("no animation '{name}' in this scene; its animations are: {known}");
            Error::Spec { key: "motion.animation".into(), reason }
        })
    }

    /// Returns the time of an item's first pair in seconds.
    fn time(motion: &Motion, animation: &Animation, draws: &Draws) -> f64 {
        match &motion.time {
            Some(time) => draws.draw(time, "motion.time"),
            None => rounded(animation.duration() * draws.unit("motion.time")),
        }
    }

    /// Moves the scene and its cameras to the time of an item's first pair.
    pub(super) fn seek(&mut self, spec: &Spec, draws: &Draws) -> Result<(), Error> {
        let Some(motion) = &spec.motion else { return Ok(()) };
        let Some(animation) = self.animation(motion)?.cloned() else { return Ok(()) };
        let time = Self::time(motion, &animation, draws);
        if self.posed == Some(time) {
            return Ok(());
        }
        // Lights of another item would not move.
        self.scene.lights.clone_from(&self.lights);
        (self.posed, self.has_changed) = (None, true); // also after an error
        animation.pose(&mut self.scene, time)?;
        self.posed = Some(time);
        for ((_, camera), moved) in self.cameras.iter_mut().zip(animation.cameras(time)?) {
            *camera = moved;
        }
        self.lights.clone_from(&self.scene.lights);
        Ok(())
    }

    /// Makes the scene of an item at another time, and uploads it if it moves. The time is 0 at the first pair and 1 at
    /// the next pair. Returns the camera of this time.
    pub(super) async fn advance(
        &mut self,
        renderer: &Renderer,
        (motion, path): (&Motion, Option<&CameraPath>),
        draws: &Draws,
        camera: StereoCamera,
        time: f64,
    ) -> Result<StereoCamera, Error> {
        let there = match path {
            None => moved_camera(camera, &motion.camera, draws, time)?,
            Some(path) => {
                let there = path.at((f64::from(draws.item) + time) as f32);
                camera.eye(there.eye_position()).target(there.target_position()).up(there.up_direction())
            }
        };
        if self.animation(motion)?.is_some() || motion.objects.is_some() || self.projector.is_some() {
            self.move_scene(renderer, motion, draws, (time, &there)).await?;
        }
        Ok(there)
    }

    /// Moves animated and drawn objects and the projector to a time, and uploads the scene.
    async fn move_scene(
        &mut self,
        renderer: &Renderer,
        motion: &Motion,
        draws: &Draws,
        (time, camera): (f64, &StereoCamera),
    ) -> Result<(), Error> {
        let mut scene = self.scene.clone();
        if let (Some(projector), Some(light)) = (&self.projector, scene.lights.last_mut()) {
            *light = projector.at(&camera.pose()?);
        }
        if let Some(animation) = self.animation(motion)? {
            let step = draws.draw(&motion.step, "motion.step");
            animation.pose(&mut scene, Self::time(motion, animation, draws) + time * step)?;
        }
        if let Some(objects) = &motion.objects {
            move_objects(&mut scene, (objects, &self.can_move), draws, time)?;
        }
        let there = self.next.take().filter(|(_, uploaded)| uploaded.belongs_to(renderer.gpu()).is_ok());
        let uploaded = match there {
            None => renderer.upload(&scene).await?,
            Some((_, mut uploaded)) => {
                renderer.update(&mut uploaded, &scene, Update::RefitOrRebuild).await?;
                uploaded
            }
        };
        self.next = Some((scene, uploaded));
        Ok(())
    }

    /// Returns the scene of the time that was last made.
    pub(super) fn next(&self) -> Result<(&Scene, &UploadedScene), Error> {
        match &self.next {
            Some((scene, uploaded)) => Ok((scene, uploaded)),
            None => Ok((&self.scene, self.uploaded()?)),
        }
    }

    /// Returns a hash of everything that pictures of the scene depend on: its content and its camera in the spec.
    pub(super) fn sha256(&self, spec: &Spec, index: usize) -> Result<String, Error> {
        if let Some(digest) = &self.digest {
            return Ok(digest.clone());
        }
        let first = Draws { seed: spec.seed, item: 0, attempt: 0 };
        let camera = self.camera(spec, index, &first)?.to_json()?;
        let mut hash = Sha256::new();
        hash.update(format!("{} {camera}", self.scene.sha256()));
        self.animations.iter().for_each(|animation| animation.content(|bytes| hash.update(bytes)));
        hash.update(content_of_path(spec));
        Ok(hex(&hash.finalize()))
    }

    /// Returns the camera that the spec gives for the scene, or the scene's own.
    fn camera(&self, spec: &Spec, index: usize, draws: &Draws) -> Result<StereoCamera, Error> {
        let [width, height] = spec.size.draw(draws);
        if let Some(path) = spec.poses.path() {
            return Ok(path.at(draws.item as f32).size(width, height));
        }
        let given = spec.scenes[index].camera.as_ref();
        let named = given.and_then(|given| given.name.as_deref());
        let own = match named {
            None => self.cameras.first().map(|(_, camera)| *camera),
            Some(name) => match self.cameras.iter().find(|(known, _)| **known == *name) {
                Some((_, camera)) => Some(*camera),
                None => {
                    let known: Vec<&str> = self.cameras.iter().take(20).map(|(name, _)| &**name).collect();
                    let known = if known.is_empty() { "none".into() } else { known.join(", ") };
                    let reason = format!("no camera '{name}' in this scene; its cameras are: {known}");
                    return Err(Error::Spec { key: "camera.name".into(), reason });
                }
            },
        };
        let mut camera = match (given, self.builtin, own, self.scene.bounds()) {
            (Some(CameraEntry { eye: Some(eye), target: Some(target), .. }), ..) => {
                StereoCamera::look_at(DVec3::from_array(*eye), DVec3::from_array(*target)).size(width, height)
            }
            (_, Some(builtin), ..) => builtin.camera(width, height),
            (_, None, Some(camera), _) => camera.size(width, height),
            (_, None, None, Some(bounds)) => StereoCamera::fitting(bounds, width, height),
            (_, None, None, None) => {
                let reason = "it is empty or has only infinite planes, so it needs a camera".into();
                return Err(Error::Scene { element: "the scene".into(), reason });
            }
        };
        if let Some(up) = given.and_then(|given| given.up) {
            camera = camera.up(vector(up));
        }
        camera.pose()?;
        Ok(camera)
    }

    /// Returns the scene's camera with the pair's rig, from which poses are drawn.
    fn rigged(&self, spec: &Spec, index: usize, draws: &Draws) -> Result<StereoCamera, Error> {
        if let Some(given) = self.given {
            return Ok(given);
        }
        let (own, rig) = (self.camera(spec, index, draws)?, &spec.rig);
        let draw =
            |value: &Option<_>, name: &str| value.as_ref().map(|value| draws.draw(value, &format!("rig.{name}")));
        let separation = draw(&rig.interaxial, "interaxial").or_else(|| draw(&rig.baseline, "baseline"));
        if let Some(around) = rig.around {
            let camera = own.projection(Projection::Equirectangular(around.projection()));
            let camera = camera.interaxial(separation.map_or(HUMAN_INTERAXIAL, |separation| separation as f32));
            camera.pose()?;
            return Ok(camera);
        }
        if let Some(lens) = &rig.lens {
            let interaxial =
                separation.map_or_else(|| Ok(own.pose()?.interaxial), |separation| Ok(separation as f32))?;
            let camera = own.interaxial(interaxial).lens(lens.drawn(draws, spec.size.draw(draws))?);
            camera.pose()?;
            return Ok(camera);
        }
        let mut camera = own;
        let distance = rig.screen_distance.as_ref().map(|value| draws.draw(value, "rig.screen_distance").0 as f32);
        let distance = distance.or_else(|| spec.format.layout().map(|_| f32::INFINITY));
        // Parallel cameras have neither parallax at infinity nor a screen width. Both are converted, to keep the view.
        if distance == Some(f32::INFINITY)
            && rig.interaxial_px.is_none()
            && let Ok(parallel) = camera.parallel()
        {
            camera = parallel;
        }
        if let Some(degrees) = draw(&rig.fov, "fov") {
            camera = camera.vertical_fov_degrees(degrees as f32);
        }
        if let Some(fx) = draw(&rig.fx, "fx") {
            let [width, height] = spec.size.draw(draws).map(f64::from);
            let center = [draw(&rig.cx, "cx").unwrap_or(width / 2.0), draw(&rig.cy, "cy").unwrap_or(height / 2.0)];
            camera = camera.intrinsics(Intrinsics::new([fx, draw(&rig.fy, "fy").unwrap_or(fx)], center));
            if separation.is_none() && rig.interaxial_px.is_none() {
                // An interaxial in pixels would depend on the focal length.
                camera = camera.interaxial(own.pose()?.interaxial);
            }
        }
        if let Some(separation) = separation {
            camera = camera.interaxial(separation as f32);
        }
        if let Some(pixels) = draw(&rig.interaxial_px, "interaxial_px") {
            camera = camera.interaxial_pixels(pixels as f32);
        }
        // Intrinsics set the screen distance, and a given distance replaces it.
        if let Some(distance) = distance {
            camera = camera.screen_distance(distance);
        }
        camera.pose()?;
        Ok(camera)
    }

    /// Returns the pair's camera, and the number of tries to find it. Free poses need the scene on the device.
    pub(super) async fn posed(
        &mut self,
        renderer: &Renderer,
        spec: &Spec,
        index: usize,
        draws: &Draws,
    ) -> Result<RandomPose, Error> {
        let camera = self.rigged(spec, index, draws)?;
        match &spec.poses {
            Poses::Fixed | Poses::Path { .. } => Ok(RandomPose { camera, tries: 1 }),
            Poses::Orbit { turn, rise, distance } => {
                let turn = draws.draw(turn, "poses.turn").to_radians();
                let rise = draws.draw(rise, "poses.rise").to_radians();
                let camera = orbited(camera, turn, rise, draws.draw(distance, "poses.distance"));
                camera.pose()?;
                Ok(RandomPose { camera, tries: 1 })
            }
            Poses::Free { clearance, max_disparity, min_surfaces } => {
                self.bring(renderer).await?;
                let limits = (clearance.as_ref(), *max_disparity, *min_surfaces);
                self.free(renderer, (spec, index), camera, draws, limits).await
            }
        }
    }

    /// Returns a free camera with the properties of `camera`, by the limits of [`Poses::Free`].
    async fn free(
        &self,
        renderer: &Renderer,
        (spec, index): (&Spec, usize),
        camera: StereoCamera,
        draws: &Draws,
        (clearance, limit, surfaces): (Option<&Drawn<f64>>, Option<f64>, Option<f64>),
    ) -> Result<RandomPose, Error> {
        // Near the poles of equirectangular pictures, disparities are as large as the picture.
        let usual = match spec.rig.around {
            None => DISPARITY_SHARE * f64::from(camera.pose()?.size[0]),
            Some(_) => f64::INFINITY,
        };
        let limit = limit.unwrap_or(usual) as f32;
        let of_format = spec.format.layout().map_or(f32::INFINITY, |layout| layout.disparity_limit());
        let mut poses = FreePoses::new(&self.scene, camera, draws.pose_seed())?.disparity(limit.min(of_format));
        if let Some(array) = &spec.rig.array {
            // All cameras are in free space then.
            let interaxial = f64::from(camera.pose()?.interaxial);
            poses = poses.clearance(((array.radius() + 1.0).max(2.0) * interaxial) as f32);
        }
        if let Some(clearance) = clearance {
            poses = poses.clearance(draws.draw(clearance, "poses.clearance") as f32);
        }
        if let Some(share) = surfaces {
            poses = poses.surfaces(share as f32);
        }
        let views = self.views_for(spec, draws);
        if spec.scenes[index].camera.is_none() && self.made_for.is_some() {
            if views.is_empty() {
                // Elsewhere in its box, a camera may be below the ground.
                let reason = "the generated scene has no free place for a camera".into();
                return Err(Error::Options { option: "poses", reason });
            }
            poses = poses.among(&views).surfaces(surfaces.unwrap_or(VIEW_SURFACES) as f32);
        }
        poses.find(renderer, self.uploaded()?, draws.item).await
    }

    /// Returns the cameras that a generated scene proposes, in the order in which a pair tries them. Pairs of one scene
    /// begin at different ones, and turn them if there are more pairs than cameras.
    fn views_for(&self, spec: &Spec, draws: &Draws) -> Vec<[DVec3; 2]> {
        let (count, pairs) = (self.views.len(), spec.scene_pairs as usize);
        let number = (draws.item % spec.scene_pairs) as usize;
        let mut views = self.views.clone();
        if count > 0 {
            views.rotate_left(number * count / pairs % count);
        }
        if number > 0 && pairs > count {
            let angle = draws.draw(&Drawn::Uniform([-TURN, TURN]), "poses.turn").to_radians();
            views.iter_mut().for_each(|[eye, target]| *target = *eye + turned(*target - *eye, DVec3::Y, angle));
        }
        views
    }

    /// Sets the pair's lights, ambient light and materials, whatever the previous pair set.
    pub(super) fn dress(
        &mut self,
        spec: &Spec,
        index: usize,
        draws: &Draws,
        camera: &StereoCamera,
    ) -> Result<(), Error> {
        let (entry, of_item) = (&spec.scenes[index], draws);
        let draws = &spec.scene_draws(draws);
        let lights = match (&spec.randomise.lights, &entry.lights) {
            (Some(random), _) => self.drawn_lights(random, draws, camera)?,
            (None, Some(Lights::Given(given))) => given.iter().map(light).collect(),
            (None, Some(Lights::Placed(count))) => self.scene.lights_around(*count as usize, camera)?,
            (None, None) if self.lights.is_empty() => self.scene.lights_around(DEFAULT_LIGHTS, camera)?,
            (None, None) => self.lights.clone(),
        };
        let mut lights = lights;
        if let (Some(entry), Some(picture)) = (&spec.rig.projector, self.picture) {
            let projector = Projector::drawn(entry, of_item, picture);
            lights.push(projector.at(&camera.pose()?));
            self.projector = Some(projector);
        }
        let drawn = spec.randomise.ambient.as_ref().map(|value| [draws.draw(value, "ambient"); 3]);
        let ambient = drawn.or(entry.ambient).map(vector).or(self.ambient);
        self.has_changed |= lights != self.scene.lights || ambient != self.scene.ambient;
        (self.scene.lights, self.scene.ambient) = (lights, ambient);
        if let Some(random) = &spec.randomise.materials {
            for (place, own) in self.materials.iter().enumerate() {
                let drawn = material(random, draws, place, own);
                if drawn != self.scene.materials()[place] {
                    self.scene.set_material(MaterialId(place as u32), drawn)?;
                    self.has_changed = true;
                }
            }
        }
        Ok(())
    }

    /// Restores the scene's own materials, lights and ambient light.
    pub(super) fn undress(&mut self) {
        (self.scene.lights, self.scene.ambient) = (self.lights.clone(), self.ambient);
        for (place, own) in self.materials.iter().enumerate() {
            // Fails only for ids out of range.
            drop(self.scene.set_material(MaterialId(place as u32), own.clone()));
        }
        self.has_changed = true;
    }

    fn drawn_lights(&self, random: &RandomLights, draws: &Draws, camera: &StereoCamera) -> Result<Vec<Light>, Error> {
        let placed = self.scene.lights_around(PLACES as usize, camera)?;
        let count = draws.draw(&random.count, "lights.count") as usize;
        let mut order: Vec<_> =
            (0..placed.len()).map(|place| (draws.unit(&format!("lights.place.{place}")), place)).collect();
        order.sort_by(|one, other| one.0.total_cmp(&other.0));
        let chosen = order.iter().take(count).enumerate();
        Ok(chosen
            .map(|(index, (_, place))| {
                let draw = |value, name: &str| draws.draw(value, &format!("lights.{index}.{name}"));
                let strength = draw(&random.strength, "strength") / count as f64;
                let intensity =
                    ["r", "g", "b"].map(|channel| strength * draw(&random.tint, &format!("tint.{channel}")));
                light(&LightEntry {
                    position: Some(placed[*place].position.to_array()),
                    towards: None,
                    intensity,
                    radius: random.radius.as_ref().map(|radius| draw(radius, "radius")),
                })
            })
            .collect())
    }

    /// Uploads the scene to the renderer's device, or updates it there.
    pub(super) async fn bring(&mut self, renderer: &Renderer) -> Result<(), Error> {
        if let Some(uploaded) = self.uploaded.as_mut().filter(|uploaded| uploaded.belongs_to(renderer.gpu()).is_ok()) {
            if self.has_changed {
                renderer.update(uploaded, &self.scene, Update::RefitOrRebuild).await?;
            }
        } else {
            self.uploaded = None; // frees its memory first
            self.uploaded = Some(renderer.upload(&self.scene).await?);
        }
        self.has_changed = false;
        Ok(())
    }

    pub(super) fn uploaded(&self) -> Result<&UploadedScene, Error> {
        self.uploaded.as_ref().ok_or(Error::ForeignScene)
    }
}

fn vector(values: [f64; 3]) -> Vec3 {
    Vec3::from_array(values.map(|value| value as f32))
}

fn light(entry: &LightEntry) -> Light {
    let (intensity, radius) = (vector(entry.intensity), entry.radius.unwrap_or(0.0) as f32);
    let position = DVec3::from_array(entry.position.unwrap_or_default());
    match entry.towards {
        Some(towards) => Light::directional(DVec3::from_array(towards), radius, intensity),
        None if radius > 0.0 => Light::sphere(position, radius, intensity),
        None => Light::point(position, intensity),
    }
}

/// Returns a material with its drawn fields.
fn material(random: &RandomMaterials, draws: &Draws, place: usize, own: &Material) -> Material {
    let mut found = own.clone();
    if draws.unit(&format!("materials.{place}.share")) >= random.share {
        return found;
    }
    let draw = |value, name: &str| draws.draw(value, &format!("materials.{place}.{name}"));
    let colors = |value, name: &str| ["r", "g", "b"].map(|channel| draw(value, &format!("{name}.{channel}")));
    if let Some(albedo) = &random.albedo {
        found.albedo = vector(colors(albedo, "albedo"));
    }
    if let Some(tint) = &random.tint {
        let (tint, albedo) = (DVec3::from_array(colors(tint, "tint")), own.albedo.as_dvec3());
        found.albedo = (tint * albedo).min(DVec3::ONE).as_vec3();
    }
    if let Some(specular) = &random.specular {
        found.specular = Vec3::splat(draw(specular, "specular") as f32);
    }
    if let Some(exponent) = &random.exponent {
        found.exponent = draw(exponent, "exponent") as f32;
    }
    // Paths would show the file's values.
    if found != *own {
        found.principled = None;
    }
    found
}

/// Returns a hash of everything that a generated scene depends on, except the item: the generator's version and
/// options, the contents of the user's folders, and the scene's sky and camera in the spec.
pub(super) fn generator_sha256(spec: &Spec, index: usize, assets: &Assets) -> Result<String, Error> {
    let entry = &spec.scenes[index];
    let mut sky = Stage::of(Scene::new());
    sky.set_pictures(spec, index)?;
    let options = (&entry.source, &entry.camera);
    let options = serde_json::to_string(&options)
        .map_err(|error| Error::Spec { key: format!("scenes[{index}]"), reason: error.to_string() })?;
    let (sky, path) = (sky.scene.sha256(), content_of_path(spec));
    let text = format!("generator {} {options} {} {sky}{path}", generate::VERSION, assets.digest());
    Ok(hex(&Sha256::digest(text)))
}

/// Returns the cameras of a path as text, or nothing.
fn content_of_path(spec: &Spec) -> String {
    spec.poses.path().map_or_else(String::new, |path| format!(" {path:?}"))
}

/// Moves a camera about its target by two angles in radians, and scales its distance.
fn orbited(camera: StereoCamera, turn: f64, rise: f64, distance: f64) -> StereoCamera {
    let up = camera.up_direction().as_dvec3().normalize();
    let target = camera.target_position();
    let mut arm = turned(camera.eye - target, up, turn);
    if let Some(side) = up.cross(arm).try_normalize() {
        arm = turned(arm, side, -rise);
    }
    camera.eye(DVec3::from_array((target + distance * arm).to_array().map(rounded)))
}

/// Rotates a vector about an axis of unit length, by an angle in radians (Rodrigues' formula).
fn turned(vector: DVec3, axis: DVec3, angle: f64) -> DVec3 {
    let (sin, cos) = angle.sin_cos();
    vector * cos + axis.cross(vector) * sin + axis * axis.dot(vector) * (1.0 - cos)
}
