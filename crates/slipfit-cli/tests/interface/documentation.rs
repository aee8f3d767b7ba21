//! The documentation covers every warning and every page, and every file it points to exists.

use crate::common::root;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn pages() -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join("docs")).unwrap().map(|e| e.unwrap().path());
    entries.filter(|p| p.extension().is_some_and(|e| e == "md")).collect()
}

/// Codes of warnings in a source file: what its `fn code` returns.
fn codes(source: &str) -> BTreeSet<String> {
    let body = source.split("fn code(&self)").nth(1).unwrap().split("\n    }\n").next().unwrap();
    let quoted = body.split('"').skip(1).step_by(2);
    quoted.filter(|w| w.chars().all(|c| c.is_ascii_lowercase() || c == '_')).map(str::to_owned).collect()
}

#[test]
fn every_warning_has_its_paragraph() {
    let page = read("docs/warnings.md");
    let explained: BTreeSet<String> = page
        .lines()
        .filter_map(|line| line.strip_prefix('`')?.split_once("`: "))
        .map(|(code, _)| code.to_owned())
        .collect();
    let codes = codes(&read("crates/slipfit/src/answer/warning/mod.rs"));
    assert!(codes.len() >= 30, "{codes:?}");
    assert_eq!(explained, codes);
}

#[test]
fn every_page_is_in_the_summary_and_the_other_way_round() {
    let summary = read("docs/SUMMARY.md");
    let linked: BTreeSet<String> = links(&summary).into_iter().collect();
    let there: BTreeSet<String> = pages()
        .iter()
        .map(|p| p.file_name().unwrap().to_string_lossy().into_owned())
        .filter(|name| name != "SUMMARY.md")
        .collect();
    assert_eq!(linked, there);
}

/// Targets of links, without those to other sites and anchors within a page.
fn links(text: &str) -> Vec<String> {
    let mut outside = String::new();
    let mut inside = false;
    for line in text.lines() {
        if line.starts_with("```") {
            inside = !inside;
        } else if !inside {
            outside += line;
            outside.push('\n');
        }
    }
    outside
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split_once(')'))
        .map(|(target, _)| target.split('#').next().unwrap_or_default().to_owned())
        .filter(|target| !target.is_empty() && !target.contains("://"))
        .collect()
}

#[test]
fn no_link_of_a_page_leads_nowhere() {
    let mut seen = 0;
    let folder = root();
    let others = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "examples/README.md"];
    for page in pages().into_iter().chain(others.map(|p| folder.join(p))) {
        for target in links(&fs::read_to_string(&page).unwrap()) {
            let path = page.parent().unwrap_or(Path::new("")).join(&target);
            assert!(path.exists(), "{}: {target}", page.display());
            seen += 1;
        }
    }
    assert!(seen > 40, "{seen}");
}

/// The worked example of a loss term is the code itself, and the files it names exist.
#[test]
fn the_worked_example_is_the_code() {
    let page = read("docs/extending.md");
    let shown = |begin: &str| {
        let from = page.find(begin).unwrap_or_else(|| panic!("{begin}"));
        page[from..].split("```").next().unwrap().to_owned()
    };
    let file = read("crates/slipfit/src/model/loss/cubic.rs");
    let code = file.split("\n#[cfg(test)]").next().unwrap().trim_end();
    assert_eq!(shown("//! Nonlinear damping").trim_end(), code);
    let line = shown("    Cubic: ");
    assert!(read("crates/slipfit/src/model/loss/mod.rs").contains(line.as_str()), "{line}");

    let folders = ["slipfit/src", "slipfit-report/src", "slipfit-io/src", "slipfit", "slipfit-io"]
        .map(|folder| root().join("crates").join(folder));
    let named = page.split('`').skip(1).step_by(2).filter(|n| n.ends_with(".rs") && n.contains('/'));
    let missing: Vec<&str> = named.filter(|n| !folders.iter().any(|f| f.join(n).exists())).collect();
    // The reader of the other example, which does not exist.
    assert_eq!(missing, ["crates/slipfit-io/src/formats/ring.rs"]);
}
