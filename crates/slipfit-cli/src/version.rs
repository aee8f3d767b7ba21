//! Version of the program and how it was called.

use slipfit_report::Provenance;

/// Version, and the commit of the build if it is known: `0.1.0 (0123456789ab)`.
pub(crate) fn long() -> String {
    match option_env!("SLIPFIT_COMMIT") {
        Some(commit) => format!("{} ({commit})", env!("CARGO_PKG_VERSION")),
        None => env!("CARGO_PKG_VERSION").to_owned(),
    }
}

/// Version and command line, for reports.
pub(crate) fn provenance() -> Provenance {
    Provenance { version: long(), call: quoted(arguments()) }
}

/// The words typed after the program's name; bytes that are not text are replaced.
pub(crate) fn arguments() -> impl Iterator<Item = String> {
    std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned())
}

fn quoted(words: impl Iterator<Item = String>) -> String {
    let mut line = "slipfit".to_owned();
    for word in words {
        line.push(' ');
        // A word with a zero byte cannot have been typed.
        line.push_str(&shlex::try_quote(&word).unwrap_or_default());
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_would_take_the_command_line_apart_again() {
        let typed = ["ringdown", "it's a \"swing\" & more.csv", "--stiffness", "12000±300", "$HOME", "-"];
        let line = quoted(typed.iter().map(|word| (*word).to_owned()));
        let back = shlex::split(&line).unwrap();
        assert_eq!(back[0], "slipfit");
        assert_eq!(back[1..], typed);
        assert!(!line.contains(" $HOME"), "{line}");
    }
}
