//! Igor waves as text: their names are above the points, the step between the points and the units below them.

use super::layout::{self, Layout};
use crate::columns::{name::Name, stated};

/// Name of the writer of such texts in `vendors`.
pub(super) const WRITER: &str = "Igor";

/// Adds the statements of `X SetScale/P x 0,0.0002,"s", deflection; SetScale y 0,0,"V", deflection` found in the text
/// or in the available part of it.
pub(super) fn add_scale(text: &[u8], layout: &mut Layout) {
    let text = layout::text(text);
    let commands =
        || text.lines().filter_map(|line| line.trim().strip_prefix("X ")).flat_map(|line| line.split(';'));
    // First value, step or last value, unit, and the waves.
    let scales = |command: &str| {
        let found = commands().find_map(|one| one.trim().strip_prefix(command));
        found.map(|scale| {
            scale.split(',').map(|cell| cell.trim().trim_matches('"').to_owned()).collect::<Vec<_>>()
        })
    };
    if let Some([_, step, unit, ..]) = scales("SetScale/P x").as_deref() {
        let step = format!("Sample interval={step}{unit}");
        let stated = stated::rate_hz([step.as_str()].into_iter(), &[','], layout.shape.decimal);
        layout.head.stated_rate_hz = layout.head.stated_rate_hz.or(stated);
    }
    let unit = match scales("SetScale y").as_deref() {
        Some([_, _, unit, ..]) if !unit.is_empty() => format!(" ({unit})"),
        _ => String::new(),
    };
    let waves = text.lines().find(|line| line.starts_with("WAVES")).unwrap_or_default();
    let waves: Vec<&str> = waves.split([' ', '\t', ',']).skip(1).filter(|wave| !wave.is_empty()).collect();
    // Each row begins with a tab.
    // Removes the note that the line above the points names no columns.
    layout.head.notes.clear();
    let names = &mut layout.head.names;
    let first = names.len().saturating_sub(waves.len());
    if first <= 1 {
        names
            .iter_mut()
            .skip(first)
            .zip(waves)
            .for_each(|(name, wave)| *name = Name::parse(&format!("{wave}{unit}")));
    }
}
