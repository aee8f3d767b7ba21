//! Foreign names stay names: each escape is tested on text composed of what it has to neutralise.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use proptest::prelude::*;
use pulldown_cmark::{Event, Options, Parser, Tag};
use slipfit_report::escape;

/// Characters with a meaning in some format, whole attacks, and any other text between them.
fn name() -> impl Strategy<Value = String> {
    const PARTS: [&str; 28] = [
        "=cmd()|' /C calc'!A0",
        "=",
        "+",
        "-",
        "@",
        "|",
        "\\",
        "\"",
        "'",
        ",",
        "\n",
        "\r",
        "\t",
        "\u{1b}[31m",
        "\u{9b}2J",
        "\u{202e}",
        "\u{2066}",
        "<script>",
        "</title>",
        "&",
        "](javascript:x)",
        "[",
        "]",
        "`",
        "*",
        "\\input{x}",
        "%$#_{}~^",
        "\u{0}",
    ];
    let part = prop_oneof![
        4 => prop::sample::select(PARTS.to_vec()).prop_map(str::to_owned),
        1 => any::<String>(),
        2 => "[a-z0-9 ]{0,6}",
    ];
    prop::collection::vec(part, 0..8).prop_map(|parts| parts.concat())
}

fn turns(c: char) -> bool {
    "\u{61c}\u{200e}\u{200f}\u{202a}\u{202b}\u{202c}\u{202d}\u{202e}\u{2066}\u{2067}\u{2068}\u{2069}"
        .contains(c)
}

fn steers(text: &str) -> bool {
    text.contains(|c: char| (c.is_control() && c != '\n') || turns(c))
}

/// What a Markdown reader shows: the text of each cell or paragraph, or the first mark-up in it.
fn read_markdown(text: &str) -> Result<Vec<String>, String> {
    let options = Options::ENABLE_TABLES
        | Options::ENABLE_FOOTNOTES
        | Options::ENABLE_STRIKETHROUGH
        | Options::ENABLE_MATH
        | Options::ENABLE_TASKLISTS;
    let mut parts = vec![String::new()];
    for event in Parser::new_ext(text, options) {
        match event {
            Event::Start(Tag::TableCell | Tag::Paragraph) => parts.push(String::new()),
            Event::Start(Tag::Table(_) | Tag::TableHead | Tag::TableRow) | Event::End(_) => {}
            Event::Text(part) => parts.last_mut().into_iter().for_each(|text| text.push_str(&part)),
            event => return Err(format!("{event:?}")),
        }
    }
    Ok(parts.split_off(1))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn nothing_steers_a_reader(name in name()) {
        for text in [
            escape::terminal(&name), escape::html(&name), escape::markdown(&name), escape::latex(&name),
            escape::comment(&name), escape::csv(&name),
        ] {
            prop_assert!(!steers(&text), "{text:?}");
        }
        for line in [escape::markdown(&name), escape::latex(&name), escape::comment(&name)] {
            prop_assert!(!line.contains(['\n', '\r']), "{line:?}");
        }
    }

    #[test]
    fn a_cell_stays_one_cell_and_no_formula(name in name()) {
        let row = format!("{},1\n", escape::csv(&name));
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(row.as_bytes());
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        prop_assert_eq!((rows.len(), rows[0].len()), (1, 2), "{}", row);
        prop_assert!(!rows[0][0].trim_start().starts_with(['=', '+', '-', '@']), "{row}");
    }

    #[test]
    fn no_part_of_a_comment_is_a_formula(name in name()) {
        let line = format!("# file = {}", escape::csv_comment(&name));
        prop_assert!(!line.contains(['\n', '\r']), "{line:?}");
        for part in line.split([',', ';']) {
            let begins = part.trim_start_matches(|c: char| c.is_whitespace() || c == '"' || c == '\u{fffd}');
            prop_assert!(!begins.starts_with(['=', '+', '-', '@']), "{line}");
        }
    }

    #[test]
    fn json_keeps_the_name(name in name()) {
        let plain = serde_json::to_string(&name).unwrap();
        let text = escape::json(&plain);
        prop_assert!(!steers(&text), "{text:?}");
        prop_assert_eq!(serde_json::from_str::<String>(&text).unwrap(), name);
    }

    #[test]
    fn html_and_svg_hold_it_as_text(name in name()) {
        let page = format!("<p title=\"{0}\">{0}</p>", escape::html(&name));
        let mut reader = quick_xml::Reader::from_str(&page);
        let mut elements = 0;
        loop {
            match reader.read_event() {
                Ok(quick_xml::events::Event::Eof) => break,
                Ok(quick_xml::events::Event::Start(start)) => {
                    elements += 1;
                    prop_assert_eq!(start.attributes().map(Result::unwrap).count(), 1, "{}", page);
                }
                Ok(event) => prop_assert!(!matches!(event, quick_xml::events::Event::Empty(_)), "{page}"),
                Err(error) => prop_assert!(false, "{error}: {page}"),
            }
        }
        prop_assert_eq!(elements, 1, "{}", page);
    }

    #[test]
    fn markdown_marks_nothing_up(name in name()) {
        let cell = escape::markdown_cell(&name);
        let table = read_markdown(&format!("| file |\n|---|\n| read {cell} |\n"));
        let table = table.map_err(|event| TestCaseError::fail(format!("{event}: {cell}")))?;
        prop_assert_eq!(table.len(), 2, "{}", cell);
        let line = escape::markdown(&name);
        let paragraphs = read_markdown(&format!("read {line}"));
        let paragraphs = paragraphs.map_err(|event| TestCaseError::fail(format!("{event}: {line}")))?;
        prop_assert_eq!(paragraphs.len(), 1, "{}", line);
    }

    #[test]
    fn latex_has_the_commands_of_the_escape_only(name in name()) {
        let mut text = escape::latex(&name);
        for known in ["\\textbackslash{}", "\\textasciitilde{}", "\\textasciicircum{}", "$<$", "$>$", "$|$"] {
            text = text.replace(known, "");
        }
        for (i, _) in text.match_indices('\\') {
            let next = text[i + 1..].chars().next();
            let greek = ["mu$", "Delta$", "delta$", "gamma$", "beta$", "Omega$", "pm$", "times$", "cdot$", "circ$", "surd$", "infty$"];
            let known = next.is_some_and(|c| "&%$#_{}".contains(c))
                || greek.iter().any(|g| text[i + 1..].starts_with(g));
            prop_assert!(known, "{text}");
        }
    }
}
