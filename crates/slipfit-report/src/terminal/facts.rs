//! What there is to say besides the numbers, each under a label.

use super::labelled;

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

    /// For the screen, whose labels are short.
    pub(crate) fn told(&self) -> String {
        self.iter().map(|(label, text)| labelled(short(label), text)).collect()
    }
}

fn short(label: &str) -> &str {
    match label {
        "frequency" => "freq",
        "amplitude" => "ampl",
        "imaginary" => "imag",
        "std_error" => "error",
        "conductance" => "conduct",
        "susceptance" => "suscept",
        "resistance" => "resist",
        "reactance" => "react",
        "response" => "signal",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_fit_their_column_on_the_screen() {
        let mut facts = Facts::default();
        facts.add("conductance", "column 3");
        facts.add("", "and its unit");
        let text = anstream::adapter::strip_str(&facts.told()).to_string();
        assert_eq!(text, "  conduct column 3\n          and its unit\n");
    }
}
