//! Rows as a table in the format given by the extension of the file name.

use super::parquet;
use crate::failure::Failure;
use crate::output::Target;
use slipfit_report::escape;
use slipfit_report::format::{Rounded, plain};
use slipfit_report::row::{Column, Row, Value};
use std::fmt::Write as _;
use std::path::Path;

/// Format of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    Csv,
    Json,
    Markdown,
    Latex,
    Parquet,
}

impl Form {
    /// The format given by the extension of a file name.
    pub(crate) fn of(path: &Path) -> Result<Self, Failure> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("csv") => Ok(Self::Csv),
            Some("json") => Ok(Self::Json),
            Some("md") => Ok(Self::Markdown),
            Some("tex") => Ok(Self::Latex),
            Some("parquet") => Ok(Self::Parquet),
            _ => Err(Failure::new(format!(
                "--table {}: no table format with this extension is known",
                path.display()
            ))
            .hint("a table is written as .csv, .json, .md, .tex or .parquet")),
        }
    }

    fn render(self, rows: &[Row], columns: &'static [Column]) -> Result<Vec<u8>, Failure> {
        let failed = |e: &dyn std::fmt::Display| Failure::new(format!("--table: {e}"));
        match self {
            Self::Csv => {
                let names = ["file", "status", "reason"].into_iter().chain(columns.iter().map(|c| c.name));
                let mut text = names.collect::<Vec<_>>().join(",") + "\n";
                for row in rows {
                    let first = [&row.file, row.status.name(), &row.reason].map(Value::text);
                    let cells: Vec<String> = first.iter().chain(&row.values).map(Value::csv).collect();
                    let _ = writeln!(text, "{}", cells.join(","));
                }
                Ok(text.into_bytes())
            }
            Self::Json => {
                let text = serde_json::to_string_pretty(rows).map_err(|e| failed(&e))?;
                let mut text = escape::json(&text).into_owned().into_bytes();
                text.push(b'\n');
                Ok(text)
            }
            Self::Markdown => Ok(markdown(rows).into_bytes()),
            Self::Latex => Ok(latex(rows).into_bytes()),
            Self::Parquet => parquet::render(rows, columns).map_err(|e| failed(&e)),
        }
    }
}

/// A table and where it goes.
pub(super) struct Table {
    pub(super) form: Form,
    pub(super) columns: &'static [Column],
    pub(super) to: Target,
}

impl Table {
    /// Replaces the content of the file with these rows.
    pub(super) fn write(&self, rows: &[Row]) -> Result<(), Failure> {
        let content = self.form.render(rows, self.columns)?;
        self.to.write(|out| out.write_all(&content))
    }
}

const HEADINGS: [&str; 7] =
    ["file", "status", "model", "frequency", "decay rate", "friction displacement", "reason"];

/// The cells for human readers: value and 95 % interval.
fn cells(row: &Row) -> [String; 7] {
    let number = |v: Option<f64>, unit: &str| v.map(|v| plain(v, 4, unit)).unwrap_or_default();
    // Value and limits in one unit, to the digits that the interval justifies.
    let within = |v: f64, low: f64, high: f64, unit: &str| {
        let shown = Rounded::new(v, 0.25 * (high - low), unit);
        let unit = &shown.scale.unit;
        let gap = if unit.is_empty() || shown.scale.power.is_some() { "" } else { " " };
        format!("{} ({} to {}){gap}{unit}", shown.value(), shown.also(low), shown.also(high))
    };
    let ranged = |v: Option<f64>, low: Option<f64>, high: Option<f64>, unit: &str| match (v, low, high) {
        // A term that the model leaves out has no value, only a limit.
        (Some(v), Some(low), Some(high)) if v == 0.0 || !(low..=high).contains(&v) => {
            format!("< {}", plain(high, 2, unit))
        }
        (Some(v), Some(low), Some(high)) => within(v, low, high, unit),
        _ => number(v, unit),
    };
    let unit = row.friction_unit();
    let quantity = |names: [&str; 3], unit: &str| {
        let [value, low, high] = names.map(|name| row.number(&[name]));
        ranged(value, low, high, unit)
    };
    [
        row.file.clone(),
        row.status.name().to_owned(),
        row.text("model").to_owned(),
        number(row.number(&["frequency_hz", "natural_frequency_hz"]), "Hz"),
        quantity(["decay_rate_per_s", "decay_rate_low_per_s", "decay_rate_high_per_s"], "1/s"),
        quantity(["friction_displacement", "friction_displacement_low", "friction_displacement_high"], unit),
        row.reason.clone(),
    ]
}

/// A table in Markdown.
pub(crate) fn markdown(rows: &[Row]) -> String {
    let mut text = format!("| {} |\n|{}\n", HEADINGS.join(" | "), "---|".repeat(HEADINGS.len()));
    for row in rows {
        let cells = cells(row).map(|c| escape::markdown_cell(&c));
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    text
}

fn latex(rows: &[Row]) -> String {
    let mut text = format!("\\begin{{tabular}}{{{}}}\n", "l".repeat(HEADINGS.len()));
    let _ = writeln!(text, "{} \\\\ \\hline", HEADINGS.join(" & "));
    for row in rows {
        let _ = writeln!(text, "{} \\\\", cells(row).map(|c| escape::latex(&c)).join(" & "));
    }
    text.push_str("\\end{tabular}\n");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_of_the_language_are_escaped() {
        let row = Row::failed(Path::new("a|b_%.csv"), "x & y", &[]);
        assert!(markdown(std::slice::from_ref(&row)).contains("a\\|b\\_%.csv"));
        let text = latex(&[row]);
        assert!(text.contains("a$|$b\\_\\%.csv & failed"), "{text}");
        assert!(text.contains("x \\& y"), "{text}");
    }

    #[test]
    fn a_value_outside_its_interval_is_a_bound() {
        const COLUMNS: &[Column] = &[
            Column::number("friction_displacement"),
            Column::number("friction_displacement_low"),
            Column::number("friction_displacement_high"),
            Column::text("unit"),
        ];
        let row = |value: f64| {
            let numbers = [value, 2.54e-4, 0.002_68].map(Value::number);
            let values = numbers.into_iter().chain([Value::text("rad")]).collect();
            cells(&Row::answered(Path::new("a.csv"), &[], COLUMNS, values))[5].clone()
        };
        assert_eq!(row(0.0), "< 2.7 mrad");
        // The limits are in the unit of the value; earlier, 1 mrad (2.54×10⁻⁴ to 0.00268) was not.
        assert_eq!(row(0.001), "1.0 (0.3 to 2.7) mrad");
    }

    #[test]
    fn the_ending_names_the_form() {
        assert_eq!(Form::of(Path::new("a.TEX")).ok(), Some(Form::Latex));
        assert!(Form::of(Path::new("a.doc")).is_err());
        assert!(Form::of(Path::new("a")).is_err());
    }
}
