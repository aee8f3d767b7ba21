//! Charts side by side, as on the page of a paper.

use super::axis::Axis;
use super::figure::{Anchor, Color, Figure, Point, Stroke, wrap};
use super::panel::{INK, Mark, Panel};
use super::picture::Picture;

const PANEL: Point = [540.0, 350.0];
const MARGIN: f64 = 10.0;

/// One set of axes with its curves.
pub struct Chart {
    /// Name of its file, without extension.
    pub file: &'static str,
    /// Title above the axes.
    pub title: String,
    /// Horizontal axis.
    pub x: Scaled,
    /// Vertical axis.
    pub y: Scaled,
    /// Curves from the lowest layer to the topmost.
    pub series: Vec<Series>,
}

/// An axis: its label with the unit, its range, linear or logarithmic.
pub struct Scaled {
    /// Label, such as `ω/ω₀` or `amplitude [nm]`.
    pub label: String,
    /// Values at its ends.
    pub range: [f64; 2],
    /// Whether it is logarithmic.
    pub log: bool,
}

impl Scaled {
    /// A linear axis.
    pub fn linear(label: &str, range: [f64; 2]) -> Self {
        Self { label: label.to_owned(), range, log: false }
    }

    /// A logarithmic axis.
    pub fn log(label: &str, range: [f64; 2]) -> Self {
        Self { label: label.to_owned(), range, log: true }
    }

    fn axis(&self) -> Axis {
        let [low, high] = self.range;
        if self.log { Axis::log(low, high, &self.label) } else { Axis::linear(low, high, &self.label) }
    }
}

/// One curve.
pub struct Series {
    /// Name in the table, and in the legend unless `legend` is set.
    pub name: String,
    /// Name in the legend if it differs; an empty one leaves the curve out of the legend.
    pub legend: Option<&'static str>,
    /// Its points; those that are not finite are left out.
    pub points: Vec<Point>,
    /// How it is drawn.
    pub style: SeriesStyle,
}

impl Series {
    /// A curve whose name the legend shows.
    #[must_use]
    pub fn new(name: impl Into<String>, points: Vec<Point>, style: SeriesStyle) -> Self {
        Self { name: name.into(), legend: None, points, style }
    }

    /// The same curve with another name in the legend; an empty name leaves it out.
    #[must_use]
    pub fn in_legend(self, name: &'static str) -> Self {
        Self { legend: Some(name), ..self }
    }
}

/// How a curve is drawn; the number chooses the colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SeriesStyle {
    /// A solid line.
    Line(usize),
    /// A wide, pale line behind others.
    Wide(usize),
    /// A dashed line.
    Dashed(usize),
    /// Small dots.
    Dots(usize),
    /// Dots large enough to be visible on a curve.
    LargeDots(usize),
}

/// Okabe and Ito's colour-blind-safe palette.
const PALETTE: [Color; 6] = [
    Color::new(0x00, 0x72, 0xb2),
    Color::new(0xd5, 0x5e, 0x00),
    Color::new(0x00, 0x9e, 0x73),
    Color::new(0x22, 0x22, 0x22),
    Color::new(0xcc, 0x79, 0xa7),
    Color::new(0x8a, 0x92, 0x9c),
];

fn color(i: usize) -> Color {
    PALETTE[i % PALETTE.len()]
}

impl SeriesStyle {
    fn stroke(self) -> Option<Stroke> {
        match self {
            Self::Line(i) => Some(Stroke::solid(color(i), 1.8)),
            Self::Wide(i) => Some(Stroke::solid(color(i).faded(0.45), 5.0)),
            Self::Dashed(i) => Some(Stroke::dashed(color(i), 1.8)),
            Self::Dots(_) | Self::LargeDots(_) => None,
        }
    }

    fn mark(self) -> Mark {
        match (self.stroke(), self) {
            (Some(stroke), _) => Mark::Line(stroke),
            (None, Self::Dots(i) | Self::LargeDots(i)) => Mark::Dot(color(i)),
            (None, _) => Mark::Dot(INK),
        }
    }
}

/// Charts two by two under a heading, with a caption below.
pub fn page(heading: &str, caption: &str, charts: &[Chart]) -> Picture {
    let width = 2.0 * PANEL[0] + 2.0 * MARGIN;
    let lines = wrap(caption, 13.5, width - 6.0 * MARGIN);
    let rows = charts.len().div_ceil(2) as f64;
    let below = 24.0 + 19.0 * lines.len() as f64;
    let mut figure = Figure::new(width, 50.0 + rows * PANEL[1] + below);
    figure.text([3.0 * MARGIN, 32.0], heading, 18.0, INK, Anchor::Start);
    for (i, chart) in charts.iter().enumerate() {
        let corner = [MARGIN + (i % 2) as f64 * PANEL[0], 50.0 + (i / 2) as f64 * PANEL[1]];
        figure.place(corner, draw(chart));
    }
    for (i, line) in lines.into_iter().enumerate() {
        let y = 50.0 + rows * PANEL[1] + 16.0 + 19.0 * i as f64;
        figure.text([3.0 * MARGIN, y], line, 13.5, INK.faded(0.8), Anchor::Start);
    }
    Picture(figure)
}

pub(super) fn draw(chart: &Chart) -> Figure {
    let mut figure = Figure::new(PANEL[0], PANEL[1]);
    let mut panel = Panel::new(&mut figure, &chart.title, chart.x.axis(), chart.y.axis());
    for series in &chart.series {
        match (series.style.stroke(), series.style) {
            (Some(stroke), _) => panel.line(series.points.iter().copied(), stroke),
            (None, SeriesStyle::LargeDots(i)) => panel.dots(series.points.iter().copied(), 3.4, color(i)),
            (None, SeriesStyle::Dots(i)) => panel.dots(series.points.iter().copied(), 2.2, color(i)),
            (None, _) => {}
        }
    }
    let named = chart.series.iter().map(|s| (s.style.mark(), s.legend.unwrap_or(&s.name)));
    let legend: Vec<(Mark, &str)> = named.filter(|(_, name)| !name.is_empty()).collect();
    if !legend.is_empty() {
        panel.legend(&legend);
    }
    figure
}
