//! Reports for the terminal: shared layout.

pub(crate) mod account;
mod braille;
mod facts;
mod inspect;
pub(crate) mod levels;
mod parameters;
pub(crate) mod resonance;
pub(crate) mod ringdown;
pub(crate) mod series;
mod table;

pub(crate) use facts::Facts;
pub use inspect::{Inspected, inspect};
pub use levels::levels;
pub(crate) use parameters::Told;
pub use resonance::resonance;
pub(crate) use ringdown::UNSETTLED;
pub use ringdown::ringdown;
pub use series::{Form, series, table as series_table};

use anstyle::{AnsiColor, Style};

/// Columns of the screen a report is laid out for.
pub(crate) const WIDTH: usize = 80;

pub(crate) const ANSWER: Style = Style::new().bold();
pub(crate) const HEADING: Style = AnsiColor::Cyan.on_default();
pub(crate) const CHOSEN: Style = AnsiColor::Green.on_default();
pub(crate) const DIM: Style = Style::new().dimmed();

/// The words of a text; a number keeps its sign and unit beside it.
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

/// `label text`, the text wrapped and hanging behind the label; lines broken by the writer,
/// such as a quoted piece of a file, stay as they are.
pub fn hanging(label: &str, style: Style, text: &str) -> String {
    let indent = label.chars().count() + 1;
    let lines: Vec<String> = match text.lines().count() {
        0 => vec![String::new()],
        1 if indent + text.chars().count() > WIDTH => wrap(text, WIDTH - indent),
        _ => text.lines().map(str::to_owned).collect(),
    };
    let word = label.trim_start();
    let margin = &label[..label.len() - word.len()];
    let first = format!("{margin}{style}{word}{style:#} {}\n", lines[0]);
    lines[1..].iter().fold(first, |text, line| text + &format!("{:indent$}{line}\n", ""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_hangs_behind_its_label() {
        let long = "one two three ".repeat(9);
        let text = anstream::adapter::strip_str(&hanging("  hint:", HEADING, &long)).to_string();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines.len() == 2 && lines.iter().all(|l| l.chars().count() <= WIDTH), "{text}");
        assert!(lines[0].starts_with("  hint: one two") && lines[1].starts_with("        one"), "{text}");
        let quoted = hanging("error:", Style::new(), "line 3\n  | a = \n  |   ^");
        assert_eq!(quoted, "error: line 3\n         | a = \n         |   ^\n");
    }

    #[test]
    fn text_breaks_between_words_only() {
        assert_eq!(wrap("one two three", 7), ["one two", "three"]);
        assert_eq!(wrap("indivisible", 3), ["indivisible"]);
        assert!(wrap("", 10).is_empty());
        assert_eq!(wrap("excluded, p < 1e-12.", 15), ["excluded,", "p < 1e-12."]);
        assert_eq!(wrap("in the last 8 s; then", 13), ["in the last", "8 s; then"]);
    }
}
