//! How files are read.

use clap::Args;
use stereotrace::{Limits, MissingTextures, Origin, SceneOptions};

use super::values::{CreaseAngle, crease_angle, missing_textures, origin};

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Reading files")]
pub(crate) struct ReadingArguments {
    /// Where a file has no normals, edges are smooth that turn by less than DEG degrees, or none: off
    #[arg(long, value_name = "DEG|off", default_value = "30", value_parser = crease_angle, allow_hyphen_values = true)]
    crease_angle: CreaseAngle,
    /// What becomes of textures that can't be read: error, or warn and go on without them
    #[arg(long, value_name = "error|warn", default_value = "error", value_parser = missing_textures)]
    missing_textures: MissingTextures,
    /// World position that a scene file's coordinates are stored relative to: none for 0, auto for the middle of a file that
    /// lies farther away than 8 times its size. Cameras, lights and ground truth stay in world coordinates
    #[arg(long, value_name = "auto|none|X,Y,Z", default_value = "auto", value_parser = origin, allow_hyphen_values = true)]
    origin: Origin,
    /// Largest scene, JSON, texture or sky file that is read, and largest sum of MTL files, in MiB [default: 1024, 16 for JSON]
    #[arg(long, value_name = "MIB")]
    max_file: Option<u32>,
    /// Largest sky in millions of pixels, as far as the adapter can hold it [default: 8.4, which is 4096x2048]
    #[arg(long, value_name = "MILLIONS")]
    max_sky: Option<u32>,
    /// Largest texture, and largest sum of a file's, in millions of pixels [default: 67.1, which is 8192x8192]
    #[arg(long, value_name = "MILLIONS")]
    max_texture: Option<u32>,
    /// Most triangles, instances counted as often as they are shown, in millions [default: the library's]
    #[arg(long, value_name = "MILLIONS")]
    max_triangles: Option<u32>,
}

impl ReadingArguments {
    pub(crate) fn limits(&self) -> Limits {
        let mut limits = Limits::default().option_names("--max-file", "--max-sky").texture_option_name("--max-texture");
        limits = limits.triangle_option_name("--max-triangles");
        if let Some(mebibytes) = self.max_file {
            let bytes = u64::from(mebibytes) << 20;
            limits = limits.file_bytes(bytes).json_bytes(bytes);
        }
        if let Some(millions) = self.max_sky {
            limits = limits.sky_pixels(1_000_000 * u64::from(millions));
        }
        if let Some(millions) = self.max_texture {
            limits = limits.texture_pixels(1_000_000 * u64::from(millions));
        }
        if let Some(millions) = self.max_triangles {
            limits = limits.triangles(1_000_000 * u64::from(millions));
        }
        limits
    }

    pub(crate) fn options(&self) -> SceneOptions {
        SceneOptions::default()
            .limits(self.limits())
            .missing_textures(self.missing_textures)
            .crease_angle(self.crease_angle.0)
            .origin(self.origin)
    }
}
