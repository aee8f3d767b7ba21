//! What programs and instruments mean by the texts they write.
//!
//! A text is read by its shape alone. Where its writer can be told, what the
//! shape does not say is filled in: units, clocks, names of values. One file a
//! writer, one line in the list.

mod analyser;
mod capstone;
mod klipper;
mod labone;
mod moku;
mod nanonis;
mod phyphox;
mod tracker;
mod vernier;

use super::layout::Layout;

/// The lines above the numbers, as a convention sees them.
pub(super) struct Look {
    /// All lines before the first row of numbers.
    pub(super) lines: Vec<String>,
    /// The names of the columns as written.
    pub(super) headers: Vec<String>,
}

impl Look {
    /// Whether a line holds a word, in any case.
    fn says(&self, word: &str) -> bool {
        self.lines.iter().any(|l| l.to_lowercase().contains(word))
    }

    /// The first value named so, in any case: `Sweep Time,7.98 s`.
    fn value(&self, name: &str) -> Option<&str> {
        self.lines.iter().find_map(|line| {
            let (key, value) =
                line.trim_start_matches(['#', '%', '!', ' ']).split_once([',', ';', '\t', ':', '='])?;
            let key = key.trim().trim_matches('"').to_lowercase();
            key.starts_with(name).then(|| value.trim().trim_matches('"'))
        })
    }
}

/// A program or instrument with ways of its own.
pub(super) trait Convention {
    /// Its name in a sentence.
    fn name(&self) -> &'static str;
    /// Whether it wrote this.
    fn fits(&self, look: &Look) -> bool;
    /// Fills in what it leaves unsaid.
    fn adjust(&self, look: &Look, layout: &mut Layout);
}

const KNOWN: &[&dyn Convention] = &[
    &labone::LabOne,
    &nanonis::Nanonis,
    &klipper::Klipper,
    &moku::Moku,
    &analyser::Analyser,
    &capstone::Capstone,
    &vernier::Vernier,
    &tracker::Tracker,
    &phyphox::Phyphox,
];

/// Fills in what the writer of a text leaves unsaid; gives the writer's name.
pub(super) fn apply(lines: &[&[u8]], layout: &mut Layout) -> Option<&'static str> {
    let above = lines[..layout.first_line.min(lines.len())].iter();
    let look = Look {
        lines: above.map(|l| super::layout::text(l).trim().to_owned()).collect(),
        headers: layout.head.names.iter().map(|n| n.header.clone()).collect(),
    };
    let convention = KNOWN.iter().find(|c| c.fits(&look))?;
    convention.adjust(&look, layout);
    Some(convention.name())
}
