//! Choices of WGSL sections for a kernel, and the constants at the beginning of its text.

use super::{Shadows, SkyKind, SoftRole, TexelPlaces, Variant, light_texels, material_texels};
use crate::{
    ShadowReuse,
    kernel::layout::{GROOVE, LARGE, MOST_PARALLAX, STEEPEST},
    kernel::traversal::{Boxes, Fetch, RaysPerLane},
    kernel::wgsl::{self, Choice, Linked},
    kernel::{Canvas, Dispatches, Does, Kernel, Role, SampleUse, Visible},
    view::rig::{CameraModel, LensModel},
};

impl Kernel {
    /// Returns the value of each choice in shared WGSL.
    pub(crate) fn choices(&self, with: &Variant) -> [Choice; 39] {
        let Does { visibility, follows, dispatches, canvas, checks, .. } = self.role.does();
        let primitives = match (with.triangles, with.spheres) {
            (true, true) => "mixed",
            (true, false) => "triangles",
            (false, true) => "spheres",
            (false, false) => "none",
        };
        let traces_at_once = dispatches == Dispatches::One && !with.count && primitives != "none";
        let tracing = if traces_at_once && with.traversal.queries_rays() { "ray_queries" } else { "kernels" };
        let is_shared = traces_at_once && with.traversal.climbs() && tracing == "kernels";
        let texels = match primitives {
            _ if with.ellipsoids => "ellipsoids",
            "spheres" => "spheres",
            _ => "corners",
        };
        let smooth = with.triangles && with.normals;
        let boxes = match with.traversal.boxes {
            Boxes::Grid16 => "grid",
            Boxes::F32 if with.world_boxes => "world",
            Boxes::F32 => "f32",
        };
        let sky = match with.sky {
            SkyKind::Constant => "constant",
            SkyKind::Gradient => "gradient",
            SkyKind::Map => "map",
        };
        let shadows = match with.shadows {
            _ if (primitives == "none" && with.planes == 0) || !with.lights => "none", // no occluders or no lights
            Shadows::None => "none",
            Shadows::FromLight => "from_light",
            Shadows::FromSurface => "from_surface",
        };
        let visibility = match visibility {
            Visible::Traced => "traced",
            Visible::Taken => "taken",
            Visible::TakenOrTraced => "taken_or_traced",
            Visible::Recalled => "recalled",
            Visible::RecalledOrTraced => "recalled_or_traced",
        };
        let shine = match (with.shine, with.normalised) {
            (false, _) if !(with.paths && with.principled) => "none",
            (_, _) if with.paths => "facets",
            (false, _) => "none",
            (true, false) => "some",
            (true, true) => "normalised",
        };
        let mirrors = match (with.mirrors, follows) {
            (false, _) => "none",
            (true, true) => "followed",
            (true, false) if with.paths => "none",
            (true, false) => "listed",
        };
        let soft = match with.soft_role(self.role) {
            SoftRole::None => "none",
            SoftRole::Skipped => "skipped",
            SoftRole::Masked => "masked",
            SoftRole::Asked => "asked",
            SoftRole::Followed => "followed",
        };
        let surroundings = match (soft, with.sky) {
            _ if self.role == Role::Paths => {
                if with.sky == SkyKind::Map {
                    "map"
                } else {
                    "none"
                }
            }
            ("none" | "skipped", _) => "none",
            _ if !with.sky_light => "ambient",
            (_, SkyKind::Constant | SkyKind::Gradient) => "cosine",
            (_, SkyKind::Map) => "map",
        };
        let bits = match with.bits {
            ShadowReuse::Rays => "none",
            ShadowReuse::Two => "two",
            ShadowReuse::Block => "block",
        };
        let canvas = match canvas {
            Canvas::Picture => "picture",
            Canvas::Middles => "middles",
            Canvas::Texels => "texels",
        };
        let samples = match with.sample_use(self.role) {
            SampleUse::None => "none",
            SampleUse::Written => "written",
            SampleUse::Read => "read",
        };
        let camera = match with.camera {
            CameraModel::Planar => "planar",
            CameraModel::Around => "around",
            CameraModel::Lens(_) => "lens",
        };
        let lens = match with.camera {
            CameraModel::Planar | CameraModel::Around => "none",
            CameraModel::Lens(LensModel::Radial) => "radial",
            CameraModel::Lens(LensModel::Fisheye) => "fisheye",
        };
        [
            ("camera", camera),
            ("lens", lens),
            ("primitives", primitives),
            ("planes", if with.planes > 0 { "some" } else { "none" }),
            ("cutouts", if with.cutouts { "some" } else { "none" }),
            ("texels", texels),
            // Scenes with spheres only have as many texels per primitive as triangles without vertex normals.
            ("normals", if smooth { "smooth" } else { "flat" }),
            ("boxes", boxes),
            ("canvas", canvas),
            ("fetch", if with.traversal.fetch == Fetch::Texture { "texture" } else { "buffer" }),
            ("rays", if with.traversal.rays == RaysPerLane::One { "one" } else { "four" }),
            ("stack", if is_shared { "workgroup" } else { "private" }),
            ("tracing", tracing),
            ("jitter", if with.jitter > 1 { "rows" } else { "none" }),
            ("dispatches", if dispatches == Dispatches::Many { "many" } else { "one" }),
            ("uv", if with.uv { "some" } else { "none" }),
            ("colors", if with.colors { "some" } else { "none" }),
            ("textures", if with.textures { "some" } else { "none" }),
            ("light", if with.paths { "paths" } else { "direct" }),
            ("shine", shine),
            ("principled", if with.principled { "some" } else { "none" }),
            ("coats", if with.coats && with.paths { "some" } else { "none" }),
            ("mirrors", mirrors),
            ("sky", sky),
            ("lights", if with.lights || with.is_soft() { "some" } else { "none" }),
            ("fading", if with.fading { "some" } else { "none" }),
            ("projectors", if with.projectors { "some" } else { "none" }),
            ("shadows", shadows),
            ("shadow_buffer", with.shadow_buffer.map_or("none", |reading| reading.rule)),
            ("soft", soft),
            ("surroundings", surroundings),
            ("visibility", visibility),
            ("bits", bits),
            ("samples", samples),
            ("sources", if with.reads_second(self.role) { "two" } else { "one" }),
            ("parts", if with.parts { "kept" } else { "none" }),
            ("linear", if with.linear { "kept" } else { "none" }),
            ("wanted", if with.masked { "masked" } else { "all" }),
            ("checks", if checks { "all" } else { "none" }),
        ]
    }

    /// Links the text that the driver compiles.
    pub(crate) fn linked(&self, with: &Variant) -> Linked {
        let with = &with.of_role(self.role);
        let Linked { text, bindings } = wgsl::linked(self.main, &self.choices(with));
        let used = self.constants(with).into_iter().filter(|(name, ..)| text.contains(name));
        let constants: String = used.map(|(name, kind, value)| format!("const {name}: {kind} = {value};\n")).collect();
        let enabled = if text.contains(": ray_query") { "enable wgpu_ray_query;\n" } else { "" };
        Linked { text: format!("{enabled}{constants}{text}"), bindings }
    }

    /// Returns the name, type and value of each constant that shared WGSL may use.
    fn constants(&self, with: &Variant) -> Vec<(&'static str, &'static str, String)> {
        // With `Two`, a sample's second word holds an occluder, unless it holds shares. With `Block`, it holds the
        // sample's own slot, since the six samples are compared by their normals.
        let shares = with.shares && with.is_soft();
        let shine = with.shine || (with.paths && with.principled);
        let TexelPlaces { uv, colors, count } = with.texel_places();
        // Soft light in mirrored surfaces is sampled by a quarter of the rays.
        let fewer = if self.role.does().follows { 4 } else { 1 };
        let [shadow_rays, occlusion_rays] = [with.shadow_rays, with.occlusion_rays].map(|rays| rays.div_ceil(fewer));
        let flag = |name, value: bool| (name, "bool", value.to_string());
        let number = |name, value: u32| (name, "u32", format!("{value}u"));
        let mut all = vec![
            number("STACK_SIZE", with.stack_size),
            number("FIRST_QUERIED", with.planes),
            flag("BY_BOXES", with.spheres),
            flag("CUTOUTS", with.cutouts),
            flag("KEEP_OCCLUDERS", with.bits == ShadowReuse::Two && !shares),
            flag("KEEP_BITS", with.sample_use(self.role) == SampleUse::Written),
            flag("CLOSE", with.close),
            ("LARGE", "f32", format!("{LARGE:?}")),
            ("STEEPEST", "f32", format!("{STEEPEST:?}")),
            ("MOST_PARALLAX", "f32", format!("{MOST_PARALLAX:?}")),
            ("GROOVE", "f32", format!("{GROOVE:?}")),
            flag("SHINE", shine),
            flag("FACETS", shine && with.paths),
            number("MATERIAL_TEXELS", material_texels(with.shine || with.mirrors, with.principled, with.coats) as u32),
            flag("COATS", with.coats && with.paths),
            number("PRIMITIVE_TEXELS", count as u32),
            number("LIGHT_TEXELS", light_texels(with.soft_lights, with.fading, with.projectors) as u32),
            flag("CASTS", with.casts),
            flag("KEEP_SHARES", shares),
            number("LIGHT_RAYS", shadow_rays),
            number("OCCLUSION_RAYS", occlusion_rays),
            number("UV_TEXEL", uv as u32),
            number("COLOR_TEXEL", colors as u32),
        ];
        all.extend((with.planes > 0).then(|| number("PLANES", with.planes)));
        all.extend((with.jitter > 1).then(|| number("SAMPLES_SIDE", with.jitter)));
        if let Some(reading) = with.shadow_buffer {
            all.push(number("BUFFERED_LIGHTS", reading.lights));
            all.push(("BUFFER_MARGIN", "f32", format!("{:?}", reading.value())));
        }
        all
    }
}
