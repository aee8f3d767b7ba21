//! Parameters formatted for reading, identically on screens, on pages and in tables.

use crate::format::{Rounded, Scale, plain};
use serde::Serialize;
use slipfit::{LossModel, LossTerm, Parameter, Parameters, Quantity};

/// If one side of an interval is longer than the other by this factor, the interval is printed on the screen.
const ASYMMETRY: f64 = 1.15;

/// One parameter in words and digits.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct ParameterRow {
    pub(crate) words: String,
    pub(crate) symbol: &'static str,
    pub(crate) value: String,
    /// Digits of the standard error; empty without one.
    pub(crate) uncertainty: String,
    /// Unit, with its prefix or power of ten.
    pub(crate) unit: String,
    /// Standard error in per cent; empty if it is not meaningful.
    pub(crate) relative: String,
    /// Both ends of the 95 % interval, in `unit`; empty without one.
    pub(crate) interval: String,
    /// Whether value and uncertainty alone would mislead.
    pub(crate) asymmetric: bool,
    /// The reported model has no such term: `value` is an upper limit.
    pub(crate) absent: bool,
}

impl ParameterRow {
    /// The parameters that carry information; JSON has all of them. `model` is the reported loss model.
    pub(super) fn list(parameters: &Parameters, model: Option<LossModel>) -> Vec<Self> {
        let shown = parameters.iter().filter(|(p, q)| is_shown(*p, q, parameters, model));
        let row = |(p, q): (Parameter, &Quantity)| match model.is_some_and(|m| is_absent(p, m)) {
            true => Self::absent(p, q),
            false => Self::new(p, q),
        };
        shown.map(row).collect()
    }

    pub(crate) fn new(parameter: Parameter, q: &Quantity) -> Self {
        let [low, high] = q.interval_95;
        if high - low < q.std_error {
            return Self::by_interval(parameter, q);
        }
        if high == f64::INFINITY && !(q.std_error <= q.value.abs()) {
            return Self::lower_limit(parameter, q);
        }
        let (words, symbol) = (parameter.label().to_owned(), parameter.symbol());
        let shown = Rounded::of(q);
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
            asymmetric: !interval.is_empty() && is_asymmetric(q),
            interval,
            absent: false,
        }
    }

    /// A parameter whose whole interval is narrower than its standard error, which then reflects only the
    /// curvature at the optimum: digits from a quarter of the interval, an upper limit if the value lies at zero.
    fn by_interval(parameter: Parameter, q: &Quantity) -> Self {
        let [low, high] = q.interval_95;
        let shown = Rounded::of(q);
        let value = match q.value <= low && low == 0.0 {
            true => format!("< {}", shown.also(high)),
            false => shown.value(),
        };
        Self {
            words: parameter.label().to_owned(),
            symbol: parameter.symbol(),
            value,
            uncertainty: String::new(),
            unit: shown.scale.unit.clone(),
            relative: String::new(),
            interval: format!("{} to {}", shown.also(low), shown.also(high)),
            asymmetric: true,
            absent: false,
        }
    }

    /// A parameter without an upper limit, whose error exceeds its value: shown as a lower limit if that is above
    /// zero.
    fn lower_limit(parameter: Parameter, q: &Quantity) -> Self {
        let low = q.interval_95[0];
        let scale = Scale::for_size(low, &q.unit);
        let least = significant(low * scale.factor, 2);
        Self {
            words: parameter.label().to_owned(),
            symbol: parameter.symbol(),
            value: if low > 0.0 { format!("> {least}") } else { "-".to_owned() },
            uncertainty: String::new(),
            unit: scale.unit,
            relative: String::new(),
            interval: format!("{least} to ∞"),
            asymmetric: true,
            absent: false,
        }
    }

    /// A term the model does not have, shown as its upper limit.
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
            asymmetric: false,
            absent: true,
        }
    }
}

/// Whether a parameter adds information to the others.
fn is_shown(parameter: Parameter, q: &Quantity, all: &Parameters, model: Option<LossModel>) -> bool {
    match parameter {
        Parameter::SlidingRate => all.get(Parameter::FRICTION_DISPLACEMENT).is_none(),
        Parameter::DuffingCoefficient => q.value != 0.0,
        Parameter::Loss(LossTerm::Viscous | LossTerm::Sliding) => q.value.is_finite(),
        Parameter::Loss(term) => model.is_some_and(|m| m.has(term)),
        _ => q.value.is_finite(),
    }
}

/// Whether the reported model lacks this term.
fn is_absent(parameter: Parameter, model: LossModel) -> bool {
    match parameter {
        Parameter::Loss(term) => !model.has(term),
        Parameter::SlidingRate | Parameter::CoulombForce | Parameter::FrictionRatio => !model.has_sliding(),
        Parameter::ViscousCoefficient | Parameter::QFactor => !model.has(LossTerm::Viscous),
        _ => false,
    }
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

fn is_asymmetric(q: &Quantity) -> bool {
    let [low, high] = q.interval_95;
    let (below, above) = (q.value - low, high - q.value);
    below.max(above) > ASYMMETRY * below.min(above)
}

/// A number of a table, to `digits` significant digits.
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
    fn an_interval_narrower_than_the_standard_error_gives_the_digits() {
        let mut q = Quantity::normal(0.0, 1400.0, "1/s");
        q.interval_95 = [0.0, 0.157];
        let row = ParameterRow::new(Parameter::Loss(LossTerm::Viscous), &q);
        assert_eq!([row.value, row.uncertainty, row.interval], ["< 0.16", "", "0.00 to 0.16"]);
        q.value = 0.1;
        let row = ParameterRow::new(Parameter::Loss(LossTerm::Viscous), &q);
        assert_eq!([row.value, row.uncertainty, row.interval], ["0.10", "", "0.00 to 0.16"]);
        assert!(row.asymmetric);
    }

    #[test]
    fn without_an_upper_limit_the_lower_one_is_shown() {
        let mut q = Quantity::normal(196.0, 4e7, "");
        q.interval_95 = [98.4, f64::INFINITY];
        let row = ParameterRow::new(Parameter::QFactor, &q);
        assert_eq!([row.value, row.uncertainty, row.interval], ["> 98", "", "98 to ∞"]);
        q.interval_95[0] = 0.0;
        let row = ParameterRow::new(Parameter::QFactor, &q);
        assert_eq!([row.value, row.interval], ["-", "0 to ∞"]);
        let known = Quantity { interval_95: [12.0, f64::INFINITY], ..Quantity::normal(19.0, 8.0, "") };
        assert_eq!(ParameterRow::new(Parameter::QFactor, &known).uncertainty, "8");
    }

    #[test]
    fn relative_uncertainties_are_left_out_where_they_say_nothing() {
        assert_eq!(relative(&Quantity::normal(2.0, 0.1, "")), "5 %");
        assert_eq!(relative(&Quantity::normal(0.0, 0.1, "")), "");
        assert_eq!(relative(&Quantity::normal(1.0, 1e-7, "")), "<0.001 %");
    }
}
