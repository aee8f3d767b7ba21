//! A picture as a list of shapes, the same for every file format.

use super::axis::Axis;
use super::font;
use crate::text::words;

/// An opaque or translucent colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Color {
    pub(super) rgb: [u8; 3],
    pub(super) opacity: f32,
}

impl Color {
    pub(super) const fn new(r: u8, g: u8, b: u8) -> Self {
        Self { rgb: [r, g, b], opacity: 1.0 }
    }

    pub(super) const fn faded(self, opacity: f32) -> Self {
        Self { opacity, ..self }
    }
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stroke {
    pub(super) color: Color,
    pub(super) width: f32,
    pub(super) dash: Option<[f32; 2]>,
}

impl Stroke {
    pub(super) const fn solid(color: Color, width: f32) -> Self {
        Self { color, width, dash: None }
    }

    pub(super) const fn dashed(color: Color, width: f32) -> Self {
        Self { color, width, dash: Some([7.0, 5.0]) }
    }
}

/// Which point of a text lies at its coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// Coordinates in the units of the picture's `width` and `height`, y downwards.
pub(super) type Point = [f64; 2];

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    Line {
        points: Vec<Point>,
        stroke: Stroke,
    },
    Area {
        points: Vec<Point>,
        color: Color,
    },
    Dots {
        points: Vec<Point>,
        radius: f32,
        color: Color,
        /// Meaning of each dot, shown if the format allows it; empty, or one per point.
        notes: Vec<String>,
    },
    /// `at` lies on the base line; `upward` turns the text by a quarter turn to the left.
    Text {
        at: Point,
        text: String,
        size: f32,
        color: Color,
        anchor: Anchor,
        upward: bool,
    },
}

/// Position of a set of axes, and the values mapped to it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Frame {
    pub(super) corner: Point,
    pub(super) size: Point,
    pub(super) x: Axis,
    pub(super) y: Axis,
}

/// What shapes belong to, for a page that zooms into a part of the axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Layer {
    /// Grid and numbers along the axes.
    Ticks,
    /// Contents of the axes, placed by their values.
    Data,
    /// Titles, labels, legends: they stay in place.
    Words,
}

/// The shapes in the order they are painted.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Figure {
    pub(super) width: f64,
    pub(super) height: f64,
    /// Description in words, for readers who cannot see the picture.
    pub(super) title: String,
    pub(super) shapes: Vec<Shape>,
    pub(super) frames: Vec<Frame>,
    /// Index of the first shape of each layer; shapes before the first layer are words.
    pub(super) layers: Vec<(usize, Layer)>,
}

impl Figure {
    pub(super) fn new(width: f64, height: f64) -> Self {
        let (shapes, frames, layers) = (Vec::new(), Vec::new(), Vec::new());
        Self { width, height, title: String::new(), shapes, frames, layers }
    }

    /// The shapes that follow belong to this layer.
    pub(super) fn begin(&mut self, layer: Layer) {
        if self.layers.last().is_none_or(|(_, last)| *last != layer) {
            self.layers.push((self.shapes.len(), layer));
        }
    }

    pub(super) fn line(&mut self, points: Vec<Point>, stroke: Stroke) {
        if points.len() > 1 {
            self.shapes.push(Shape::Line { points, stroke });
        }
    }

    pub(super) fn area(&mut self, points: Vec<Point>, color: Color) {
        if points.len() > 2 {
            self.shapes.push(Shape::Area { points, color });
        }
    }

    pub(super) fn rectangle(&mut self, [left, top]: Point, [right, bottom]: Point, color: Color) {
        self.area(vec![[left, top], [right, top], [right, bottom], [left, bottom]], color);
    }

    pub(super) fn dots(&mut self, points: Vec<Point>, radius: f32, color: Color, notes: Vec<String>) {
        if !points.is_empty() {
            self.shapes.push(Shape::Dots { points, radius, color, notes });
        }
    }

    /// Puts another picture into this one, its upper left corner at `corner`.
    pub(super) fn place(&mut self, corner: Point, other: Self) {
        let moved = |p: &mut Point| *p = [p[0] + corner[0], p[1] + corner[1]];
        for mut shape in other.shapes {
            match &mut shape {
                Shape::Line { points, .. } | Shape::Area { points, .. } | Shape::Dots { points, .. } => {
                    points.iter_mut().for_each(moved)
                }
                Shape::Text { at, .. } => moved(at),
            }
            self.shapes.push(shape);
        }
        for mut frame in other.frames {
            moved(&mut frame.corner);
            self.frames.push(frame);
        }
    }

    pub(super) fn text(
        &mut self,
        at: Point,
        text: impl Into<String>,
        size: f32,
        color: Color,
        anchor: Anchor,
    ) {
        self.shapes.push(Shape::Text { at, text: text.into(), size, color, anchor, upward: false });
    }

    pub(super) fn text_upward(&mut self, at: Point, text: impl Into<String>, size: f32, color: Color) {
        let anchor = Anchor::Middle;
        self.shapes.push(Shape::Text { at, text: text.into(), size, color, anchor, upward: true });
    }
}

/// Breaks text between words so that no line is wider than `width`.
pub(super) fn wrap(text: &str, size: f32, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words(text) {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match (lines.last_mut(), longer) {
            (Some(line), Some(longer)) if f64::from(font::width(&longer, size)) <= width => *line = longer,
            _ => lines.push(word),
        }
    }
    lines
}
