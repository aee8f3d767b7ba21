//! SVG: text remains text, in the viewer's sans-serif font.

use super::axis::Axis;
use super::figure::{Anchor, Color, Figure, Layer, Point, Shape, Stroke};
use crate::escape::html as escape;
use std::fmt::Write as _;

const FAMILY: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";

pub(super) fn render(figure: &Figure) -> Vec<u8> {
    let (w, h) = (figure.width, figure.height);
    let version = env!("CARGO_PKG_VERSION");
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
         font-family=\"{FAMILY}\">\n<!-- slipfit {version} -->\n<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n"
    );
    write_shapes(&mut svg, &figure.shapes);
    svg.push_str("</svg>\n");
    svg.into_bytes()
}

/// For an HTML page: as wide as the space available, on the background of the page. The positions of the axes are
/// included, so that a script can show the values under the pointer.
pub(super) fn inline(figure: &Figure) -> String {
    let (w, h) = (figure.width, figure.height);
    let title = escape(&figure.title);
    let mut svg = format!(
        "<svg viewBox=\"0 0 {w} {h}\" role=\"img\" aria-label=\"{title}\" font-family=\"{FAMILY}\">\n"
    );
    for frame in &figure.frames {
        let ([left, top], [width, height]) = (frame.corner, frame.size);
        let axis = |axis: &Axis| {
            // Names that replace numbers are in the values of the dots.
            let kind = if !axis.names.is_empty() {
                "names"
            } else if axis.log {
                "log"
            } else {
                "linear"
            };
            format!("{kind};{};{};{}", axis.low, axis.high, escape(&axis.label))
        };
        let _ = writeln!(
            svg,
            "<rect class=\"frame\" x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"none\" \
             data-x=\"{}\" data-y=\"{}\"/>",
            axis(&frame.x),
            axis(&frame.y)
        );
    }
    write_layers(&mut svg, figure);
    svg.push_str("</svg>\n");
    svg
}

/// Writes the shapes in groups by layer.
fn write_layers(svg: &mut String, figure: &Figure) {
    let ends = figure.layers.iter().skip(1).map(|(begin, _)| *begin).chain([figure.shapes.len()]);
    let first = figure.layers.first().map_or(figure.shapes.len(), |(begin, _)| *begin);
    write_shapes(svg, &figure.shapes[..first]);
    for ((begin, layer), end) in figure.layers.iter().zip(ends) {
        let class = match layer {
            Layer::Ticks => "ticks",
            Layer::Data => "data",
            Layer::Words => "words",
        };
        svg.push_str(&format!("<g class=\"{class}\">\n"));
        write_shapes(svg, &figure.shapes[*begin..end]);
        svg.push_str("</g>\n");
    }
}

fn write_shapes(svg: &mut String, shapes: &[Shape]) {
    for shape in shapes {
        // Writing to a String cannot fail.
        let _ = write_shape(svg, shape);
    }
}

fn write_shape(svg: &mut String, shape: &Shape) -> std::fmt::Result {
    match shape {
        Shape::Line { points, stroke } => {
            svg.push_str("<path fill=\"none\" stroke-linejoin=\"round\" d=\"");
            write_path(svg, points)?;
            write_stroke(svg, stroke)?;
            svg.push_str("/>\n");
        }
        Shape::Area { points, color } => {
            svg.push_str("<path d=\"");
            write_path(svg, points)?;
            svg.push_str("Z\"");
            write_color(svg, "fill", *color)?;
            svg.push_str("/>\n");
        }
        Shape::Dots { points, radius, color, notes } => {
            svg.push_str("<g");
            write_color(svg, "fill", *color)?;
            svg.push_str(">\n");
            for (i, [x, y]) in points.iter().enumerate() {
                write!(svg, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\"")?;
                match notes.get(i) {
                    Some(note) => writeln!(svg, "><title>{}</title></circle>", escape(note))?,
                    None => svg.push_str("/>\n"),
                }
            }
            svg.push_str("</g>\n");
        }
        Shape::Text { at: [x, y], text, size, color, anchor, upward } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            write!(svg, "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size}\" text-anchor=\"{anchor}\"")?;
            write_color(svg, "fill", *color)?;
            if *upward {
                write!(svg, " transform=\"rotate(-90 {x:.2} {y:.2})\"")?;
            }
            writeln!(svg, ">{}</text>", escape(text))?;
        }
    }
    Ok(())
}

fn write_path(svg: &mut String, points: &[Point]) -> std::fmt::Result {
    for (i, [x, y]) in points.iter().enumerate() {
        write!(svg, "{}{x:.2} {y:.2}", if i == 0 { 'M' } else { 'L' })?;
    }
    Ok(())
}

fn write_stroke(svg: &mut String, stroke: &Stroke) -> std::fmt::Result {
    svg.push('"');
    write_color(svg, "stroke", stroke.color)?;
    write!(svg, " stroke-width=\"{}\"", stroke.width)?;
    if let Some([on, off]) = stroke.dash {
        write!(svg, " stroke-dasharray=\"{on} {off}\"")?;
    }
    Ok(())
}

fn write_color(svg: &mut String, what: &str, color: Color) -> std::fmt::Result {
    let [r, g, b] = color.rgb;
    write!(svg, " {what}=\"#{r:02x}{g:02x}{b:02x}\"")?;
    if color.opacity < 1.0 {
        write!(svg, " {what}-opacity=\"{}\"", color.opacity)?;
    }
    Ok(())
}
