//! Symbols such as `x_F`, `δ`, `f₀` and units such as `µrad`, in the notation of each format.

use crate::escape::html as escape;

/// Greek letters used in symbols, and their commands in LaTeX.
const GREEK: [(&str, &str); 4] = [("δ", r"\delta"), ("γ", r"\gamma"), ("τ", r"\tau"), ("β", r"\beta")];

/// Letter and index of a symbol such as `x_F` or `x₀`.
fn parts(symbol: &str) -> (String, String) {
    let digit = |c: char| ('₀'..='₉').contains(&c).then(|| char::from(b'0' + (c as u32 - '₀' as u32) as u8));
    if let Some((letter, index)) = symbol.split_once('_') {
        return (letter.to_owned(), index.to_owned());
    }
    let letter: String = symbol.chars().filter(|c| digit(*c).is_none()).collect();
    (letter, symbol.chars().filter_map(digit).collect())
}

/// Whether a text is a symbol, alone or in a ratio: `δ`, `x_F`, `R/x₀`, not `rms`. A heading may be foreign text,
/// so text with a character that a format reads as mark-up is not a symbol.
fn is_symbol(text: &str) -> bool {
    let letter = |c: char| c.is_ascii_alphabetic() || GREEK.iter().any(|(greek, _)| greek.starts_with(c));
    let one = |part: &str| {
        let (name, index) = parts(part);
        name.chars().count() == 1
            && name.chars().all(letter)
            && index.chars().all(|c| c.is_ascii_alphanumeric())
    };
    !text.is_empty() && text.split('/').all(one)
}

pub(super) fn html(symbol: &str) -> String {
    let one = |part: &str| match parts(part) {
        (letter, index) if index.is_empty() => format!("<i>{}</i>", escape(&letter)),
        (letter, index) => format!("<i>{}</i><sub>{}</sub>", escape(&letter), escape(&index)),
    };
    symbol.split('/').map(one).collect::<Vec<_>>().join("/")
}

pub(super) fn markdown(symbol: &str) -> String {
    let one = |part: &str| match parts(part) {
        (letter, index) if index.is_empty() => format!("*{letter}*"),
        (letter, index) => format!("*{letter}*<sub>{index}</sub>"),
    };
    symbol.split('/').map(one).collect::<Vec<_>>().join("/")
}

pub(super) fn latex(symbol: &str) -> String {
    let one = |part: &str| {
        let (letter, index) = parts(part);
        let letter = GREEK
            .iter()
            .find_map(|(greek, command)| (*greek == letter).then(|| (*command).to_owned()))
            .unwrap_or(letter);
        if index.is_empty() {
            letter
        } else if index.bytes().all(|b| b.is_ascii_digit()) {
            format!("{letter}_{index}")
        } else {
            format!(r"{letter}_\mathrm{{{index}}}")
        }
    };
    format!("${}$", symbol.split('/').map(one).collect::<Vec<_>>().join("/"))
}

/// A heading such as `x_F [mrad]`, its symbol formatted by `symbol` and the rest by `text`.
pub(super) fn heading(
    heading: &str,
    symbol: impl Fn(&str) -> String,
    text: impl Fn(&str) -> String,
) -> String {
    match heading.split_once(" [") {
        Some((name, unit)) if is_symbol(name) => format!("{} [{}", symbol(name), text(unit)),
        None if is_symbol(heading) => symbol(heading),
        _ => text(heading),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_format_has_its_spelling() {
        assert_eq!(html("x_F"), "<i>x</i><sub>F</sub>");
        assert_eq!(html("R/x₀"), "<i>R</i>/<i>x</i><sub>0</sub>");
        assert_eq!(markdown("f₀"), "*f*<sub>0</sub>");
        assert_eq!(latex("x_F"), r"$x_\mathrm{F}$");
        assert_eq!(latex("δ"), r"$\delta$");
        assert_eq!(latex("a₂"), "$a_2$");
    }

    #[test]
    fn words_are_told_from_symbols() {
        assert!(is_symbol("δ"));
        assert!(is_symbol("x_F"));
        assert!(is_symbol("R/x₀"));
        assert!(!is_symbol("rms"));
        assert!(!is_symbol("model"));
        assert!(!is_symbol(""));
        for hostile in ["$_}\\input{x}", "x_<img>", "x_}$\\relax", "<", "%", "x_|", "*", "x_F/<"] {
            assert!(!is_symbol(hostile), "{hostile}");
        }
        let written = heading("x_F [mrad]", markdown, str::to_owned);
        assert_eq!(written, "*x*<sub>F</sub> [mrad]");
        assert_eq!(heading("rms [mrad]", markdown, str::to_owned), "rms [mrad]");
    }
}
