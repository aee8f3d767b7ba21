//! A number with its uncertainty, in the ways people write it.

use std::str::FromStr;

/// `12000`, `12000±300`, `12000+-300`, `12000±2%`, `12000(300)`, `1.20(3)e4`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Uncertain {
    pub(crate) value: f64,
    /// Zero when none is given.
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

/// The metrologist's shorthand: digits in parentheses count in units of the
/// last digit of the value, unless they carry a decimal point of their own.
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
    fn nonsense_is_refused() {
        for text in ["", "±3", "12±", "12(3", "12(3)x", "nan", "-5", "0", "5±-1", "5±nan", "1(2)3", "12()"]
        {
            assert!(text.parse::<Uncertain>().is_err(), "{text}");
        }
    }
}
