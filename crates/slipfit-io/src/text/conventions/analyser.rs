//! Spectrum analysers of Keysight and Siglent: lines of names and values, then
//! the trace. At zero span its first column is time, or there is none and the
//! sweep time spaces the points.

use super::{Convention, Layout, Look};
use crate::columns::names::Name;

pub(super) struct Analyser;

/// A number with a unit of time or frequency, such as `100 ms`, in s or Hz.
fn quantity(text: &str) -> Option<f64> {
    let text = text.trim();
    let end = text.find(|c: char| c.is_alphabetic() && !matches!(c, 'e' | 'E')).unwrap_or(text.len());
    let number: f64 = text[..end].trim().parse().ok()?;
    let factor = match text[end..].trim().to_lowercase().as_str() {
        "" | "s" | "hz" => 1.0,
        "ms" => 1e-3,
        "us" | "\u{b5}s" => 1e-6,
        "khz" => 1e3,
        "mhz" => 1e6,
        "ghz" => 1e9,
        _ => return None,
    };
    Some(number * factor).filter(|v| v.is_finite())
}

impl Convention for Analyser {
    fn name(&self) -> &'static str {
        "a spectrum analyser"
    }

    fn fits(&self, look: &Look) -> bool {
        let sweep = look.says("sweep time") || look.says("swptime");
        sweep && (look.says("span") || look.says("start freq") || look.says("rbw") || look.says("dbm"))
    }

    fn adjust(&self, look: &Look, layout: &mut Layout) {
        let of = |name: &str| look.value(name).and_then(quantity);
        let sweep_s = of("sweep time").or_else(|| of("swptime"));
        let span = of("span").or_else(|| Some(of("stop freq")? - of("start freq")?));
        let zero_span =
            span == Some(0.0) || look.value("x axis unit").is_some_and(|u| u.eq_ignore_ascii_case("s"));
        let unit = look.value("y axis unit").or_else(|| look.value("yunit")).map(str::to_owned);
        let unit = unit.or_else(|| look.says("dbm").then(|| "dBm".to_owned())).unwrap_or_default();
        let points = of("number of points").or_else(|| of("points")).or_else(|| of("sweep points"));
        let trace = Name::parse(&format!("Power ({unit})"));
        let names = &mut layout.head.names;
        let unnamed = |n: &Name| n.unit.is_empty();
        match names.len() {
            1 if zero_span => {
                names[0] = trace;
                match (sweep_s, points) {
                    (Some(sweep_s), Some(points)) if sweep_s > 0.0 && points > 1.0 => {
                        layout.head.rate_hz = Some((points - 1.0) / sweep_s);
                        layout.head.notes.push(format!(
                            "zero span: the {points} points were spaced evenly over the sweep time of {sweep_s} s"
                        ));
                    }
                    _ => {
                        layout.head.notes.push("the sweep time or the number of points is missing".to_owned())
                    }
                }
            }
            n if n >= 2 => {
                if unnamed(&names[0]) {
                    names[0] = Name::parse(if zero_span { "Time (s)" } else { "Frequency (Hz)" });
                }
                for (i, name) in names.iter_mut().enumerate().skip(1).filter(|(_, n)| unnamed(n)) {
                    *name = if i == 1 { trace.clone() } else { Name::parse(&format!("Trace {i} ({unit})")) };
                }
                if zero_span {
                    layout
                        .head
                        .notes
                        .push("zero span: the first column was taken as time in seconds".to_owned());
                }
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_carry_their_prefix() {
        for (text, value) in [("0.1", 0.1), ("100 ms", 0.1), ("1e9", 1e9), ("2.4GHz", 2.4e9), ("0 Hz", 0.0)] {
            assert_eq!(quantity(text), Some(value), "{text}");
        }
        assert_eq!(quantity("10 dB"), None);
    }
}
