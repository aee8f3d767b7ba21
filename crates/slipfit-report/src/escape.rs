//! Escaping of foreign text (file names, headers, units), one function per format.
//!
//! A name in a file must not mark up a page, give a command to LaTeX, a spreadsheet or a terminal, or change the
//! direction of the text around it.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Replaces a character that a format cannot show safely.
const REPLACED: char = '\u{fffd}';

/// Invisible controls of the writing direction, which would reorder the text around them.
fn turns_direction(c: char) -> bool {
    matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Escapes text for HTML, XML and SVG, in an element or between quotes. Control characters, which XML does not
/// allow, become blanks.
pub fn html(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            '\n' => safe.push('\n'),
            c if c.is_control() => safe.push(' '),
            '\u{fffe}' | '\u{ffff}' => safe.push(' '),
            c if turns_direction(c) => safe.push(REPLACED),
            c => safe.push(c),
        }
    }
    safe
}

/// Escapes text for a line of Markdown, in a paragraph or a list.
pub fn markdown(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut before = ' ';
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        let inside = before.is_alphanumeric() && rest.peek().is_some_and(|c| c.is_alphanumeric());
        match c {
            // Before a blank, as in `p < 1e-12`, it starts no tag.
            '<' if rest.peek() == Some(&' ') => out.push('<'),
            '<' => out.push_str("&lt;"),
            '&' => out.push_str("&amp;"),
            // Between letters, an underscore is not mark-up.
            '_' if inside => out.push('_'),
            '[' if rest.peek() == Some(&'^') => out.push_str("\\["),
            // Brackets form a link only before one of these characters.
            ']' if matches!(rest.peek(), Some('(' | '[' | ':')) => out.push_str("\\]"),
            // Some renderers read dollars as mathematics.
            '\\' | '`' | '*' | '_' | '$' | '~' => out.extend(['\\', c]),
            c if c.is_control() => out.push(' '),
            c if turns_direction(c) => out.push(REPLACED),
            c => out.push(c),
        }
        before = c;
    }
    out
}

/// Escapes text for a table cell in Markdown.
pub fn markdown_cell(text: &str) -> String {
    markdown(text).replace('|', "\\|")
}

/// Escapes text for LaTeX; signs beyond ASCII are written without the need for a package. Letters that are not
/// Latin stay as they are, for XeLaTeX and LuaLaTeX.
pub fn latex(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            // At the beginning of a row they would be read as part of the end of the previous row.
            '[' | '*' if out.trim().is_empty() => out.extend(['{', c, '}']),
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
            c if superscript(c).is_some() => {
                let _ = write!(out, "$^{}$", superscript(c).unwrap_or(' '));
            }
            c if c.is_control() || turns_direction(c) => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

fn superscript(c: char) -> Option<char> {
    "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().zip('0'..='9').find_map(|(up, digit)| (up == c).then_some(digit))
}

/// Escapes text for a comment that ends with its line, in LaTeX or at the head of a CSV file.
pub fn comment(text: &str) -> String {
    // Some readers end a line at line and paragraph separators.
    let ends = |c: char| c.is_control() || matches!(c, '\u{2028}' | '\u{2029}');
    text.replace(ends, " ").replace(turns_direction, &REPLACED.to_string())
}

/// Escapes text for a comment at the head of a CSV file, which a spreadsheet splits at commas and semicolons like
/// any other line: no part of it begins like a formula.
pub fn csv_comment(text: &str) -> String {
    guard_parts(comment(text), &[',', ';'])
}

/// Changes the text so that no part between these separators begins like a formula.
fn guard_parts(text: String, separators: &[char]) -> String {
    if !text.contains(separators) {
        return text;
    }
    let mut out = String::with_capacity(text.len());
    let mut begins = false;
    for c in text.chars() {
        if begins && begins_formula(c) {
            out.push('\'');
        }
        begins = separators.contains(&c) || begins && (c.is_whitespace() || c == '"' || c == REPLACED);
        out.push(c);
    }
    out
}

/// Whether a spreadsheet takes text that begins with this character for a formula.
fn begins_formula(c: char) -> bool {
    matches!(c, '=' | '+' | '-' | '@')
}

/// A text cell of a CSV file. An apostrophe in front makes a spreadsheet treat what begins like a formula (`=`,
/// `+`, `-`, `@`, a tab, blanks before them) as text. Control characters become blanks: the file may be shown by
/// a terminal, and not every spreadsheet respects the quotes around a line end.
pub fn csv(text: &str) -> String {
    let formula =
        text.trim_start_matches(|c: char| c.is_whitespace() || c.is_control() || turns_direction(c));
    let marks = formula.starts_with(begins_formula) || text.starts_with(['\t', '\r']);
    let inert = text.replace(|c: char| c.is_control(), " ").replace(turns_direction, &REPLACED.to_string());
    let text = guard_parts(if marks { format!("'{inert}") } else { inert }, &[';']);
    if text.contains([',', ';', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

/// JSON text, or part of a string in it: characters that a terminal or a reader would act on are written as JSON
/// escapes, so that the value is unchanged.
pub fn json(text: &str) -> Cow<'_, str> {
    let is_active = |c: char| c.is_control() && c > '\u{1f}' || turns_direction(c);
    if !text.contains(is_active) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_active(c) {
            let _ = write!(out, "\\u{:04x}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    Cow::Owned(out)
}

/// Escapes text for a terminal: no escape sequences, and no control characters except the line end.
pub fn terminal(text: &str) -> String {
    let unsafe_here = |c: char| (c.is_control() && c != '\n') || turns_direction(c);
    text.replace('\t', " ").replace(unsafe_here, &REPLACED.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names that try to break out of their place.
    const HOSTILE: [&str; 10] = [
        "a|b",
        "\\input{secret}",
        "=cmd()|' /C calc'!A0",
        "\u{1b}[31mred\u{1b}[0m",
        "\u{9b}2J",
        "abc\u{202e}vsc.exe",
        "</text></svg><script>alert(1)</script>",
        "\" onload=\"alert(1)",
        "a\r\n% \\end{document}",
        "[x](javascript:alert) **b** `c` $\\write18$ & # ~ ^",
    ];

    #[test]
    fn names_cannot_break_out_of_an_element_or_attribute() {
        assert_eq!(html("p < 1e-12 & \u{1}</text>\"'"), "p &lt; 1e-12 &amp;  &lt;/text&gt;&quot;&#39;");
        for name in HOSTILE {
            let text = html(name);
            assert!(!text.contains(['<', '>', '"', '\'']), "{text}");
            assert!(!text.contains(turns_direction), "{text}");
            let page = format!("<p title=\"{text}\">{text}</p>");
            let mut reader = quick_xml::Reader::from_str(&page);
            let events = std::iter::from_fn(|| match reader.read_event() {
                Ok(quick_xml::events::Event::Eof) => None,
                event => Some(event.map(|e| e.into_owned())),
            });
            let events: Vec<_> = events.collect::<Result<_, _>>().unwrap();
            let elements = events.iter().filter(|e| matches!(e, quick_xml::events::Event::Start(_)));
            assert_eq!(elements.count(), 1, "{page}");
        }
    }

    #[test]
    fn names_cannot_mark_up_markdown() {
        assert_eq!(markdown_cell("a|b<script>*x*\n[l](u)"), "a\\|b&lt;script>\\*x\\* [l\\](u)");
        assert_eq!(markdown("p < 1e-12 <"), "p < 1e-12 &lt;");
        assert_eq!(markdown_cell("tuning_fork_9nN"), "tuning_fork_9nN");
        assert_eq!(markdown_cell("_x_"), "\\_x\\_");
        for name in HOSTILE {
            let cell = markdown_cell(name);
            assert!(!cell.contains('<'), "{cell}");
            assert!(!cell.contains(|c: char| c.is_control() || turns_direction(c)), "{cell}");
            let bare = cell
                .replace("\\\\", "")
                .replace("\\|", "")
                .replace("\\`", "")
                .replace("\\*", "")
                .replace("\\]", "");
            assert!(!bare.contains(['|', '`', '*']), "{cell}");
            assert!(!bare.contains("]("), "{cell}");
        }
    }

    #[test]
    fn names_cannot_give_commands_to_latex() {
        assert_eq!(latex("a_b%$\\input{x}"), "a\\_b\\%\\$\\textbackslash{}input\\{x\\}");
        assert_eq!(latex("×10⁻⁷ µm²"), "$\\times$10$^{-}$$^7$ $\\mu$m$^2$");
        assert_eq!(comment("a\n\\input{x}"), "a \\input{x}");
        assert_eq!(latex(" [3cm] a [b]*"), " {[}3cm] a [b]*");
        for name in HOSTILE {
            let text = latex(name);
            for command in ["\\input", "\\write", "\\end", "\n", "\r"] {
                assert!(!text.contains(command), "{text}");
            }
            assert!(!comment(name).contains(['\n', '\r', '\u{1b}']), "{name}");
        }
    }

    #[test]
    fn names_cannot_be_formulas_of_a_spreadsheet() {
        assert_eq!(csv("=cmd()"), "'=cmd()");
        assert_eq!(csv("-1+2"), "'-1+2");
        assert_eq!(csv("a,b \"c\""), "\"a,b \"\"c\"\"\"");
        assert_eq!(csv("plain_name.csv"), "plain_name.csv");
        assert_eq!(csv_comment("a,=b;@c, - d, 1-2"), "a,'=b;'@c, '- d, 1-2");
        for name in HOSTILE {
            let row = format!("{},1\n", csv(name));
            let mut reader = ::csv::ReaderBuilder::new().has_headers(false).from_reader(row.as_bytes());
            let rows: Vec<::csv::StringRecord> = reader.records().map(Result::unwrap).collect();
            assert_eq!((rows.len(), rows[0].len()), (1, 2), "{row}");
            assert!(!rows[0][0].starts_with(['=', '+', '-', '@']), "{row}");
        }
    }

    #[test]
    fn names_cannot_steer_a_terminal() {
        for name in HOSTILE {
            let text = terminal(name);
            assert!(
                !text.contains(|c: char| (c.is_control() && c != '\n') || turns_direction(c)),
                "{text:?}"
            );
        }
        assert_eq!(terminal("two\nlines, µm"), "two\nlines, µm");
    }
}
