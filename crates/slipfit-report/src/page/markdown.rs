//! Tables in Markdown.

use super::symbol;
use crate::Provenance;
use crate::document::{Document, Table};
use crate::escape::{comment, markdown as line, markdown_cell as cell};
use std::fmt::Write as _;

/// Sentence, parameters, tables and warnings.
pub fn markdown(document: &Document<'_>, provenance: &Provenance) -> String {
    let mut text = format!("**{}**: {}\n", line(&document.subject).trim(), line(&document.sentence));
    if !document.parameters.is_empty() {
        text += "\n| parameter | symbol | value | ± | unit | 95 % interval |\n|---|---|--:|--:|---|---|\n";
        for row in &document.parameters {
            let symbol = if row.symbol.is_empty() { String::new() } else { symbol::markdown(row.symbol) };
            let interval = if row.absent { "not in the model" } else { &row.interval };
            let cells = [
                cell(&row.words),
                symbol,
                cell(&row.value),
                cell(&row.uncertainty),
                cell(&row.unit),
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
        for warning in &document.warnings {
            let _ = writeln!(text, "- {}: {}", warning.code.replace('_', " "), line(&warning.text));
        }
    }
    for input in &document.inputs {
        let _ = write!(text, "\n`{}` SHA-256 {}  ", comment(&input.path).replace('`', " "), input.sha256);
    }
    let _ = writeln!(text, "\nslipfit {}", line(&provenance.version));
    text
}

fn one(table: &Table) -> String {
    let (head, rows) = table.split();
    let heads: Vec<String> =
        table.headings().iter().map(|h| symbol::heading(h, symbol::markdown, cell)).collect();
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
