//! Contents of a report.

use super::facts::Facts;
use super::method::Step;
use super::parameter::ParameterRow;
use crate::plot::Picture;
use crate::warning::warning_text;
use serde::ser::{Serialize, SerializeStruct as _, Serializer};
use slipfit::answer::Warning;
use slipfit::answer::hint::Spelling;

/// Everything a report says, independent of the output format.
pub struct Document<'a> {
    /// The command, such as `ringdown`.
    pub(crate) command: &'static str,
    /// Title given by the user.
    pub(crate) title: Option<String>,
    /// What was measured: the name of the file, or the title.
    pub(crate) subject: String,
    pub(crate) sentence: String,
    pub(crate) parameters: Vec<ParameterRow>,
    pub(crate) tables: Vec<Table>,
    pub(crate) facts: Facts,
    pub(crate) warnings: Vec<DocumentWarning>,
    pub(crate) method: Vec<Step>,
    pub(crate) inputs: Vec<Input>,
    /// Drawn only when they are shown.
    pub(crate) pictures: Box<dyn Fn() -> Vec<Picture> + 'a>,
}

/// For a page that lays out the report itself: text, tables, and each panel as an `<svg>` element in the colours
/// of a light page ([`crate::plot::dark_rules`] converts them for a dark one).
impl Serialize for Document<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Document", 7)?;
        fields.serialize_field("command", self.command)?;
        fields.serialize_field("subject", &self.subject)?;
        fields.serialize_field("sentence", &self.sentence)?;
        fields.serialize_field("parameters", &self.parameters)?;
        fields.serialize_field("tables", &self.tables)?;
        fields.serialize_field("facts", &self.facts.iter().collect::<Vec<_>>())?;
        let panels: Vec<String> = (self.pictures)().iter().map(Picture::inline_svg).collect();
        fields.serialize_field("panels", &panels)?;
        fields.end()
    }
}

impl Serialize for Table {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Table", 5)?;
        fields.serialize_field("title", self.title)?;
        fields.serialize_field("headings", &self.headings())?;
        fields.serialize_field("rows", self.split().1)?;
        fields.serialize_field("chosen", &self.chosen)?;
        fields.serialize_field("note", &self.note)?;
        fields.end()
    }
}

/// A warning with its code.
pub struct DocumentWarning {
    /// Machine-readable, as in the JSON answer.
    pub code: &'static str,
    /// Human-readable.
    pub text: String,
}

/// A file and the fingerprint that identifies it.
pub(crate) struct Input {
    pub(crate) path: String,
    pub(crate) sha256: String,
}

/// A table. The first row holds the headings; columns without any content are left out.
pub(crate) struct Table {
    pub(crate) title: &'static str,
    pub(crate) rows: Vec<Vec<String>>,
    /// Group headings with the number of columns each spans; empty if one line of headings is enough.
    pub(crate) groups: Vec<(String, usize)>,
    /// Index of the reported row, not counting the headings.
    pub(crate) chosen: Option<usize>,
    /// Note below the table; may be empty.
    pub(crate) note: String,
}

impl Table {
    pub(crate) fn new(title: &'static str, rows: Vec<Vec<String>>) -> Self {
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        let filled: Vec<usize> =
            (0..columns).filter(|&c| rows.iter().any(|r| r.get(c).is_some_and(|s| !s.is_empty()))).collect();
        let kept =
            |row: &Vec<String>| filled.iter().map(|&c| row.get(c).cloned().unwrap_or_default()).collect();
        Self {
            title,
            rows: rows.iter().map(kept).collect(),
            groups: Vec::new(),
            chosen: None,
            note: String::new(),
        }
    }

    /// Headings, and the rows below them.
    pub(crate) fn split(&self) -> (&[String], &[Vec<String>]) {
        match self.rows.split_first() {
            Some((head, rows)) => (head, rows),
            None => (&[], &[]),
        }
    }

    /// The group heading of each column; empty if the column has none.
    pub(crate) fn group_of_each(&self) -> Vec<String> {
        let groups = self.groups.iter().flat_map(|(name, columns)| std::iter::repeat_n(name, *columns));
        // The column `z` compares the other columns of its group and does not have their unit.
        let own = self.split().0;
        groups.zip(own).map(|(name, own)| if own == "z" { String::new() } else { name.clone() }).collect()
    }

    /// Headings in one line, the group heading before the column heading: `x_F [mrad], ring-down`.
    pub(crate) fn headings(&self) -> Vec<String> {
        let own = self.split().0;
        let groups = self.group_of_each().into_iter().chain(std::iter::repeat(String::new()));
        let joined = |(own, group): (&String, String)| match group.as_str() {
            "" => own.clone(),
            group => format!("{group}, {own}"),
        };
        own.iter().zip(groups).map(joined).collect()
    }
}

/// Warnings with their codes.
pub(super) fn warnings(list: &[Warning], spell: Spelling<'_>) -> Vec<DocumentWarning> {
    list.iter().map(|w| DocumentWarning { code: w.code(), text: warning_text(w, spell) }).collect()
}

/// The last part of a path.
pub(super) fn file_name(path: &str) -> String {
    let path = std::path::Path::new(path);
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_that_say_nothing_are_left_out() {
        let row = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
        let table = Table::new("t", vec![row(["a", "", "c"]), row(["1", "", "2"])]);
        assert_eq!(table.rows, [["a", "c"], ["1", "2"]]);
    }
}
