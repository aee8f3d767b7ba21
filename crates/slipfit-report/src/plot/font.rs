//! The typeface, embedded so that a picture needs no installed font.
#![cfg_attr(not(feature = "png"), allow(dead_code, reason = "only PNG draws outlines"))]

use ab_glyph::{Font as _, FontRef, OutlineCurve, Point, ScaleFont as _};
use std::sync::LazyLock;

/// DejaVu Sans, reduced to Latin, Greek, Cyrillic and mathematical signs; its licence is in the same folder.
static FONT: LazyLock<FontRef<'static>> = LazyLock::new(|| {
    FontRef::try_from_slice(include_bytes!("../../fonts/DejaVuSans-subset.ttf"))
        .expect("the typeface built in is a whole one: a test loads it")
});

/// Width of a line of text, in the units of `size`.
pub(super) fn width(text: &str, size: f32) -> f32 {
    let font = FONT.as_scaled(em(size));
    text.chars().map(|c| font.h_advance(font.glyph_id(c))).sum()
}

/// A part of a glyph's outline, y upwards from the base line.
pub(super) enum Segment {
    Move(Point),
    Line(Point),
    Quad(Point, Point),
    Cubic(Point, Point, Point),
    Close,
}

/// Outlines of a line of text that starts at the origin.
pub(super) fn outline(text: &str, size: f32, mut draw: impl FnMut(Segment)) {
    let font = FONT.as_scaled(em(size));
    let unit = em(size) / FONT.height_unscaled();
    let mut x = 0.0;
    for c in text.chars() {
        let id = font.glyph_id(c);
        if let Some(glyph) = FONT.outline(id) {
            let at = |p: Point| Point { x: x + p.x * unit, y: p.y * unit };
            let mut last: Option<Point> = None;
            for curve in glyph.curves {
                let (first, end) = ends(&curve);
                if last != Some(first) {
                    if last.is_some() {
                        draw(Segment::Close);
                    }
                    draw(Segment::Move(at(first)));
                }
                draw(match curve {
                    OutlineCurve::Line(_, p) => Segment::Line(at(p)),
                    OutlineCurve::Quad(_, c, p) => Segment::Quad(at(c), at(p)),
                    OutlineCurve::Cubic(_, c, d, p) => Segment::Cubic(at(c), at(d), at(p)),
                });
                last = Some(end);
            }
            if last.is_some() {
                draw(Segment::Close);
            }
        }
        x += font.h_advance(id);
    }
}

/// The crate scales by the full height of a line; type sizes are given in ems.
fn em(size: f32) -> f32 {
    size * FONT.height_unscaled() / FONT.units_per_em().unwrap_or(2048.0)
}

fn ends(curve: &OutlineCurve) -> (Point, Point) {
    match *curve {
        OutlineCurve::Line(a, b) | OutlineCurve::Quad(a, _, b) | OutlineCurve::Cubic(a, _, _, b) => (a, b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sign_in_use_has_a_glyph() {
        for c in "Aaä0.,±×−⁻⁰¹²³⁴⁵⁶⁷⁸⁹₀₂δγτµσ≤∞ΔΩ°·Ж".chars() {
            assert_ne!(FONT.glyph_id(c).0, 0, "{c}");
        }
    }

    #[test]
    fn an_em_is_the_size() {
        // The em dash is one em wide in this typeface.
        assert!((width("—", 100.0) - 100.0).abs() < 0.5);
        let mut top = 0.0f32;
        outline("H", 100.0, |s| {
            if let Segment::Move(p) | Segment::Line(p) = s {
                top = top.max(p.y);
            }
        });
        assert!((top - 73.0).abs() < 1.0, "cap height {top}");
    }
}
