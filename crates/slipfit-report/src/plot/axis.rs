//! Axes: ranges, ticks, labels, and the position of a value.

/// One axis: its range in displayed units, and its label.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) log: bool,
    pub(super) label: String,
    /// Names at 1, 2, 3, … in place of numbers.
    pub(super) names: Vec<String>,
    /// Ticks are labelled with numbers although there are names.
    pub(super) hidden: bool,
}

/// A tick and its label.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub(super) value: f64,
    pub(super) label: String,
}

impl Axis {
    /// A linear axis; an empty or non-finite range is replaced by a usable one.
    pub(super) fn linear(low: f64, high: f64, label: impl Into<String>) -> Self {
        let (low, high) = if low.is_finite() && high.is_finite() && high > low {
            (low, high)
        } else if low.is_finite() {
            (low - 0.5 * low.abs().max(1.0), low + 0.5 * low.abs().max(1.0))
        } else {
            (0.0, 1.0)
        };
        Self { low, high, log: false, label: label.into(), names: Vec::new(), hidden: false }
    }

    /// A logarithmic axis; unless `low` and `high` are above zero and in order, a decade around one.
    pub(super) fn log(low: f64, high: f64, label: impl Into<String>) -> Self {
        let usable = low > 0.0 && high > low && high.is_finite();
        let (low, high) = if usable { (low, high) } else { (0.3, 3.0) };
        Self { low, high, log: true, label: label.into(), names: Vec::new(), hidden: false }
    }

    /// An axis of names, the first at 1.
    pub(super) fn named(names: Vec<String>, label: impl Into<String>) -> Self {
        let high = names.len() as f64 + 0.5;
        Self { low: 0.5, high: high.max(1.5), log: false, label: label.into(), names, hidden: false }
    }

    /// Names at 1, 2, 3, … that appear only in the values of the dots, because they may be many and long.
    pub(super) fn numbered(names: Vec<String>, label: impl Into<String>) -> Self {
        Self { hidden: true, ..Self::named(names, label) }
    }

    /// Position of a value, 0 at the low end and 1 at the high end; `None` if it has none.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        let place = if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        place.is_finite().then_some(place)
    }

    /// A value in words, to the resolution of the axis: `amplitude 12.3 mrad`; `error` goes between number and
    /// unit.
    pub(super) fn describe(&self, value: f64, error: &str) -> String {
        let (name, unit) = match self.label.rsplit_once(" [") {
            Some((name, unit)) => (name, unit.trim_end_matches(']')),
            None => (self.label.as_str(), ""),
        };
        let named = (value.round() as usize).checked_sub(1).and_then(|i| self.names.get(i));
        let number = match named {
            Some(name) => name.clone(),
            None if self.log => crate::format::plain(value, 4, ""),
            None => {
                let finest = (self.high - self.low) / 5e3;
                let decimals = (-finest.log10().floor()).clamp(0.0, 12.0) as usize;
                minus(format!("{value:.decimals$}"))
            }
        };
        // An operator before the number would look like its sign.
        let name = if name.contains(['−', '/']) { format!("{name}:") } else { name.to_owned() };
        format!("{name} {number}{error} {unit}").trim().to_owned()
    }

    /// Ticks inside the range, about `wanted` of them on a linear axis.
    pub(super) fn ticks(&self, wanted: usize) -> Vec<Tick> {
        if self.hidden {
            let whole = |t: &Tick| t.value >= 1.0 && (t.value - t.value.round()).abs() < 1e-6;
            return self.linear_ticks(wanted).into_iter().filter(whole).collect();
        }
        if !self.names.is_empty() {
            let named = self.names.iter().enumerate();
            return named.map(|(i, name)| Tick { value: i as f64 + 1.0, label: name.clone() }).collect();
        }
        if self.log { self.log_ticks() } else { self.linear_ticks(wanted) }
    }

    fn linear_ticks(&self, wanted: usize) -> Vec<Tick> {
        let raw = (self.high - self.low) / wanted.max(1) as f64;
        let decade = 10f64.powf(raw.log10().floor());
        let step =
            [1.0, 2.0, 5.0, 10.0].map(|s| s * decade).into_iter().find(|s| *s >= raw * 0.999).unwrap_or(raw);
        let first = (self.low / step - 1e-6).ceil();
        let decimals = (-(step.log10() + 1e-9).floor()).clamp(0.0, 12.0) as usize;
        (0..=2 * wanted)
            .map(|i| (first + i as f64) * step)
            .take_while(|v| *v <= self.high + 1e-6 * step)
            .map(|value| {
                // -0 becomes 0.
                let value = if value.abs() < 1e-9 * step { 0.0 } else { value };
                Tick { value, label: minus(format!("{value:.decimals$}")) }
            })
            .collect()
    }

    fn log_ticks(&self) -> Vec<Tick> {
        let decades = (self.high / self.low).log10();
        let mantissas: &[f64] = match decades {
            d if d < 0.4 => &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
            d if d < 1.0 => &[1.0, 2.0, 3.0, 4.0, 5.0, 7.0],
            d if d < 2.6 => &[1.0, 2.0, 5.0],
            _ => &[1.0],
        };
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let stride = ((last - first) / 8).max(1) as usize;
        // Powers of ten are written with exponents, so that no zeros have to be counted.
        let powers = mantissas.len() == 1 && (self.high >= 9e3 || self.low <= 1.1e-4);
        (first..=last)
            .step_by(stride)
            .flat_map(|e| mantissas.iter().map(move |m| (m * 10f64.powi(e), e)))
            .filter(|(v, _)| (self.low * 0.999..=self.high * 1.001).contains(v))
            .map(|(value, e)| {
                if powers {
                    return Tick { value, label: power_of_ten(e) };
                }
                let decimals = (1 - e).clamp(0, 6) as usize;
                let text = format!("{value:.decimals$}");
                let text =
                    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
                Tick { value, label: text.to_owned() }
            })
            .collect()
    }
}

fn power_of_ten(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    match exponent {
        0 => "1".to_owned(),
        1 => "10".to_owned(),
        _ => {
            let raised = |c: char| c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize]);
            format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
        }
    }
}

/// With the typographic minus sign, which is as wide as a plus sign.
pub(super) fn minus(text: String) -> String {
    match text.strip_prefix('-') {
        Some(rest) => format!("\u{2212}{rest}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks(5).into_iter().map(|t| t.label).collect()
    }

    #[test]
    fn linear_ticks_are_round_and_inside() {
        assert_eq!(labels(&Axis::linear(0.0, 10.0, "")), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels(&Axis::linear(-0.31, 0.29, "")), ["−0.2", "0.0", "0.2"]);
        assert_eq!(labels(&Axis::linear(28.0, 80.0, "")), ["40", "60", "80"]);
    }

    #[test]
    fn log_ticks_thicken_where_the_range_is_short() {
        assert_eq!(labels(&Axis::log(0.9, 1200.0, "")), ["1", "10", "100", "1000"]);
        assert_eq!(labels(&Axis::log(0.02, 0.6, "")), ["0.02", "0.05", "0.1", "0.2", "0.5"]);
        assert_eq!(labels(&Axis::log(2.2, 6.0, "")), ["3", "4", "5"]);
        assert_eq!(labels(&Axis::log(1.0, 1e4, "")), ["1", "10", "10²", "10³", "10⁴"]);
        assert_eq!(labels(&Axis::log(1e-5, 1e-1, "")), ["10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹"]);
    }

    #[test]
    fn unusable_ranges_still_make_an_axis() {
        for axis in [
            Axis::linear(f64::NAN, 1.0, ""),
            Axis::linear(2.0, 2.0, ""),
            Axis::linear(0.0, f64::INFINITY, ""),
            Axis::log(0.0, 1.0, ""),
            Axis::log(5.0, 5.0, ""),
        ] {
            assert!(axis.high > axis.low, "{axis:?}");
            assert!(axis.place(axis.low) == Some(0.0), "{axis:?}");
            assert!(!axis.ticks(5).is_empty(), "{axis:?}");
        }
        assert_eq!(Axis::log(0.1, 1.0, "").place(-1.0), None);
    }
}
