//! Tables in LaTeX, which need no package.

use super::{Document, Table, symbol};
use std::fmt::Write as _;

/// Parameters and models, the sentence and the doubts as comments.
pub fn latex(document: &Document<'_>) -> String {
    let mut text = format!("% {}: {}\n", comment(&document.subject), comment(&document.sentence));
    for doubt in &document.warnings {
        let _ = writeln!(text, "% {}: {}", doubt.code.replace('_', " "), comment(&doubt.text));
    }
    for input in &document.inputs {
        let _ = writeln!(text, "% {} SHA-256 {}", comment(&input.path), input.sha256);
    }
    let _ = writeln!(text, "% slipfit {}", document.provenance.version);
    if !document.parameters.is_empty() {
        text += "\\begin{tabular}{llrll}\n\\hline\n";
        text += "parameter & & value & unit & 95\\,\\% interval \\\\\n\\hline\n";
        for told in &document.parameters {
            let symbol = if told.symbol.is_empty() { String::new() } else { symbol::latex(told.symbol) };
            let value = match told.uncertainty.as_str() {
                "" => number(&told.value),
                error => format!("${} \\pm {}$", bare(&told.value), bare(error)),
            };
            let interval = if told.absent { "not in the model".to_owned() } else { range(&told.interval) };
            let cells = [escaped(&told.words), symbol, value, escaped(&told.unit), interval];
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
    let heads: Vec<String> = head.iter().map(|h| symbol::heading(h, symbol::latex, escaped)).collect();
    let mut text = format!("\\begin{{tabular}}{{{columns}}}\n\\hline\n{} \\\\\n\\hline\n", heads.join(" & "));
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

/// `0.1 to 0.2` with its numbers in mathematics.
fn range(text: &str) -> String {
    match text.split_once(" to ") {
        Some((low, high)) => format!("{} to {}", number(low), number(high)),
        None => escaped(text),
    }
}

/// A number in mathematics, anything else as text.
fn number(text: &str) -> String {
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

/// Text in which LaTeX sees no commands, signs beyond ASCII as it writes them.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\\' => out.push_str("\\textbackslash{}"),
            '~' => out.push_str("\\textasciitilde{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '<' => out.push_str("$<$"),
            '>' => out.push_str("$>$"),
            '|' => out.push_str("$|$"),
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => out.extend(['\\', c]),
            'µ' | 'μ' => out.push_str("$\\mu$"),
            'Δ' => out.push_str("$\\Delta$"),
            'δ' => out.push_str("$\\delta$"),
            'γ' => out.push_str("$\\gamma$"),
            'β' => out.push_str("$\\beta$"),
            'Ω' => out.push_str("$\\Omega$"),
            '±' => out.push_str("$\\pm$"),
            '×' => out.push_str("$\\times$"),
            '·' => out.push_str("$\\cdot$"),
            '°' => out.push_str("$^\\circ$"),
            '√' => out.push_str("$\\surd$"),
            '∞' => out.push_str("$\\infty$"),
            '\u{2212}' => out.push_str("$-$"),
            '–' => out.push_str("--"),
            '⁻' => out.push_str("$^{-}$"),
            c if raised(c).is_some() => {
                let _ = write!(out, "$^{}$", raised(c).unwrap_or(' '));
            }
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

fn raised(c: char) -> Option<char> {
    "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().zip('0'..='9').find_map(|(up, digit)| (up == c).then_some(digit))
}

/// Text that stays in its comment.
fn comment(text: &str) -> String {
    text.replace(|c: char| c.is_control(), " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_give_commands() {
        assert_eq!(escaped("a_b%$\\input{x}"), "a\\_b\\%\\$\\textbackslash{}input\\{x\\}");
        assert_eq!(escaped("×10⁻⁷ µm²"), "$\\times$10$^{-}$$^7$ $\\mu$m$^2$");
        assert_eq!(comment("a\n\\input{x}"), "a \\input{x}");
    }

    #[test]
    fn numbers_are_mathematics() {
        assert_eq!(number("-1.5e-9"), "$-1.5e-9$");
        assert_eq!(number("< 2.1"), "$< 2.1$");
        assert_eq!(number("-"), "--");
        assert_eq!(number("at 0"), "at 0");
        assert_eq!(range("0.1 to ∞"), "$0.1$ to $\\infty$");
    }
}
