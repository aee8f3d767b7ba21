//! Panels two by two under a heading.

use super::figure::{Anchor, Figure, Point, wrap};
use super::panel::INK;

/// The usual size of a panel.
pub(super) const PANEL: Point = [530.0, 330.0];

const MARGIN: f64 = 10.0;
const TITLE_SIZE: f32 = 18.0;
const SUBTITLE_SIZE: f32 = 14.0;

/// All panels, which have the same size, in one picture.
pub(super) fn headed(title: &str, subtitle: &str, panels: Vec<Figure>) -> Figure {
    let (wide, high) = panels.first().map_or((PANEL[0], PANEL[1]), |p| (p.width, p.height));
    let width = 2.0 * (wide + MARGIN);
    let lines = wrap(title, TITLE_SIZE, width - 4.0 * MARGIN);
    let below = wrap(subtitle, SUBTITLE_SIZE, width - 4.0 * MARGIN);
    let heading = 24.0 + 24.0 * lines.len() as f64 + 20.0 * below.len() as f64;
    let rows = panels.len().div_ceil(2) as f64;
    let mut figure = Figure::new(width, heading + rows * high + MARGIN);
    title.clone_into(&mut figure.title);
    let mut y = 10.0;
    for line in lines {
        y += 24.0;
        figure.text([2.0 * MARGIN, y], line, TITLE_SIZE, INK, Anchor::Start);
    }
    for line in below {
        y += 20.0;
        figure.text([2.0 * MARGIN, y + 2.0], line, SUBTITLE_SIZE, INK.faded(0.75), Anchor::Start);
    }
    for (i, panel) in panels.into_iter().enumerate() {
        figure.place([MARGIN + (i % 2) as f64 * wide, heading + (i / 2) as f64 * high], panel);
    }
    figure
}
