//! Lines of sight that pass see-through surfaces, and bend at mirrors and glass, in f64 on the host.

use glam::{DVec2, DVec3};

use super::{
    layers::Layering,
    surface::{Surface, at, moved, weights},
};
use crate::{
    Error, Finish, MISS, Material, Ray, Renderer, Scene, Texture, TextureKind, UploadedScene, Wrap, scene::Primitive,
    srgb::BRIGHTNESS,
};

/// Two hits on one object this close, as a share of the distance, are one surface met at an edge of its triangles.
const SAME_SURFACE: f64 = 1.0 / 4_194_304.0;
/// Distance of a bent leg's start from the surface, as a share of the position and of the last leg. The kernels use the
/// same values (shaders/shared/light.wgsl).
const OFF_BY_PLACE: f64 = 1.0 / 2_097_152.0;
const OFF_BY_DISTANCE: f64 = 1.0 / 131_072.0;

/// A scene, and the same scene on the device.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) scene: &'a Scene,
    pub(super) uploaded: &'a UploadedScene,
}

/// How a surface continues a line of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Onward {
    /// It is opaque.
    Ends,
    Straight,
    Bends(Bend),
}

/// A bend of a line of sight. The index of refraction is that of the far side relative to the near side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Bend {
    Reflected,
    Refracted(f64),
}

/// A surface that a line of sight meets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) primitive: u32,
    /// Position relative to the scene's origin.
    pub(super) position: DVec3,
    pub(super) surface: Surface,
    /// Parameter of the hit on its ray.
    pub(super) t: f64,
    /// Length of the line from the eye to here.
    pub(super) distance: f64,
    /// Normals on the line's side, of unit length. They are those of `surface`, in f64 where that is known.
    normal: DVec3,
    geometric: DVec3,
    from_outside: bool,
    /// Whether a line may meet the primitive twice.
    is_closed: bool,
}

/// State of a line of sight.
#[derive(Clone, Copy, Debug)]
pub(super) enum State {
    /// Its next surface is to be found.
    Open,
    At(Seen),
    /// It leaves the scene.
    Gone,
}

/// A line of sight. Its present leg is straight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Start of the leg relative to the scene's origin. The first leg starts at an eye.
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    pub(super) state: State,
    /// Number of bends so far.
    pub(super) bends: u32,
    /// Offset of the ray's origin from the leg's start.
    offset: DVec3,
    /// Length of the earlier legs.
    travelled: f64,
    t_min: f32,
    /// The last surface.
    last: Option<Seen>,
}

impl Sight {
    /// Starts a line of sight with a ray in world coordinates.
    pub(super) fn new(scene: &Scene, (origin, direction): (DVec3, DVec3)) -> Self {
        Self {
            origin: origin - scene.origin(),
            direction,
            state: State::Open,
            bends: 0,
            offset: DVec3::ZERO,
            travelled: 0.0,
            t_min: 0.0,
            last: None,
        }
    }

    pub(super) fn is_open(&self) -> bool {
        matches!(self.state, State::Open)
    }

    /// Continues the line beyond the surface that it is at.
    pub(super) fn continue_by(&mut self, onward: Onward) {
        let State::At(seen) = self.state else { return };
        match onward {
            Onward::Ends => self.state = State::Gone,
            Onward::Straight => self.pass(seen),
            Onward::Bends(bend) => self.bend(seen, bend),
        }
    }

    fn pass(&mut self, seen: Seen) {
        (self.state, self.last) = (State::Open, Some(seen));
        self.t_min = self.t_min.max((seen.t as f32).next_up());
    }

    fn bend(&mut self, seen: Seen, bend: Bend) {
        let incoming = self.direction.normalize();
        let outgoing = match bend {
            Bend::Reflected => reflected(incoming, &seen),
            Bend::Refracted(ratio) => refracted(incoming, seen.normal, ratio),
        };
        let side = if matches!(bend, Bend::Reflected) { 1.0 } else { -1.0 };
        let off =
            (seen.position.abs() * OFF_BY_PLACE + (seen.position - self.origin).abs() * OFF_BY_DISTANCE).max_element();
        // A closed primitive may be met again from within.
        let last = (seen.from_outside || !seen.is_closed).then_some(seen);
        *self = Self {
            origin: seen.position,
            direction: outgoing,
            state: State::Open,
            bends: self.bends + 1,
            offset: seen.geometric * (side * off),
            travelled: seen.distance,
            t_min: 0.0,
            last,
        };
    }

    /// Returns whether a hit is on the surface that the line has just passed or left.
    fn is_last(&self, seen: &Seen) -> bool {
        let Some(last) = &self.last else { return false };
        let is_same_side = last.from_outside == seen.from_outside;
        if last.primitive == seen.primitive {
            return !seen.is_closed || is_same_side;
        }
        is_same_side
            && last.surface.object == seen.surface.object
            && seen.distance - last.distance <= SAME_SURFACE * seen.distance
    }

    /// Takes a hit, the leg's nearest one that is not behind `t_min`. Surfaces that hide nothing are passed.
    pub(super) fn take(&mut self, scene: &Scene, primitive: u32, t: f64) {
        if primitive == MISS {
            self.state = State::Gone;
            return;
        }
        let seen = self.seen(scene, primitive, t);
        let last = if self.is_last(&seen) { self.last } else { Some(seen) };
        if self.is_last(&seen) || opacity(scene, &seen, (self.origin, self.direction)) <= 0.0 {
            self.pass(seen);
            self.last = last;
        } else {
            self.state = State::At(seen);
        }
    }

    fn seen(&self, scene: &Scene, primitive: u32, t: f64) -> Seen {
        let (ray, of) = ((self.origin, self.direction), scene.primitive(primitive));
        let Some(met) = moved((&of, &of), ray, t) else { unreachable!("a primitive is of its own kind") };
        let (outward, is_closed) = match of {
            Primitive::Triangle(triangle) => {
                let [a, b, c] = triangle.corners.map(|corner| corner.as_dvec3());
                ((b - a).cross(c - a), false)
            }
            Primitive::Plane(plane) => (plane.unit_normal().as_dvec3(), false),
            Primitive::Sphere(_) | Primitive::Ellipsoid(_) => (met.outward, true),
        };
        let from_outside = outward.dot(self.direction) < 0.0;
        let geometric = outward.normalize() * if from_outside { 1.0 } else { -1.0 };
        let surface = Surface { object: scene.object_of(primitive), ..at(scene, primitive, ray, t) };
        let position = met.positions[0];
        // Straight lines keep the picture's depth.
        let leg = if self.bends == 0 { t * self.direction.length() } else { position.distance(self.origin) };
        let distance = self.travelled + leg;
        let is_smooth = surface.shading_normal != surface.geometric_normal;
        let normal = if is_smooth { surface.shading_normal.as_dvec3().normalize() } else { geometric };
        Seen { primitive, position, surface, t, distance, normal, geometric, from_outside, is_closed }
    }
}

impl Seen {
    /// Returns whether the surface is flat around the point.
    pub(super) fn is_flat(&self) -> bool {
        !self.is_closed && self.normal == self.geometric
    }

    /// Returns how the surface continues a line of sight.
    pub(super) fn onward(&self, scene: &Scene, sight: &Sight, layering: &Layering) -> Onward {
        let material = &scene.materials()[self.surface.material.0 as usize];
        match material.finish {
            Finish::Glass { index, .. } if layering.refracted && !is_thin(material) => {
                let index = f64::from(index);
                let ratio = if self.from_outside { index } else { 1.0 / index };
                let cosine = -sight.direction.normalize().dot(self.normal);
                let is_totally_reflected = 1.0 - cosine * cosine >= ratio * ratio;
                Onward::Bends(if is_totally_reflected { Bend::Reflected } else { Bend::Refracted(ratio) })
            }
            Finish::Glass { .. } => Onward::Straight,
            Finish::Mirror { .. } if layering.mirrored => Onward::Bends(Bend::Reflected),
            _ if opacity(scene, self, (sight.origin, sight.direction)) < 1.0 => Onward::Straight,
            _ => Onward::Ends,
        }
    }
}

fn is_thin(material: &Material) -> bool {
    material.principled.is_some_and(|surface| surface.thin)
}

/// Mirrors a direction, and keeps it above the surface, as kernels do.
fn reflected(incoming: DVec3, &Seen { normal, geometric, .. }: &Seen) -> DVec3 {
    let mirrored = incoming - normal * (2.0 * normal.dot(incoming)).min(0.0);
    (mirrored + geometric * (1e-4 - mirrored.dot(geometric)).max(0.0)).normalize()
}

/// Refracts a unit direction by Snell's law, from index 1 to index `ratio`.
fn refracted(incoming: DVec3, normal: DVec3, ratio: f64) -> DVec3 {
    let cosine = (-normal.dot(incoming)).clamp(0.0, 1.0);
    let inner = (1.0 - (1.0 - cosine * cosine) / (ratio * ratio)).max(0.0).sqrt();
    (incoming / ratio + normal * (cosine / ratio - inner)).normalize()
}

/// Returns the share of the background that a surface hides. Glass hides all of it, since it bends or tints light.
fn opacity(scene: &Scene, seen: &Seen, ray: (DVec3, DVec3)) -> f64 {
    let material = &scene.materials()[seen.surface.material.0 as usize];
    if matches!(material.finish, Finish::Glass { .. }) {
        return 1.0;
    }
    let texture = material.texture.filter(|_| material.blends()).map(|id| &scene.textures()[id.0 as usize]);
    let alpha = match (texture, scene.primitive(seen.primitive)) {
        (Some(texture), Primitive::Triangle(triangle)) => {
            let corners = scene.uv().get(seen.primitive as usize).copied().unwrap_or_default();
            let weights = weights(triangle, ray.0, ray.1);
            alpha(texture, corners.iter().zip(weights).map(|(uv, weight)| uv.as_dvec2() * weight).sum())
        }
        _ => 1.0,
    };
    f64::from(material.opacity) * alpha
}

/// Returns the alpha of the nearest pixel or square of a texture.
fn alpha(texture: &Texture, uv: DVec2) -> f64 {
    let place = |x: f64, side: u32| {
        let side = f64::from(side);
        let at = (x * side).floor();
        let turn = at.rem_euclid(2.0 * side);
        let found = match texture.wrap {
            Wrap::Repeat => at.rem_euclid(side),
            Wrap::Mirror => turn.min(2.0 * side - 1.0 - turn),
            Wrap::Clamp => at.clamp(0.0, side - 1.0),
        };
        found as usize
    };
    match texture.kind() {
        TextureKind::Image { size: [width, height], pixels } => {
            let row = *height as usize - 1 - place(uv.y, *height);
            f64::from(pixels[row * *width as usize + place(uv.x, *width)][3]) / 255.0
        }
        TextureKind::Checkerboard { colors, squares } => {
            let color = colors[(place(uv.x, *squares) + place(uv.y, *squares)) % 2];
            color.as_dvec3().dot(BRIGHTNESS).min(1.0)
        }
    }
}

impl Renderer {
    /// Finds the next surface of open lines of sight.
    pub(super) async fn advance(&self, place: Place<'_>, mut open: Vec<&mut Sight>) -> Result<(), Error> {
        let scene = place.scene;
        while !open.is_empty() {
            let ray = |sight: &&mut Sight| {
                let origin = scene.origin() + sight.origin + sight.offset;
                Ray::new(origin, sight.direction.as_vec3()).t_min(sight.t_min)
            };
            let rays = Vec::from_iter(open.iter().map(ray));
            let hits = self.closest_hits(place.uploaded, &rays).await?.hits;
            for (sight, hit) in open.iter_mut().zip(hits) {
                sight.take(scene, hit.primitive, hit.t.into());
            }
            open.retain(|sight| sight.is_open());
        }
        Ok(())
    }
}
