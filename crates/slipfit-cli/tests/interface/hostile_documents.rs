//! Whole documents about files with hostile names, headers and units: each output is parsed by a parser of its
//! format and has the structure of the same document about a file with tame names.
#![cfg(unix)]

use crate::common::{example, root, slipfit};
use html5gum::{DefaultEmitter, Token, Tokenizer};
use pulldown_cmark::{Event, Options, Parser, Tag};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// Names of files, units and conditions with a meaning in some format.
const HOSTILE: [&str; 22] = [
    "=cmd()|' C calc'!A0",
    "a,=1+1;@SUM(A1)",
    "+1",
    "-1",
    "@SUM(A1:A9)",
    "\t=1",
    "<script>alert(1)<!--",
    "\" onload=\"alert(1)",
    "' onload='alert(1)",
    "a|b|c",
    "\\input{x}\\write18{id}%",
    "$x_{1}$ & # ~ ^ {",
    "\\",
    "\u{1b}[31mred\u{1b}]0;title\u{7}",
    "\u{9b}2J",
    "abc\u{202e}vsc.exe\u{2066}",
    "two\nlines\r\n\n# heading\n- item\n> quote",
    "[x](javascript:alert(1)) ![i](x) <b>",
    "*b* _i_ `c` ~~d~~ [^1]: x",
    "x_<img src=x onerror=alert(1)>",
    "x_}$\\relax",
    "]]>&lt;&amp;--><![CDATA[",
];

/// The tame replacement for them.
const TAME: &str = "tame";

/// A name as a TOML value.
fn toml(name: &str) -> String {
    let escaped: String = name.chars().map(|c| format!("\\U{:08x}", u32::from(c))).collect();
    format!("\"{escaped}\"")
}

/// A folder with a measurement of each kind; files, titles and conditions are named `name`.
fn folder(name: &str) -> TempDir {
    folder_with(name, TAME)
}

/// The same, with a column of this name and unit in the ring-down.
fn folder_with(name: &str, column: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = |kind: &str, ending: &str| folder.path().join(format!("{kind}{name}.{ending}"));
    let header = format!("{column} ({})", column.replace(' ', "")).replace(['\n', '\r'], " ");
    let mut text = format!("time (s),\"{}\"\n", header.replace('"', "\"\""));
    for i in 0..1500 {
        let t = 0.02 * f64::from(i);
        let noise = 1e-4 * (7.7 * f64::from(i * i)).sin();
        text += &format!("{t:.2},{:.5}\n", 0.3 * (-0.04 * t).exp() * (7.85 * t).cos() + noise);
    }
    fs::write(path("swing", "csv"), text).unwrap();
    for (from, kind) in [
        ("tuning_fork_9nN_sweep.csv", "sweep"),
        ("tuning_fork_free_sweep.csv", "free"),
        ("tuning_fork_9nN_levels.csv", "levels"),
        ("tuning_fork_9nN.csv", "decay"),
    ] {
        fs::copy(example(from), path(kind, "csv")).unwrap();
    }
    fs::copy(root().join("validation/reference/maps/stack.npy"), path("stack", "npy")).unwrap();
    let file = |kind: &str| toml(path(kind, "csv").file_name().unwrap().to_str().unwrap());
    let manifest = format!(
        "title = {0}\ncondition = {0}\n\
         [[measurement]]\nname = {0}\ncondition = {0}\nsweep = {1}\nreference = {2}\n\
         [[measurement]]\nname = {0}\ncondition = {0}\nringdown = {3}\n",
        toml(name),
        file("sweep"),
        file("free"),
        file("decay"),
    );
    fs::write(path("series", "toml"), manifest).unwrap();
    folder
}

/// A command, its inputs by kind and extension, and its further flags.
type Invocation = (&'static str, &'static [(&'static str, &'static str)], &'static [&'static str]);

/// The commands that analyse.
const COMMANDS: [Invocation; 4] = [
    ("ringdown", &[("swing", "csv")], &[]),
    ("resonance", &[("sweep", "csv")], &[]),
    ("levels", &[("levels", "csv")], &[]),
    ("series", &[("series", "toml")], &[]),
];

fn run(folder: &Path, command: &str, name: &str, inputs: &[(&str, &str)], flags: &[&str]) -> Output {
    let mut slipfit = slipfit();
    slipfit.current_dir(folder).arg(command).args(flags).arg("--");
    slipfit.args(inputs.iter().map(|(kind, ending)| format!("{kind}{name}.{ending}")));
    let output = slipfit.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command} {flags:?} on {name:?}: {said}");
    output
}

/// The document that a flag writes to standard output.
fn document(command: &str, name: &str, inputs: &[(&str, &str)], flags: &[&str]) -> String {
    of_folder(&folder(name), command, name, inputs, flags)
}

fn of_folder(folder: &TempDir, command: &str, name: &str, inputs: &[(&str, &str)], flags: &[&str]) -> String {
    String::from_utf8(run(folder.path(), command, name, inputs, flags).stdout).unwrap()
}

fn turns(c: char) -> bool {
    matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Checks that there is no character that a terminal or a reader would act on.
fn is_inert(text: &str, what: &str) {
    let found = text.find(|c: char| (c.is_control() && c != '\n') || turns(c));
    assert_eq!(found.map(|at| &text[at.saturating_sub(40)..]), None, "{what}");
}

/// Checks that the result is that of `of(TAME)` for every hostile name.
fn as_if_tame<T: PartialEq + std::fmt::Debug>(what: &str, of: impl Fn(&str) -> Vec<T>) {
    let tame = of(TAME);
    for name in HOSTILE {
        let found = of(name);
        let differ = found.iter().zip(&tame).position(|(a, b)| a != b).or(Some(found.len().min(tame.len())));
        let show =
            |all: &[T], at: usize| format!("{:?}", all.get(at.saturating_sub(2)..all.len().min(at + 3)));
        let parts = differ.map(|at| (show(&found, at), show(&tame, at)));
        assert!(found == tame, "{what}, {name:?}: {parts:#?}");
    }
}

#[test]
fn nothing_steers_the_terminal() {
    for name in HOSTILE {
        let folder = folder_with(name, name);
        let inspect = ("inspect", &[("swing", "csv")][..], &[][..]);
        let map = ("map", &[("stack", "npy")][..], &["--dt", "0.02"][..]);
        let table = ("ringdown", &[("swing", "csv"), ("decay", "csv")][..], &[][..]);
        for (command, inputs, flags) in COMMANDS.into_iter().chain([inspect, map, table]) {
            let output = run(folder.path(), command, name, inputs, flags);
            for bytes in [output.stdout, output.stderr] {
                is_inert(&String::from_utf8(bytes).unwrap(), &format!("{command}, {name:?}"));
            }
        }
        // The message about a bad file contains its name and its header.
        fs::write(folder.path().join(format!("bad{name}.csv")), format!("{name}\nno numbers\n")).unwrap();
        for command in ["ringdown", "resonance", "levels", "series", "inspect"] {
            let mut slipfit = slipfit();
            let bad = format!("bad{name}.csv");
            let output = slipfit.current_dir(folder.path()).args([command, "--", &bad]).output().unwrap();
            // The contents of a file are shown even if it cannot be used.
            let code = output.status.code();
            assert!(code == Some(2) || command == "inspect" && code == Some(0), "{command}, {name:?}");
            is_inert(&String::from_utf8(output.stdout).unwrap(), &format!("{command}, {name:?}"));
            is_inert(&String::from_utf8(output.stderr).unwrap(), &format!("error of {command}, {name:?}"));
        }
    }
}

/// Tags with the names of their attributes, and declarations; for comments only that there are any.
fn html_structure(page: &str) -> Vec<String> {
    let mut emitter = DefaultEmitter::default();
    emitter.naively_switch_states(true);
    let mut found = Vec::new();
    for Ok(token) in Tokenizer::new_with_emitter(page, emitter) {
        match token {
            Token::StartTag(tag) => {
                let names = tag.attributes.keys().map(|k| String::from_utf8_lossy(k).into_owned());
                let name = String::from_utf8_lossy(&tag.name).into_owned();
                found.push(format!("<{name} {}>", names.collect::<Vec<_>>().join(" ")));
            }
            Token::EndTag(tag) => found.push(format!("</{}>", String::from_utf8_lossy(&tag.name))),
            Token::Comment(_) => found.push("<!-- -->".to_owned()),
            Token::Doctype(_) => found.push("<!DOCTYPE>".to_owned()),
            Token::Error(error) => panic!("{error:?}"),
            Token::String(_) => {}
        }
    }
    assert!(found.len() > 50, "{found:?}");
    found
}

#[test]
fn a_page_has_no_other_element_and_no_other_attribute() {
    for (command, inputs, _) in COMMANDS {
        as_if_tame(command, |name| {
            let page = document(command, name, inputs, &["--html", "-", "-q"]);
            is_inert(&page, name);
            // It is XML as well, so attribute names are unique and all end tags exist.
            let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
            let tree = roxmltree::Document::parse_with_options(&page, options).unwrap();
            assert!(tree.descendants().filter(|n| n.has_tag_name("script")).count() == 1);
            html_structure(&page)
        });
    }
}

#[test]
fn a_picture_has_no_other_element_and_no_other_attribute() {
    let stack: (&str, &[(&str, &str)], &[&str]) = ("map", &[("stack", "npy")], &["--dt", "0.02"]);
    let files: (&str, &[(&str, &str)], &[&str]) = ("ringdown", &[("swing", "csv"), ("decay", "csv")], &[]);
    for (command, inputs, flags) in COMMANDS.into_iter().chain([stack, files]) {
        as_if_tame(command, |name| {
            let folder = folder(name);
            let flags = [flags, &["--plot", "out.svg", "-q"]].concat();
            run(folder.path(), command, name, inputs, &flags);
            let picture = fs::read_to_string(folder.path().join("out.svg")).unwrap();
            is_inert(&picture, name);
            let tree = roxmltree::Document::parse(&picture).unwrap();
            let of = |node: roxmltree::Node<'_, '_>| {
                let names: Vec<_> = node.attributes().map(|a| a.name().to_owned()).collect();
                (node.tag_name().name().to_owned(), names)
            };
            // Text inside Markdown is drawn as letters, each a shape or a text.
            let kinds: Vec<_> = tree.descendants().filter(roxmltree::Node::is_element).map(of).collect();
            assert!(kinds.iter().all(|(kind, _)| {
                !["script", "a", "foreignObject", "image", "style"].contains(&kind.as_str())
                    || kind == "style"
            }));
            kinds.into_iter().filter(|(kind, _)| kind != "text" && kind != "tspan").collect::<Vec<_>>()
        });
    }
}

/// Other words in a header may cause another remark on what was read, but not another kind of element.
#[test]
fn headers_and_units_are_text_in_every_document() {
    let kinds = |mut list: Vec<String>| {
        list.sort();
        list.dedup();
        list
    };
    let swing = [("swing", "csv")];
    as_if_tame("a page", |column| {
        let folder = folder_with(TAME, column);
        let page = of_folder(&folder, "ringdown", TAME, &swing, &["--html", "-", "-q"]);
        is_inert(&page, column);
        roxmltree::Document::parse_with_options(
            &page,
            roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() },
        )
        .unwrap();
        kinds(html_structure(&page))
    });
    as_if_tame("Markdown", |column| {
        let folder = folder_with(TAME, column);
        let text = of_folder(&folder, "ringdown", TAME, &swing, &["--md", "-", "-q"]);
        is_inert(&text, column);
        kinds(markdown_structure(&text))
    });
    as_if_tame("CSV", |column| {
        let folder = folder_with(TAME, column);
        let mut rows =
            csv_structure(&of_folder(&folder, "ringdown", TAME, &swing, &["--csv", "-", "-q"]), column);
        rows.dedup();
        rows
    });
    as_if_tame("a picture", |column| {
        let folder = folder_with(TAME, column);
        run(folder.path(), "ringdown", TAME, &swing, &["--plot", "out.svg", "-q"]);
        let picture = fs::read_to_string(folder.path().join("out.svg")).unwrap();
        is_inert(&picture, column);
        let tree = roxmltree::Document::parse(&picture).unwrap();
        kinds(tree.descendants().map(|n| n.tag_name().name().to_owned()).collect())
    });
}

/// Events without their texts; raw HTML other than subscripts is a failure.
fn markdown_structure(text: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for event in Parser::new_ext(text, Options::all()) {
        match event {
            Event::Text(_) | Event::SoftBreak | Event::HardBreak => {
                if found.last().is_none_or(|last| last != "text") {
                    found.push("text".to_owned());
                }
            }
            Event::InlineHtml(tag) => {
                assert!(["<sub>", "</sub>"].contains(&&*tag), "{tag} in {text}");
                found.push(tag.to_string());
            }
            Event::Start(Tag::Link { .. } | Tag::Image { .. }) => panic!("a link in {text}"),
            Event::Start(tag) => found.push(format!("{tag:?}")),
            Event::End(tag) => found.push(format!("end {tag:?}")),
            Event::Code(_) => found.push("code".to_owned()),
            other => panic!("{other:?} in {text}"),
        }
    }
    // A cell may be empty: text or no text count as the same.
    found.retain(|event| event != "text");
    found
}

#[test]
fn markdown_has_no_markup_of_others() {
    for (command, inputs, _) in COMMANDS {
        as_if_tame(command, |name| {
            let text = document(command, name, inputs, &["--md", "-", "-q"]);
            is_inert(&text, name);
            markdown_structure(&text)
        });
    }
    let files = [("swing", "csv"), ("decay", "csv")];
    as_if_tame("a table", |name| {
        let folder = folder(name);
        run(folder.path(), "ringdown", name, &files, &["--table", "out.md", "-q"]);
        markdown_structure(&fs::read_to_string(folder.path().join("out.md")).unwrap())
    });
}

/// Rows of a text table; no cell other than a number begins like a formula.
fn csv_structure(text: &str, what: &str) -> Vec<usize> {
    is_inert(text, what);
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(text.as_bytes());
    let records: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    // In some locales spreadsheets split at semicolons, regardless of quotes, and split comments like any line.
    let cells = records.iter().flatten().chain(text.lines().flat_map(|line| line.split(';')));
    for cell in cells.map(|cell| cell.trim_start_matches(|c: char| c.is_whitespace() || c == '"')) {
        let formula = cell.starts_with(['=', '+', '-', '@', '\t', '\r']);
        assert!(!formula || cell.parse::<f64>().is_ok(), "{cell:?} in {what}");
    }
    let rows = records.iter().filter(|r| !r[0].starts_with('#'));
    rows.map(csv::StringRecord::len).collect()
}

#[test]
fn csv_holds_cells_and_no_formulas() {
    for (command, inputs, _) in COMMANDS {
        as_if_tame(command, |name| {
            csv_structure(&document(command, name, inputs, &["--csv", "-", "-q"]), name)
        });
    }
    let files = [("swing", "csv"), ("decay", "csv")];
    as_if_tame("a table", |name| {
        let folder = folder(name);
        run(folder.path(), "ringdown", name, &files, &["--table", "out.csv", "-q"]);
        csv_structure(&fs::read_to_string(folder.path().join("out.csv")).unwrap(), name)
    });
    as_if_tame("a map", |name| {
        let csv = document("map", name, &[("stack", "npy")], &["--dt", "0.02", "--table", "-", "-q"]);
        csv_structure(&csv, name)
    });
    as_if_tame("a simulation", |unit| {
        let decay = "simulate decay --frequency-hz 1 --q 9 --amplitude 1 --duration 2 --rate-hz 20";
        let output = slipfit().args(decay.split(' ')).arg(format!("--unit={unit}")).output().unwrap();
        csv_structure(&String::from_utf8(output.stdout).unwrap(), unit)
    });
}

/// Keys in their order and the kinds of values; a number may be missing if a name is not a number.
fn json_structure(value: &serde_json::Value, out: &mut Vec<String>) {
    match value {
        serde_json::Value::Object(map) => {
            for (key, value) in map {
                out.push(key.clone());
                // A file with longer names is longer.
                if key != "bytes" {
                    json_structure(value, out);
                }
            }
        }
        serde_json::Value::Array(list) => list.iter().for_each(|value| json_structure(value, out)),
        serde_json::Value::String(_) => out.push("text".to_owned()),
        serde_json::Value::Number(_) | serde_json::Value::Null => out.push("number".to_owned()),
        serde_json::Value::Bool(value) => out.push(value.to_string()),
    }
}

#[test]
fn json_has_the_names_as_they_are() {
    for (command, inputs, _) in COMMANDS {
        as_if_tame(command, |name| {
            let text = document(command, name, inputs, &["--json", "-", "-q"]);
            is_inert(&text, name);
            let answer: serde_json::Value = serde_json::from_str(&text).unwrap();
            let (kind, ending) = inputs[0];
            assert!(
                answer.to_string().contains(&serde_json::json!(format!("{kind}{name}.{ending}")).to_string())
            );
            let mut structure = Vec::new();
            json_structure(&answer, &mut structure);
            structure
        });
    }
}

#[test]
fn latex_is_typeset_by_a_tex_engine() {
    let mut pages = String::new();
    let files = [("swing", "csv"), ("decay", "csv")];
    for name in HOSTILE {
        let folder = folder_with(name, name);
        for (command, inputs, _) in COMMANDS {
            pages += &of_folder(&folder, command, name, inputs, &["--latex", "-", "-q"]);
            pages += "\n\\newpage\n";
        }
        run(folder.path(), "ringdown", name, &files, &["--table", "out.tex", "-q"]);
        pages += &fs::read_to_string(folder.path().join("out.tex")).unwrap();
        pages += "\n\\newpage\n";
    }
    is_inert(&pages, "LaTeX");
    let folder = tempfile::tempdir().unwrap();
    // A name that acted as a command would write a file or end the document.
    let text =
        format!("\\documentclass{{article}}\n\\begin{{document}}\n{pages}last page\n\\end{{document}}\n");
    fs::write(folder.path().join("all.tex"), text).unwrap();
    let mut engine = Command::new("pdflatex");
    let output = engine
        .current_dir(folder.path())
        .args(["-no-shell-escape", "-interaction=nonstopmode", "-halt-on-error", "all.tex"])
        .output();
    let Ok(output) = output else {
        assert!(std::env::var_os("SLIPFIT_TEX").is_none(), "SLIPFIT_TEX is set, but there is no pdflatex");
        #[allow(clippy::print_stderr, reason = "what is not tested is said")]
        {
            eprintln!("LaTeX NOT typeset: there is no pdflatex; SLIPFIT_TEX=1 makes that a failure");
        }
        return;
    };
    let said = String::from_utf8_lossy(&output.stdout);
    let error = said.find("\n!").map(|at| said[at..].chars().take(500).collect::<String>());
    assert!(output.status.success(), "{error:?}");
    let wanted = 5 * HOSTILE.len() + 1;
    assert!(said.replace('\n', "").contains(&format!("({wanted} pages")), "{said}");
}
