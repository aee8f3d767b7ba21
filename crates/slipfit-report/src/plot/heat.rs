//! Heat maps on a logarithmic scale of errors.

use super::Picture;
use super::axis::Axis;
use super::figure::{Anchor, Color, Figure, Point, wrap};
use super::panel::{INK, Panel};

const PANEL: Point = [400.0, 340.0];
const BAR: f64 = 130.0;
/// Decades of the colour scale.
const SCALE: [f64; 2] = [1e-5, 1.0];

/// Colour of a missing value: grey, which is not part of the scale.
pub(super) const NONE: Color = Color::new(205, 208, 212);

/// A value for each cell of a grid; `None` where there is none.
pub struct HeatMap {
    /// Title above the map.
    pub title: String,
    /// Values row by row in `y`, along `x` within a row.
    pub values: Vec<Option<f64>>,
}

/// Maps over one grid of `x` (logarithmic) and `y`, three in a row, with their common scale.
pub fn heat_maps(
    heading: &str,
    caption: &str,
    [x_label, y_label, scale_label]: [&str; 3],
    x: &[f64],
    y: &[f64],
    maps: &[HeatMap],
) -> Picture {
    let width = 3.0 * PANEL[0] + BAR;
    let lines = wrap(caption, 13.5, width - 60.0);
    let rows = maps.len().div_ceil(3) as f64;
    let mut figure = Figure::new(width, 50.0 + rows * PANEL[1] + 24.0 + 19.0 * lines.len() as f64);
    figure.text([30.0, 32.0], heading, 18.0, INK, Anchor::Start);
    let (x_edges, y_edges) = (edges(x, true), edges(y, false));
    for (i, map) in maps.iter().enumerate() {
        let corner = [(i % 3) as f64 * PANEL[0], 50.0 + (i / 3) as f64 * PANEL[1]];
        let x_axis = Axis::log(x_edges[0], x_edges[x.len()], x_label);
        let y_axis = Axis::linear(y_edges[0], y_edges[y.len()], y_label);
        let mut drawn = Figure::new(PANEL[0], PANEL[1]);
        let mut panel = Panel::new(&mut drawn, &map.title, x_axis, y_axis);
        for (cell, value) in map.values.iter().enumerate() {
            let (row, column) = (cell / x.len(), cell % x.len());
            let low = [x_edges[column], y_edges[row]];
            panel.patch(low, [x_edges[column + 1], y_edges[row + 1]], value.map_or(NONE, shade));
        }
        figure.place(corner, drawn);
    }
    figure.place([3.0 * PANEL[0], 50.0], scale(scale_label));
    for (i, line) in lines.into_iter().enumerate() {
        let y = 50.0 + rows * PANEL[1] + 16.0 + 19.0 * i as f64;
        figure.text([30.0, y], line, 13.5, INK.faded(0.8), Anchor::Start);
    }
    Picture(figure)
}

fn scale(label: &str) -> Figure {
    const STEPS: i32 = 120;
    let axis = Axis::log(SCALE[0], SCALE[1], label);
    let mut figure = Figure::new(BAR - 12.0, PANEL[1]);
    let x = Axis { low: 0.0, high: 1.0, log: false, label: String::new(), names: Vec::new(), hidden: false };
    let mut panel = Panel::new(&mut figure, "", x, axis);
    let at = |i: i32| SCALE[0] * (SCALE[1] / SCALE[0]).powf(f64::from(i) / f64::from(STEPS));
    for i in 0..STEPS {
        panel.patch([0.0, at(i)], [1.0, at(i + 1)], shade((at(i) * at(i + 1)).sqrt()));
    }
    figure
}

/// Cell edges halfway between neighbouring centres.
fn edges(centres: &[f64], log: bool) -> Vec<f64> {
    let inner = |a: f64, b: f64| if log { (a * b).sqrt() } else { 0.5 * (a + b) };
    let beyond = |a: f64, b: f64| if log { a * (a / b).sqrt() } else { a + 0.5 * (a - b) };
    let n = centres.len();
    let mut all = vec![beyond(centres[0], centres[1.min(n - 1)])];
    all.extend(centres.windows(2).map(|w| inner(w[0], w[1])));
    all.push(beyond(centres[n - 1], centres[n.saturating_sub(2)]));
    all
}

/// Colour of an error, darker as the error grows.
fn shade(value: f64) -> Color {
    darkening((value.abs().max(SCALE[0]) / SCALE[0]).log10() / (SCALE[1] / SCALE[0]).log10())
}

/// Colour from light at 0 to dark at 1, uniform in lightness and legible in greyscale.
pub(super) fn darkening(place: f64) -> Color {
    const STOPS: [[f64; 3]; 7] = [
        [255.0, 251.0, 232.0],
        [254.0, 227.0, 160.0],
        [253.0, 187.0, 96.0],
        [241.0, 131.0, 68.0],
        [205.0, 71.0, 70.0],
        [137.0, 34.0, 88.0],
        [52.0, 14.0, 70.0],
    ];
    let along = place.clamp(0.0, 1.0) * 6.0;
    let i = (along.floor() as usize).min(5);
    let part = along - i as f64;
    let [r, g, b] = [0, 1, 2].map(|c| (STOPS[i][c] + part * (STOPS[i + 1][c] - STOPS[i][c])).round() as u8);
    Color::new(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_lie_between_and_beyond() {
        assert_eq!(edges(&[0.0, 1.0, 2.0], false), [-0.5, 0.5, 1.5, 2.5]);
        let log = edges(&[1.0, 100.0], true);
        assert!((log[1] - 10.0).abs() < 1e-12);
        assert!((log[0] - 0.1).abs() < 1e-12);
    }

    #[test]
    fn shades_darken() {
        let sum = |v: f64| shade(v).rgb.iter().map(|c| u32::from(*c)).sum::<u32>();
        let sums: Vec<u32> = (-7..=1).map(|e| sum(10f64.powi(e))).collect();
        assert!(sums.windows(2).all(|w| w[0] >= w[1]), "{sums:?}");
    }
}
