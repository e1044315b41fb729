//! Ray-traces a stereo pair on the GPU for little more than one eye's price, and says how exact the second eye is.
//!
//! The left view is traced. Each of its samples then says how deep the right view must be searched where it lands: one
//! query of the BVH a tile of right pixels finds what their rays hit, exactly, and shadows are taken over where left
//! samples agree ([`Method::BRACKET`], docs/BRACKET.md). The methods that it goes beyond are here too: pixels carried
//! from eye to eye and checked by short rays (Adelson & Hodges 1993; Al-Hagri 2012). What each saves and gets wrong is
//! measured against tracing both views, in the same run.
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
//! # Reading order
//!
//! 1. this page: the way of the data;
//! 2. `renderer.rs`: [`Renderer`], what it takes and what it gives;
//! 3. `frame/plan.rs`: `Plan::of`, the steps of each method's frame, a line each, and `frame/driver.rs`, which runs
//!    them;
//! 4. the steps, a file each in `steps/`: their kernels, and what these read and write;
//! 5. the kernels, a file each in `shaders/`: `trace_left`, `reproject`, `resolve_right` (`trace_listed` and
//!    `shade_listed` are its second half), `take_over`.
//!
//! ```text
//! Scene ──obvhs──▶ Bvh ──upload──▶ UploadedScene   (once per scene)
//! StereoCamera ─▶ trace_left     one thread a pixel or block of 2x2: closest hit, shade, keep depth and primitive
//!              ─▶ reproject      atomicMax of the left column into the right-eye index buffer
//!              ─▶ resolve_right  reused pixels checked by length-limited rays, the rest traced
//!                                (bracket: bound_tiles for reproject; search_tiles, resolve_tiles, shade_sky, trace_bounded,
//!                                shade_tiles and shade_listed for resolve_right)
//!              ─▶ take_over      reused pixels become those of their source
//!              all of a band of rows, then the next band
//! StereoPair ◀── left, right, depth and ids, re-trace map, statistics
//! ```
//!
//! Geometry, methods and metrics are defined in `docs/DESIGN.md`, which comments cite by section.
//!
//! # Adapters
//!
//! Any adapter that wgpu offers will do, software ones included. [`Gpu::open`] takes an [`Adapter`]; [`Gpu::new`] asks
//! the environment variable `STEREOTRACE_ADAPTER` (`software`, or a part of a name), and `WGPU_BACKEND` (`vulkan`,
//! `gl`, …) chooses the backend. The tests of pictures pass on lavapipe, on `SwiftShader` and on llvmpipe's OpenGL
//! (`scripts/other_drivers.sh`). A device of the caller's must have [`Gpu::required_limits`]. The library prints
//! nothing: messages go through the `log` facade. (Mesa prints a line about `XDG_RUNTIME_DIR` on headless machines; it
//! means nothing, and `NODEVICE_SELECT=1` stops it.)
//!
//! # Waiting
//!
//! Each operation that waits for the device is there twice: as an async function (`…_async`), and as one that blocks.
//! Futures are `Send` but on wasm32. On native targets the thread that polls one is blocked while the device works,
//! since nobody else drives it; in a browser nothing is.
//!
//! # Features
//!
//! On by default, and none of them needed by the core:
//! - `native`: wgpu's backends Vulkan, Metal, DirectX 12 and OpenGL, each where the system has it;
//! - `blocking`: the blocking forms; not on wasm32, where to block is to keep the browser from what is waited for;
//! - `obj` (read OBJ and MTL), `gltf` (read glTF 2.0), `ply` (read PLY), `png` (write PNG), `jpeg` (write JPEG, JPS and
//!   MPO), `textures` (read textures from PNG and JPEG), `sky` (read skies from PNG, JPEG and HDR) and `json` (read and
//!   write cameras). On wasm32 they build, but there are no files: what takes a path returns [`Error::Io`].
//!
//! Off by default: `exr` (write `OpenEXR`), `serde` (serialise scenes, materials and lights by serde), and `webgpu`,
//! the backend of browsers, for wasm32. A build without any backend takes a device of the caller's alone
//! ([`Gpu::from_device`]).
#![cfg_attr(not(test), warn(clippy::unwrap_used, clippy::print_stdout))]

pub use glam;
pub use wgpu;

mod auto;
#[cfg(all(feature = "blocking", not(target_arch = "wasm32")))]
mod blocking;
mod bvh;
pub mod camera;
#[cfg(feature = "json")]
mod camera_file;
pub mod cast;
pub mod cpu;
mod cutouts;
#[cfg(feature = "png")]
pub mod dataset;
mod disparity;
mod error;
#[cfg(test)]
#[path = "../tests/it/common/folder.rs"]
#[allow(dead_code, reason = "unit tests use a part of it")]
mod folder;
mod frame;
mod geometry;
pub mod gpu;
mod ground_truth;
#[cfg(all(feature = "blocking", feature = "png", not(target_arch = "wasm32")))]
pub mod guide;
#[cfg(any(feature = "scene-files", feature = "sky", feature = "textures", feature = "json"))]
mod input;
mod kernels;
mod lanes;
mod large;
mod layout;
pub mod message;
pub mod method;
pub mod metrics;
mod occlusion;
mod options;
pub mod output;
pub mod pair;
mod random;
pub mod renderer;
pub mod rig;
mod samples;
pub mod scene;
mod shadow_buffer;
mod steps;
mod table;
mod traversal;
mod tree;
mod upload;
mod variant;
mod visibility;
mod wgsl;

pub use auto::Choice;
#[cfg(all(feature = "blocking", not(target_arch = "wasm32")))]
pub use blocking::{render_stereo, render_views};
pub use bvh::BvhBuild;
pub use camera::{CameraPath, Comfort, Convergence, FAR, Pose, StereoCamera};
pub use cast::{Cast, Ray, RayHit};
pub use disparity::Occlusion;
pub use error::Error;
pub use frame::{Encoded, EncodedView, OnRows, Rows, ViewRows};
pub use gpu::{Adapter, Gpu};
pub use ground_truth::{EyeTruth, GroundTruth};
#[cfg(any(feature = "scene-files", feature = "sky", feature = "textures", feature = "json"))]
pub use input::Limits;
pub use method::{BufferDepth, Check, Method, ShadowReuse, Sweep};
pub use occlusion::Occlusions;
pub use options::{Adaptive, AmbientOcclusion, GBuffer, MAX_BOUNCES, MAX_SOFT_RAYS, Options, Penumbra, Tone};
pub use pair::{MISS, PassTimes, PixelSource, Rays, ShadowSource, Statistics, StereoPair, View, Work};
pub use renderer::{OnProgress, Progress, Renderer, render_stereo_async, render_views_async};
pub use rig::{Rig, RigView, Views};
pub use samples::Filter;
pub use scene::builtin::Builtin;
pub use scene::{
    Ellipsoid, Finish, Light, LightShape, Material, MaterialId, Mesh, Plane, Scene, Sky, SkyMap, Sphere, Texture,
    TextureId, TextureKind, Triangle, Wrap,
};
#[cfg(feature = "scene-files")]
pub use scene::{MissingTextures, ObjOptions, Origin, OutsideFiles, SceneFile, SceneOptions};
pub use shadow_buffer::{MAX_SHADOW_BUFFERS, ShadowBuffer, ShadowBufferWork, ShadowRule};
pub use traversal::{Boxes, Fetch, RaysPerLane, Traversal};
pub use upload::{Update, UploadInfo, UploadedScene};
pub use visibility::Visibility;
