//! The same pictures on a dark background.

use super::figure::Color;
use std::fmt::Write as _;

/// Background of a dark page, as in its style sheet.
#[cfg(test)]
const DARK_BACKGROUND: Color = Color::new(0x0f, 0x13, 0x18);

/// Colours of pictures and their replacements on dark pages; all others are used on both.
const DARK: [(Color, Color); 13] = [
    // Ink, grid and background of legends.
    (Color::new(0x22, 0x22, 0x22), Color::new(0xe3, 0xe6, 0xea)),
    (Color::new(0xe4, 0xe6, 0xe9), Color::new(0x2c, 0x33, 0x3b)),
    (Color::new(0xff, 0xff, 0xff), Color::new(0x0f, 0x13, 0x18)),
    // Data, left-out data, points.
    (Color::new(0x8f, 0xb4, 0xd0), Color::new(0x4f, 0x7d, 0xa3)),
    (Color::new(0xcf, 0xd3, 0xd8), Color::new(0x4a, 0x52, 0x5b)),
    (Color::new(0x55, 0x5b, 0x63), Color::new(0xb4, 0xbc, 0xc6)),
    (Color::new(0x33, 0x66, 0x99), Color::new(0x86, 0xb6, 0xe6)),
    (Color::new(0xa9, 0xb0, 0xb8), Color::new(0x76, 0x80, 0x8b)),
    // Okabe and Ito's blue, vermilion, green, purple.
    (Color::new(0x00, 0x72, 0xb2), Color::new(0x58, 0xa6, 0xe6)),
    (Color::new(0xd5, 0x5e, 0x00), Color::new(0xff, 0x8a, 0x3d)),
    (Color::new(0x00, 0x9e, 0x73), Color::new(0x2f, 0xc7, 0x9a)),
    (Color::new(0xcc, 0x79, 0xa7), Color::new(0xe0, 0x98, 0xc0)),
    (Color::new(0x8a, 0x92, 0x9c), Color::new(0x9a, 0xa4, 0xaf)),
];

/// Style rules that convert the colours of inline pictures for a dark screen. Any style rule overrides attributes
/// of SVG.
pub fn dark_rules() -> String {
    let mut rules = String::from("@media screen and (prefers-color-scheme: dark) {\n");
    for (light, dark) in DARK {
        let (light, dark) = (hex(light), hex(dark));
        for what in ["fill", "stroke"] {
            let _ = writeln!(rules, "  figure svg [{what}=\"{light}\"] {{ {what}: {dark}; }}");
        }
    }
    rules.push_str("}\n");
    rules
}

fn hex(color: Color) -> String {
    let [r, g, b] = color.rgb;
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::super::figure::Shape;
    use super::*;

    /// Relative luminance and contrast as the Web Content Accessibility Guidelines define them.
    fn contrast(a: Color, b: Color) -> f64 {
        let luminance = |c: Color| {
            let linear = c.rgb.map(|v| {
                let v = f64::from(v) / 255.0;
                if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
            });
            0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
        };
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    fn dark_color(color: Color) -> Color {
        DARK.iter().find(|(light, _)| light.rgb == color.rgb).map_or(color, |(_, dark)| *dark)
    }

    #[test]
    fn text_and_dots_are_legible_on_both_grounds() {
        let white = Color::new(0xff, 0xff, 0xff);
        crate::example::by_hand(
            |_| (),
            |analysed| {
                let mut seen = 0;
                for shape in super::super::ringdown::panels(analysed).iter().flat_map(|f| &f.shapes) {
                    let (color, least) = match shape {
                        Shape::Text { color, .. } => (*color, 7.0),
                        // Left-out data are faint on purpose.
                        Shape::Dots { color, .. } if color.rgb != [0xcf, 0xd3, 0xd8] => (*color, 3.0),
                        _ => continue,
                    };
                    seen += 1;
                    assert!(contrast(color, white) >= least, "{color:?}");
                    assert!(contrast(dark_color(color), DARK_BACKGROUND) >= least, "{color:?}");
                }
                assert!(seen > 40, "{seen}");
            },
        );
    }

    #[test]
    fn the_ground_is_the_style_sheets() {
        assert!(include_str!("../page/style.css").contains(&format!("--ground: {}", hex(DARK_BACKGROUND))));
    }
}
