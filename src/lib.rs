//! Renders stereo pairs by ray tracing on the GPU, at little more than the cost of one eye.
//!
//! The left view is traced. Its samples bound the depth to which the right view is searched: one BVH query per tile of
//! right pixels finds all primitives that their rays hit. Where left samples agree on a shadow, the right view reuses
//! their visibility bit ([`Method::BRACKET`], docs/BRACKET.md). Primary visibility is exact.
//!
//! The library also has the earlier methods, which copy pixels from eye to eye and check them by short rays (Adelson &
//! Hodges 1993; Al-Hagri 2012). Tracing both views is the ground truth that benchmarks compare them with.
//!
//! ```
//! use stereotrace::{Material, Scene, Sphere, StereoCamera, glam::Vec3, output::Anaglyph, render_stereo};
//!
//! let mut scene = Scene::new();
//! let red = scene.add_material(Material::new(Vec3::new(0.8, 0.1, 0.1)));
//! scene.add_sphere(Sphere::new(Vec3::ZERO, 1.0, red))?;
//! let camera = StereoCamera::look_at(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO).size(320, 240).interaxial_pixels(8.0);
//! scene.place_lights(3, &camera)?;
//!
//! let pair = render_stereo(&scene, &camera)?;
//! println!("{:.1}% of the right view traced again", 100.0 * pair.statistics.retraced_share());
//! # #[cfg(feature = "png")]
//! pair.anaglyph(Anaglyph::Dubois).save_png(std::env::temp_dir().join("sphere.png"))?;
//! # Ok::<(), stereotrace::Error>(())
//! ```
//!
//! # Where to begin
//!
//! | I want to | Use |
//! |---|---|
//! | render one stereo pair | [`render_stereo`] |
//! | render many pairs or frames | [`Renderer`], [`Renderer::upload`], [`Renderer::pair`] |
//! | build a scene | [`Scene`], [`Mesh`], [`Sphere`], [`Material`], [`Light`], [`Sky`] |
//! | read a scene from a file | [`SceneFile`] |
//! | set up the eyes | [`StereoCamera`], or [`Rig`] for more than two views |
//! | choose a method or more samples | [`Method`], [`Options`] |
//! | write anaglyphs and other files | [`output`] |
//! | show pictures while paths refine them | [`Passes`] |
//! | get disparity, occlusion and normals | [`GroundTruth`], [`Channel`] |
//! | get optical flow and scene flow | [`Flow`], [`Renderer::flow`] |
//! | blur what moves | [`MotionBlur`] |
//! | get ground truth of an array of cameras | [`Rig`], [`Views::pair`], [`Views::pair_below`] |
//! | get all surfaces behind glass and in mirrors | [`Layers`], [`Renderer::layers`] |
//! | compare pictures | [`metrics`] |
//! | compare a method of my own | [`metrics`], [`PixelSource::Filled`], `examples/own_method.rs` |
//! | trace my own rays | [`Ray`], [`Renderer::closest_hits`] |
//! | draw into my own GPU program | [`Gpu::from_device`], [`FrameBuilder::encode`] |
//!
//! ```text
//! Scene ──obvhs──▶ Bvh ──upload──▶ UploadedScene   (once per scene)
//! StereoCamera ─▶ trace_left     one thread a pixel or block of 2x2: closest hit, shade, keep depth and primitive
//!              ─▶ reproject      atomicMax of the left column into the right-eye index buffer
//!              ─▶ resolve_right  reused pixels checked by length-limited rays, the rest traced
//!                                (bracket: bound_tiles for reproject; search_tiles, resolve_tiles, shade_sky,
//!                                trace_bounded, shade_tiles and shade_listed for resolve_right)
//!              ─▶ take_over      copies reused pixels from their source
//!              (repeated for each band of rows)
//! StereoPair ◀── left, right, depth and ids, re-trace map, statistics
//! ```
//!
//! The [guide] has five chapters with examples that the tests run; `examples/` has whole programs.
//! Contributors begin with `docs/ARCHITECTURE.md`. Geometry, methods and metrics are defined in `docs/DESIGN.md`, which
//! comments cite by section.
//!
//! # Adapters
//!
//! The library runs on any wgpu adapter, software ones included. [`Gpu::open`] takes an [`Adapter`]. [`Gpu::new`] reads
//! the environment variables `STEREOTRACE_ADAPTER` (`software`, or a part of a name) and `WGPU_BACKEND` (`vulkan`,
//! `gl`, …). The picture tests pass on lavapipe, on `SwiftShader` and on llvmpipe's OpenGL
//! (`scripts/other_drivers.sh`). A device that the caller provides must have [`Gpu::required_limits`].
//!
//! The library prints nothing; it logs through the `log` facade. On headless machines Mesa prints a harmless line about
//! `XDG_RUNTIME_DIR`; `NODEVICE_SELECT=1` stops it.
//!
//! # Waiting
//!
//! Operations that wait for the device are async functions. [`blocking::Wait`] waits for them on the calling thread.
//! Futures are `Send`, except on wasm32. On native targets no other thread drives the device, so a future
//! waits for the device in slices of 5 ms. Work on the host, such as building a BVH, is not divided. In a browser
//! nothing blocks.
//!
//! # Features
//!
//! On by default; the core needs none of them:
//! - `native`: wgpu's backends Vulkan, Metal, DirectX 12 and OpenGL, where the system has them;
//! - `blocking`: blocking functions, except on wasm32, where blocking stops the browser from finishing the work;
//! - `obj` (read OBJ and MTL), `gltf` (read glTF 2.0), `ply` (read PLY), `png` (write PNG), `jpeg` (write JPEG, JPS and
//!   MPO), `textures` (read textures from PNG and JPEG), `sky` (read skies from PNG, JPEG and HDR) and `json` (read and
//!   write cameras). They build on wasm32 too, but functions that take a path return [`Error::Io`] there.
//!
//! Off by default: `testing` (twins of the kernels, hard scenes and the choice of the traversal, for tests), `exr`
//! (write `OpenEXR`), `dataset` (make the pairs of a spec), `serde` (serialise scenes, materials and lights), and
//! `webgpu`, the browser backend for wasm32.
//! A build without any backend needs a device from the caller ([`Gpu::from_device`]).
#![cfg_attr(not(test), warn(clippy::unwrap_used, clippy::print_stdout))]

pub use glam;
pub use wgpu;

mod accel;
mod ask;
#[cfg(all(feature = "blocking", not(target_arch = "wasm32")))]
pub mod blocking;
#[cfg(feature = "png")]
pub mod dataset;
mod error;
#[cfg(test)]
#[path = "../tests/it/common/folder.rs"]
#[allow(dead_code, reason = "unit tests use a part of it")]
mod folder;
mod frame;
pub mod gpu;
#[cfg(all(feature = "blocking", feature = "png", not(target_arch = "wasm32")))]
pub mod guide;
mod import;
mod kernel;
#[doc(hidden)]
pub mod message;
mod methods;
pub mod output;
#[cfg_attr(not(any(test, feature = "testing")), allow(unreachable_pub, dead_code, reason = "tests use all of it"))]
mod random;
mod render;
mod report;
mod sampling;
pub mod scene;
mod shadow_buffer;
mod srgb;
mod steps;
mod t_buffer;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
mod truth;
mod view;

pub use truth::metrics;

/// Limits of cameras, and cameras by intrinsics or for a display.
pub mod camera {
    pub use crate::view::camera::{
        ComfortRule, Comfortable, Display, HUMAN_INTERAXIAL, Intrinsics, MAX_COORDINATE, MAX_EYE_COORDINATE,
        MAX_EYE_SHIFT, MAX_SIDE, MAX_WORLD_COORDINATE, MIN_EXTENT, MIN_PIXEL_ANGLE, SCREEN_DISTANCES,
    };
}

pub use accel::bvh::BvhBuild;
pub use ask::channel::{Channel, Maker};
pub use ask::method::{BufferDepth, Check, Method, ShadowReuse, Sweep};
pub use ask::options::{
    Adaptive, AmbientOcclusion, GBuffer, Lighting, MAX_BOUNCES, MAX_PATH_BOUNCES, MAX_PATHS, MAX_SOFT_RAYS, Options,
    Penumbra, Tone,
};
pub use ask::progress::{OnProgress, Progress};
pub use ask::samples::Filter;
pub use ask::settings::Setting;
pub use ask::shadow_buffer::{MAX_SHADOW_BUFFERS, ShadowBuffer, ShadowBufferWork, ShadowRule};
pub use ask::visibility::Visibility;
#[cfg(all(feature = "blocking", not(target_arch = "wasm32")))]
pub use blocking::render_stereo;
pub use error::Error;
pub use frame::view::{PixelSource, ShadowSource, View};
pub use frame::work::{Rays, Work};
pub use frame::{OnRows, Rows, ViewRows};
pub use gpu::{Adapter, Gpu};
pub use gpu::{GpuWork, PassTimes};
#[cfg(any(feature = "scene-files", feature = "sky", feature = "textures", feature = "json"))]
pub use import::input::Limits;
#[cfg(feature = "scene-files")]
pub use import::{MissingTextures, Origin, OutsideFiles, SceneFile, SceneOptions};
#[cfg(any(test, feature = "testing"))]
pub use kernel::traversal::{Boxes, Fetch, RaysPerLane, Stack, Tracing, Traversal};
#[cfg(not(any(test, feature = "testing")))]
pub(crate) use kernel::traversal::{Boxes, RaysPerLane};
pub use methods::auto::{Calibration, Choice};
pub use render::cast::{Cast, Ray, RayHit};
pub use render::pair::{Statistics, StereoPair};
pub use render::{Encoded, EncodedView};
pub use render::{FrameBuilder, MotionBlur, Passes, Renderer};
pub use render::{RigView, Views};
pub use render::{Update, UploadInfo, UploadedScene};
pub use report::{Report, ReportEntry, ReportMethod, ReportPlan};
#[cfg(feature = "scene-files")]
pub use scene::animation::Animation;
pub use scene::builtin::Builtin;
pub use scene::{
    Cone, Ellipsoid, Falloff, Finish, Light, LightShape, MISS, Material, MaterialId, Mesh, Plane, Principled,
    Projector, Scene, Sky, SkyMap, Sphere, Texture, TextureId, TextureKind, Triangle, Wrap,
};
pub use truth::channels::{Channels, Values};
pub use truth::correspondence::{Correspondence, EyeMatches, MatchClass};
pub use truth::disparity::Occlusion;
pub use truth::flow::{EyeFlow, Flow, FlowClass, Moment};
pub use truth::ground_truth::{EyeTruth, GroundTruth};
pub use truth::layers::{EyeLayers, LayerClass, Layering, Layers};
pub use truth::occlusion::Occlusions;
pub use truth::surface::Surface;
pub use view::camera::{
    CameraPath, Comfort, Distortion, Equirectangular, FAR, Lens, PoleMerge, Pose, Projection, Span, StereoCamera,
};
pub use view::rig::{MAX_VIEWS, Rig};
