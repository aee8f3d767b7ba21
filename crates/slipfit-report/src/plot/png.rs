//! PNG, drawn at twice the size for print and high-resolution screens.

use super::figure::{Anchor, Color, Figure, Point, Shape, Stroke};
use super::font::{self, Segment};
use tiny_skia::{FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, StrokeDash, Transform};

const SCALE: f32 = 2.0;

/// `None` if the picture does not fit into memory.
pub(super) fn render(figure: &Figure) -> Option<Vec<u8>> {
    let size = |length: f64| (length as f32 * SCALE).ceil() as u32;
    let mut pixels = Pixmap::new(size(figure.width), size(figure.height))?;
    pixels.fill(tiny_skia::Color::WHITE);
    let page = Transform::from_scale(SCALE, SCALE);
    for shape in &figure.shapes {
        draw(&mut pixels, shape, page);
    }
    encode(pixels).ok()
}

fn encode(pixels: Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let program = concat!("slipfit ", env!("CARGO_PKG_VERSION"));
    encoder.add_text_chunk("Software".to_owned(), program.to_owned())?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels.take_demultiplied())?;
    writer.finish()?;
    Ok(bytes)
}

fn draw(pixels: &mut Pixmap, shape: &Shape, page: Transform) {
    match shape {
        Shape::Line { points, stroke } => {
            if let Some(path) = path(points, false) {
                pixels.stroke_path(&path, &paint(stroke.color), &pen(stroke), page, None);
            }
        }
        Shape::Area { points, color } => {
            if let Some(path) = path(points, true) {
                pixels.fill_path(&path, &paint(*color), FillRule::Winding, page, None);
            }
        }
        Shape::Dots { points, radius, color, .. } => {
            let paint = paint(*color);
            for &[x, y] in points {
                if let Some(dot) = PathBuilder::from_circle(x as f32, y as f32, *radius) {
                    pixels.fill_path(&dot, &paint, FillRule::Winding, page, None);
                }
            }
        }
        Shape::Text { at, text, size, color, anchor, upward } => {
            let width = font::width(text, *size);
            let shift = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => -0.5 * width,
                Anchor::End => -width,
            };
            let turn = if *upward { -90.0 } else { 0.0 };
            let place = page
                .pre_translate(at[0] as f32, at[1] as f32)
                .pre_concat(Transform::from_rotate(turn))
                .pre_translate(shift, 0.0);
            if let Some(path) = letters(text, *size) {
                pixels.fill_path(&path, &paint(*color), FillRule::Winding, place, None);
            }
        }
    }
}

fn paint(color: Color) -> Paint<'static> {
    let [r, g, b] = color.rgb;
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, (color.opacity * 255.0).round() as u8);
    paint.anti_alias = true;
    paint
}

fn pen(stroke: &Stroke) -> tiny_skia::Stroke {
    tiny_skia::Stroke {
        width: stroke.width,
        line_cap: LineCap::Butt,
        line_join: LineJoin::Round,
        dash: stroke.dash.and_then(|d| StrokeDash::new(d.to_vec(), 0.0)),
        ..tiny_skia::Stroke::default()
    }
}

fn path(points: &[Point], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::with_capacity(points.len() + 1, points.len());
    for (i, &[x, y]) in points.iter().enumerate() {
        match i {
            0 => path.move_to(x as f32, y as f32),
            _ => path.line_to(x as f32, y as f32),
        }
    }
    if closed {
        path.close();
    }
    path.finish()
}

fn letters(text: &str, size: f32) -> Option<Path> {
    let mut path = PathBuilder::new();
    font::outline(text, size, |segment| match segment {
        Segment::Move(p) => path.move_to(p.x, -p.y),
        Segment::Line(p) => path.line_to(p.x, -p.y),
        Segment::Quad(c, p) => path.quad_to(c.x, -c.y, p.x, -p.y),
        Segment::Cubic(c, d, p) => path.cubic_to(c.x, -c.y, d.x, -d.y, p.x, -p.y),
        Segment::Close => path.close(),
    });
    path.finish()
}
