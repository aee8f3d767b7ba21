//! Vernier Logger Pro and Graphical Analysis: `Latest: Time (s)`, further runs
//! in further groups of columns.

use super::{Convention, Layout, Look};

pub(super) struct Vernier;

impl Convention for Vernier {
    fn name(&self) -> &'static str {
        "Vernier"
    }

    fn fits(&self, look: &Look) -> bool {
        let of_a_set = |h: &String| {
            let h = h.to_lowercase();
            h.starts_with("latest:") || h.starts_with("data set") || h.starts_with("run ") && h.contains(':')
        };
        !look.headers.is_empty() && look.headers.iter().all(of_a_set)
    }

    fn adjust(&self, _: &Look, _: &mut Layout) {}
}
