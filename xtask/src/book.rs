//! Runs the commands of the documentation and compares their output with what the pages show.
//!
//! A page shows a command in a `console` block, after `$ `, with its output below:
//!
//! ```console
//! $ slipfit --version
//! slipfit 0.1.0 (0123456789ab)
//! ```
//!
//! All commands of a page run one after the other, by `sh`, in a separate folder that starts as a copy of
//! `examples/`, with standard error appended to standard output. Only the version and commit of slipfit are ignored
//! in the comparison.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use crate::Failure;
use crate::places::{root, slipfit};

/// Folders of the pages with commands.
const PAGES: [&str; 3] = ["docs", "examples", "."];

/// `cargo xtask book [--write]`.
pub(crate) fn chore(arguments: &[String]) -> Result<ExitCode, Failure> {
    let write = match arguments {
        [] => false,
        [flag] if flag == "--write" => true,
        _ => return Err("cargo xtask book takes --write only".into()),
    };
    let found = check(write)?;
    println!("{} commands on {} pages, {} other than shown", found.commands, found.pages, found.differ.len());
    for difference in &found.differ {
        println!("\n{difference}");
    }
    Ok(if found.differ.is_empty() || write { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Result of running the commands.
pub(crate) struct Found {
    pub(crate) commands: usize,
    pub(crate) pages: usize,
    /// Page, line, command, output shown and output printed.
    pub(crate) differ: Vec<String>,
}

/// Runs all commands; with `write`, the pages are updated with the output.
pub(crate) fn check(write: bool) -> Result<Found, Failure> {
    let slipfit = slipfit()?;
    let programs = slipfit.parent().ok_or("the program lies in no folder")?;
    let mut found = Found { commands: 0, pages: 0, differ: Vec::new() };
    for page in pages()? {
        let text = fs::read_to_string(&page)?;
        let shown = page.strip_prefix(root()).unwrap_or(&page).display().to_string();
        let Some(renewed) = one(&text, &shown, programs, &mut found)? else { continue };
        found.pages += 1;
        if write && renewed != text {
            fs::write(&page, renewed)?;
        }
    }
    Ok(found)
}

fn pages() -> Result<Vec<PathBuf>, Failure> {
    let mut pages = Vec::new();
    for folder in PAGES {
        for entry in fs::read_dir(root().join(folder))? {
            let path = entry?.path();
            if path.extension().is_some_and(|e| e == "md") {
                pages.push(path);
            }
        }
    }
    pages.sort();
    Ok(pages)
}

/// The text of a page with the output of its commands updated; `None` if it has no commands.
fn one(text: &str, page: &str, programs: &Path, found: &mut Found) -> Result<Option<String>, Failure> {
    let commands = commands(text);
    if commands.is_empty() {
        return Ok(None);
    }
    let folder = Workplace::new()?;
    let mut renewed: Vec<String> = Vec::new();
    let lines: Vec<&str> = text.lines().collect();
    let mut next = 0;
    for Shown { line, command, output } in commands {
        renewed.extend(lines[next..=line].iter().map(|l| (*l).to_owned()));
        next = line + 1 + output.len();
        let printed = printed(&command, &folder.0, programs)?;
        found.commands += 1;
        let wanted: Vec<String> = output.iter().map(|l| unversioned(l)).collect();
        let given: Vec<String> = printed.iter().map(|l| unversioned(l)).collect();
        if wanted == given {
            renewed.extend(output);
        } else {
            let (shown, said) = (output.join("\n"), printed.join("\n"));
            found.differ.push(format!("{page}:{}: $ {command}\nshown:\n{shown}\nprinted:\n{said}", line + 1));
            renewed.extend(printed);
        }
    }
    renewed.extend(lines[next..].iter().map(|l| (*l).to_owned()));
    Ok(Some(renewed.join("\n") + "\n"))
}

/// A command of a page.
#[derive(Debug, PartialEq)]
struct Shown {
    /// Line number of the command, from zero.
    line: usize,
    command: String,
    output: Vec<String>,
}

fn commands(text: &str) -> Vec<Shown> {
    let mut all: Vec<Shown> = Vec::new();
    let mut inside = false;
    for (line, content) in text.lines().enumerate() {
        if content.starts_with("```") {
            inside = !inside && content == "```console";
        } else if inside && let Some(command) = content.strip_prefix("$ ") {
            all.push(Shown { line, command: command.to_owned(), output: Vec::new() });
        } else if inside && let Some(last) = all.last_mut() {
            last.output.push(content.to_owned());
        }
    }
    all
}

/// The output of a command, without trailing blanks on its lines.
fn printed(command: &str, folder: &Path, programs: &Path) -> Result<Vec<String>, Failure> {
    let mut path = OsString::from(programs);
    if let Some(others) = std::env::var_os("PATH") {
        path.push(if cfg!(windows) { ";" } else { ":" });
        path.push(others);
    }
    let output = Command::new("sh")
        .args(["-c", command])
        .current_dir(folder)
        .env("PATH", path)
        .env_remove("NO_COLOR")
        .env_remove("CLICOLOR_FORCE")
        .env_remove("COLUMNS")
        .output()
        .map_err(|error| format!("`sh` could not be started: {error}"))?;
    let both = [output.stdout, output.stderr].concat();
    Ok(String::from_utf8_lossy(&both).lines().map(|line| line.trim_end().to_owned()).collect())
}

/// A line without the version of slipfit and the commit it was built from.
fn unversioned(line: &str) -> String {
    const NAME: &str = "slipfit ";
    let mut out = String::new();
    let mut rest = line;
    while let Some(at) = rest.find(NAME) {
        let (before, after) = rest.split_at(at + NAME.len());
        out.push_str(before);
        rest = after;
        let version = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        if rest[..version].matches('.').count() == 2 {
            out.push('V');
            rest = &rest[version..];
            if let Some(commit) = rest.strip_prefix(" (")
                && let Some((hash, after)) = commit.split_once(')')
                && hash.len() == 12
                && hash.bytes().all(|b| b.is_ascii_hexdigit())
            {
                rest = after;
            }
        }
    }
    out + rest
}

/// A folder that starts as a copy of the examples and is removed at the end.
struct Workplace(PathBuf);

impl Workplace {
    fn new() -> Result<Self, Failure> {
        let folder = std::env::temp_dir().join(format!("slipfit-book-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder)?;
        let place = Self(folder);
        for entry in fs::read_dir(root().join("examples"))? {
            let entry = entry?;
            fs::copy(entry.path(), place.0.join(entry.file_name()))?;
        }
        Ok(place)
    }
}

impl Drop for Workplace {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_taken_from_console_blocks_alone() {
        let page = "a\n```console\n$ slipfit --version\nslipfit 0.1.0\n$ ls\n```\n```sh\n$ not this\n```\n$ nor this\n";
        let found = commands(page);
        assert_eq!(found.len(), 2);
        assert_eq!(found[0].command, "slipfit --version");
        assert_eq!((found[0].line, found[0].output.as_slice()), (2, &["slipfit 0.1.0".to_owned()][..]));
        assert!(found[1].output.is_empty());
    }

    #[test]
    fn nothing_but_version_and_commit_is_made_equal() {
        assert_eq!(unversioned("slipfit 0.1.0 (0123456789ab)"), unversioned("slipfit 1.20.3"));
        assert_eq!(unversioned("# slipfit 0.1.0 ringdown"), "# slipfit V ringdown");
        assert_eq!(unversioned("slipfit ringdown a.csv"), "slipfit ringdown a.csv");
        assert_ne!(unversioned("x_F = 2.0"), unversioned("x_F = 2.1"));
        assert_eq!(unversioned("slipfit 0.1.0 (of old)"), "slipfit V (of old)");
    }

    #[test]
    fn a_page_with_another_output_is_found_and_mended() {
        if !Path::new("/bin/sh").exists() {
            return;
        }
        let page = "```console\n$ echo one; echo two\none\nthree\n```\nafter\n";
        let mut found = Found { commands: 0, pages: 0, differ: Vec::new() };
        let renewed = one(page, "page.md", Path::new("/nowhere"), &mut found).unwrap().unwrap();
        assert_eq!(renewed, "```console\n$ echo one; echo two\none\ntwo\n```\nafter\n");
        assert_eq!((found.commands, found.differ.len()), (1, 1));
        assert!(found.differ[0].starts_with("page.md:2: $ echo one"));
    }
}
