//! Parameters as people read them, the same on a screen, on a page and in a table.

use super::WIDTH;
use super::table::{Align, columns};
use crate::format::{Rounded, Scale, plain};
use slipfit::{Parameter, Quantity};

/// An interval this much longer on one side than on the other is printed on the screen.
const ASYMMETRY: f64 = 1.15;

/// One parameter in words and digits.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Told {
    pub(crate) words: String,
    pub(crate) symbol: &'static str,
    pub(crate) value: String,
    /// Digits of the standard error; empty without one.
    pub(crate) uncertainty: String,
    /// With its prefix or power of ten.
    pub(crate) unit: String,
    /// Standard error in per cent; empty where it says nothing.
    pub(crate) relative: String,
    /// Both ends of the 95 % interval, in `unit`; empty without one.
    pub(crate) interval: String,
    /// Whether value and uncertainty alone would mislead.
    lopsided: bool,
    /// The model reported has no such term: `value` is how large it could be.
    pub(crate) absent: bool,
}

impl Told {
    pub(crate) fn new(parameter: Parameter, q: &Quantity) -> Self {
        let (words, symbol) = (parameter.label().to_owned(), parameter.symbol());
        let shown = Rounded::new(q.value, q.std_error, &q.unit);
        let [low, high] = q.interval_95;
        let interval = if low.is_finite() || high.is_finite() {
            format!("{} to {}", shown.also(low), shown.also(high))
        } else {
            String::new()
        };
        Self {
            words,
            symbol,
            value: shown.value(),
            uncertainty: shown.uncertainty().unwrap_or_default(),
            unit: shown.scale.unit.clone(),
            relative: relative(q),
            lopsided: !interval.is_empty() && is_lopsided(q),
            interval,
            absent: false,
        }
    }

    /// A term the model does not have: how large it could be.
    pub(crate) fn absent(parameter: Parameter, q: &Quantity) -> Self {
        let (words, symbol) = (parameter.label().to_owned(), parameter.symbol());
        let high = q.interval_95[1];
        let (value, unit) = if high.is_finite() && high > 0.0 {
            let scale = Scale::for_size(high, &q.unit);
            (format!("< {}", significant(high * scale.factor, 2)), scale.unit)
        } else {
            ("-".to_owned(), String::new())
        };
        Self {
            words,
            symbol,
            value,
            uncertainty: String::new(),
            unit,
            relative: String::new(),
            interval: String::new(),
            lopsided: false,
            absent: true,
        }
    }

    /// Cells for the screen.
    fn row(&self) -> Vec<String> {
        let uncertainty = match self.uncertainty.as_str() {
            "" => String::new(),
            digits => format!("± {digits}"),
        };
        let value = self.value.clone();
        vec![self.words.clone(), self.symbol.to_owned(), value, uncertainty, self.unit.clone()]
    }

    /// What stands behind the cells, and what may stand below them.
    fn note(&self) -> [String; 2] {
        let relative = format!("{:>8}", self.relative).trim_end().to_owned();
        match (self.absent, self.lopsided) {
            (true, _) if self.value == "-" => [String::new(), "not in model".to_owned()],
            (true, _) => [String::new(), "95 %, not in model".to_owned()],
            (_, true) => [relative, format!("95 %: {}", self.interval)],
            _ => [relative, String::new()],
        }
    }
}

/// Parameters on the screen, a line each; an interval goes below where the line is full.
pub(super) fn laid_out(told: &[Told]) -> String {
    const MARGIN: usize = 2;
    const RELATIVE: usize = 8;
    let left = Align::Left;
    let align = [left, left, Align::Right, left, left, left];
    // A mark stands where the notes begin.
    let marked = |t: &Told| t.row().into_iter().chain(["|".repeat(RELATIVE)]).collect();
    let lines = columns(&told.iter().map(marked).collect::<Vec<_>>(), &align);
    let mut text = String::new();
    for (line, told) in lines.iter().zip(told) {
        let cells = line.trim_end_matches('|');
        let place = MARGIN + cells.chars().count();
        let [behind, below] = told.note();
        let gap = if behind.is_empty() || below.is_empty() { "" } else { "  " };
        let all = format!("{behind}{gap}{below}");
        if place + all.chars().count() <= WIDTH {
            text += format!("{:MARGIN$}{cells}{all}", "").trim_end();
        } else {
            text += format!("{:MARGIN$}{cells}{behind}", "").trim_end();
            let indent = place.min(WIDTH.saturating_sub(below.chars().count()));
            text += &format!("\n{:indent$}{below}", "");
        }
        text.push('\n');
    }
    text
}

fn relative(q: &Quantity) -> String {
    let share = q.std_error / q.value.abs();
    if !share.is_finite() || share <= 0.0 || share >= 10.0 {
        return String::new();
    }
    match share * 100.0 {
        p if p < 0.001 => "<0.001 %".to_owned(),
        p => format!("{} %", plain(p, 2, "")),
    }
}

fn is_lopsided(q: &Quantity) -> bool {
    let [low, high] = q.interval_95;
    let (below, above) = (q.value - low, high - q.value);
    below.max(above) > ASYMMETRY * below.min(above)
}

/// A number of a table, to so many digits.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { "?".to_owned() };
    }
    let decade = value.abs().log10().floor() as i64;
    if !(-5..7).contains(&decade) {
        return plain(value, digits as i32, "");
    }
    format!("{value:.*}", (digits as i64 - 1 - decade).max(0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_a_table_keep_three_digits() {
        assert_eq!(significant(0.031_234, 3), "0.0312");
        assert_eq!(significant(1234.5, 3), "1234");
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!(significant(1.234e-9, 3), "1.23×10⁻⁹");
        assert_eq!(significant(f64::NAN, 3), "?");
    }

    #[test]
    fn an_interval_is_on_the_screen_where_it_is_lopsided() {
        let mut q = Quantity::normal(1e-4, 1e-4, "rad");
        assert_eq!(Told::new(Parameter::InitialAmplitude, &q).note(), ["   100 %", ""]);
        q.interval_95 = [0.0, 3.1e-4];
        assert_eq!(Told::new(Parameter::InitialAmplitude, &q).note(), ["   100 %", "95 %: 0 to 310"]);
        assert_eq!(Told::new(Parameter::InitialAmplitude, &q).interval, "0 to 310");
    }

    #[test]
    fn an_interval_goes_below_where_the_line_is_full() {
        let lopsided = |words: &str| {
            let mut q = Quantity::normal(1e-4, 1e-4, "rad");
            q.interval_95 = [0.0, 3.1e-4];
            Told { words: words.to_owned(), symbol: "", ..Told::new(Parameter::InitialAmplitude, &q) }
        };
        assert_eq!(laid_out(&[lopsided("x")]), "  x  100  ± 100  µrad     100 %  95 %: 0 to 310\n");
        let long = "a name as long as those of quantities ever become";
        let text = laid_out(&[lopsided(long), lopsided("x")]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 4, "{text}");
        assert!(lines.iter().all(|l| l.chars().count() <= WIDTH), "{text}");
        assert_eq!(lines[1].trim_start(), "95 %: 0 to 310", "{text}");
        assert_eq!(lines[3], lines[1], "{text}");
    }

    #[test]
    fn relative_uncertainties_are_left_out_where_they_say_nothing() {
        assert_eq!(relative(&Quantity::normal(2.0, 0.1, "")), "5 %");
        assert_eq!(relative(&Quantity::normal(0.0, 0.1, "")), "");
        assert_eq!(relative(&Quantity::normal(1.0, 1e-7, "")), "<0.001 %");
    }
}
