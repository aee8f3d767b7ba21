//! p values in the texts of warnings.

/// `p < 1e-12`, `p = 3e-5`, `p = 0.012`.
pub(crate) fn p_value(p: f64) -> String {
    if p < 1e-12 {
        return "p < 1e-12".to_owned();
    }
    if p < 1e-3 {
        return format!("p = {p:.0e}");
    }
    // Two significant digits.
    let decimals = (1.0 - p.log10().floor()).max(0.0);
    let decimals = if decimals.is_finite() { decimals as usize } else { 0 };
    format!("p = {}", format!("{p:.decimals$}").trim_end_matches('0').trim_end_matches('.'))
}

#[cfg(test)]
mod tests {
    use super::p_value;

    #[test]
    fn two_digits_are_shown_down_to_one_in_a_thousand() {
        let cases = [(0.0, "p < 1e-12"), (3.2e-5, "p = 3e-5"), (0.0123, "p = 0.012"), (0.5, "p = 0.5")];
        for (p, text) in cases {
            assert_eq!(p_value(p), text);
        }
        assert_eq!(p_value(1.0), "p = 1");
        assert_eq!(p_value(f64::NAN), "p = NaN");
    }
}
