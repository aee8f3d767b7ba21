//! One set of axes: maps values to positions and clips what lies outside.

use super::axis::Axis;
use super::figure::{Anchor, Color, Figure, Frame, Layer, Point, Stroke};
use super::font;

pub(super) const INK: Color = Color::new(0x22, 0x22, 0x22);
const GRID: Color = Color::new(0xe4, 0xe6, 0xe9);
const TEXT_SIZE: f32 = 14.0;
const LEGEND_SIZE: f32 = 13.5;
/// Margins of the axes for ticks and labels: left of them, then below them.
const LEFT: f64 = 74.0;
const BELOW: f64 = 52.0;
const ABOVE: f64 = 26.0;
const RIGHT: f64 = 14.0;
/// Above this number, dots carry no values, because single dots could not be pointed at.
const MOST_LABELLED: usize = 3000;

/// Symbol of a legend entry.
pub(super) enum Mark {
    Line(Stroke),
    Dot(Color),
    Patch(Color),
}

/// Axes on a figure.
pub(super) struct Panel<'f> {
    figure: &'f mut Figure,
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    x: Axis,
    y: Axis,
    /// Points that the legend should not cover.
    occupied: Vec<Point>,
}

impl<'f> Panel<'f> {
    /// Draws the axes into the whole figure, labels included.
    pub(super) fn new(figure: &'f mut Figure, title: &str, x: Axis, y: Axis) -> Self {
        let (width, height) = (figure.width - LEFT - RIGHT, figure.height - ABOVE - BELOW);
        let mut panel = Self { figure, left: LEFT, top: ABOVE, width, height, x, y, occupied: Vec::new() };
        panel.draw_axes(title);
        title.clone_into(&mut panel.figure.title);
        panel.figure.frames.push(Frame {
            corner: [panel.left, panel.top],
            size: [panel.width, panel.height],
            x: panel.x.clone(),
            y: panel.y.clone(),
        });
        panel
    }

    /// Width of the axes in units of the figure: about the number of pixels.
    pub(super) fn columns(&self) -> usize {
        self.width as usize
    }

    fn draw_axes(&mut self, title: &str) {
        let (left, top) = (self.left, self.top);
        let (right, bottom) = (left + self.width, top + self.height);
        let grid = Stroke::solid(GRID, 1.0);
        self.figure.begin(Layer::Ticks);
        // An axis too narrow for a label gets no ticks.
        let x_ticks = if self.width > 40.0 { self.x.ticks(6) } else { Vec::new() };
        for tick in x_ticks {
            let Some(place) = self.x.place(tick.value) else { continue };
            let x = left + place * self.width;
            self.figure.line(vec![[x, top], [x, bottom]], grid);
            self.figure.text([x, bottom + 18.0], tick.label, TEXT_SIZE, INK, Anchor::Middle);
        }
        let mut widest = 0.0f32;
        for tick in self.y.ticks(5) {
            let Some(place) = self.y.place(tick.value) else { continue };
            let y = bottom - place * self.height;
            self.figure.line(vec![[left, y], [right, y]], grid);
            widest = widest.max(font::width(&tick.label, TEXT_SIZE));
            self.figure.text([left - 7.0, y + 5.0], tick.label, TEXT_SIZE, INK, Anchor::End);
        }
        self.figure.begin(Layer::Words);
        let axis = Stroke::solid(INK, 1.2);
        self.figure.line(vec![[left, top], [left, bottom], [right, bottom]], axis);
        let middle = left + 0.5 * self.width;
        self.figure.text([middle, bottom + 40.0], self.x.label.clone(), TEXT_SIZE, INK, Anchor::Middle);
        let beside = (left - f64::from(widest) - 18.0).max(left - LEFT + 13.0);
        self.figure.text_upward([beside, top + 0.5 * self.height], self.y.label.clone(), TEXT_SIZE, INK);
        self.figure.text([left, top - 9.0], title, TEXT_SIZE + 1.0, INK, Anchor::Start);
    }

    pub(super) fn at(&self, [x, y]: Point) -> Option<Point> {
        Some([
            self.left + self.x.place(x)? * self.width,
            self.top + self.height - self.y.place(y)? * self.height,
        ])
    }

    fn inside(&self, [x, y]: Point) -> bool {
        (self.left - 0.5..=self.left + self.width + 0.5).contains(&x)
            && (self.top - 0.5..=self.top + self.height + 0.5).contains(&y)
    }

    /// A line through points; it breaks at points without a position and is clipped at the axes.
    pub(super) fn line(&mut self, points: impl IntoIterator<Item = Point>, stroke: Stroke) {
        self.figure.begin(Layer::Data);
        let mut run: Vec<Point> = Vec::new();
        let mut last: Option<Point> = None;
        for point in points {
            let here = self.at(point);
            if let (Some(a), Some(b)) = (last, here) {
                match self.cut(a, b) {
                    Some((p, q)) => {
                        if run.last() != Some(&p) {
                            self.figure.line(std::mem::take(&mut run), stroke);
                            run.push(p);
                        }
                        run.push(q);
                        self.occupied.push(q);
                    }
                    None => self.figure.line(std::mem::take(&mut run), stroke),
                }
            } else {
                self.figure.line(std::mem::take(&mut run), stroke);
            }
            last = here;
        }
        self.figure.line(run, stroke);
    }

    /// The part of a segment inside the axes (Liang and Barsky).
    fn cut(&self, a: Point, b: Point) -> Option<(Point, Point)> {
        let (mut from, mut to) = (0.0f64, 1.0f64);
        let sides = [
            (a[0] - b[0], a[0] - self.left),
            (b[0] - a[0], self.left + self.width - a[0]),
            (a[1] - b[1], a[1] - self.top),
            (b[1] - a[1], self.top + self.height - a[1]),
        ];
        for (p, q) in sides {
            if p == 0.0 {
                if q < 0.0 {
                    return None;
                }
            } else if p < 0.0 {
                from = from.max(q / p);
            } else {
                to = to.min(q / p);
            }
        }
        if from > to {
            return None;
        }
        let along = |t: f64| match t {
            0.0 => a,
            1.0 => b,
            t => [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])],
        };
        Some((along(from), along(to)))
    }

    /// Dots; those outside the axes are left out.
    pub(super) fn dots(&mut self, points: impl IntoIterator<Item = Point>, radius: f32, color: Color) {
        self.sized_dots(points.into_iter().map(|p| (p, f64::NAN)), radius, color);
    }

    /// Dots with their standard errors, which appear in the values but are not drawn; NaN if unknown.
    pub(super) fn sized_dots(
        &mut self,
        points: impl IntoIterator<Item = (Point, f64)>,
        radius: f32,
        color: Color,
    ) {
        let seen: Vec<(Point, Point, f64)> = points
            .into_iter()
            .filter_map(|(p, error)| Some((self.at(p)?, p, error)))
            .filter(|(place, ..)| self.inside(*place))
            .collect();
        let places: Vec<Point> = seen.iter().map(|(place, ..)| *place).collect();
        let labelled = if seen.len() <= MOST_LABELLED { &seen[..] } else { &[] };
        let notes = labelled.iter().map(|(_, p, error)| self.values(*p, *error)).collect();
        self.occupied.extend_from_slice(&places);
        self.figure.begin(Layer::Data);
        self.figure.dots(places, radius, color, notes);
    }

    /// Values of a point, one line per axis.
    fn values(&self, [x, y]: Point, error: f64) -> String {
        let error = if error.is_finite() && error > 0.0 {
            format!(" ± {}", crate::format::plain(error, 2, ""))
        } else {
            String::new()
        };
        format!("{}\n{}", self.x.describe(x, ""), self.y.describe(y, &error))
    }

    /// Vertical bars from low to high.
    pub(super) fn bars(&mut self, bars: impl IntoIterator<Item = [f64; 3]>, stroke: Stroke) {
        for [x, low, high] in bars {
            self.line([[x, low], [x, high]], stroke);
        }
    }

    /// The area between two curves over the same abscissae.
    pub(super) fn band(&mut self, points: &[[f64; 3]], color: Color) {
        let inside = |v: f64| v.clamp(self.y.low, self.y.high);
        let upper = points.iter().filter_map(|&[x, _, high]| self.at([x, inside(high)]));
        let lower = points.iter().rev().filter_map(|&[x, low, _]| self.at([x, inside(low)]));
        let outline: Vec<Point> = upper.chain(lower).filter(|p| self.inside(*p)).collect();
        self.figure.begin(Layer::Data);
        self.figure.area(outline, color);
    }

    /// A rectangle between two corners, clipped at the axes.
    pub(super) fn patch(&mut self, low: Point, high: Point, color: Color) {
        let inside = |axis: &Axis, v: f64| v.clamp(axis.low, axis.high);
        let cut = |p: Point| [inside(&self.x, p[0]), inside(&self.y, p[1])];
        if let (Some(a), Some(b)) = (self.at(cut(low)), self.at(cut(high))) {
            // Slightly wider, so that no gap shows between neighbours.
            let right = (b[0] + 0.6).min(self.left + self.width);
            let low = (a[1] + 0.6).min(self.top + self.height);
            self.figure.begin(Layer::Data);
            self.figure.rectangle([a[0], b[1]], [right, low], color);
        }
    }

    /// A remark below the top edge, on the left.
    pub(super) fn remark(&mut self, text: &str) {
        self.figure.begin(Layer::Words);
        let at = [self.left + 8.0, self.top + 14.0];
        self.figure.text(at, text, TEXT_SIZE - 2.0, INK.faded(0.7), Anchor::Start);
    }

    /// A note in the middle, where there is nothing to draw.
    pub(super) fn note(&mut self, text: &str) {
        self.figure.begin(Layer::Words);
        let at = [self.left + 0.5 * self.width, self.top + 0.5 * self.height];
        self.figure.text(at, text, TEXT_SIZE, INK.faded(0.7), Anchor::Middle);
    }

    /// The legend, in the corner where it covers the fewest points, on a background that keeps it readable.
    pub(super) fn legend(&mut self, entries: &[(Mark, &str)]) {
        const LINE: f64 = 20.0;
        const MARK: f64 = 28.0;
        let widest = entries.iter().map(|(_, text)| font::width(text, LEGEND_SIZE)).fold(0.0, f32::max);
        let (width, height) = (MARK + 14.0 + f64::from(widest) + 8.0, LINE * entries.len() as f64 + 8.0);
        let (right, bottom) = (self.left + self.width, self.top + self.height);
        let (near, far) = (self.left + 8.0, right - width - 4.0);
        let (high, low) = (self.top + 4.0, bottom - height - 6.0);
        let covered = |[x, y]: Point| {
            let inside = |p: &&Point| (x..x + width).contains(&p[0]) && (y..y + height).contains(&p[1]);
            self.occupied.iter().filter(inside).count()
        };
        let [x, y] = [[far, high], [near, high], [near, low], [far, low]]
            .into_iter()
            .min_by_key(|corner| covered(*corner))
            .unwrap_or([far, high]);
        self.figure.begin(Layer::Words);
        self.figure.rectangle([x, y], [x + width, y + height], Color::new(255, 255, 255).faded(0.85));
        for (i, (mark, text)) in entries.iter().enumerate() {
            let middle = y + 4.0 + LINE * (i as f64 + 0.5);
            let (start, end) = (x + 7.0, x + 7.0 + MARK);
            match mark {
                Mark::Line(stroke) => self.figure.line(vec![[start, middle], [end, middle]], *stroke),
                Mark::Dot(color) => {
                    self.figure.dots(vec![[0.5 * (start + end), middle]], 3.0, *color, Vec::new())
                }
                Mark::Patch(color) => {
                    self.figure.rectangle([start, middle - 5.0], [end, middle + 5.0], *color)
                }
            }
            self.figure.text([end + 7.0, middle + 4.8], *text, LEGEND_SIZE, INK, Anchor::Start);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::figure::Shape;
    use super::*;

    #[test]
    fn lines_end_at_the_axes() {
        let mut figure = Figure::new(500.0, 400.0);
        let (x, y) = (Axis::linear(0.0, 1.0, ""), Axis::linear(0.0, 1.0, ""));
        let mut panel = Panel::new(&mut figure, "", x, y);
        let drawn = panel.figure.shapes.len();
        panel.line(
            [[-1.0, 0.5], [2.0, 0.5], [0.5, f64::NAN], [0.2, 5.0], [0.4, 6.0]],
            Stroke::solid(INK, 1.0),
        );
        let lines: Vec<&Shape> = panel.figure.shapes[drawn..].iter().collect();
        let [Shape::Line { points, .. }] = lines.as_slice() else { panic!("{lines:?}") };
        assert_eq!(points.first().map(|p| p[0]), Some(LEFT));
        assert_eq!(points.last().map(|p| p[0]), Some(500.0 - RIGHT));
    }
}
