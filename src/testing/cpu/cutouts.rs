//! Twin of shaders/shared/cutouts.wgsl. It reads the pixels of textures in place of masks.

use glam::{Vec2, Vec3};

use crate::{Scene, Texture, TextureKind, Wrap, accel::bvh::shortest_edge};

/// Returns whether a triangle has a surface where a ray meets it.
pub(super) fn has_surface(scene: &Scene, id: usize, texture: &Texture, origin: Vec3, direction: Vec3) -> bool {
    let mut corners = scene.triangles()[id].corners;
    let mut uv = scene.uv().get(id).copied().unwrap_or_default();
    let first = shortest_edge(corners);
    corners.rotate_left(first);
    uv.rotate_left(first);
    let [a, b, c] = corners.map(|corner| corner - origin);
    let edge = |p: Vec3, q: Vec3| direction.dot((p + q).cross(q - p));
    let weights = Vec3::new(edge(b, c), edge(c, a), edge(a, b));
    let weights = if weights.x + weights.y + weights.z < 0.0 { -weights } else { weights }.max(Vec3::ZERO);
    let sum = weights.x + weights.y + weights.z;
    let weights = if sum == 0.0 { Vec3::X } else { weights / sum };
    let [a, b, c] = uv.map(|corner| corner.clamp(Vec2::splat(-1e15), Vec2::splat(1e15)));
    is_opaque(texture, a * weights.x + b * weights.y + c * weights.z)
}

/// Returns whether the pixel or square at these texture coordinates is opaque.
fn is_opaque(texture: &Texture, uv: Vec2) -> bool {
    let place = |x: f32, side: u32| {
        let near = if texture.wrap == Wrap::Clamp { x.clamp(-64.0, 65.0) } else { x - 2.0 * (0.5 * x).floor() };
        let (at, side) = ((near * side as f32).floor() as i64, i64::from(side));
        let turn = at.rem_euclid(2 * side);
        (match texture.wrap {
            Wrap::Repeat => at.rem_euclid(side),
            Wrap::Mirror => turn.min(2 * side - 1 - turn),
            Wrap::Clamp => at.clamp(0, side - 1),
        }) as usize
    };
    match texture.kind() {
        TextureKind::Image { size: [width, height], pixels } => {
            let row = *height as usize - 1 - place(uv.y, *height);
            pixels[row * *width as usize + place(uv.x, *width)][3] > 127
        }
        TextureKind::Checkerboard { colors, squares } => {
            let color = colors[(place(uv.x, *squares) + place(uv.y, *squares)) % 2];
            0.2126 * color.x + 0.7152 * color.y + 0.0722 * color.z >= 0.5
        }
    }
}
