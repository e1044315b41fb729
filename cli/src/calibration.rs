//! Keeps what `auto` chooses by, for each adapter and driver, in the user's cache folder.

use std::{
    fs,
    path::{Path, PathBuf},
};

use etcetera::BaseStrategy;
use serde_json::{Value, json};
use stereotrace::{Calibration, Error, Gpu, Renderer, blocking::Wait, output::write_whole};

use crate::shown;

/// Name of the file in the cache folder.
const FILE: &str = "stereotrace/calibrations.json";

/// Returns a renderer on a device. `auto` chooses by the calibration that is kept for it, if there is one. With
/// `measure`, it is measured first and kept.
pub(crate) fn renderer(gpu: Gpu, measure: bool) -> Result<Renderer, Error> {
    let mut renderer = Renderer::new(gpu);
    if measure {
        let found = renderer.calibrate().wait()?;
        log::info!("calibration: {found:?}");
        keep_for(renderer.gpu(), found);
    } else if let Some(found) = file().and_then(|file| kept(&file, &key(renderer.gpu()))) {
        log::info!("calibration: {found:?}, as kept");
        renderer.set_calibration(found);
    }
    Ok(renderer)
}

/// Keeps a calibration of an adapter for later runs.
pub(crate) fn keep_for(gpu: &Gpu, found: Calibration) {
    if let Some(file) = file()
        && let Err(error) = keep(&file, &key(gpu), found)
    {
        log::warn!("the calibration is not kept: {error}");
    }
}

/// Returns the path of the file that keeps calibrations, if the user has a cache folder.
fn file() -> Option<PathBuf> {
    etcetera::choose_base_strategy().map(|folders| folders.cache_dir().join(FILE)).ok()
}

/// Returns the name of an adapter and its driver, whose new version has other costs. Ray queries have other costs too.
fn key(gpu: &Gpu) -> String {
    let tracing = if gpu.has_ray_queries() { "; ray queries" } else { "" };
    format!("{}; {}{tracing}", gpu.adapter_name(), gpu.driver())
}

/// Returns all calibrations of a file, or `None` if it is missing or not the command's own.
fn all(file: &Path) -> Option<serde_json::Map<String, Value>> {
    let text = fs::read_to_string(file).ok()?;
    let read = serde_json::from_str(&text);
    if read.is_err() {
        log::warn!("{}: not a list of calibrations; it is ignored", shown(file));
    }
    read.ok()
}

/// Returns the calibration that a file has for an adapter.
fn kept(file: &Path, key: &str) -> Option<Calibration> {
    let found = all(file)?.remove(key)?;
    let number = |name: &str| found[name].as_f64().map(|value| value as f32).filter(|value| value.is_finite());
    let names = ["ray_seconds", "search", "shadow"];
    if let [Some(ray_seconds), Some(search), Some(shadow)] = names.map(number) {
        return Some(Calibration { ray_seconds, search, shadow });
    }
    let missing = Vec::from_iter(names.into_iter().filter(|name| number(name).is_none())).join(", ");
    let remedy = "it is ignored, and --calibrate measures it again";
    log::warn!("{}: the calibration of {key} lacks {missing}; {remedy}", shown(file));
    None
}

fn keep(file: &Path, key: &str, found: Calibration) -> Result<(), Box<dyn std::error::Error>> {
    let folder = file.parent().map(PathBuf::from).unwrap_or_default();
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", shown(&folder)))?;
    let mut all = all(file).unwrap_or_default();
    let Calibration { ray_seconds, search, shadow } = found;
    let costs = json!({ "ray_seconds": ray_seconds, "search": search, "shadow": shadow });
    all.insert(key.into(), costs);
    write_whole(file, format!("{:#}\n", Value::Object(all)).as_bytes())?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_found_again_for_the_same_adapter_alone() {
        let folder = std::env::temp_dir().join(format!("stereotrace-calibration-{}", std::process::id()));
        let file = folder.join(FILE);
        let [one, other] = [(1e-9, 0.5, 0.25), (0.0, 1.5, 0.75)].map(|(ray_seconds, search, shadow)| Calibration {
            ray_seconds,
            search,
            shadow,
        });
        assert_eq!(kept(&file, "a"), None);
        keep(&file, "a", other).unwrap();
        keep(&file, "a", one).unwrap();
        keep(&file, "b", other).unwrap();
        assert_eq!([kept(&file, "a"), kept(&file, "b"), kept(&file, "c")], [Some(one), Some(other), None]);
        for broken in ["{\"a\": {\"search\": 1}}", "[1]", "{"] {
            fs::write(&file, broken).unwrap();
            assert_eq!(kept(&file, "a"), None, "{broken}");
        }
        keep(&file, "a", one).unwrap();
        assert_eq!(kept(&file, "a"), Some(one));
        fs::remove_dir_all(&folder).unwrap();
    }
}
