//! `report.csv`: one line per rung.

use super::data::Report;
use super::json::columns;
use serde_json::Value;
use std::error::Error;

/// Returns a header and the rungs in the format of RFC 4180.
///
/// # Errors
/// Rows differ in their number of fields.
pub(super) fn table(report: &Report<'_>) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut writer = ::csv::WriterBuilder::new().terminator(::csv::Terminator::CRLF).from_writer(Vec::new());
    for (index, rung) in report.ladder.rungs.iter().enumerate() {
        let columns = columns(report, rung);
        if index == 0 {
            writer.write_record(columns.iter().map(|(name, _)| name.as_str()))?;
        }
        writer.write_record(columns.iter().map(|(_, value)| field(value)))?;
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}

/// Formats a field: text unchanged, unknown values empty.
fn field(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        value => value.to_string(),
    }
}
