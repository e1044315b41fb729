//! Twins of the passes of `bracket`, for scenes without vertex normals. They cover `bound_tiles.wgsl`, the sources of
//! pixels in `resolve_tiles.wgsl`, and visibility bits (`shared/bits.wgsl`).

use glam::Vec3;

use super::{Eye, Frame, intersect::closest_hit, reproject::landing_x};
use crate::{
    FAR, MISS, PixelSource, Scene, ShadowReuse, ShadowSource,
    kernel::layout::{TILE, WIDE_TILE},
    scene::{Primitive, components},
};

/// Factor on the bound, since a surface between two samples may be slightly deeper than both.
const BETWEEN: f32 = 1.001;
/// `GROOVE` of `src/kernel/layout.rs`.
const GROOVE: f32 = 1.0 / 96.0;
/// `REACH_OF_SHADOW`, `REACH_OF_LIGHT` and `FLAT` of `mark_busy.wgsl`.
const REACH_OF_SHADOW: f32 = 32.0;
const REACH_OF_LIGHT: f32 = 12.0;
const FLAT: f32 = 1.0 / 32.0;
/// Smallest cosine between the normals of primitives that may share a shadow.
const SAME_NORMAL: f32 = 0.9;

/// Returns the bound of each tile of right pixels, row by row. It is the largest depth of the left samples that land
/// there. Each sample covers the columns from one pixel before the previous landing to one pixel behind its own.
pub fn tile_bounds(frame: &Frame, left_depth: &[f32]) -> Vec<f32> {
    let [width, height] = frame.size();
    let tile = TILE as usize;
    let across = width.div_ceil(tile);
    let mut bounds = vec![0.0_f32; across * height.div_ceil(tile)];
    for row in 0..height {
        let depths = &left_depth[row * width..(row + 1) * width];
        let landed = |column: usize| landing_x(frame, column, depths[column]).clamp(-2.0, width as f32 + 2.0);
        for column in 0..width {
            let here = landed(column);
            let (before, before_depth) =
                if column == 0 { (0.0, depths[0]) } else { (landed(column - 1), depths[column - 1]) };
            let gap = here >= before;
            let from = (if gap { before } else { here } - 1.0).max(0.0);
            let to = if column + 1 == width { width as f32 } else { here + 1.0 }.min(width as f32 - 0.5);
            let depth = if gap { depths[column].max(before_depth) } else { depths[column] };
            if from <= to {
                for index in from as usize / tile..=to as usize / tile {
                    let bound = &mut bounds[row / tile * across + index];
                    *bound = bound.max(depth);
                }
            }
        }
    }
    bounds
}

/// Returns the bounds for pictures of jittered samples: each tile takes the largest bound in its block of two by two
/// tiles.
pub fn wide_bounds(frame: &Frame, bounds: &[f32]) -> Vec<f32> {
    let across = frame.size()[0].div_ceil(TILE as usize);
    let (down, four) = (bounds.len() / across, (WIDE_TILE / TILE) as usize);
    let deepest = |index: usize| {
        let [row, column] = [index / across, index % across].map(|place| place / four * four);
        let rows = row..(row + four).min(down);
        let tiles = rows.flat_map(|row| (column..(column + four).min(across)).map(move |column| row * across + column));
        tiles.map(|tile| bounds[tile]).fold(0.0, f32::max)
    };
    (0..bounds.len()).map(deepest).collect()
}

/// Returns the source of each right pixel, from the bounds and the hits of its own ray.
pub fn sources(frame: &Frame, bounds: &[f32], right: &[(f32, u32)]) -> Vec<PixelSource> {
    let [width, _] = frame.size();
    let tile = TILE as usize;
    let fate = |(index, (depth, _)): (usize, &(f32, u32))| {
        let bound = bounds[index / width / tile * width.div_ceil(tile) + index % width / tile];
        match (bound * BETWEEN).min(FAR) {
            0.0 => PixelSource::Missed,
            bound if *depth <= bound || bound >= FAR => PixelSource::Reused,
            _ => PixelSource::Bad,
        }
    };
    right.iter().enumerate().map(fate).collect()
}

/// Visibility bits of the lights: `known` for lights in front of a surface, `lit` for lights visible from it.
#[derive(Clone, Copy, Default)]
struct Bits {
    known: u32,
    lit: u32,
}

/// A traced view and its hits: a depth and an id per pixel. In its frame it is `Eye::Left`, and the target is
/// `Eye::Right`.
pub type Source<'a> = (&'a Frame, &'a [(f32, u32)]);

/// Returns the source of each right pixel's visibility bits: reuse, or a shadow ray. The bits can be reused from the
/// source view, or from a second source view if there is one. `right` has the hits of the target view's own rays.
pub fn shadow_sources(
    scene: &Scene,
    sources: &[Source<'_>],
    right: &[(f32, u32)],
    reuse: ShadowReuse,
) -> Vec<ShadowSource> {
    let components = marked_components(scene);
    let bits: Vec<Vec<Bits>> = sources
        .iter()
        .map(|(frame, left)| {
            (0..left.len()).map(|index| light_bits(scene, frame, Eye::Left, index, left[index], true)).collect()
        })
        .collect();
    let busy = busy_lights(&components, sources[0], &bits[0]);
    let (width, tile) = (sources[0].0.size()[0], TILE as usize);
    let source = |(index, &hit): (usize, &(f32, u32))| {
        if hit.1 == MISS {
            return ShadowSource::Taken;
        }
        let known = |(source, bits): (&Source<'_>, &Vec<Bits>)| {
            agreed_bits(scene, &components, *source, bits, (index, hit), reuse)
        };
        let agreed = sources.iter().zip(&bits).map(known).fold(0, |agreed, more| agreed | more);
        let agreed = agreed & !busy[index / width / tile * width.div_ceil(tile) + index % width / tile];
        let wanted = light_bits(scene, sources[0].0, Eye::Right, index, hit, false).known;
        if wanted & !agreed == 0 { ShadowSource::Taken } else { ShadowSource::Traced }
    };
    right.iter().enumerate().map(source).collect()
}

/// Returns the connected component of each primitive, as in packed primitives. Cut-out and solid triangles that share
/// corners get different components.
fn marked_components(scene: &Scene) -> Vec<u32> {
    let mut components = components::of(scene);
    for (id, component) in components.iter_mut().enumerate() {
        let triangle = scene.triangles().get(id);
        *component = *component << 1 | u32::from(triangle.is_some_and(|triangle| scene.cutout_of(triangle).is_some()));
    }
    components
}

/// Returns, for each tile, the lights whose visibility bits are not reused. Their shadows are too narrow for the
/// samples that land near the tile.
fn busy_lights(components: &[u32], (frame, left): Source<'_>, bits: &[Bits]) -> Vec<u32> {
    let [width, height] = frame.size();
    let tile = TILE as usize;
    let across = width.div_ceil(tile);
    let mut busy = vec![0; across * height.div_ceil(tile)];
    let step = Vec3::from(frame.raw.step_x).length();
    for (index, &(depth, id)) in left.iter().enumerate().filter(|(_, hit)| hit.1 != MISS) {
        let (row, column) = (index / width, index % width);
        // Returns the sample `columns` away in the row, if it has the same component.
        let beside = |columns: isize| {
            let place = column.checked_add_signed(columns).filter(|&column| column < width)? + row * width;
            (left[place].1 != MISS && components[left[place].1 as usize] == components[id as usize]).then_some(place)
        };
        let unlike = |columns: isize| {
            let other = beside(columns).map_or(Bits::default(), |place| bits[place]);
            bits[index].known & other.known & (bits[index].lit ^ other.lit)
        };
        let lights = (unlike(-1) | unlike(-2)) & (unlike(1) | unlike(2));
        let is_flat = |columns: isize| match (beside(-columns), beside(columns)) {
            (Some(a), Some(b)) => (depth / left[a].0 + depth / left[b].0 - 2.0).abs() < FLAT * columns as f32 * step,
            _ => false,
        };
        let x = landing_x(frame, column, depth);
        let mut mark = |reach: f32, lights: u32| {
            let (low, high) = ((x - reach).max(0.0), (x + reach).min(width as f32 - 0.5));
            if low <= high {
                (low as usize / tile..=high as usize / tile).for_each(|at| busy[row / tile * across + at] |= lights);
            }
        };
        if is_flat(1) {
            mark(REACH_OF_LIGHT, lights);
        }
        if is_flat(1) && is_flat(2) {
            mark(REACH_OF_SHADOW, lights & !bits[index].lit);
        }
    }
    busy
}

/// Returns the lights whose visibility bits can be reused. The source samples around the point that a right pixel shows
/// must agree on these bits.
fn agreed_bits(
    scene: &Scene,
    components: &[u32],
    (frame, left): Source<'_>,
    bits: &[Bits],
    (index, (depth, id)): (usize, (f32, u32)),
    reuse: ShadowReuse,
) -> u32 {
    let [width, height] = frame.size();
    let parallax = |depth: f32| frame.parallax(depth);
    let (column, row) = (index % width, index / width);
    let point_parallax = parallax(depth);
    let place = column as f32 + 0.5 - point_parallax - 0.5;
    let position = place.floor();
    if position < 0.0 || position + 1.0 >= width as f32 {
        return 0;
    }
    let normal = surface_normal(scene, frame, Eye::Right, index, (depth, id));
    let vouches = |at: usize| {
        let (its_depth, its_id) = left[at];
        let same = its_id != MISS
            && components[its_id as usize] == components[id as usize]
            && (parallax(its_depth) - point_parallax).abs() <= frame.raw.same_parallax;
        let smooth = || {
            let its_normal = || surface_normal(scene, frame, Eye::Left, at, left[at]);
            reuse != ShadowReuse::Block || its_id == id || its_normal().dot(normal).abs() >= SAME_NORMAL
        };
        if same && smooth() { bits[at] } else { Bits::default() }
    };
    let rows = match reuse {
        ShadowReuse::Rays => 0..0,
        ShadowReuse::Two => row..row + 1,
        ShadowReuse::Block if row == 0 || row + 1 == height => 0..0,
        ShadowReuse::Block => row - 1..row + 2,
    };
    let samples: Vec<Bits> =
        rows.flat_map(|row| [0, 1].map(|side| row * width + position as usize + side)).map(vouches).collect();
    let agreed = samples.iter().fold(if samples.is_empty() { 0 } else { u32::MAX }, |agreed, sample| {
        agreed & sample.known & !(sample.lit ^ samples[0].lit)
    });
    let in_groove = || {
        let at = row * width + position as usize;
        let [before, after] = [left[at].0, left[at + 1].0].map(parallax);
        let deeper = point_parallax - (before + (after - before) * (place - position));
        deeper * frame.raw.parallax_px.signum() > GROOVE * frame.raw.same_parallax
    };
    let open = if reuse == ShadowReuse::Two && in_groove() { samples[0].lit } else { 0 };
    agreed & !open
}

/// Returns the normal, turned towards the eye, of the surface that a pixel's ray hits.
fn surface_normal(scene: &Scene, frame: &Frame, eye: Eye, index: usize, (depth, id): (f32, u32)) -> Vec3 {
    let width = frame.size()[0];
    let direction = frame.direction(eye, index % width, index / width);
    let from = |center: Vec3| direction * depth - (center - frame.eye(eye));
    let normal = match scene.primitive(id) {
        Primitive::Triangle(triangle) => {
            let [a, b, c] = triangle.corners;
            (b - a).cross(c - a)
        }
        Primitive::Sphere(sphere) => from(sphere.center),
        Primitive::Ellipsoid(ellipsoid) => {
            let rows = ellipsoid.to_sphere().rows;
            rows.iter().map(|&row| row * row.dot(from(ellipsoid.center))).sum()
        }
        Primitive::Plane(plane) => plane.unit_normal(),
    };
    let normal = normal.normalize();
    if normal.dot(direction) > 0.0 { -normal } else { normal }
}

/// Returns which lights are in front of a hit. If requested, it also traces which of them are visible from the hit, by
/// shadow rays as in shared/lights.wgsl.
fn light_bits(scene: &Scene, frame: &Frame, eye: Eye, index: usize, hit: (f32, u32), trace: bool) -> Bits {
    let mut bits = Bits::default();
    if hit.1 == MISS {
        return bits;
    }
    let width = frame.size()[0];
    let normal = surface_normal(scene, frame, eye, index, hit);
    let point = frame.eye(eye) + frame.direction(eye, index % width, index / width) * hit.0;
    let reach = (point.abs() / 2_097_152.0 + (point - frame.eye(eye)).abs() / 131_072.0).max_element();
    for (bit, light) in scene.lights.iter().enumerate().take(16) {
        let place = scene.local_position(light);
        let straight = point - place;
        let from_light = straight + normal * (reach + straight.abs().max_element() / 1_048_576.0);
        let direction = from_light.normalize();
        if normal.dot(direction) >= 0.0 {
            continue;
        }
        bits.known |= 1 << bit;
        if trace && closest_hit(scene, place, direction, 0.0, from_light.length()).1 == MISS {
            bits.lit |= 1 << bit;
        }
    }
    bits
}
