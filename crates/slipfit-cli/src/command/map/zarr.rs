//! A map as a zarr store of version 2, which programs of version 3 read as well: an array for each column.

use super::answers::Map;
use super::layout::{Field, fields, put};
use serde_json::{Value, json};

/// The files of the store, by their path in it.
pub(super) fn files(map: &Map) -> Vec<(String, Vec<u8>)> {
    let group = json!({"zarr_format": 2});
    let made = json!({"slipfit": env!("CARGO_PKG_VERSION")});
    let mut files = vec![(".zgroup".to_owned(), text(&group)), (".zattrs".to_owned(), text(&made))];
    // Readers of many arrays open this instead of one file per array.
    let mut all = serde_json::Map::from_iter([(".zgroup".to_owned(), group), (".zattrs".to_owned(), made)]);
    for (at, field) in fields(map).iter().enumerate() {
        let Field { name, width, .. } = field;
        let mut values = Vec::new();
        for part in &map.parts {
            for row in 0..part.num_rows() {
                put(&mut values, part.column(at), row, *width);
            }
        }
        for (file, said) in [(".zarray", array(map.pixels, field)), (".zattrs", attributes(map, name))] {
            files.push((format!("{name}/{file}"), text(&said)));
            all.insert(format!("{name}/{file}"), said);
        }
        files.push((format!("{name}/0.0"), values));
    }
    files.push((".zmetadata".to_owned(), text(&json!({"zarr_consolidated_format": 1, "metadata": all}))));
    files
}

fn text(value: &Value) -> Vec<u8> {
    format!("{value:#}\n").into_bytes()
}

/// One chunk, because a map is viewed as a whole.
fn array(pixels: [usize; 2], field: &Field) -> Value {
    let fill = if field.code == "<f8" { json!("NaN") } else { Value::Null };
    json!({
        "zarr_format": 2, "shape": pixels, "chunks": pixels, "dtype": field.code, "order": "C",
        "compressor": null, "filters": null, "fill_value": fill,
    })
}

fn attributes(map: &Map, column: &str) -> Value {
    let mut said = json!({"_ARRAY_DIMENSIONS": ["y", "x"]});
    let unit = map.unit_of(column);
    if !unit.is_empty() {
        said["units"] = Value::String(unit);
    }
    said
}
