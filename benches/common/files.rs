//! Files that are written whole or not at all.

use std::{
    error::Error,
    fs,
    path::{Path, PathBuf},
};

use stereotrace::output::Batch;

/// Writes files of these names and texts. None takes its name before all are written.
pub fn save(files: &[(String, String)], folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut batch = Batch::new();
    for (name, text) in files {
        batch.add(folder.join(name), text.as_bytes())?;
    }
    Ok(batch.commit()?)
}
