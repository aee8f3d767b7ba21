//! Recognises from its content whether slipfit wrote a file.
//!
//! | format | mark |
//! |---|---|
//! | JSON | `"schema": "slipfit/…"`, first or after the samples |
//! | CSV, LaTeX | a first comment `# slipfit …`, a comment `% slipfit …` |
//! | Markdown | a last line `slipfit …` |
//! | SVG, HTML | a comment, `<meta name="generator">` |
//! | PNG, WAV | the text chunks `Software`, `ISFT` |
//! | Parquet | `created_by` |
//! | Arrow | the key `slipfit_map` of its metadata |
//! | manual page | `.TH slipfit` |
//! | journal of a table | a first line `slipfit …` |
//! | `--table` as CSV, JSON, Markdown, LaTeX | the names of its first columns |
//!
//! An empty file holds nothing to lose. NPY has no room for a mark: such a file always
//! needs `--force`.

use crate::failure::Failure;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::Path;

/// The error for a file that slipfit did not write.
pub(crate) fn foreign(shown: &str) -> Failure {
    Failure::new(format!("{shown}: the file exists and was not written by slipfit"))
        .hint("--force replaces it; another name keeps it")
}

/// Number of bytes read from the start and from the end.
const BYTES_EXAMINED: u64 = 4096;

/// Whether it may be replaced without asking.
pub(super) fn is_ours(path: &Path) -> io::Result<bool> {
    let mut file = File::open(path)?;
    let mut head = Vec::new();
    file.by_ref().take(BYTES_EXAMINED).read_to_end(&mut head)?;
    if head.starts_with(b"PAR1") {
        return Ok(parquet_is_ours(file));
    }
    let length = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(length.saturating_sub(BYTES_EXAMINED)))?;
    let mut tail = Vec::new();
    file.take(BYTES_EXAMINED).read_to_end(&mut tail)?;
    Ok(bytes_are_ours(&head, &tail))
}

fn parquet_is_ours(file: File) -> bool {
    SerializedFileReader::new(file)
        .ok()
        .and_then(|r| Some(r.metadata().file_metadata().created_by()?.starts_with("slipfit ")))
        .unwrap_or(false)
}

fn bytes_are_ours(head: &[u8], tail: &[u8]) -> bool {
    if head.is_empty() {
        return true;
    }
    if head.starts_with(b"\x89PNG") {
        return holds(head, b"tEXtSoftware\0slipfit ");
    }
    if head.starts_with(b"ARROW1") {
        return holds(head, b"slipfit_map") || holds(tail, b"slipfit_map");
    }
    if head.starts_with(b"RIFF") {
        return tail.windows(16).any(|w| w.starts_with(b"ISFT") && w.ends_with(b"slipfit "));
    }
    let head = String::from_utf8_lossy(head);
    let tail = String::from_utf8_lossy(tail);
    let first = head.lines().next().unwrap_or_default();
    let last = tail.lines().rev().find(|l| !l.trim().is_empty()).unwrap_or_default();
    let squeezed = || head.chars().filter(|c| !c.is_whitespace()).take(80).collect::<String>();
    let marked = first.starts_with("# slipfit ")
        || head.lines().any(|l| l.starts_with("% slipfit ") || l.starts_with(".TH slipfit"))
        || (first.starts_with("<svg") && head.contains("<!-- slipfit "))
        || (first.starts_with("<!DOCTYPE html") && head.contains("name=\"generator\" content=\"slipfit "))
        || named_version(first)
        || named_version(last);
    let table = first.starts_with("file,status,reason,model,")
        || first.starts_with("| file | status | model | frequency |")
        || head.lines().nth(1).is_some_and(|l| l.starts_with("file & status & model & frequency &"));
    marked || table || {
        let squeezed = squeezed();
        squeezed.starts_with("{\"schema\":\"slipfit/")
            || (squeezed.starts_with("[{\"file\":")
                && head.contains("\"status\":")
                && head.contains("\"reason\":"))
            || (squeezed.starts_with('{') && tail.contains("\n  \"schema\": \"slipfit/"))
    }
}

/// `slipfit 0.1.0`, with or without a commit.
fn named_version(line: &str) -> bool {
    line.strip_prefix("slipfit ").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
}

fn holds(bytes: &[u8], mark: &[u8]) -> bool {
    bytes.windows(mark.len()).any(|w| w == mark)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ours(text: &str) -> bool {
        bytes_are_ours(text.as_bytes(), text.as_bytes())
    }

    #[test]
    fn marks_are_known() {
        for text in [
            "",
            "# slipfit 0.1.0 ringdown\n# file = a.csv\n",
            "% a.csv: sentence\n% slipfit 0.1.0 (abc)\n\\begin{tabular}",
            "{\n  \"schema\": \"slipfit/ringdown-1\",\n",
            "[\n  {\n    \"file\": \"a.csv\",\n    \"status\": \"done\",\n    \"reason\": \"\",\n",
            "file,status,reason,model,frequency_hz\n",
            "**a.csv**: a sentence\n\n`a.csv` SHA-256 00  \nslipfit 0.1.0 (210515bbb0ed)\n",
            "<svg xmlns=\"http://www.w3.org/2000/svg\">\n<!-- slipfit 0.1.0 -->\n",
            "ARROW1\0\0 slipfit_map",
            ".ie \\n(.g .ds Aq \\(aq\n.el .ds Aq '\n.TH slipfit-man 1  \"man \" \n",
        ] {
            assert!(ours(text), "{text}");
        }
    }

    #[test]
    fn measurements_of_others_are_not_ours() {
        for text in [
            "time (s),angle (rad)\n0,1\n",
            "# exported by slipfitter\n0,1\n",
            "{\"data\": [1, 2], \"note\": \"compare slipfit/ringdown-1\"}",
            "notes on\nslipfit and other programs\n",
            "[{\"file\": \"a.csv\", \"size\": 3}]",
            "file,status\na,b\n",
            "<svg></svg>\n",
            "\u{89}PNG",
            "ARROW1\0\0 a table of others",
            " ",
        ] {
            assert!(!ours(text), "{text}");
        }
        assert!(!bytes_are_ours(b"\x89PNG\r\n\x1a\n", b""));
        assert!(!bytes_are_ours(b"RIFF\x00\x00\x00\x00WAVE", b"data"));
    }
}
