//! The command's information on itself: version, completions, manual pages.

use crate::common::{slipfit, stdout};
use std::process::{Command, Stdio};

#[test]
fn the_version_names_the_commit_where_there_is_a_repository() {
    let text = stdout(slipfit().arg("--version"));
    let said = text.trim().strip_prefix(concat!("slipfit ", env!("CARGO_PKG_VERSION"))).unwrap();
    let repository = Command::new("git")
        .args(["rev-parse", "--show-prefix"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .is_ok_and(|o| o.status.success() && o.stdout.starts_with(b"crates/slipfit-cli/"));
    if repository {
        let commit = said.strip_prefix(" (").and_then(|s| s.strip_suffix(')')).unwrap();
        assert!(commit.len() == 12, "{said}");
        assert!(commit.bytes().all(|b| b.is_ascii_hexdigit()), "{said}");
    } else {
        assert!(said.is_empty() || said.starts_with(" ("), "{said}");
    }
}

#[test]
fn every_shell_gets_completions_that_know_the_commands() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = stdout(slipfit().args(["completions", shell]));
        for word in ["ringdown", "resonance", "levels", "series", "--html", "--table"] {
            // Fish and others write long options without their dashes.
            assert!(script.contains(word.trim_start_matches('-')), "{shell}: {word}");
        }
    }
    let refused = slipfit().args(["completions", "tcsh"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn bash_takes_its_completions() {
    let script = stdout(slipfit().args(["completions", "bash"]));
    let complete = format!(
        "{script}\nCOMP_WORDS=(slipfit ringdown --ht); COMP_CWORD=2; _slipfit slipfit --ht ringdown; \
         echo \"${{COMPREPLY[@]}}\""
    );
    let Ok(output) = Command::new("bash").args(["-c", &complete]).stderr(Stdio::null()).output() else {
        return;
    };
    assert_eq!(String::from_utf8(output.stdout).unwrap().trim(), "--html");
}

#[test]
fn there_is_a_manual_page_for_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("man");
    assert_eq!(stdout(slipfit().args(["man", "--out"]).arg(&pages)), "");
    for page in ["slipfit", "slipfit-ringdown", "slipfit-simulate-decay", "slipfit-series"] {
        let text = std::fs::read_to_string(pages.join(format!("{page}.1"))).unwrap();
        assert!(text.contains(".TH"), "{page}");
        assert!(text.contains(".SH NAME"), "{page}");
    }
    let main = stdout(slipfit().arg("man"));
    assert_eq!(main, std::fs::read_to_string(pages.join("slipfit.1")).unwrap());
}

/// Tests are built without `SLIPFIT_SITE`.
#[test]
fn a_program_without_the_page_says_how_to_build_it_in() {
    let mut app = slipfit();
    let output =
        app.args(["app", "--no-browser"]).timeout(std::time::Duration::from_secs(30)).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("built without the browser page") && said.contains("SLIPFIT_SITE"), "{said}");
}
