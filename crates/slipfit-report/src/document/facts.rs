//! What there is to say besides the numbers, each under a label.

/// Labelled sentences in the order they are read; an empty label goes on with the one before.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Facts(Vec<(&'static str, String)>);

impl Facts {
    pub(crate) fn add(&mut self, label: &'static str, text: impl Into<String>) {
        self.0.push((label, text.into()));
    }

    pub(crate) fn notes(&mut self, notes: &[String]) {
        notes.iter().for_each(|note| self.add("note", note));
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&'static str, &str)> {
        self.0.iter().map(|(label, text)| (*label, text.as_str()))
    }
}
