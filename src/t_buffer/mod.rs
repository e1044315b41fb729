//! Finds a view's first hits by a T-buffer (docs/T-BUFFER.md). Primitives are projected, and drawn twice over the
//! pixels that they may cover. The first pass finds each pixel's nearest t, the second finds the primitive with this t.
//! Then each pixel's hit is read. Later steps of the view are the same as for traced hits.

mod lists;

use crate::{
    frame::plan::{Launch, Step},
    kernel::layout::TO_TRACE,
    kernel::{
        Canvas, Hits, Kernel,
        Resource::{Drawing, Lists, TBuffer},
        Role, kernel,
    },
    steps::{resolve::TRACE_LISTED, soft, step},
};
pub(crate) use lists::{DRAWING_HEAD, Drawn};

pub(crate) const BEGIN_PASS: Kernel = kernel!("t_buffer", "begin_pass", Role::Pixels);
pub(crate) const PROJECT_PRIMITIVES: Kernel = kernel!("t_buffer", "project_primitives", Role::Draw(Canvas::Picture));
/// Draws primitives that cover few pixels.
pub(crate) const DRAW_FEW: Kernel = kernel!("t_buffer", "draw_few", Role::Draw(Canvas::Picture));
/// Draws primitives that cover a few tiles.
pub(crate) const DRAW_MORE: Kernel = kernel!("t_buffer", "draw_more", Role::Draw(Canvas::Picture));
/// Draws parts of primitives that cover many tiles.
pub(crate) const DRAW_PARTS: Kernel = kernel!("t_buffer", "draw_parts", Role::Draw(Canvas::Picture));
pub(crate) const READ_T_BUFFER: Kernel = kernel!("t_buffer", "read_t_buffer", Role::Hits(Hits::Drawn));
/// Traces pixels with a t but no primitive.
pub(crate) const TRACE_NAMELESS: Kernel = Kernel { name: "trace_nameless", ..TRACE_LISTED };

/// Indices of the lists' heads.
const FEW: u32 = 0;
const MORE: u32 = 1;
const PARTS: u32 = 2;

/// Returns the steps that find and shade a view's hits. Soft light is sampled in this many parts.
pub(crate) fn view(view: usize, drawn: Drawn, soft: Option<usize>) -> Vec<Step> {
    [hits(view, drawn), soft::behind_hits(view, Launch::Pixels, soft.unwrap_or(0))].concat()
}

fn hits(view: usize, drawn: Drawn) -> Vec<Step> {
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
    let project = [
        Step::Clear(TBuffer, None),
        Step::Clear(Drawing, Some(DRAWING_HEAD)),
        step(&PROJECT_PRIMITIVES, view, Launch::Number(drawn.workgroups())),
        begin,
    ];
    [project.as_slice(), &pass, &[begin], &pass, &read].concat()
}

#[cfg(test)]
mod tests {
    use crate::blocking::Wait;
    use glam::Vec3;

    use crate::{Mesh, Method, Options, Renderer, Scene, StereoCamera, Visibility, random::Random};

    /// Each triangle occurs three times with rotated corners, so all three have equal t. For many triangles the
    /// smallest id comes after the others in the tree.
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
        let mut renderer = Renderer::new(crate::Gpu::under_test());
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let place = |id: u32| uploaded.ids.iter().position(|other| *other == id).unwrap();
        let camera = StereoCamera::look_at(Vec3::new(0.0, 0.4, 3.0), Vec3::ZERO).size(64, 49);
        let options = Options::new(Method::Naive).visibility(Visibility::TBuffer);
        let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
        let seen = pair.left.primitive.iter().filter(|&&id| id != crate::MISS);
        let behind = seen.filter(|&&id| {
            assert!(id < 60, "{id} is seen");
            place(id) > place(id + 60).min(place(id + 120))
        });
        assert!(behind.count() > 100);
    }
}
