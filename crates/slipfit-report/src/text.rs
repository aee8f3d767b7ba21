//! Line breaking of text, for screens and figures.

/// The words of a text; a number stays together with its sign and unit.
pub(crate) fn words(text: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut glue = false;
    for word in text.split_whitespace() {
        let unit = word.trim_end_matches(['.', ',', ';', ':', ')']);
        let after_number = words.last().is_some_and(|w| w.ends_with(|c: char| c.is_ascii_digit()));
        let sign = matches!(word, "<" | "=" | "±");
        let is_unit = matches!(unit, "%" | "s" | "ms" | "Hz" | "kHz" | "1/s" | "cycles" | "samples");
        match words.last_mut() {
            Some(last) if glue || sign || (after_number && is_unit) => {
                last.push(' ');
                last.push_str(word);
            }
            _ => words.push(word.to_owned()),
        }
        glue = sign;
    }
    words
}

/// Breaks text between words into lines of at most `width` characters.
pub(crate) fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words(text) {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_breaks_between_words_only() {
        assert_eq!(wrap("one two three", 7), ["one two", "three"]);
        assert_eq!(wrap("indivisible", 3), ["indivisible"]);
        assert!(wrap("", 10).is_empty());
        assert_eq!(wrap("excluded, p < 1e-12.", 15), ["excluded,", "p < 1e-12."]);
        assert_eq!(wrap("in the last 8 s; then", 13), ["in the last", "8 s; then"]);
    }
}
