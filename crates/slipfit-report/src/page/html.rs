//! A self-contained page: it needs no network, no fonts, and no script to be read.

use super::{formula, symbol};
use crate::Provenance;
use crate::document::{Document, ParameterRow, Table, method};
use crate::escape::html as escape;
use crate::plot::dark_rules;
use std::fmt::Write as _;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

/// Content security policy: the browser may only show the page.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// The page. It is well-formed XML as well, so that other programs can parse it.
pub fn html(document: &Document<'_>, provenance: &Provenance) -> String {
    let subject = escape(&document.subject);
    let version = escape(&provenance.version);
    let dark = dark_rules();
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta name=\"generator\" content=\"slipfit {version}\"/>\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\"/>\n\
         <title>{subject} – slipfit {}</title>\n<style>\n{STYLE}{dark}</style>\n</head>\n<body>\n<main>\n",
        document.command
    );
    let _ = write!(
        page,
        "<header>\n<p class=\"kind\">{}</p>\n<h1>{subject}</h1>\n<p class=\"answer\">{}</p>\n</header>\n",
        kind(document.command),
        escape(&document.sentence)
    );
    warnings(&mut page, document);
    if !document.parameters.is_empty() {
        page += "<section>\n<h2>Parameters</h2>\n";
        parameters(&mut page, &document.parameters);
        page += "</section>\n";
    }
    if document.parameters.is_empty() {
        document.tables.iter().for_each(|table| section(&mut page, table));
    }
    page += "<section>\n<h2>Data and fit</h2>\n<div class=\"figures\">\n";
    for picture in (document.pictures)() {
        let _ = writeln!(page, "<figure>{}</figure>", picture.inline_svg());
    }
    page += "</div>\n</section>\n";
    if !document.parameters.is_empty() {
        document.tables.iter().for_each(|table| section(&mut page, table));
    }
    page += "<section>\n<h2>How it was read and fitted</h2>\n<dl>\n";
    for (label, text) in document.facts.iter() {
        let _ = writeln!(page, "<dt>{}</dt><dd>{}</dd>", escape(&label.replace('_', " ")), escape(text));
    }
    page += "</dl>\n</section>\n<section>\n<h2>Method</h2>\n<ol>\n";
    for step in &document.method {
        let _ = write!(page, "<li><b>{}</b>", escape(step.what));
        if !step.formula.is_empty() {
            let _ = write!(page, "<p class=\"formula\">{}</p>", formula::html(step.formula));
        }
        let _ = writeln!(page, "<p class=\"source\">{}</p></li>", formula::text(step.source));
    }
    let _ = write!(page, "</ol>\n<p class=\"note\">The paper: {}</p>\n</section>\n", escape(method::PAPER));
    reproduce(&mut page, document, provenance);
    let _ = write!(page, "</main>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n");
    page
}

/// The answer, its warnings, parameters and tables as an element to embed in a page of another program, such as a
/// notebook, which provides the style.
pub fn fragment(document: &Document<'_>) -> String {
    let mut part = format!("<div class=\"slipfit\">\n<p><b>{}</b></p>\n", escape(&document.sentence));
    if !document.warnings.is_empty() {
        warnings(&mut part, document);
    }
    if !document.parameters.is_empty() {
        parameters(&mut part, &document.parameters);
    }
    document.tables.iter().for_each(|table| section(&mut part, table));
    part.push_str("</div>\n");
    part
}

fn kind(command: &str) -> &str {
    match command {
        "ringdown" => "Ring-down: viscous and sliding loss of a free decay",
        "resonance" => "Resonance curve: viscous and sliding loss of a driven oscillator",
        "levels" => "Amplitude at resonance over the level of the drive",
        "series" => "Several measurements of one oscillator",
        other => other,
    }
}

fn warnings(page: &mut String, document: &Document<'_>) {
    if document.warnings.is_empty() {
        page.push_str("<p class=\"note\">No warnings.</p>\n");
        return;
    }
    page.push_str("<ul class=\"warnings\">\n");
    for warning in &document.warnings {
        let code = escape(&warning.code.replace('_', " "));
        let _ = writeln!(page, "<li><b>Warning, {code}:</b> {}</li>", escape(&warning.text));
    }
    page.push_str("</ul>\n");
}

fn parameters(page: &mut String, parameters: &[ParameterRow]) {
    page.push_str(
        "<div class=\"scroll\"><table>\n<thead><tr><th>parameter</th><th></th><th class=\"n\">value</th>\
         <th class=\"n\">± standard error</th><th>unit</th><th>95 % interval</th><th class=\"n\">relative</th></tr></thead>\n\
         <tbody>\n",
    );
    for row in parameters {
        let symbol = if row.symbol.is_empty() { String::new() } else { symbol::html(row.symbol) };
        let (class, interval) = match row.absent {
            true => (" class=\"absent\"", "95 %, not in the model reported"),
            false => ("", row.interval.as_str()),
        };
        let _ = writeln!(
            page,
            "<tr{class}><td>{}</td><td>{symbol}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td><td>{}</td>\
             <td class=\"n\">{}</td></tr>",
            escape(&row.words),
            escape(&row.value),
            escape(&row.uncertainty),
            escape(&row.unit),
            escape(interval),
            escape(&row.relative)
        );
    }
    page.push_str("</tbody>\n</table></div>\n");
}

fn section(page: &mut String, table: &Table) {
    let (_, rows) = table.split();
    let _ = write!(
        page,
        "<section>\n<h2>{}</h2>\n<div class=\"scroll\"><table>\n<thead><tr>",
        escape(table.title)
    );
    for (i, name) in table.headings().iter().enumerate() {
        let class = if i > 0 { " class=\"n\"" } else { "" };
        let _ = write!(page, "<th{class}>{}</th>", symbol::heading(name, symbol::html, escape));
    }
    page.push_str("</tr></thead>\n<tbody>\n");
    for (i, row) in rows.iter().enumerate() {
        page.push_str(if table.chosen == Some(i) { "<tr class=\"chosen\">" } else { "<tr>" });
        for (i, cell) in row.iter().enumerate() {
            let class = if i > 0 { " class=\"n\"" } else { "" };
            let _ = write!(page, "<td{class}>{}</td>", escape(cell));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody>\n</table></div>\n");
    if !table.note.is_empty() {
        let _ = writeln!(page, "<p class=\"note\">{}</p>", escape(&table.note));
    }
    page.push_str("</section>\n");
}

fn reproduce(page: &mut String, document: &Document<'_>, provenance: &Provenance) {
    let _ = write!(
        page,
        "<section>\n<h2>To reproduce</h2>\n<pre><code>{}</code></pre>\n<div class=\"scroll\"><table>\n\
         <thead><tr><th>input</th><th>SHA-256</th></tr></thead>\n<tbody>\n",
        escape(&provenance.call)
    );
    for input in &document.inputs {
        let _ =
            writeln!(page, "<tr><td>{}</td><td><code>{}</code></td></tr>", escape(&input.path), input.sha256);
    }
    let _ = write!(
        page,
        "</tbody>\n</table></div>\n</section>\n<footer>slipfit {}</footer>\n",
        escape(&provenance.version)
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::by_hand;
    use slipfit::ringdown::Answer;

    fn page(change: impl FnOnce(&mut Answer)) -> String {
        let provenance =
            crate::Provenance { version: "0.0.0".into(), call: "slipfit ringdown swing.csv".into() };
        by_hand(change, |analysed| html(&Document::ringdown(analysed, &crate::example::spell), &provenance))
    }

    /// Whether the page is well-formed XML, which every browser parses alike.
    fn is_well_formed(page: &str) -> bool {
        let mut reader = quick_xml::Reader::from_str(page);
        loop {
            match reader.read_event() {
                Ok(quick_xml::events::Event::Eof) => return true,
                Ok(_) => {}
                Err(_) => return false,
            }
        }
    }

    #[test]
    fn numbers_that_are_none_still_make_a_page() {
        type Change = fn(&mut Answer);
        let changes: [Change; 4] = [
            |_| (),
            |a| {
                for parameter in slipfit::Parameter::all() {
                    let Some(q) = a.parameters.get_mut(parameter) else { continue };
                    q.std_error = f64::NAN;
                    q.interval_95 = [f64::NEG_INFINITY, f64::INFINITY];
                }
            },
            |a| {
                a.parameters = Default::default();
                a.comparison.clear();
                a.envelope.clear();
                a.loss.clear();
            },
            |a| {
                a.comparison.iter_mut().for_each(|c| (c.rms, c.delta_bic) = (f64::NAN, f64::INFINITY));
                a.diagnostics.noise_rms = f64::NAN;
            },
        ];
        for change in changes {
            let page = page(change);
            assert!(is_well_formed(&page), "{page:.2000}");
            for figure in page.split("<figure>").skip(1) {
                let figure = figure.split("</figure>").next().unwrap_or_default();
                assert!(!figure.contains("NaN"), "{figure:.2000}");
                assert!(!figure.contains("inf"), "{figure:.2000}");
            }
        }
    }

    #[test]
    fn a_fragment_is_one_element() {
        let part = by_hand(
            |a| a.warnings = vec![slipfit::answer::Warning::FrequencyUnknown],
            |analysed| fragment(&Document::ringdown(analysed, &crate::example::spell)),
        );
        assert!(is_well_formed(&part), "{part:.2000}");
        assert!(part.starts_with("<div"), "{part:.2000}");
        assert!(part.trim_end().ends_with("</div>"), "{part:.2000}");
        for word in ["friction displacement", "viscous+sliding+drag", "Warning, "] {
            assert!(part.contains(word), "{word}: {part:.2000}");
        }
    }

    #[test]
    fn the_row_reported_is_marked() {
        let page = page(|_| ());
        let chosen = page.split("<tr class=\"chosen\">").nth(1).unwrap();
        assert!(chosen.starts_with("<td>viscous+sliding</td>"), "{chosen:.200}");
        assert_eq!(page.matches("class=\"chosen\"").count(), 1);
    }

    #[test]
    fn a_page_without_a_script_lacks_nothing_but_haste() {
        // Every value that the script shows under the pointer is also in the page as text.
        let page = page(|_| ());
        let with_values = page.matches("<title>time ").count() + page.matches("<title>amplitude ").count();
        assert!(with_values > 30, "{with_values}");
    }
}
