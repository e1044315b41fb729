//! Files that are written whole or not at all.

use std::{
    error::Error,
    fs,
    path::{Path, PathBuf},
};

/// Writes files of these names and texts. None takes its name before all are written.
pub fn save(files: &[(String, String)], folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let at = |path: &Path, error: std::io::Error| format!("{}: {error}", path.display());
    let partial = |name: &str| folder.join(format!(".{name}.partial"));
    let all = || -> Result<Vec<PathBuf>, String> {
        fs::create_dir_all(folder).map_err(|error| at(folder, error))?;
        for (name, text) in files {
            fs::write(partial(name), text).map_err(|error| at(&partial(name), error))?;
        }
        let paths = files.iter().map(|(name, _)| {
            let path = folder.join(name);
            fs::rename(partial(name), &path).map_err(|error| at(&path, error)).map(|()| path)
        });
        paths.collect()
    };
    let written = all();
    if written.is_err() {
        for (name, _) in files {
            let _ = fs::remove_file(partial(name)); // the first error is the one to tell
        }
    }
    Ok(written?)
}
