//! Reports to hand in: a self-contained page, and tables.

use crate::common::{example, root, slipfit, stdout};
use quick_xml::Reader;
use quick_xml::events::Event;
use sha2::{Digest, Sha256};
use std::fs;

/// An analysis of each kind on the shipped examples, run in their folder.
const ANALYSES: [&[&str]; 4] = [
    &["ringdown", "classroom_pendulum.csv"],
    &["resonance", "tuning_fork_9nN_sweep.csv", "--reference", "tuning_fork_free_sweep.csv"],
    &["levels", "tuning_fork_9nN_levels.csv"],
    &["series", "tuning_fork.toml"],
];

fn run(arguments: &[&str]) -> String {
    stdout(slipfit().current_dir(root().join("examples")).args(arguments))
}

fn page(analysis: &[&str]) -> String {
    run(&[analysis, &["--html", "-"]].concat())
}

/// Elements with their attributes, and all text, unescaped; fails if it is not well-formed.
fn take_apart(xml: &str) -> (Vec<(String, String)>, String) {
    let mut reader = Reader::from_str(xml);
    reader.config_mut().check_end_names = true;
    let (mut elements, mut text) = (Vec::new(), String::new());
    loop {
        match reader.read_event().unwrap() {
            Event::Start(e) | Event::Empty(e) => {
                let pair = |a: quick_xml::events::attributes::Attribute<'_>| {
                    format!("{}={}", a.key.as_ref(), a.value)
                };
                let attributes: Vec<String> = e.attributes().map(|a| pair(a.unwrap())).collect();
                elements.push((e.name().as_ref().to_owned(), attributes.join("\n")));
            }
            Event::Text(t) => text += &t,
            Event::GeneralRef(r) => {
                text += match &*r {
                    "amp" => "&",
                    "lt" => "<",
                    "gt" => ">",
                    "quot" => "\"",
                    "#39" => "'",
                    other => panic!("&{other};"),
                };
            }
            Event::Eof => break,
            _ => {}
        }
    }
    (elements, text)
}

/// The pictures of a page.
fn pictures(page: &str) -> Vec<&str> {
    page.split("<figure>").skip(1).map(|rest| rest.split("</figure>").next().unwrap()).collect()
}

#[test]
fn every_analysis_gives_one_page_that_holds_its_answer() {
    for analysis in ANALYSES {
        let page = page(analysis);
        let (elements, text) = take_apart(&page);
        // The screen wraps the sentence; a series has its title above it.
        let screen = run(analysis);
        let told: Vec<&str> = screen.lines().take_while(|l| !l.is_empty()).collect();
        let sentence = told[usize::from(analysis[0] == "series")..].join(" ");
        assert!(text.contains(&sentence), "{analysis:?}: {sentence}");
        for name in analysis.iter().filter(|word| word.contains('.')) {
            let bytes = fs::read(example(name)).unwrap();
            let hash: String = Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect();
            assert!(text.contains(&hash), "{analysis:?}: {hash}");
        }
        assert!(text.contains(&format!("slipfit {}", analysis.join(" "))), "{analysis:?}");
        assert!(text.contains(concat!("slipfit ", env!("CARGO_PKG_VERSION"))), "{analysis:?}");
        assert!(text.contains("Eq. (2) of the paper"), "{analysis:?}");
        assert!(elements.iter().any(|(name, _)| name == "table"), "{analysis:?}");
        assert!(!pictures(&page).is_empty(), "{analysis:?}");
    }
}

#[test]
fn a_page_fetches_nothing() {
    for analysis in ANALYSES {
        let page = page(analysis);
        for word in ["http:", "https:", "//", "url(", "@import", "<link", "<img", "<iframe", "src="] {
            let found: Vec<&str> =
                page.match_indices(word).map(|(i, _)| page[i..].lines().next().unwrap()).collect();
            // The comment of the script itself is not an address.
            let found: Vec<&&str> = found.iter().filter(|line| !line.starts_with("// Values")).collect();
            assert!(found.is_empty(), "{analysis:?}: {word} in {found:?}");
        }
        assert!(page.contains("default-src 'none'"));
    }
}

#[test]
fn pictures_are_well_formed_and_their_dots_tell_values() {
    for analysis in ANALYSES {
        let page = page(analysis);
        assert!(page.matches("<title>").count() > 4, "{analysis:?}");
        for picture in pictures(&page) {
            let (elements, text) = take_apart(picture);
            assert_eq!(elements[0].0, "svg");
            assert!(elements.iter().any(|(name, a)| name == "rect" && a.contains("class=frame")));
            let dots = picture.matches("<circle").count();
            let told = picture.matches("<title>").count();
            // Dots in the legend represent no value.
            assert!(dots - told <= 4, "{analysis:?}: {dots} dots, {told} told");
            assert!(!text.contains("NaN"));
            assert!(!picture.contains("=\"NaN"));
        }
    }
    let svg = tempfile::tempdir().unwrap();
    let path = svg.path().join("swing.svg");
    run(&["ringdown", "classroom_pendulum.csv", "--plot", path.to_str().unwrap()]);
    let text = fs::read_to_string(path).unwrap();
    take_apart(&text);
    assert_eq!(text.matches("http").count(), 1, "the namespace alone");
    assert!(text.contains("<title>time "), "dots tell their values there as well");
}

#[test]
fn hostile_names_stay_text() {
    let folder = tempfile::tempdir().unwrap();
    let name = "<script>alert('x')</script> \"&amp; $(rm) `id` 100%_\\.csv";
    let name = name.replace('/', "∕");
    let data = fs::read_to_string(example("classroom_pendulum.csv")).unwrap();
    let data = data.replace("displacement (rad)", "displacement <img onerror=x> (rad)");
    fs::write(folder.path().join(&name), data).unwrap();
    let run = |flag: &str| {
        stdout(slipfit().current_dir(folder.path()).args(["ringdown", &name, "--signal", "2", flag, "-"]))
    };
    let page = run("--html");
    let (elements, text) = take_apart(&page);
    assert_eq!(elements.iter().filter(|(name, _)| name == "script").count(), 1, "its own");
    assert!(!elements.iter().any(|(name, _)| name == "img"));
    assert!(text.contains(&name), "{text}");
    // A shell parses the command line into the same words.
    let line = text.lines().find(|l| l.trim_start().starts_with("slipfit ringdown")).unwrap();
    assert_eq!(shlex::split(line.trim()).unwrap()[2], name);
    let table = run("--latex");
    assert!(table.lines().filter(|l| l.contains("alert")).all(|l| l.starts_with('%')), "{table}");
    let markdown = run("--md");
    assert!(markdown.starts_with("**&lt;script>"), "{markdown}");
}

#[test]
fn tables_of_the_examples_read_like_this() {
    for (analysis, name) in ANALYSES.iter().zip(["ringdown", "resonance", "levels", "series"]) {
        for flag in ["md", "latex"] {
            let text = run(&[analysis, &[&format!("--{flag}"), "-"][..]].concat());
            // The commit changes with every build.
            let kept: Vec<&str> = text.lines().filter(|l| !l.contains("slipfit 0")).collect();
            insta::assert_snapshot!(format!("{name}_{flag}"), kept.join("\n"));
        }
    }
}

#[test]
fn two_outputs_into_one_stream_are_refused() {
    let output = slipfit()
        .current_dir(root().join("examples"))
        .args(["ringdown", "classroom_pendulum.csv", "--html", "-", "--json", "-"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("--json and --html both go to standard output"), "{said}");
    assert!(output.stdout.is_empty());
}

#[test]
fn warnings_stand_on_the_page_with_their_codes() {
    let page = page(&["ringdown", "classroom_pendulum.csv", "--model", "viscous"]);
    let (_, text) = take_apart(&page);
    assert!(text.contains("Warning, model not preferred:"), "{text:.600}");
    assert!(text.contains("not in the model reported"));
}
