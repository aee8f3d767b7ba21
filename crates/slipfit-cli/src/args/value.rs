//! Values as they are typed on a command line or written in a manifest.

use serde::de::{self, Deserialize, Deserializer, Visitor};
use slipfit::ringdown::LawOption;
use slipfit::{LossModel, LossTerm};
use slipfit_io::Format;
use std::fmt;
use std::marker::PhantomData;
use std::str::FromStr;

/// A column, a unit or a name; may also be written as a number.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Text(pub(crate) String);

/// A finite number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Finite(pub(crate) f64);

/// A finite number above zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Positive(pub(crate) f64);

/// A loss model by its name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Loss(pub(crate) LossModel);

/// A model-free law, by its name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Law(pub(crate) LawOption);

/// A file format, with the name that was typed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FormatName {
    pub(crate) typed: String,
    pub(crate) format: Format,
}

/// The help text of `--model`; for a resonance curve without the losses that only free decays determine.
pub(crate) fn model_help(of_curves: bool) -> String {
    let compared: Vec<&str> = LossModel::compared(None).map(LossModel::name).collect();
    let mut help = format!("Report this model, whichever the data prefer: {}", compared.join(", "));
    let further = |term: &LossTerm| !(term.is_compared() || of_curves && term.is_shaped());
    let further: Vec<LossTerm> = LossTerm::ALL.iter().copied().filter(further).collect();
    if let Some(first) = further.first() {
        let terms: Vec<String> = further.iter().map(|t| format!("{} ({})", t.name(), t.words())).collect();
        let terms = terms.join(", ");
        help += &format!("; compared only if named here: {terms}, as in viscous+{}", first.name());
    }
    help
}

impl FromStr for Text {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(Self(text.to_owned()))
    }
}

impl FromStr for Finite {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        finite(text).map(Self)
    }
}

impl FromStr for Positive {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        positive(text).map(Self)
    }
}

impl FromStr for FormatName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(Self { typed: text.to_owned(), format: text.parse()? })
    }
}

impl FromStr for Loss {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        loss_model(text).map(Self)
    }
}

impl FromStr for Law {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.parse().map(Self)
    }
}

/// A word at least this similar to a known one was probably meant as it (Jaro-Winkler similarity).
const SIMILAR: f64 = 0.8;

/// The known word that was probably meant.
pub(crate) fn similar<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let likeness = |known: &str| strsim::jaro_winkler(word, known);
    let best = known.into_iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    best.filter(|known| likeness(known) >= SIMILAR)
}

/// A loss model; if there is none of this name, the error names the one that was probably meant.
pub(super) fn loss_model(text: &str) -> Result<LossModel, String> {
    text.parse::<LossModel>().map_err(|unknown| {
        let term = |typed: &str| similar(typed, LossTerm::ALL.iter().map(|term| term.name()));
        let terms: Option<Vec<&str>> = text.split('+').map(term).collect();
        match terms.and_then(|terms| terms.join("+").parse::<LossModel>().ok()) {
            Some(meant) => format!("{unknown}; did you mean `{meant}`?"),
            None => unknown,
        }
    })
}

/// In a manifest, the typed value may be a string or a number.
struct Scalar<T>(PhantomData<T>);

impl<T: FromStr<Err: fmt::Display>> Visitor<'_> for Scalar<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a text or a number")
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<T, E> {
        text.parse().map_err(|e| E::custom(format!("{text}: {e}")))
    }

    fn visit_i64<E: de::Error>(self, number: i64) -> Result<T, E> {
        self.visit_str(&number.to_string())
    }

    fn visit_f64<E: de::Error>(self, number: f64) -> Result<T, E> {
        self.visit_str(&number.to_string())
    }
}

macro_rules! as_typed {
    ($($value:ty),*) => {
        $(impl<'de> Deserialize<'de> for $value {
            fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                from.deserialize_any(Scalar(PhantomData))
            }
        })*
    };
}
as_typed!(
    Text,
    Finite,
    Positive,
    FormatName,
    Loss,
    Law,
    Uncertain,
    InUnit,
    Stiffness,
    Mass,
    TorsionStiffness,
    Inertia
);

/// A finite number: clap's own parser accepts `nan` and `inf`.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err("not a finite number".to_owned()),
        Err(_) => Err("not a number".to_owned()),
    }
}

/// A finite number above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|v| if v > 0.0 { Ok(v) } else { Err("must be above zero".to_owned()) })
}

/// A finite number, zero or above.
pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).and_then(|v| if v >= 0.0 { Ok(v) } else { Err("must not be negative".to_owned()) })
}

/// An integer from 1 on.
pub(super) fn count(text: &str) -> Result<usize, String> {
    match text.trim().parse::<usize>() {
        Ok(number) if number > 0 => Ok(number),
        _ => Err("must be a whole number from 1 on".to_owned()),
    }
}

/// The text of a value, if it is given.
pub(super) fn text(value: &Option<Text>) -> Option<String> {
    value.as_ref().map(|text| text.0.clone())
}

pub(super) fn number(value: Option<Positive>) -> Option<f64> {
    value.map(|number| number.0)
}

/// A frequency band of two ends.
pub(super) fn band(ends: Option<&[Positive]>) -> Option<[f64; 2]> {
    match ends {
        Some(&[low, high]) => Some([low.0, high.0]),
        _ => None,
    }
}

/// `12000`, `12000±300`, `12000+-300`, `12000±2%`, `12000(300)`, `1.20(3)e4`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Uncertain {
    pub(crate) value: f64,
    /// Zero if none is given.
    pub(crate) std_error: f64,
}

impl FromStr for Uncertain {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let compact: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        let parsed = if let Some((value, error)) = split_plus_minus(&compact) {
            plus_minus(value, error)
        } else if let Some((value, rest)) = compact.split_once('(') {
            parenthesis(value, rest)
        } else {
            compact.parse().ok().map(|value| Self { value, std_error: 0.0 })
        };
        let number = parsed.ok_or("write it as 12000, 12000±300, 12000+-300 or 12000(300)")?;
        if !(number.value > 0.0 && number.value.is_finite()) {
            return Err("must be above zero".to_owned());
        }
        if !(number.std_error >= 0.0 && number.std_error.is_finite()) {
            return Err("the uncertainty must not be negative".to_owned());
        }
        Ok(number)
    }
}

/// A number with or without an uncertainty, and its unit: `1 nm`, `0.0625±0.001 V`, `1e-6 m/N`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct InUnit {
    pub(crate) number: Uncertain,
    /// Without surrounding blanks; `None` if none is given.
    pub(crate) unit: Option<String>,
}

impl FromStr for InUnit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refused = match text.parse() {
            Ok(number) => return Ok(Self { number, unit: None }),
            Err(refused) => refused,
        };
        let begins = |c: char| c.is_alphabetic() || "\u{b0}\u{221a}(%".contains(c);
        let split = |(at, c): (usize, char)| {
            let (number, unit) = (text[..at].parse().ok().filter(|_| begins(c))?, text[at..].trim());
            Some(Self { number, unit: Some(unit.to_owned()) })
        };
        // Searched from the end, so that the exponent of a number belongs to the number.
        text.char_indices().rev().find_map(split).ok_or(refused)
    }
}

/// A mechanical constant in SI units, which may be typed in another unit of its quantity: `200g`, `12±0.3 N/mm`.
macro_rules! constants {
    ($($name:ident in $unit:literal, $doc:literal;)*) => {
        $(
            #[doc = $doc]
            #[derive(Debug, Clone, Copy, PartialEq)]
            pub(crate) struct $name(pub(crate) Uncertain);

            impl FromStr for $name {
                type Err = String;

                fn from_str(text: &str) -> Result<Self, String> {
                    let InUnit { number, unit } = text.parse()?;
                    let factor = match &unit {
                        None => 1.0,
                        Some(unit) => slipfit_io::unit_factor(unit, $unit)
                            .ok_or_else(|| format!("{unit} is not a known unit; it is taken in {}", $unit))?,
                    };
                    Ok(Self(Uncertain { value: factor * number.value, std_error: factor * number.std_error }))
                }
            }
        )*
    };
}
constants! {
    Stiffness in "N/m", "Stiffness (N/m).";
    Mass in "kg", "Mass (kg).";
    TorsionStiffness in "N m/rad", "Torsion stiffness (N m/rad).";
    Inertia in "kg m^2", "Moment of inertia (kg m²).";
}

fn split_plus_minus(text: &str) -> Option<(&str, &str)> {
    ["±", "+/-", "+-"].into_iter().find_map(|sign| text.split_once(sign))
}

fn plus_minus(value: &str, error: &str) -> Option<Uncertain> {
    let value: f64 = value.parse().ok()?;
    let std_error = match error.strip_suffix('%') {
        Some(percent) => value.abs() * percent.parse::<f64>().ok()? / 100.0,
        None => error.parse().ok()?,
    };
    Some(Uncertain { value, std_error })
}

/// The metrological shorthand: digits in parentheses count in units of the last digit of the value, unless they
/// contain a decimal point.
fn parenthesis(value: &str, rest: &str) -> Option<Uncertain> {
    let (error, exponent) = rest.split_once(')')?;
    let scale: f64 = format!("1{exponent}").parse().ok()?;
    if !(exponent.is_empty() || exponent.starts_with(['e', 'E'])) {
        return None;
    }
    let mut std_error: f64 = error.parse().ok()?;
    if !error.contains('.') {
        let decimals = value.split_once('.').map_or(0, |(_, fraction)| fraction.len());
        std_error *= 10f64.powi(-i32::try_from(decimals).ok()?);
    }
    Some(Uncertain { value: value.parse::<f64>().ok()? * scale, std_error: std_error * scale })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_of_writing_an_uncertainty_is_read() {
        let near = |text: &str, value: f64, error: f64| {
            let u: Uncertain = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
            assert!((u.value - value).abs() <= 1e-12 * value, "{text}: {u:?}");
            assert!((u.std_error - error).abs() <= 1e-12 * value, "{text}: {u:?}");
        };
        near("12000", 12000.0, 0.0);
        near("12000±300", 12000.0, 300.0);
        near("12000 ± 300", 12000.0, 300.0);
        near("12000+-300", 12000.0, 300.0);
        near("12000+/-300", 12000.0, 300.0);
        near("12000±2.5%", 12000.0, 300.0);
        near("12000(300)", 12000.0, 300.0);
        near("1.20(3)e4", 12000.0, 300.0);
        near("1.234(5)", 1.234, 0.005);
        near("1.2(0.3)", 1.2, 0.3);
        near("1e-3±2e-5", 1e-3, 2e-5);
    }

    #[test]
    fn a_number_may_have_its_unit_behind_it() {
        for (text, value, error, unit) in [
            ("1", 1.0, 0.0, None),
            ("1 nm", 1.0, 0.0, Some("nm")),
            ("1e-6 m/N", 1e-6, 0.0, Some("m/N")),
            ("10mV", 10.0, 0.0, Some("mV")),
            ("0.25\u{b1}0.01 \u{b5}m", 0.25, 0.01, Some("\u{b5}m")),
            ("4.0(2) \u{b0}", 4.0, 0.2, Some("\u{b0}")),
        ] {
            let found: InUnit = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
            assert!((found.number.value - value).abs() <= 1e-12 * value, "{text}: {found:?}");
            assert!((found.number.std_error - error).abs() <= 1e-12 * value, "{text}: {found:?}");
            assert_eq!(found.unit.as_deref(), unit, "{text}");
        }
        for text in ["nm", "-2 nm", "0 nm", "", "12\u{b1}"] {
            assert!(text.parse::<InUnit>().is_err(), "{text}");
        }
    }

    #[test]
    fn constants_are_taken_in_the_unit_that_is_typed() {
        let near = |found: Uncertain, value: f64, error: f64| {
            assert!((found.value - value).abs() <= 1e-12 * value, "{found:?}");
            assert!((found.std_error - error).abs() <= 1e-12 * value, "{found:?}");
        };
        near("200g".parse::<Mass>().unwrap().0, 0.2, 0.0);
        near("0.2".parse::<Mass>().unwrap().0, 0.2, 0.0);
        near("200±3 g".parse::<Mass>().unwrap().0, 0.2, 0.003);
        near("0.200(3) kg".parse::<Mass>().unwrap().0, 0.2, 0.003);
        near("12 N/mm".parse::<Stiffness>().unwrap().0, 12000.0, 0.0);
        near("5 mN m/rad".parse::<TorsionStiffness>().unwrap().0, 0.005, 0.0);
        near("30 g cm^2".parse::<Inertia>().unwrap().0, 3e-6, 0.0);
        let refused = "200 mm".parse::<Mass>().unwrap_err();
        assert_eq!(refused, "mm is not a known unit; it is taken in kg");
        assert!("g".parse::<Mass>().is_err());
    }

    #[test]
    fn numbers_must_be_finite() {
        assert_eq!(finite("1e-3"), Ok(1e-3));
        for text in ["nan", "inf", "x", ""] {
            assert!(finite(text).is_err(), "{text}");
        }
        assert!(positive("0").is_err());
        assert_eq!(not_negative("0"), Ok(0.0));
        assert!(not_negative("-1").is_err());
        assert_eq!(count("3"), Ok(3));
        for text in ["-1", "0", "1.5", ""] {
            assert_eq!(count(text), Err("must be a whole number from 1 on".to_owned()), "{text}");
        }
    }

    #[test]
    fn an_unknown_model_names_the_terms_and_the_one_that_was_meant() {
        let refusal = |text: &str| text.parse::<Loss>().unwrap_err();
        let terms = "its terms may be viscous, sliding, drag, cubic, power, stribeck, presliding, joined by + as in \
                     viscous+sliding";
        assert_eq!(refusal("foo"), format!("no loss model is called `foo`; {terms}"));
        for (typed, meant) in [("slidng+viscous", "viscous+sliding"), ("viscouss", "viscous")] {
            let said = refusal(typed);
            assert_eq!(said, format!("no loss model is called `{typed}`; {terms}; did you mean `{meant}`?"));
        }
    }

    #[test]
    fn nonsense_is_refused() {
        for text in ["", "±3", "12±", "12(3", "12(3)x", "nan", "-5", "0", "5±-1", "5±nan", "1(2)3", "12()"]
        {
            assert!(text.parse::<Uncertain>().is_err(), "{text}");
        }
    }
}
