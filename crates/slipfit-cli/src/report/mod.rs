//! Reports for the terminal: shared layout.

mod ringdown;
mod table;

pub(crate) use ringdown::{label, ringdown};

use anstyle::{AnsiColor, Style};

/// Columns of the screen a report is laid out for.
pub(crate) const WIDTH: usize = 80;

pub(crate) const ANSWER: Style = Style::new().bold();
pub(crate) const HEADING: Style = AnsiColor::Cyan.on_default();
pub(crate) const CHOSEN: Style = AnsiColor::Green.on_default();
pub(crate) const DIM: Style = Style::new().dimmed();

/// Breaks text between words into lines of at most `width` characters.
pub(crate) fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// `label   text`, the text wrapped and hanging.
pub(crate) fn labelled(label: &str, text: &str) -> String {
    const INDENT: usize = 10;
    wrap(text, WIDTH - INDENT)
        .iter()
        .enumerate()
        .map(|(i, line)| match i {
            0 => format!("  {HEADING}{label:<8}{HEADING:#}{line}\n"),
            _ => format!("{:INDENT$}{line}\n", ""),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_breaks_between_words_only() {
        assert_eq!(wrap("one two three", 7), ["one two", "three"]);
        assert_eq!(wrap("indivisible", 3), ["indivisible"]);
        assert!(wrap("", 10).is_empty());
    }
}
