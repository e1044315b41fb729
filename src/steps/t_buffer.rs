//! First hits of a view by a T-buffer (docs/T-BUFFER.md). Primitives are projected and drawn over the pixels that they
//! may cover, twice: first for the nearest t, then for its primitive. Then each pixel is read. Later steps of a view
//! are the same.

use super::{resolve::TRACE_LISTED, step};
use crate::{
    UploadedScene,
    frame::plan::{Launch, Step},
    gpu::Gpu,
    kernel::layout::{LIST_WORKGROUP, TO_TRACE},
    kernel::{
        Canvas, Hits, Kernel,
        Resource::{Drawing, Lists},
        Role, kernel,
    },
};

pub(crate) const BEGIN_PASS: Kernel = kernel!("t_buffer", "begin_pass", Role::Pixels);
pub(crate) const PROJECT_PRIMITIVES: Kernel = kernel!("t_buffer", "project_primitives", Role::Draw(Canvas::Picture));
/// Draws primitives that cover few pixels.
pub(crate) const DRAW_FEW: Kernel = kernel!("t_buffer", "draw_few", Role::Draw(Canvas::Picture));
/// Draw primitives that cover a few tiles, and parts of those that cover many.
pub(crate) const DRAW_MORE: Kernel = kernel!("t_buffer", "draw_more", Role::Draw(Canvas::Picture));
pub(crate) const DRAW_PARTS: Kernel = kernel!("t_buffer", "draw_parts", Role::Draw(Canvas::Picture));
pub(crate) const READ_T_BUFFER: Kernel = kernel!("t_buffer", "read_t_buffer", Role::Hits(Hits::Drawn));
/// Traces pixels with a t but no primitive.
pub(crate) const TRACE_NAMELESS: Kernel = Kernel { name: "trace_nameless", ..TRACE_LISTED };

/// Bytes of `Drawing` before its entries (`shaders/shared/t_buffer.wgsl`, like the following constants).
pub(crate) const DRAWING_HEAD: u64 = 56;
/// Bytes of a primitive's entries, and of a further part.
const ENTRIES: u64 = 12;
const PART: u64 = 8;
/// Entries for further parts of primitives.
const FURTHER_PARTS: u32 = 65536;
/// With more primitives their parts, up to 64 each, would overflow their counter.
const MOST_PRIMITIVES: u32 = 1 << 26;
/// Indices of the lists' heads.
const FEW: u32 = 0;
const MORE: u32 = 1;
const PARTS: u32 = 2;
/// Parts per row of workgroups.
const PARTS_IN_ROW: u32 = 512;
/// Workgroups in a row of the dispatch over primitives.
const PROJECTED_ACROSS: u32 = 1024;

/// Returns the bytes of the lists for this many primitives.
pub(crate) fn drawing_bytes(primitives: u32) -> u64 {
    DRAWING_HEAD + ENTRIES * u64::from(primitives) + PART * u64::from(FURTHER_PARTS)
}

/// Returns how many primitives of a scene are drawn, or `None` if their lists do not fit one binding.
pub(crate) fn drawn(scene: &UploadedScene, gpu: &Gpu) -> Option<u32> {
    let primitives = scene.ids.len() as u32 - scene.variant.planes;
    let most = u64::from(PARTS_IN_ROW) * u64::from(gpu.limits.max_compute_workgroups_per_dimension);
    let fits = primitives <= MOST_PRIMITIVES
        && drawing_bytes(primitives) <= gpu.binding_limit()
        && u64::from(primitives + FURTHER_PARTS) <= most;
    if !fits {
        log::info!("{primitives} primitives are too many for a T-buffer's lists: rays are traced");
    }
    (fits && scene.variant.has_tree()).then_some(primitives)
}

/// Returns the workgroups for this many primitives, one thread each.
pub(crate) fn workgroups(primitives: u32) -> [u32; 3] {
    let all = primitives.div_ceil(LIST_WORKGROUP);
    [all.min(PROJECTED_ACROSS), all.div_ceil(PROJECTED_ACROSS), 1]
}

/// Returns the steps that find a view's hits.
pub(crate) fn hits(view: usize) -> Vec<Step> {
    let begin = step(&BEGIN_PASS, view, Launch::Once);
    let pass = [
        step(&DRAW_FEW, view, Launch::Listed(Drawing, FEW)),
        step(&DRAW_MORE, view, Launch::Listed(Drawing, MORE)),
        step(&DRAW_PARTS, view, Launch::Listed(Drawing, PARTS)),
    ];
    let read = [
        Step::EmptyLists,
        step(&READ_T_BUFFER, view, Launch::Pixels),
        step(&TRACE_NAMELESS, view, Launch::Listed(Lists, TO_TRACE)),
    ];
    let project = [Step::EmptyTBuffer, step(&PROJECT_PRIMITIVES, view, Launch::Primitives), begin];
    [project.as_slice(), &pass, &[begin], &pass, &read].concat()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::{Mesh, Method, Options, Renderer, Scene, StereoCamera, Visibility, testing::random::Random};

    #[test]
    fn host_and_wgsl_have_the_same_numbers() {
        let text = crate::kernel::wgsl::part!("shared/t_buffer.wgsl").text;
        for (name, value) in [
            ("FURTHER_PARTS", FURTHER_PARTS),
            ("GROUP", 8),
            ("PARTS_ACROSS", PARTS_IN_ROW * 8 / LIST_WORKGROUP),
            ("PROJECTED_ACROSS", PROJECTED_ACROSS),
        ] {
            assert!(text.contains(&format!("const {name}: u32 = {value}u;")), "{name}");
        }
    }

    #[test]
    fn each_primitive_gets_a_thread() {
        for primitives in [1, 64, 65, 65_535, 65_536, 65_537, 1_000_000, 34_000_000] {
            let [x, y, z] = workgroups(primitives);
            let threads = u64::from(x) * u64::from(y) * u64::from(z) * u64::from(LIST_WORKGROUP);
            let more = threads - u64::from(primitives);
            assert!(
                more < u64::from(PROJECTED_ACROSS * LIST_WORKGROUP) && x.max(y) <= 1024,
                "{primitives}: {x} {y} {z}"
            );
        }
    }
    /// Triangles that occur three times with rotated corners, so their t are equal. For many, the smallest id comes
    /// after the others in the tree.
    #[test]
    fn of_equal_t_the_smaller_id_wins_wherever_it_stands_in_the_tree() {
        let mut random = Random::new(21);
        let base: Vec<[Vec3; 3]> = (0..60)
            .map(|_| {
                let at = random.point(1.0);
                [(); 3].map(|()| at + random.point(0.5))
            })
            .collect();
        let mut scene = Scene::new();
        for turn in [1, 2, 0] {
            let turned = |corners: &[Vec3; 3]| [0, 1, 2].map(|corner| corners[(corner + turn) % 3]);
            let triangles = (0..60).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
            scene.add_mesh(&Mesh::new(base.iter().flat_map(turned).collect(), triangles)).unwrap();
        }
        let wanted = std::env::var(crate::gpu::ADAPTER_VARIABLE).unwrap_or_else(|_| "software".into());
        let mut renderer = Renderer::new(Gpu::open(wanted).unwrap());
        let uploaded = renderer.upload(&scene).unwrap();
        let place = |id: u32| uploaded.ids.iter().position(|other| *other == id).unwrap();
        let camera = StereoCamera::look_at(Vec3::new(0.0, 0.4, 3.0), Vec3::ZERO).size(64, 49);
        let options = Options::new(Method::Naive).visibility(Visibility::TBuffer);
        let pair = renderer.render(&uploaded, &camera, &options).unwrap();
        let seen = pair.left.primitive.iter().filter(|&&id| id != crate::MISS);
        let behind = seen.filter(|&&id| {
            assert!(id < 60, "{id} is seen");
            place(id) > place(id + 60).min(place(id + 120))
        });
        assert!(behind.count() > 100);
    }
}
