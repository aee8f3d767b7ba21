//! Tables of the video analysis program Tracker: names of the tracks over
//! `t x y …`, blanks where a mark is missing.

use super::{Convention, Layout, Look};
use crate::columns::names::Name;

pub(super) struct Tracker;

/// Letters that stand for angles in Tracker's tables.
const ANGLES: &[&str] = &["θ", "θr", "θv", "θa", "φ", "ϕ", "theta"];

impl Convention for Tracker {
    fn name(&self) -> &'static str {
        "Tracker"
    }

    fn fits(&self, look: &Look) -> bool {
        let names: Vec<String> = look.headers.iter().map(|h| h.trim().to_lowercase()).collect();
        let first = names.first().is_some_and(|n| n == "t");
        let letters = names.iter().all(|n| n.is_empty() || n.chars().count() <= 5 && !n.contains(['(', '[']));
        let marked = look.says("#multi:") || look.lines.iter().any(|l| l.to_lowercase().contains("mass "));
        first && letters && marked
    }

    /// Times are in seconds; lengths in the unit of the calibration; of angles
    /// the file does not say whether they are degrees or radians.
    fn adjust(&self, look: &Look, layout: &mut Layout) {
        self.name_tracks(look, layout);
        let mut angle = false;
        for name in &mut layout.head.names {
            if name.bare == "t" {
                name.unit = "s".to_owned();
            }
            angle |= ANGLES.contains(&name.bare.to_lowercase().as_str());
        }
        let angles = if angle {
            "; whether its angles are degrees or radians it leaves open, --unit deg or --unit rad says so"
        } else {
            ""
        };
        layout.head.notes.push(format!(
            "Tracker writes no units: times were taken as seconds, lengths as the unit of its calibration{angles}"
        ));
    }
}

impl Tracker {
    /// Puts the name of the track before the columns below it.
    fn name_tracks(&self, look: &Look, layout: &mut Layout) {
        let Some(header) = layout.header_line else { return };
        let Some(above) = look.lines.get(..header).and_then(|l| l.iter().rev().find(|l| !l.is_empty()))
        else {
            return;
        };
        let separator = super::super::dialect::separator(layout.shape.delimiter).map(char::from);
        let Some(separator) = separator else { return };
        let tracks: Vec<&str> = above.trim_start_matches("#multi:").split(separator).map(str::trim).collect();
        if tracks.iter().filter(|t| !t.is_empty()).count() < 2 {
            return;
        }
        let mut current = "";
        for (i, name) in layout.head.names.iter_mut().enumerate() {
            current = tracks.get(i).copied().filter(|t| !t.is_empty()).unwrap_or(current);
            if name.bare != "t" && !current.is_empty() {
                let parsed = Name::parse(&name.header);
                *name = Name { header: format!("{current}: {}", parsed.header), ..parsed };
            }
        }
    }
}
