//! Formatting of numbers in sentences.

/// A number with the given count of significant digits; all digits before the decimal point are kept, trailing zeros
/// after it are dropped.
pub(crate) fn figures(value: f64, digits: i32) -> String {
    if !(value.is_finite() && value != 0.0) {
        return format!("{value}");
    }
    let decimals = (digits - 1 - value.abs().log10().floor() as i32).clamp(0, 12);
    let text = format!("{value:.*}", decimals as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A number in a unit with the SI prefix that leaves one to three digits before the decimal point.
pub(crate) fn scaled(value: f64, digits: i32, unit: &str) -> String {
    const PREFIXES: [&str; 9] = ["f", "p", "n", "µ", "m", "", "k", "M", "G"];
    let third = (value.abs().log10() / 3.0).floor();
    let third = if third.is_finite() { third.clamp(-5.0, 3.0) } else { 0.0 };
    let prefix = PREFIXES.get((third + 5.0) as usize).unwrap_or(&"");
    format!("{} {prefix}{unit}", figures(value / 1000f64.powf(third), digits))
}

/// A count of things, with a plural `s` unless it is one.
pub(crate) fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_asked_for_and_no_more() {
        let cases = [
            (118.9102, 4, "118.9"),
            (283.929, 4, "283.9"),
            (133.9568, 4, "134"),
            (0.096351, 4, "0.09635"),
            (0.7076004, 5, "0.7076"),
            (297.66712, 5, "297.67"),
            (1_712_345_678.25, 4, "1712345678"),
            (9.9996, 4, "10"),
            (0.0, 4, "0"),
        ];
        for (value, digits, text) in cases {
            assert_eq!(figures(value, digits), text);
        }
    }

    #[test]
    fn a_prefix_keeps_numbers_short() {
        assert_eq!(scaled(5.3284e-3, 3, "s"), "5.33 ms");
        assert_eq!(scaled(-2.5e-7, 3, "s"), "-250 ns");
        assert_eq!(scaled(1.25, 3, "s"), "1.25 s");
        assert_eq!(scaled(0.0, 3, "s"), "0 s");
    }

    #[test]
    fn one_thing_is_singular() {
        assert_eq!(counted(1, "point"), "1 point");
        assert_eq!(counted(0, "point"), "0 points");
    }
}
