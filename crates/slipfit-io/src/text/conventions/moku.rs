//! Moku instruments: remarks with `%`, the last of them the header.

use super::{Convention, Layout, Look};

pub(super) struct Moku;

impl Convention for Moku {
    fn name(&self) -> &'static str {
        "Moku"
    }

    fn fits(&self, look: &Look) -> bool {
        look.lines.iter().any(|l| l.starts_with('%') && l.contains("Moku"))
    }

    fn adjust(&self, _: &Look, _: &mut Layout) {}
}
