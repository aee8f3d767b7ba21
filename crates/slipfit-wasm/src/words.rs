//! Options as words of a page.

use slipfit::answer::hint::HintValue;

/// An option of a library as a page names it: `band 79 to 82 Hz`, `the analysis levels`.
pub(crate) fn words(option: &'static str, value: Option<&HintValue>) -> String {
    let (name, unit) = match option.rsplit_once('_') {
        Some((name, "hz")) => (name, " Hz"),
        Some((name, "s")) => (name, " s"),
        _ => (option, ""),
    };
    let name = name.replace('_', " ");
    match value {
        None => name,
        Some(HintValue::Number(number)) => format!("{name} {number}{unit}"),
        Some(HintValue::Range([low, high])) => format!("{name} {low} to {high}{unit}"),
        Some(HintValue::Text(word)) => format!("{name} {word}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_carry_their_unit() {
        assert_eq!(words("band_hz", Some(&[79.0, 82.0].into())), "band 79 to 82 Hz");
        assert_eq!(words("rate_hz", None), "rate");
        assert_eq!(
            words("analysis", Some(&slipfit::answer::hint::Analysis::Levels.into())),
            "analysis levels"
        );
    }
}
