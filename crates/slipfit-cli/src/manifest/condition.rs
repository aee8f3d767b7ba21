//! The condition of a measurement: a label and its number.

use crate::args::Uncertain;
use serde::Deserialize;
use slipfit::series::Condition;

/// A number, plain or as text with its uncertainty.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub(super) enum Number {
    Plain(f64),
    Text(String),
}

/// A condition as written, and the unit of the number in its label.
#[derive(Debug)]
pub(super) struct Written {
    pub(super) condition: Condition,
    /// `None` for a number in the unit of the series, or for no number; empty if the label names no unit.
    unit: Option<String>,
}

/// The condition written as `given`, with the number `value` if the label does not contain it.
pub(super) fn condition(
    given: Option<&Number>,
    value: Option<&Number>,
    unit: &str,
) -> Result<Written, String> {
    let with_unit = |text: &str| if unit.is_empty() { text.to_owned() } else { format!("{text} {unit}") };
    let (label, own, own_unit) = match given {
        None => (String::new(), None, None),
        Some(Number::Plain(value)) => (with_unit(&value.to_string()), Some([*value, 0.0]), None),
        Some(Number::Text(text)) => {
            let number = text.trim_end_matches(|c: char| !c.is_ascii_digit() && c != ')' && c != '%');
            let (own, named) = (pair(number).ok(), text[number.len()..].trim());
            match own {
                // A number between quotes is a number.
                Some(_) if named.is_empty() => (with_unit(text.trim()), own, None),
                Some(_) => (text.clone(), own, Some(named.to_owned())),
                None => (text.clone(), None, None),
            }
        }
    };
    let (value, own_unit) = match value {
        Some(Number::Plain(value)) => (Some([*value, 0.0]), None),
        Some(Number::Text(text)) => (Some(pair(text).map_err(|e| format!("value: {e}"))?), None),
        None => (own, own_unit),
    };
    let label = if label.is_empty() {
        value.map_or_else(|| "(none)".to_owned(), |v| with_unit(&v[0].to_string()))
    } else {
        label
    };
    if let Some([value, _]) = value.filter(|v| !v[0].is_finite()) {
        return Err(format!("value = {value}: must be a finite number"));
    }
    Ok(Written { condition: Condition { label, value }, unit: own_unit })
}

/// Converts all numbers to one unit: that of the series or, if it names none, that of the first label with a
/// unit. Labels whose units are incompatible are treated as names without numbers.
///
/// Returns the unit; the error contains the index of its condition.
pub(super) fn in_one_unit(all: &mut [Written], unit: &str) -> Result<String, (usize, String)> {
    let Some(first) = all.iter().find_map(|written| written.unit.clone()) else { return Ok(unit.to_owned()) };
    let wanted = if unit.is_empty() { first } else { unit.to_owned() };
    let factors: Vec<Option<f64>> = all
        .iter()
        .map(|written| written.unit.as_deref().map_or(Some(1.0), |own| slipfit_io::unit_factor(own, &wanted)))
        .collect();
    if let Some(at) = factors.iter().position(Option::is_none) {
        let label = &all[at].condition.label;
        if !unit.is_empty() {
            let problem =
                format!("condition = {label:?} is not in {unit}, the condition_unit; value gives its number");
            return Err((at, problem));
        }
        for written in all.iter_mut().filter(|written| written.unit.is_some()) {
            written.condition.value = None;
        }
        return Ok(String::new());
    }
    let bare = |written: &Written| written.unit.is_none() && written.condition.value.is_some();
    if let Some(at) = all.iter().position(bare).filter(|_| unit.is_empty()) {
        let label = &all[at].condition.label;
        return Err((
            at,
            format!(
                "condition = {label} has no unit, others have {wanted}: condition_unit names that of plain numbers"
            ),
        ));
    }
    for (written, factor) in all.iter_mut().zip(factors) {
        let factor = factor.unwrap_or(1.0);
        written.condition.value = written.condition.value.map(|value| value.map(|v| v * factor));
    }
    Ok(wanted)
}

/// A value of any sign with its standard error.
fn pair(text: &str) -> Result<[f64; 2], String> {
    if let Ok(value) = text.trim().parse::<f64>() {
        return Ok([value, 0.0]);
    }
    let negative = text.trim().starts_with('-');
    let u: Uncertain = text.trim().trim_start_matches('-').parse()?;
    Ok([if negative { -u.value } else { u.value }, u.std_error])
}
