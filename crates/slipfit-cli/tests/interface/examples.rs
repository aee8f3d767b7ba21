//! The shipped examples are the output of their commands.

use crate::common::{example, root, slipfit};

/// The commands in examples/README.md: one per paragraph, lines joined at the backslash.
fn commands() -> Vec<Vec<String>> {
    let readme = std::fs::read_to_string(root().join("examples/README.md")).unwrap();
    readme
        .replace("\\\n", " ")
        .lines()
        .filter_map(|line| line.strip_prefix("slipfit simulate "))
        .map(|rest| std::iter::once("simulate").chain(rest.split_whitespace()).map(str::to_owned).collect())
        .collect()
}

#[test]
fn the_commands_write_the_same_bytes_again() {
    let commands = commands();
    assert_eq!(commands.len(), 8);
    let folder = tempfile::tempdir().unwrap();
    for command in commands {
        slipfit().current_dir(folder.path()).args(&command).assert().success().stdout("").stderr("");
        let name = command.last().unwrap();
        let (made, shipped) = (std::fs::read(folder.path().join(name)), std::fs::read(example(name)));
        assert!(made.unwrap() == shipped.unwrap(), "{name} differs from what its command writes");
    }
}

#[test]
fn another_seed_writes_another_record() {
    let write = |seed: &str| {
        let command = ["simulate", "decay", "--frequency-hz", "1", "--amplitude", "1", "--duration", "1"];
        let rest = ["--rate-hz", "20", "--noise-rms", "0.1", "--seed", seed];
        crate::common::stdout(slipfit().args(command).args(rest))
    };
    assert_eq!(write("7"), write("7"));
    assert_ne!(write("7"), write("8"));
}

#[test]
fn examples_stay_small() {
    let total: u64 = std::fs::read_dir(root().join("examples"))
        .unwrap()
        .map(|e| e.unwrap().metadata().unwrap().len())
        .sum();
    assert!(total < 2_000_000, "{total} bytes");
}
