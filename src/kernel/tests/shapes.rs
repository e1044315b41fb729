//! The modules of GPUs in the kinds of scenes that matter.

use super::*;
use crate::{
    Builtin, ShadowReuse,
    kernel::traversal::{Tracing, Traversal},
    kernel::variant::{Shadows, SkyKind},
    steps::bracket::{SEARCH_TILES, SEARCH_WIDE_TILES},
};

/// Size of the stack of a scene with a million triangles.
const STACK: u32 = 40;

/// Returns the kinds of scenes by name, from simple to complete.
fn kinds() -> [(&'static str, Variant); 8] {
    let hall = Variant::over_tree(&Builtin::Hall.scene(), Traversal::GPU, false, STACK);
    let hall = Variant { samples: true, bits: ShadowReuse::Two, ..hall };
    // The features that most glTF files use.
    let gltf = Variant {
        triangles: true,
        spheres: false,
        planes: 0,
        normals: true,
        uv: true,
        textures: true,
        shine: true,
        principled: true,
        cutouts: true,
        lights: true,
        fading: true,
        shadows: Shadows::FromLight,
        sky: SkyKind::Map,
        linear: true,
        ..hall
    };
    let queries = Traversal::GPU.tracing(Tracing::RayQueries);
    let soft = Variant { soft_lights: true, shadow_rays: 16, occlusion_rays: 16, ..hall };
    [
        ("triangles", Variant { spheres: false, planes: 0, ..hall }),
        ("hall", hall),
        ("gltf", gltf),
        ("mirrors", Variant { mirrors: true, ..gltf }),
        ("soft", soft),
        ("paths", Variant { mirrors: true, coats: true, paths: true, ..gltf }),
        ("queries", Variant { traversal: queries, spheres: false, planes: 0, ..hall }),
        ("queries-boxes", Variant { traversal: queries, spheres: true, ..hall }),
    ]
}

/// Returns the modules of a kernel with the names of their kinds. Kernels that only CPU adapters run have none.
pub(super) fn modules_of(kernel: &Kernel) -> Vec<(&'static str, String)> {
    let is_of_cpus = [SEARCH_TILES.name, SEARCH_WIDE_TILES.name].contains(&kernel.name);
    if is_of_cpus || kernel.role.does().dispatches == Dispatches::Many {
        return Vec::new();
    }
    let suits = |with: &Variant| match kernel.role {
        Role::Shade(Shading::ListMirrors | Shading::Mirrored | Shading::MirroredLit) | Role::Hits(Hits::Bounced) => {
            with.mirrors
        }
        Role::Paths | Role::SharePaths => with.paths,
        Role::Shade(Shading::Soft | Shading::SoftListed | Shading::SoftUnknown | Shading::RecalledSoft) => {
            with.is_soft()
        }
        _ => true,
    };
    let kinds = kinds().into_iter().filter(|(_, with)| suits(with));
    let modules = kinds.map(|(kind, with)| (kind, with, kernel.linked(&with).text));
    let differs = |with: &Variant, text: &str| !with.traversal.queries_rays() || text.contains("ray_query");
    modules.filter(|(_, with, text)| differs(with, text)).map(|(kind, _, text)| (kind, text)).collect()
}
