//! The report as JSON.

use serde_json::{Value, json};

use super::{Report, ReportEntry, ReportMethod};
use crate::Rays;

impl Report {
    /// Returns the report as a JSON object. Times are in milliseconds, sizes in pixels or bytes as their names say.
    pub fn to_json(&self) -> String {
        let limits = self.limits.iter().map(|(name, value)| ((*name).to_owned(), json!(value)));
        let left_out = self.left_out.iter().map(|(scene, size)| json!({ "scene": scene.name(), "size": size }));
        let report = json!({
            "version": self.version,
            "adapter": self.adapter,
            "driver": self.driver,
            "ray_queries": self.ray_queries,
            "limits": serde_json::Map::from_iter(limits),
            "timestamps": self.timestamps,
            "calibration": {
                "ray_seconds": self.calibration.ray_seconds,
                "search": self.calibration.search,
                "shadow": self.calibration.shadow,
            },
            "first_picture_ms": ms(self.first_picture),
            "scenes": Vec::from_iter(self.entries.iter().map(entry)),
            "left_out": Vec::from_iter(left_out),
            "faults": self.faults(),
            "took_ms": ms(self.took),
        });
        format!("{report:#}\n")
    }
}

fn ms(time: std::time::Duration) -> f64 {
    1e3 * time.as_secs_f64()
}

fn entry(entry: &ReportEntry) -> Value {
    json!({
        "scene": entry.scene.name(),
        "size": entry.size,
        "primitives": entry.primitives,
        "scene_bytes": entry.scene_bytes,
        "build_ms": ms(entry.build),
        "ids": format!("{:016x}", entry.ids),
        "has_known_ids": entry.has_known_ids,
        "methods": Vec::from_iter(entry.methods.iter().map(method)),
    })
}

fn method(row: &ReportMethod) -> Value {
    let [left, right] = row.rays.map(rays);
    json!({
        "method": row.method.to_string(),
        "pair_ms": ms(row.pair),
        "pair_ms_range": row.range.map(ms),
        "wall_ms": ms(row.wall),
        "second_eye": row.second_eye,
        "rays": { "left": left, "right": right },
        "retraced": row.retraced,
        "identical_percent": row.identical_percent,
        "wrong_surface_percent": row.wrong_surface_percent,
        "intermediate_bytes": row.intermediate_bytes,
        "chosen": row.chosen.map(|method| method.to_string()),
        "submissions": row.work.submissions,
        "waits": row.work.waits,
        "dispatches": row.work.dispatches,
        "indirect_dispatches": row.work.indirect_dispatches,
        "bytes_read": row.work.bytes_read,
    })
}

fn rays(rays: Rays) -> Value {
    json!({
        "primary": rays.primary,
        "verification": rays.verification,
        "shadow": rays.shadow,
        "secondary": rays.secondary,
    })
}
