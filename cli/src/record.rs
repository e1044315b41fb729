//! Records the settings and inputs of output files, so that a folder does not mix files of different settings.

use std::{
    error::Error,
    fmt::Debug,
    fs,
    io::{self, Read as _},
    path::Path,
};

use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use stereotrace::{Animation, Scene};

use crate::{arguments::Subject, shown};

/// Returns a record of the program's version, hashes of the named files and of the scene's content (with MTL files and
/// textures), and all settings.
pub(crate) fn of(subject: &Subject, scene: &Scene, more: &impl Debug) -> Result<Value, Box<dyn Error>> {
    let files = subject.files().into_iter().map(|file| {
        let bytes = fs::read(&file).map_err(|error| format!("{}: {error}", shown(&file)))?;
        Ok(json!({ "file": file.to_string_lossy(), "sha256": hex(Sha256::digest(&bytes)) }))
    });
    let files = files.collect::<Result<Vec<_>, String>>()?;
    Ok(json!({
        "version": env!("CARGO_PKG_VERSION"),
        "files": files,
        "scene_sha256": scene.sha256(),
        "settings": format!("{:?}", (subject, more)),
    }))
}

/// Returns a hash of an animation's content.
pub(crate) fn of_animation(animation: &Animation) -> String {
    let mut hash = Sha256::new();
    animation.content(|bytes| hash.update(bytes));
    hex(hash.finalize())
}

/// Returns the SHA-256 of a file's content.
pub(crate) fn sha256_of(path: &Path) -> io::Result<String> {
    let (mut hash, mut file) = (Sha256::new(), fs::File::open(path)?);
    let mut block = vec![0; 1 << 16];
    loop {
        match file.read(&mut block)? {
            0 => return Ok(hex(hash.finalize())),
            count => hash.update(&block[..count]),
        }
    }
}

fn hex(digest: impl IntoIterator<Item = u8>) -> String {
    digest.into_iter().map(|byte| format!("{byte:02x}")).collect()
}
