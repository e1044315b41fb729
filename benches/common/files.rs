//! Writes files completely or not at all.

use std::{
    error::Error,
    fs,
    path::{Path, PathBuf},
};

use stereotrace::output::Batch;

/// Returns the repository's folder. The benchmarks of both packages use it.
pub fn root() -> &'static Path {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    if package.ends_with("studies") { package.parent().unwrap_or(package) } else { package }
}

/// Writes these texts to files with these names. No file gets its final name before all files are written.
pub fn save(files: &[(String, String)], folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut batch = Batch::new();
    for (name, text) in files {
        batch.add(folder.join(name), text.as_bytes())?;
    }
    Ok(batch.commit()?)
}
