//! Figures as CSV and JSON.

use serde_json::Value;

/// Names and values of one measurement. All records of a file have the same names.
pub type Record = Vec<(&'static str, Value)>;

pub fn csv(records: &[Record]) -> String {
    let line = |cells: Vec<String>| cells.join(",") + "\n";
    let head = records.iter().take(1).map(|record| record.iter().map(|(name, _)| (*name).to_owned()).collect());
    let rows = records.iter().map(|record| {
        let cells = record.iter().map(|(_, value)| match value {
            Value::Null => String::new(),
            Value::String(text) => format!("\"{}\"", text.replace('"', "\"\"")),
            number => number.to_string(),
        });
        cells.collect()
    });
    head.chain(rows).map(line).collect()
}

/// Formats records as JSON, one per line, with fields in the record's order.
pub fn json(records: &[Record]) -> String {
    let object = |record: &Record| {
        let fields = record.iter().map(|(name, value)| format!("\"{name}\": {value}"));
        format!("  {{ {} }}", fields.collect::<Vec<_>>().join(", "))
    };
    format!("[\n{}\n]\n", records.iter().map(object).collect::<Vec<_>>().join(",\n"))
}
