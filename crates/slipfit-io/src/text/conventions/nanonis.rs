//! Nanonis .dat: names and values between tabs, `[DATA]`, then the table.

use super::{Convention, Layout, Look};

pub(super) struct Nanonis;

impl Convention for Nanonis {
    fn name(&self) -> &'static str {
        "Nanonis"
    }

    fn fits(&self, look: &Look) -> bool {
        look.lines.iter().any(|l| l == "[DATA]")
    }

    /// Every line before `[DATA]` names a value, in words as well as in numbers.
    fn adjust(&self, look: &Look, layout: &mut Layout) {
        layout.head.named_values = look
            .lines
            .iter()
            .take_while(|l| *l != "[DATA]")
            .filter_map(|l| l.split_once('\t'))
            .map(|(name, value)| (name.trim().to_owned(), value.trim().to_owned()))
            .filter(|(_, value)| !value.is_empty())
            .collect();
    }
}
