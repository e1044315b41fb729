//! Ground truth of all surfaces along a pixel's line of sight: through glass, veils and holes, and by way of mirrors.

use crate::{
    Error, MISS, Renderer, Scene, StereoPair, UploadedScene, View,
    truth::{
        ground_truth::{check_pair, check_scene},
        occlusion::Pixels,
        other_eye::{Counterpart, Line, OtherEye},
        sight::{Onward, Place, Sight, State},
    },
};

/// Which surfaces lines of sight meet ([`Renderer::layers`]).
///
/// A line passes glass ([`Finish::Glass`](crate::Finish::Glass)), veils (opacities below 1) and the holes of cut-outs.
/// It ends at the first opaque surface. By default it stays straight and ends at mirrors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Layering {
    /// Maximum number of surfaces per pixel, 1 to [`Layering::MOST_SURFACES`].
    pub surfaces: u32,
    /// Whether glass bends lines by Snell's law, as light is bent. Otherwise they pass it straight. Thin glass never
    /// bends them.
    pub refracted: bool,
    /// Whether mirrors ([`Finish::Mirror`](crate::Finish::Mirror)) reflect lines. Otherwise lines end there.
    pub mirrored: bool,
}

impl Layering {
    /// Largest value of [`Layering::surfaces`].
    pub const MOST_SURFACES: u32 = 32;

    /// Makes straight lines of at most so many surfaces.
    pub fn new(surfaces: u32) -> Self {
        Self { surfaces, refracted: false, mirrored: false }
    }

    /// Sets whether glass bends lines of sight. The default is false.
    pub fn refracted(mut self, refracted: bool) -> Self {
        self.refracted = refracted;
        self
    }

    /// Sets whether mirrors reflect lines of sight. The default is false.
    pub fn mirrored(mut self, mirrored: bool) -> Self {
        self.mirrored = mirrored;
        self
    }
}

/// Whether the other eye sees a point of a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u8)]
pub enum LayerClass {
    /// It sees the point. A reflected or refracted point is seen by way of the same surfaces.
    Visible = 0,
    /// It sees the point through further see-through surfaces.
    Through = 1,
    /// An opaque surface hides the point, or a plane mirror ends before it could show it.
    Hidden = 2,
    /// The point lies outside the other picture.
    OutOfFrame = 3,
    /// Not known. The search found no such line of sight from the other eye, or glass bends that line. Disparities are
    /// NaN after a search that failed.
    Unknown = 4,
    /// The pixel has no such surface.
    #[default]
    None = 5,
}

/// All surfaces that the lines of sight of a pair meet, made by [`Renderer::layers`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Layers {
    /// Surfaces of the left view.
    pub left: EyeLayers,
    /// Surfaces of the right view.
    pub right: EyeLayers,
}

/// The surfaces that a view's lines of sight meet, in their order from the eye. All lists but `count` have the shape
/// `[surfaces][height][width]`, nearest surface first, top row first. Where a pixel has fewer surfaces, ids are
/// [`MISS`], lengths are infinite, and the other values are 0.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct EyeLayers {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Number of layers: [`Layering::surfaces`].
    pub surfaces: u32,
    /// Number of surfaces of each pixel, `[height][width]`.
    pub count: Vec<u32>,
    /// Depth in world units, as in [`EyeTruth`](crate::EyeTruth). After a bend it is the depth of the virtual point:
    /// the point on the pixel's ray that is as far away as the line is long.
    pub depth: Vec<f32>,
    /// Length of the line from the eye to the surface, in world units.
    pub distance: Vec<f32>,
    /// Disparity `x_l - x_r` in pixels. After a bend it is the virtual disparity, between the places where both eyes
    /// see the same point by way of the same surfaces.
    pub disparity: Vec<f32>,
    /// Difference of rows `y_l - y_r` of these places in pixels. It is 0 before a bend, and for plane mirrors.
    pub vertical_disparity: Vec<f32>,
    /// Whether the other eye sees the point.
    pub class: Vec<LayerClass>,
    /// Number of reflections and refractions before the surface.
    pub bends: Vec<u32>,
    /// Position relative to [`Scene::origin`].
    pub position: Vec<[f32; 3]>,
    /// Geometric normal on the side that the line comes from: unit length, world frame.
    pub geometric_normal: Vec<[f32; 3]>,
    /// Shading normal on the side of the geometric normal: unit length, world frame.
    pub shading_normal: Vec<[f32; 3]>,
    /// Id of the primitive.
    pub primitive: Vec<u32>,
    /// Id of the primitive's object ([`Scene::object_of`]).
    pub object: Vec<u32>,
    /// Id of the primitive's material ([`MaterialId`](crate::MaterialId)).
    pub material: Vec<u32>,
}

impl EyeLayers {
    fn empty(view: &View, surfaces: u32) -> Self {
        let pixels = view.primitive.len();
        let all = pixels * surfaces as usize;
        let (lengths, ids, vectors) = (vec![f32::INFINITY; all], vec![MISS; all], vec![[0.0; 3]; all]);
        Self {
            width: view.width,
            height: view.height,
            surfaces,
            count: vec![0; pixels],
            depth: lengths.clone(),
            distance: lengths,
            disparity: vec![0.0; all],
            vertical_disparity: vec![0.0; all],
            class: vec![LayerClass::None; all],
            bends: vec![0; all],
            position: vectors.clone(),
            geometric_normal: vectors.clone(),
            shading_normal: vectors,
            primitive: ids.clone(),
            object: ids.clone(),
            material: ids,
        }
    }

    /// Returns the part of a list that belongs to a layer, below [`EyeLayers::surfaces`]: `[height][width]`. 0 is the
    /// nearest layer.
    pub fn layer<'a, T>(&self, list: &'a [T], layer: u32) -> &'a [T] {
        let pixels = self.count.len();
        &list[layer as usize * pixels..][..pixels]
    }

    /// Sets the surface that a line is at.
    fn set(&mut self, layer: usize, line: &Line) {
        let State::At(seen) = line.sight.state else { return };
        let place = layer * self.count.len() + line.pixel;
        self.count[line.pixel] += 1;
        self.depth[place] = line.depth(&seen) as f32;
        self.distance[place] = seen.distance as f32;
        self.bends[place] = line.sight.bends;
        self.position[place] = seen.position.as_vec3().to_array();
        self.geometric_normal[place] = seen.surface.geometric_normal.to_array();
        self.shading_normal[place] = seen.surface.shading_normal.to_array();
        self.primitive[place] = seen.primitive;
        self.object[place] = seen.surface.object;
        self.material[place] = seen.surface.material.0;
    }

    fn set_counterpart(&mut self, layer: usize, line: &Line, other: &Counterpart) {
        let place = layer * self.count.len() + line.pixel;
        self.disparity[place] = other.apart[0] as f32;
        self.vertical_disparity[place] = other.apart[1] as f32;
        self.class[place] = other.class;
    }
}

impl Renderer {
    /// Returns all surfaces that the lines of sight through the pixels' centres meet, and whether the other eye sees
    /// them. Pairs need what [`Renderer::ground_truth`] needs. `uploaded` must be the current state of `scene`.
    ///
    /// Straight lines meet their surfaces at one pixel, so a surface's disparity follows from its depth. After a bend,
    /// Newton's method searches the other picture for the line that reaches the same point by way of the same objects.
    /// It begins at the image of the point in plane mirrors, which is exact there. The positions are computed in f64.
    ///
    /// A point with an opacity of 0 is no surface. The alpha of a texture counts on triangles only, at its nearest
    /// pixel. Of two surfaces at the same distance, the one with the smaller id counts. Normal maps bend no lines.
    ///
    /// ```
    /// use stereotrace::{Builtin, Gpu, LayerClass, Layering, Renderer, blocking::Wait};
    ///
    /// let (scene, camera) = (Builtin::ThreeSpheresMirrors.scene(), Builtin::ThreeSpheresMirrors.camera(64, 48));
    /// let mut renderer = Renderer::new(Gpu::new().wait()?);
    /// let uploaded = renderer.upload(&scene).wait()?;
    /// let pair = renderer.pair(&uploaded, &camera).read().wait()?;
    /// let layers = renderer.layers(&uploaded, &scene, &pair, &Layering::new(4)).wait()?;
    /// let first = &layers.left.class[..64 * 48];
    /// assert!(first.iter().any(|class| *class == LayerClass::Visible));
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Options`] for a number of surfaces out of range; [`Error::Rig`] for toed-in eyes and lenses; and the
    /// errors of [`Renderer::ground_truth`].
    pub async fn layers(
        &self,
        uploaded: &UploadedScene,
        scene: &Scene,
        pair: &StereoPair,
        layering: &Layering,
    ) -> Result<Layers, Error> {
        check(layering)?;
        check_pair(pair)?;
        check_scene(uploaded, scene, pair)?;
        if let Some(name) = pair.pose.projection.without_rows() {
            return Err(Error::Rig { reason: format!("{name} have no disparity, which layers need") });
        }
        let place = Place { scene, uploaded };
        Ok(Layers {
            left: self.eye_layers(place, pair, -1.0, layering).await?,
            right: self.eye_layers(place, pair, 1.0, layering).await?,
        })
    }

    /// Returns the surfaces of the left view (-1) or the right view (1).
    async fn eye_layers(
        &self,
        place: Place<'_>,
        pair: &StereoPair,
        side: f64,
        layering: &Layering,
    ) -> Result<EyeLayers, Error> {
        let view = if side < 0.0 { &pair.left } else { &pair.right };
        let pixels = Pixels::of(&pair.pose, 0.5 * side);
        let other = OtherEye::new(self, place, &pair.pose, side, layering);
        let mut lines = begun(view, place.scene, &pixels);
        let mut found = EyeLayers::empty(view, layering.surfaces);
        for layer in 0..layering.surfaces as usize {
            lines.retain(|line| !matches!(line.sight.state, State::Gone));
            let open = lines.iter_mut().map(|line| &mut line.sight).filter(|sight| sight.is_open());
            self.advance(place, open.collect()).await?;
            lines.retain(|line| matches!(line.sight.state, State::At(_)));
            let counterparts = other.counterparts(&pixels, &lines).await?;
            for (line, counterpart) in lines.iter_mut().zip(counterparts) {
                found.set(layer, line);
                found.set_counterpart(layer, line, &counterpart);
                line.go_on(place.scene, layering);
            }
        }
        Ok(found)
    }
}

/// Returns the lines of sight of a view's pixels. Each is at the surface that the picture shows.
fn begun(view: &View, scene: &Scene, pixels: &Pixels) -> Vec<Line> {
    let width = (view.width as usize).max(1);
    let line = |(pixel, (&primitive, &depth)): (usize, (&u32, &f32))| {
        let place = [(pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5];
        let ray = pixels.ray_through(place);
        let mut sight = Sight::new(scene, ray);
        sight.take(scene, primitive, depth.into());
        Line { pixel, place, scale: ray.1.length(), sight, bends: Vec::new() }
    };
    view.primitive.iter().zip(&view.depth).enumerate().map(line).collect()
}

impl Line {
    fn go_on(&mut self, scene: &Scene, layering: &Layering) {
        let State::At(seen) = self.sight.state else { return };
        let onward = seen.onward(scene, &self.sight, layering);
        if let Onward::Bends(bend) = onward {
            self.bends.push((bend, seen));
        }
        self.sight.continue_by(onward);
    }
}

fn check(layering: &Layering) -> Result<(), Error> {
    let most = Layering::MOST_SURFACES;
    match (1..=most).contains(&layering.surfaces) {
        true => Ok(()),
        false => {
            let reason = format!("{} surfaces; it must be 1 to {most}", layering.surfaces);
            Err(Error::Options { option: "layers", reason })
        }
    }
}
