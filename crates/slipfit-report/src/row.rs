//! The row of a table for one file.

use serde::ser::{Serialize, SerializeMap, Serializer};
use std::path::Path;

/// A column after `file`, `status` and `reason`, with which every table begins.
#[derive(Debug, PartialEq)]
pub struct Column {
    /// Its heading, with the unit.
    pub name: &'static str,
    /// What it holds.
    pub kind: Kind,
}

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Text.
    Text,
    /// A number.
    Number,
    /// A count.
    Count,
    /// True or false.
    Flag,
}

impl Column {
    /// A column of text.
    pub const fn text(name: &'static str) -> Self {
        Self { name, kind: Kind::Text }
    }

    /// A column of numbers.
    pub const fn number(name: &'static str) -> Self {
        Self { name, kind: Kind::Number }
    }

    /// A column of counts.
    pub const fn count(name: &'static str) -> Self {
        Self { name, kind: Kind::Count }
    }

    /// A column of flags.
    pub const fn flag(name: &'static str) -> Self {
        Self { name, kind: Kind::Flag }
    }
}

/// A cell; a missing value is an empty cell.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Value {
    /// No value.
    None,
    /// Text.
    Text(String),
    /// A finite number.
    Number(f64),
    /// A count.
    Count(u64),
    /// True or false.
    Flag(bool),
}

impl Value {
    /// A number; [`Value::None`] if it is not finite.
    pub fn number(value: f64) -> Self {
        if value.is_finite() { Self::Number(value) } else { Self::None }
    }

    /// Text.
    pub fn text(text: &str) -> Self {
        Self::Text(text.to_owned())
    }

    /// A count.
    pub fn count(count: u64) -> Self {
        Self::Count(count)
    }

    /// True or false.
    pub fn flag(flag: bool) -> Self {
        Self::Flag(flag)
    }

    /// The cell of a CSV file; foreign text cannot become a formula there.
    pub fn csv(&self) -> String {
        match self {
            Self::None => String::new(),
            Self::Text(text) => crate::escape::csv(text),
            Self::Number(value) => serde_json::Value::from(*value).to_string(),
            Self::Count(value) => value.to_string(),
            Self::Flag(value) => value.to_string(),
        }
    }
}

/// Outcome of the analysis of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// An answer without warnings.
    Done,
    /// An answer with warnings.
    Warned,
    /// No answer.
    Failed,
}

impl Status {
    const ALL: [Self; 3] = [Self::Done, Self::Warned, Self::Failed];

    /// Name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Warned => "warned",
            Self::Failed => "failed",
        }
    }
}

/// One row.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name of the file, for display.
    pub file: String,
    /// Outcome of the analysis of a file.
    pub status: Status,
    /// Codes of the warnings, or why it failed.
    pub reason: String,
    /// The columns after `reason`.
    pub columns: &'static [Column],
    /// One value per column.
    pub values: Vec<Value>,
}

impl Row {
    /// The row of an answer.
    pub fn answered(file: &Path, warnings: &[&str], columns: &'static [Column], values: Vec<Value>) -> Self {
        debug_assert_eq!(values.len(), columns.len());
        let status = if warnings.is_empty() { Status::Done } else { Status::Warned };
        Self { file: file.display().to_string(), status, reason: warnings.join(" "), columns, values }
    }

    /// The row of a file without an answer.
    pub fn failed(file: &Path, reason: &str, columns: &'static [Column]) -> Self {
        let empty = |c: &Column| if c.kind == Kind::Text { Value::text("") } else { Value::None };
        Self {
            file: file.display().to_string(),
            status: Status::Failed,
            reason: reason.split_whitespace().collect::<Vec<_>>().join(" "),
            columns,
            values: columns.iter().map(empty).collect(),
        }
    }

    fn value(&self, name: &str) -> Option<&Value> {
        self.columns.iter().position(|c| c.name == name).and_then(|i| self.values.get(i))
    }

    /// The number in the first of these columns that exists and holds a number.
    pub fn number(&self, names: &[&str]) -> Option<f64> {
        names.iter().find_map(|name| match self.value(name)? {
            Value::Number(v) => Some(*v),
            _ => None,
        })
    }

    /// The text in a column; empty if there is none.
    pub fn text(&self, name: &str) -> &str {
        match self.value(name) {
            Some(Value::Text(text)) => text,
            _ => "",
        }
    }

    /// The unit of friction displacements; that of the signal if there is no column for it.
    pub fn friction_unit(&self) -> &str {
        match self.text("friction_unit") {
            "" => self.text("unit"),
            unit => unit,
        }
    }

    /// Reads a row back from its line in the journal; `None` if the line is not a row.
    pub fn parse(line: &str, columns: &'static [Column]) -> Option<Self> {
        let map: serde_json::Map<String, serde_json::Value> = serde_json::from_str(line).ok()?;
        let word = |name: &str| map.get(name)?.as_str().map(str::to_owned);
        let status = word("status")?;
        let cell = |c: &Column| {
            let held = map.get(c.name)?;
            if held.is_null() && c.kind != Kind::Text {
                return Some(Value::None);
            }
            match c.kind {
                Kind::Text => held.as_str().map(Value::text),
                Kind::Number => held.as_f64().map(Value::Number),
                Kind::Count => held.as_u64().map(Value::Count),
                Kind::Flag => held.as_bool().map(Value::Flag),
            }
        };
        Some(Self {
            file: word("file")?,
            status: Status::ALL.into_iter().find(|s| s.name() == status)?,
            reason: word("reason")?,
            columns,
            values: columns.iter().map(cell).collect::<Option<_>>()?,
        })
    }
}

/// An object whose keys keep the order of the columns.
impl Serialize for Row {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(3 + self.columns.len()))?;
        map.serialize_entry("file", &self.file)?;
        map.serialize_entry("status", self.status.name())?;
        map.serialize_entry("reason", &self.reason)?;
        for (column, value) in self.columns.iter().zip(&self.values) {
            map.serialize_entry(column.name, value)?;
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: &[Column] =
        &[Column::text("unit"), Column::number("x"), Column::count("n"), Column::flag("seen")];

    #[test]
    fn a_row_comes_back_from_its_line_to_the_last_bit() {
        // Numbers that an imprecise parser rounds to a neighbouring one.
        for x in [0.1 + 0.2, 1.0 / 3.0, 5e-324, f64::EPSILON, f64::MIN_POSITIVE.next_down(), 1e23] {
            let values =
                vec![Value::text("mrad"), Value::number(x), Value::Count(u64::MAX), Value::Flag(true)];
            let row = Row::answered(Path::new("a \"b\".csv"), &["bent"], COLUMNS, values);
            let line = serde_json::to_string(&row).unwrap();
            assert_eq!(Row::parse(&line, COLUMNS), Some(row));
        }
        let failed = Row::failed(Path::new("x"), "no\n table", COLUMNS);
        assert_eq!(Row::parse(&serde_json::to_string(&failed).unwrap(), COLUMNS), Some(failed));
        assert_eq!(Row::parse("{\"file\": \"half", COLUMNS), None);
        assert_eq!(Row::parse("{\"file\": \"x\", \"status\": \"done\", \"reason\": \"\"}", COLUMNS), None);
    }
}
