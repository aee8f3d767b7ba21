//! Formulas in plain-text notation, `|X_{n+1}| = e^{−δT} |X_n|`, converted for a page.

use crate::escape::html as escape;

/// HTML of a formula: `_` and `^` lower and raise the next character or `{group}`; single Latin letters are
/// italic, names of functions are upright.
pub(super) fn html(formula: &str) -> String {
    let mut out = String::new();
    let mut rest = formula;
    while let Some(first) = rest.chars().next() {
        if let Some(tag) = match first {
            '_' => Some("sub"),
            '^' => Some("sup"),
            _ => None,
        } {
            let (inner, after) = group(&rest[1..]);
            out.push_str(&format!("<{tag}>{}</{tag}>", html(inner)));
            rest = after;
        } else if first.is_alphabetic() {
            let end = rest.find(|c: char| !c.is_alphabetic()).unwrap_or(rest.len());
            let (word, after) = rest.split_at(end);
            out.push_str(&letters(word));
            rest = after;
        } else {
            out.push_str(&escape(&rest[..first.len_utf8()]));
            rest = &rest[first.len_utf8()..];
        }
    }
    out
}

/// HTML of a sentence in which symbols such as `x_F` occur.
pub(super) fn text(sentence: &str) -> String {
    let mut out = String::new();
    let mut before = ' ';
    let mut rest = sentence;
    while let Some(c) = rest.chars().next() {
        rest = &rest[c.len_utf8()..];
        if c == '_' && before.is_alphabetic() {
            let (inner, after) = group(rest);
            out.push_str(&format!("<sub>{}</sub>", escape(inner)));
            rest = after;
        } else {
            out.push_str(&escape(c.encode_utf8(&mut [0; 4])));
        }
        before = c;
    }
    out
}

/// The argument of `_` or `^`, and the text after it.
fn group(text: &str) -> (&str, &str) {
    if let Some(inside) = text.strip_prefix('{')
        && let Some(end) = inside.find('}')
    {
        return (&inside[..end], &inside[end + 1..]);
    }
    let end = text.chars().next().map_or(0, char::len_utf8);
    text.split_at(end)
}

/// Sets letters in italics and known words upright.
fn letters(word: &str) -> String {
    const UPRIGHT: [&str; 17] = [
        "sgn",
        "coth",
        "sinh",
        "cosh",
        "cos",
        "sin",
        "ln",
        "lag",
        "drag",
        "for",
        "above",
        "the",
        "threshold",
        "RSS",
        "BIC",
        "best",
        "ΔBIC",
    ];
    if UPRIGHT.contains(&word) {
        return word.to_owned();
    }
    word.chars()
        .map(|c| {
            let leans = c.is_ascii_alphabetic() || ('α'..='ω').contains(&c);
            if leans { format!("<i>{c}</i>") } else { escape(&c.to_string()) }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_and_powers_find_their_place() {
        assert_eq!(html("x_F"), "<i>x</i><sub><i>F</i></sub>");
        assert_eq!(
            html("|X_{n+1}| = e^{−δT}"),
            "|<i>X</i><sub><i>n</i>+1</sub>| = <i>e</i><sup>−<i>δ</i><i>T</i></sup>"
        );
        assert_eq!(html("F sgn(v) < 2"), "<i>F</i> sgn(<i>v</i>) &lt; 2");
    }

    #[test]
    fn prose_keeps_its_words_and_lowers_its_indices() {
        assert_eq!(
            text("x_F and ω_{0}, a_1 < 2, _x"),
            "x<sub>F</sub> and ω<sub>0</sub>, a<sub>1</sub> &lt; 2, _x"
        );
    }

    #[test]
    fn an_unfinished_group_is_still_text() {
        assert_eq!(html("x_{a"), "<i>x</i><sub>{</sub><i>a</i>");
        assert_eq!(html("x_"), "<i>x</i><sub></sub>");
    }
}
