//! The condition of a measurement: a label and its number.

use crate::args::Uncertain;
use serde::Deserialize;
use slipfit::series::Condition;

/// A number, alone or as text with its uncertainty.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub(super) enum Number {
    Plain(f64),
    Text(String),
}

/// The condition written as `given`, with the number `value` where the label does not say it.
pub(super) fn condition(
    given: Option<&Number>,
    value: Option<&Number>,
    unit: &str,
) -> Result<Condition, String> {
    let beside = |text: &str| if unit.is_empty() { text.to_owned() } else { format!("{text} {unit}") };
    let (label, own) = match given {
        None => (String::new(), None),
        Some(Number::Plain(value)) => (beside(&value.to_string()), Some([*value, 0.0])),
        Some(Number::Text(text)) => {
            let number = text.trim_end_matches(|c: char| !c.is_ascii_digit() && c != ')' && c != '%');
            (text.clone(), pair(number).ok())
        }
    };
    let value = match value {
        Some(Number::Plain(value)) => Some([*value, 0.0]),
        Some(Number::Text(text)) => Some(pair(text).map_err(|e| format!("value: {e}"))?),
        None => own,
    };
    let label = if label.is_empty() {
        value.map_or_else(|| "(none)".to_owned(), |v| beside(&v[0].to_string()))
    } else {
        label
    };
    if let Some([value, _]) = value.filter(|v| !v[0].is_finite()) {
        return Err(format!("value = {value}: must be a finite number"));
    }
    Ok(Condition { label, value })
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
