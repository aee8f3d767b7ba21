//! PASCO Capstone and SPARKvue: `Time (s) Run #1`, several runs a file.

use super::{Convention, Layout, Look};

pub(super) struct Capstone;

impl Convention for Capstone {
    fn name(&self) -> &'static str {
        "PASCO Capstone"
    }

    fn fits(&self, look: &Look) -> bool {
        let headers = look.headers.iter().filter(|h| !h.is_empty());
        let tagged = headers.clone().filter(|h| h.contains("Run #")).count();
        tagged > 0 && tagged * 2 >= headers.count()
    }

    fn adjust(&self, _: &Look, _: &mut Layout) {}
}
