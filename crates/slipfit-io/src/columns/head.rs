//! Description of a table in its file, apart from its numbers.

use slipfit::SignalKind;

use super::name::Name;
use crate::{
    error::{OptionProblem, ReadProblem},
    format::Format,
    report::{ColumnInfo, Note, ReadReport},
};

/// Names and values given along with the numbers of a table.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Head {
    /// Sheet, variable, group or track; empty if the file has only one table.
    pub(crate) name: String,
    /// One per column; empty without a header.
    pub(crate) names: Vec<Name>,
    /// Samples per second, if the format itself states it.
    pub(crate) rate_hz: Option<f64>,
    /// Samples per second stated in the lines above a table without times.
    pub(crate) stated_rate_hz: Option<f64>,
    /// Time step between rows (s) as stated in the file; the first column rounds it.
    pub(crate) step_s: Option<f64>,
    /// Values named outside the table.
    pub(crate) named_values: Vec<(String, String)>,
    /// Whether these are variables of the file and not text above a table.
    pub(crate) has_variables: bool,
    /// Whether the samples went through a lossy compression.
    pub(crate) lossy: bool,
    /// Notes on irregularities.
    pub(crate) notes: Vec<Note>,
}

impl Head {
    /// A table with these headers.
    pub(crate) fn of(headers: impl IntoIterator<Item = impl AsRef<str>>) -> Self {
        let names = headers.into_iter().map(|header| Name::parse(header.as_ref())).collect();
        Self { names, ..Self::default() }
    }

    /// A sound with one column per channel.
    pub(crate) fn of_channels(channels: usize, rate_hz: f64) -> Self {
        let mut head = Self::of((1..=channels).map(|c| format!("channel {c}")));
        head.rate_hz = Some(rate_hz);
        if channels > 1 {
            let text = format!("the sound has {channels} channels");
            head.notes.push(Note::new(text).hint("signal", "chooses one"));
        }
        head
    }

    /// Notes that a column was left out.
    #[cfg(any(feature = "arrow", feature = "parquet"))]
    pub(crate) fn note_not_numbers(&mut self, header: &str) {
        self.notes.push(format!("column `{header}` holds no numbers and was left out").into());
    }

    /// The columns as named in the report.
    pub(crate) fn infos(&self) -> Vec<ColumnInfo> {
        (0..self.names.len()).map(|index| self.info(index)).collect()
    }

    /// A report on the table before any data are read.
    pub(crate) fn report(&self) -> ReadReport {
        ReadReport {
            path: String::new(),
            format: Format::Text,
            sha256: String::new(),
            bytes: 0,
            sheet: self.name.clone(),
            dialect: None,
            columns: self.infos(),
            rows_read: 0,
            skipped: Vec::new(),
            taken: Vec::new(),
            time: None,
            kind: SignalKind::Displacement,
            named: false,
            parts: 1,
            part: 1,
            runs: 1,
            run: 1,
            named_values: self.named_values.clone(),
            records: Vec::new(),
            files_left_out: 0,
            notes: Vec::new(),
        }
    }

    pub(crate) fn info(&self, index: usize) -> ColumnInfo {
        let name = &self.names[index];
        ColumnInfo { number: index + 1, header: name.header.clone(), unit: name.unit.clone() }
    }

    /// ``column 4 `Weg / rad` `` or `column 4`.
    pub(crate) fn label(&self, index: usize) -> String {
        let header = &self.names[index].header;
        let number = index + 1;
        if header.is_empty() { format!("column {number}") } else { format!("column {number} `{header}`") }
    }

    /// Columns as listed in a message.
    pub(crate) fn list(&self, indices: &[usize]) -> String {
        const MOST: usize = 12;
        let mut labels: Vec<String> = indices.iter().take(MOST).map(|&i| self.label(i)).collect();
        if indices.len() > MOST {
            labels.push(format!("and {} more", indices.len() - MOST));
        }
        labels.join(", ")
    }

    pub(crate) fn all(&self) -> Vec<usize> {
        (0..self.names.len()).collect()
    }

    /// Finds a column by number or name; names are searched in `near` first.
    pub(crate) fn find(
        &self,
        option: &'static str,
        wanted: &str,
        near: &[usize],
    ) -> Result<usize, ReadProblem> {
        let all = self.all();
        let key = wanted.trim().to_lowercase();
        let refused = |problem| ReadProblem::Option { option, value: wanted.to_owned(), problem };
        let unknown = || refused(OptionProblem::NoSuchColumn(self.list(&all)));
        if key.is_empty() {
            return Err(unknown());
        }
        let header = |i: usize| self.names[i].header.to_lowercase();
        let whole = |i: usize| header(i) == key;
        let bare = |i: usize| self.names[i].bare.to_lowercase() == key;
        let tests: [&dyn Fn(usize) -> bool; 2] = [&whole, &bare];
        for test in tests {
            if let Some(index) = near.iter().chain(&all).copied().find(|i| test(*i)) {
                return Ok(index);
            }
        }
        if let Ok(number) = key.parse::<usize>() {
            return if (1..=all.len()).contains(&number) { Ok(number - 1) } else { Err(unknown()) };
        }
        for place in [near, &all] {
            let fits: Vec<usize> = place.iter().copied().filter(|i| header(*i).contains(&key)).collect();
            match fits[..] {
                [] => {}
                [index] => return Ok(index),
                _ => return Err(refused(OptionProblem::SeveralColumns(self.list(&fits)))),
            }
        }
        Err(unknown())
    }
}
