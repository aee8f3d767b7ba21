//! Tables in LaTeX that need no package.

use super::symbol;
use crate::Provenance;
use crate::document::{Document, Table};
use crate::escape::{comment, latex as escaped};
use std::fmt::Write as _;

/// Tables of parameters and models, with the sentence and the warnings as comments.
pub fn latex(document: &Document<'_>, provenance: &Provenance) -> String {
    let mut text = format!("% {}: {}\n", comment(&document.subject), comment(&document.sentence));
    for warning in &document.warnings {
        let _ = writeln!(text, "% {}: {}", warning.code.replace('_', " "), comment(&warning.text));
    }
    for input in &document.inputs {
        let _ = writeln!(text, "% {} SHA-256 {}", comment(&input.path), input.sha256);
    }
    let _ = writeln!(text, "% slipfit {}", comment(&provenance.version));
    if !document.parameters.is_empty() {
        text += "\\begin{tabular}{llrll}\n\\hline\n";
        text += "parameter & & value & unit & 95\\,\\% interval \\\\\n\\hline\n";
        for row in &document.parameters {
            let symbol = if row.symbol.is_empty() { String::new() } else { symbol::latex(row.symbol) };
            let value = match row.uncertainty.as_str() {
                "" => number(&row.value),
                error => format!("${} \\pm {}$", bare(&row.value), bare(error)),
            };
            let interval = if row.absent { "not in the model".to_owned() } else { range(&row.interval) };
            let cells = [escaped(&row.words), symbol, value, escaped(&row.unit), interval];
            let _ = writeln!(text, "{} \\\\", cells.join(" & "));
        }
        text += "\\hline\n\\end{tabular}\n";
    }
    for (i, table) in document.tables.iter().enumerate() {
        text += if i == 0 && document.parameters.is_empty() { "\n" } else { "\n\\bigskip\n\n" };
        text += &one(table);
    }
    text
}

fn one(table: &Table) -> String {
    let (head, rows) = table.split();
    let columns = format!("l{}", "r".repeat(head.len().saturating_sub(1)));
    let heading = |text: &String| symbol::heading(text, symbol::latex, escaped);
    let mut text = format!("\\begin{{tabular}}{{{columns}}}\n\\hline\n");
    let group = |(name, columns): &(String, usize)| match name.as_str() {
        "" => String::new(),
        _ => format!("\\multicolumn{{{columns}}}{{c}}{{{}}}", heading(name)),
    };
    if !table.groups.is_empty() {
        let groups: Vec<String> = table.groups.iter().map(group).collect();
        let _ = writeln!(text, "{} \\\\", groups.join(" & "));
    }
    let heads: Vec<String> = head.iter().map(heading).collect();
    let _ = writeln!(text, "{} \\\\\n\\hline", heads.join(" & "));
    for (i, row) in rows.iter().enumerate() {
        let cell = |(column, c): (usize, &String)| match (column, table.chosen == Some(i)) {
            (0, true) => format!("\\textbf{{{}}}", escaped(c)),
            (0, false) => escaped(c),
            _ => number(c),
        };
        let _ = writeln!(text, "{} \\\\", row.iter().enumerate().map(cell).collect::<Vec<_>>().join(" & "));
    }
    text += "\\hline\n\\end{tabular}\n";
    if !table.note.is_empty() {
        let _ = writeln!(text, "% {}", comment(&table.note));
    }
    text
}

/// `0.1 to 0.2` with its numbers in math mode.
fn range(text: &str) -> String {
    match text.split_once(" to ") {
        Some((low, high)) => format!("{} to {}", number(low), number(high)),
        None => escaped(text),
    }
}

/// A number in math mode, anything else as text.
fn number(text: &str) -> String {
    if let Some((value, error)) = text.split_once(" ± ") {
        return format!("${} \\pm {}$", bare(value), bare(error));
    }
    let plain = bare(text);
    if plain.trim_start_matches(['<', ' ']).replace("\\infty", "1").parse::<f64>().is_ok() {
        format!("${plain}$")
    } else if text == "-" {
        "--".to_owned()
    } else {
        escaped(text)
    }
}

fn bare(text: &str) -> String {
    text.replace('\u{2212}', "-").replace('∞', "\\infty")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_mathematics() {
        assert_eq!(number("-1.5e-9"), "$-1.5e-9$");
        assert_eq!(number("< 2.1"), "$< 2.1$");
        assert_eq!(number("-"), "--");
        assert_eq!(number("15.01 ± 0.09"), "$15.01 \\pm 0.09$");
        assert_eq!(number("at 0"), "at 0");
        assert_eq!(range("0.1 to ∞"), "$0.1$ to $\\infty$");
    }
}
