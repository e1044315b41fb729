//! `dataset verify`: reads a data set back and says what is missing or changed.

use std::{
    collections::{BTreeMap, BTreeSet},
    error::Error,
    fs, io,
    path::{Component, Path, PathBuf},
};

use clap::Args;
use serde_json::{Value, json};
use stereotrace::message::counted;

use crate::{manifest::MANIFEST, record::sha256_of, shown, summary::Summary};

/// Head of a data set that the Python package made.
const HEAD: &str = "dataset.json";

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// Folder of the data set
    folder: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Summary, Box<dyn Error>> {
    let folder = &arguments.folder;
    let mut found = Found::default();
    if folder.join(HEAD).is_file() {
        shards(folder, &mut found)?;
    } else if folder.join(MANIFEST).is_file() {
        pairs(folder, &mut found)?;
    } else {
        return Err(format!("{}: it has neither {HEAD} nor {MANIFEST}, so this is no data set", shown(folder)).into());
    }
    let Found { files, faults } = found;
    let verdict = match faults.len() {
        0 => "no fault".to_owned(),
        count => counted(count, "fault", "faults"),
    };
    let lines: String = faults.iter().map(|fault| format!("{fault}\n")).collect();
    let text = format!("{lines}{}: {verdict} in {}\n", shown(folder), counted(files, "file", "files"));
    let json = json!({ "version": env!("CARGO_PKG_VERSION"), "files": files, "faults": faults });
    Ok(Summary { text, json, has_failed: !faults.is_empty(), ..Summary::default() })
}

/// What was read.
#[derive(Default)]
struct Found {
    files: usize,
    faults: Vec<String>,
}

impl Found {
    fn fault(&mut self, of: &str, reason: &str) {
        self.faults.push(stereotrace::message::escaped(&format!("{of}: {reason}")));
    }

    /// Compares a file with its SHA-256.
    fn check(&mut self, folder: &Path, name: &str, expected: Option<&str>) {
        self.files += 1;
        // Nothing is read outside the folder.
        if !Path::new(name).components().all(|part| matches!(part, Component::Normal(_))) {
            return self.fault(name, "it is not within the data set's folder");
        }
        match (sha256_of(&folder.join(name)), expected) {
            (Err(error), _) if error.kind() == io::ErrorKind::NotFound => self.fault(name, "no such file"),
            (Err(error), _) => self.fault(name, &error.to_string()),
            (Ok(_), None) => self.fault(name, "its record has no SHA-256"),
            (Ok(found), Some(expected)) if found != expected => {
                self.fault(name, "its SHA-256 is not that of its record");
            }
            (Ok(_), Some(_)) => {}
        }
    }

    /// Compares a list of files with their SHA-256.
    fn check_all(&mut self, folder: &Path, prefix: &str, files: &Value) {
        for (name, hash) in files.as_object().into_iter().flatten() {
            self.check(folder, &format!("{prefix}{name}"), hash.as_str());
        }
    }
}

fn text_of(path: &Path) -> Result<String, Box<dyn Error>> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", shown(path)).into())
}

/// Checks a data set of the command: the files of its manifest's pairs.
fn pairs(folder: &Path, found: &mut Found) -> Result<(), Box<dyn Error>> {
    let (mut lines, mut last) = (BTreeMap::new(), None);
    for (number, line) in text_of(&folder.join(MANIFEST))?.lines().enumerate() {
        let Ok(line) = serde_json::from_str::<Value>(line) else {
            found.fault(&format!("{MANIFEST}:{}", number + 1), "it is no JSON");
            continue;
        };
        if number == 0 {
            last = line["pairs"].as_u64();
        } else if let Some(item) = line["item"].as_u64() {
            lines.insert(item, line); // the last line of a pair is the valid one
        }
    }
    for item in 0..last.unwrap_or(0) {
        match lines.get(&item) {
            None => found.fault(&format!("item {item}"), "it has not been made"),
            Some(line) => match line["error"].as_str() {
                Some(error) => found.fault(&format!("item {item}"), &format!("it could not be made: {error}")),
                None => found.check_all(folder, "", &line["files"]),
            },
        }
    }
    Ok(())
}

/// Checks a data set of the Python package: the shards' files against their records.
fn shards(folder: &Path, found: &mut Found) -> Result<(), Box<dyn Error>> {
    let head: Value =
        serde_json::from_str(&text_of(&folder.join(HEAD))?).map_err(|error| format!("{HEAD}: {error}"))?;
    let (Some(name), Some(count)) = (head["spec"]["name"].as_str(), head["shards"].as_u64()) else {
        return Err(format!("{}: it does not belong to a data set", shown(&folder.join(HEAD))).into());
    };
    let there: BTreeSet<String> = fs::read_dir(folder)
        .map_err(|error| format!("{}: {error}", shown(folder)))?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .collect();
    for shard in 0..count {
        let shard = format!("{name}-{shard:06}");
        let file = format!("{shard}.json");
        if !there.contains(&file) {
            found.fault(&shard, "it has not been made");
            continue;
        }
        let Ok(record) = serde_json::from_str::<Value>(&text_of(&folder.join(&file))?) else {
            found.fault(&file, "it is no JSON");
            continue;
        };
        for error in record["errors"].as_array().into_iter().flatten() {
            let reason = error["error"].as_str().unwrap_or_default();
            found.fault(&format!("item {}", error["item"]), &format!("it could not be made: {reason}"));
        }
        match (record["file"].as_str(), record["files"].is_object()) {
            (Some(name), true) if name == shard => found.check_all(folder, &format!("{shard}/"), &record["files"]),
            // All shards share one folder.
            (_, true) => found.check_all(folder, "", &record["files"]),
            (Some(name), false) => found.check(folder, name, record["sha256"].as_str()),
            (None, false) => found.fault(&file, "it names no file"),
        }
    }
    Ok(())
}
