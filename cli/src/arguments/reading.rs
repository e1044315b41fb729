//! Defines the options of reading files, and their limits.

use std::path::Path;

use clap::Args;
use stereotrace::{Limits, MissingTextures, Origin, OutsideFiles, SceneOptions};

use super::values::{CreaseAngle, Millions, crease_angle, millions, missing_textures, origin, outside_files};

/// Default crease angle in degrees, as in modelling programs.
const CREASE_ANGLE: f32 = 30.0;

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "How files are read")]
pub(crate) struct ReadingArguments {
    /// Give objects without normals smooth edges where faces turn by less than DEG degrees; off keeps faces flat
    /// [default: 30; off for glTF, as its specification requires]
    #[arg(long, value_name = "DEG|off", value_parser = crease_angle, allow_hyphen_values = true)]
    crease_angle: Option<CreaseAngle>,
    /// Treatment of a texture that can't be read: error, or warn and render without the texture
    #[arg(long, value_name = "error|warn", default_value = "error", value_parser = missing_textures)]
    missing_textures: MissingTextures,
    /// World position that a scene file's coordinates are stored relative to. none is 0,0,0. auto uses the file's
    /// rounded centre if the file lies farther away than 8 times its longest side, else 0,0,0. Cameras, lights and
    /// ground truth stay in world coordinates
    #[arg(
        long,
        value_name = "auto|none|X,Y,Z",
        default_value = "auto",
        value_parser = origin,
        allow_hyphen_values = true
    )]
    origin: Origin,
    /// Treatment of files that a scene names outside its own folder, such as ../textures: refuse, or allow if you trust
    /// the scene
    #[arg(long, value_name = "refuse|allow", default_value = "refuse", value_parser = outside_files)]
    outside_files: OutsideFiles,
    /// Maximum size in MiB of a scene, JSON, texture or sky file, and of all MTL files together [default: 1024, 16 for
    /// JSON]
    #[arg(long, value_name = "MIB")]
    max_file: Option<u32>,
    /// Maximum size of a sky in millions of pixels; the adapter's limit may be lower [default: 8.388608, which is
    /// 4096x2048]
    #[arg(long, value_name = "MILLIONS", value_parser = millions)]
    max_sky: Option<Millions>,
    /// Maximum size of all textures of a file together, in millions of pixels [default: 67.108864, which is 8192x8192]
    #[arg(long, value_name = "MILLIONS", value_parser = millions)]
    max_texture: Option<Millions>,
    /// Maximum number of triangles in millions; each instance counts [default: 33.554432]
    #[arg(long, value_name = "MILLIONS", value_parser = millions)]
    max_triangles: Option<Millions>,
}

impl ReadingArguments {
    pub(crate) fn limits(&self) -> Limits {
        let mut limits = Limits::default().option_names("--max-file", "--max-sky").texture_option_name("--max-texture");
        limits = limits.triangle_option_name("--max-triangles");
        if let Some(mebibytes) = self.max_file {
            let bytes = u64::from(mebibytes) << 20;
            limits = limits.file_bytes(bytes).json_bytes(bytes);
        }
        if let Some(Millions(count)) = self.max_sky {
            limits = limits.sky_pixels(count);
        }
        if let Some(Millions(count)) = self.max_texture {
            limits = limits.texture_pixels(count);
        }
        if let Some(Millions(count)) = self.max_triangles {
            limits = limits.triangles(count);
        }
        limits
    }

    /// Returns the options for reading a scene file. The default crease angle depends on the file name's extension.
    pub(crate) fn options(&self, scene: &Path) -> SceneOptions {
        let is_gltf =
            ["gltf", "glb"].iter().any(|ending| scene.extension().is_some_and(|it| it.eq_ignore_ascii_case(ending)));
        let otherwise = CreaseAngle(if is_gltf { None } else { Some(CREASE_ANGLE) });
        SceneOptions::default()
            .limits(self.limits())
            .missing_textures(self.missing_textures)
            .outside_files(self.outside_files)
            .outside_option_name("--outside-files allow")
            .crease_angle(self.crease_angle.unwrap_or(otherwise).0)
            .origin(self.origin)
    }
}
