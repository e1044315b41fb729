//! What files were made with, so that nothing else is mixed with them.

use std::{error::Error, fmt::Debug, fs};

use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::{arguments::Subject, shown};

/// The program's version, the files that are read, and all settings.
pub(crate) fn of(subject: &Subject, more: &impl Debug) -> Result<Value, Box<dyn Error>> {
    let files = subject.files().into_iter().map(|file| {
        let bytes = fs::read(&file).map_err(|error| format!("{}: {error}", shown(&file)))?;
        let digest: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(json!({ "file": file.to_string_lossy(), "sha256": digest }))
    });
    let files = files.collect::<Result<Vec<_>, String>>()?;
    Ok(json!({
        "version": env!("CARGO_PKG_VERSION"),
        "files": files,
        "settings": format!("{:?}", (subject, more)),
    }))
}
