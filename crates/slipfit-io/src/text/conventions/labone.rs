//! Zurich Instruments LabOne: `chunk;timestamp;x;y;…`, times in ticks of the
//! instrument's clock.

use super::{Convention, Layout, Look};
use crate::columns::names::Name;

pub(super) struct LabOne;

impl Convention for LabOne {
    fn name(&self) -> &'static str {
        "Zurich Instruments LabOne"
    }

    fn fits(&self, look: &Look) -> bool {
        let has = |name: &str| look.headers.iter().any(|h| h.trim_start_matches(['%', ' ']) == name);
        has("chunk") && has("timestamp")
    }

    /// Ticks become seconds by a clock that the file may name (`clockbase`) and
    /// mostly does not.
    fn adjust(&self, look: &Look, layout: &mut Layout) {
        let clock = look.value("clockbase").and_then(|v| v.parse::<f64>().ok()).filter(|v| *v > 0.0);
        for name in &mut layout.head.names {
            let plain = name.header.trim_start_matches(['%', ' ']).to_owned();
            let unit = match plain.as_str() {
                "timestamp" => clock.map_or_else(|| "ticks".to_owned(), |c| format!("{c} Hz")),
                "x" | "y" | "r" | "auxin0" | "auxin1" => "V".to_owned(),
                "freq" | "frequency" => "Hz".to_owned(),
                "phase" => "rad".to_owned(),
                _ => continue,
            };
            *name = Name { unit, ..Name::parse(&plain) };
        }
    }
}
