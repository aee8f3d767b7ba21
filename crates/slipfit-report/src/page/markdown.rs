//! Tables in Markdown.

use super::{Document, Table, symbol};
use std::fmt::Write as _;

/// Sentence, parameters, models and doubts.
pub fn markdown(document: &Document<'_>) -> String {
    let mut text = format!("**{}**: {}\n", line(&document.subject), line(&document.sentence));
    if !document.parameters.is_empty() {
        text += "\n| parameter | symbol | value | ± | unit | 95 % interval |\n|---|---|--:|--:|---|---|\n";
        for told in &document.parameters {
            let symbol = if told.symbol.is_empty() { String::new() } else { symbol::markdown(told.symbol) };
            let interval = if told.absent { "not in the model" } else { &told.interval };
            let cells = [
                cell(&told.words),
                symbol,
                cell(&told.value),
                cell(&told.uncertainty),
                cell(&told.unit),
                cell(interval),
            ];
            let _ = writeln!(text, "| {} |", cells.join(" | "));
        }
    }
    for table in &document.tables {
        text.push('\n');
        text += &one(table);
    }
    if !document.warnings.is_empty() {
        text.push('\n');
        for doubt in &document.warnings {
            let _ = writeln!(text, "- {}: {}", doubt.code.replace('_', " "), line(&doubt.text));
        }
    }
    for input in &document.inputs {
        let _ = write!(text, "\n`{}` SHA-256 {}  ", input.path.replace(['`', '\n'], " "), input.sha256);
    }
    let _ = writeln!(text, "\nslipfit {}", document.provenance.version);
    text
}

fn one(table: &Table) -> String {
    let (head, rows) = table.split();
    let heads: Vec<String> = head.iter().map(|h| symbol::heading(h, symbol::markdown, cell)).collect();
    let mut text =
        format!("| {} |\n|---|{}\n", heads.join(" | "), "--:|".repeat(head.len().saturating_sub(1)));
    for (i, row) in rows.iter().enumerate() {
        let chosen = table.chosen == Some(i);
        let shown = |c: &String| if chosen && !c.is_empty() { format!("**{}**", cell(c)) } else { cell(c) };
        let _ = writeln!(text, "| {} |", row.iter().map(shown).collect::<Vec<_>>().join(" | "));
    }
    if !table.note.is_empty() {
        let _ = writeln!(text, "\n{}", line(&table.note));
    }
    text
}

/// Text inside a cell.
pub fn cell(text: &str) -> String {
    line(text).replace('|', "\\|")
}

/// Text in which Markdown sees no marks of its own.
fn line(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut before = ' ';
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        let inside = before.is_alphanumeric() && rest.peek().is_some_and(|c| c.is_alphanumeric());
        match c {
            '<' => out.push_str("&lt;"),
            '&' => out.push_str("&amp;"),
            // Between letters an underscore marks nothing.
            '_' if inside => out.push('_'),
            // Brackets are a link only where these follow.
            ']' if matches!(rest.peek(), Some('(' | '[' | ':')) => out.push_str("\\]"),
            '\\' | '`' | '*' | '_' => out.extend(['\\', c]),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
        before = c;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_mark_up_the_page() {
        assert_eq!(cell("a|b<script>*x*\n[l](u)"), "a\\|b&lt;script>\\*x\\* [l\\](u)");
        assert_eq!(cell("tuning_fork_9nN"), "tuning_fork_9nN");
        assert_eq!(cell("_x_"), "\\_x\\_");
    }
}
