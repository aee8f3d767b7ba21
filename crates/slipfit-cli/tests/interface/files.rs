//! The user's files: no output destroys an input or a file of another program, and the old file stays whole
//! however a run ends.

use crate::common::{example, root, slipfit};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// Flags that write a file, with an extension each accepts.
const ANSWERS: [(&str, &str); 6] = [
    ("--json", "json"),
    ("--csv", "csv"),
    ("--html", "html"),
    ("--md", "md"),
    ("--latex", "tex"),
    ("--plot", "svg"),
];

const FOREIGN: &str = "my own notes\n";

const DECAY: &str = "simulate decay --frequency-hz 1.2 --q 60 --friction-displacement 0.002 --amplitude 0.3 \
     --duration 20 --rate-hz 50";

/// A folder with a ring-down, a curve with its reference, levels and a series of them.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (from, to) in [
        ("classroom_pendulum.csv", "swing.csv"),
        ("tuning_fork_9nN_sweep.csv", "sweep.csv"),
        ("tuning_fork_free_sweep.csv", "free.csv"),
        ("tuning_fork_9nN_levels.csv", "levels.csv"),
    ] {
        fs::copy(example(from), folder.path().join(to)).unwrap();
    }
    fs::copy(root().join("validation/reference/maps/stack.npy"), folder.path().join("stack.npy")).unwrap();
    let series = "[[measurement]]\nsweep = \"sweep.csv\"\nreference = \"free.csv\"\n\
                  [[measurement]]\nlevels = \"levels.csv\"\n";
    fs::write(folder.path().join("series.toml"), series).unwrap();
    folder
}

fn run(folder: &Path, line: &str) -> Output {
    slipfit().current_dir(folder).args(line.split_whitespace()).output().unwrap()
}

fn refusal(folder: &Path, line: &str) -> String {
    let output = run(folder, line);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}: {said}");
    assert!(output.stdout.is_empty(), "{line}: nothing is written");
    // As one line, regardless of line breaks.
    said.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn done(folder: &Path, line: &str) {
    let output = run(folder, line);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Names and contents of everything in a folder.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let entries = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_file());
    let mut all: Vec<_> = entries.map(|p| (p.clone(), fs::read(p).unwrap())).collect();
    all.sort();
    all
}

/// Every command that reads files, with the files it reads.
const READS: [(&str, &[&str]); 5] = [
    ("ringdown swing.csv", &["swing.csv"]),
    ("resonance sweep.csv --reference free.csv", &["sweep.csv", "free.csv"]),
    ("levels levels.csv", &["levels.csv"]),
    ("series series.toml", &["series.toml", "sweep.csv", "free.csv", "levels.csv"]),
    ("ringdown swing.csv free.csv", &["swing.csv", "free.csv"]),
];

#[test]
fn no_output_is_an_input_whatever_its_name() {
    let folder = folder();
    let path = folder.path();
    let before = contents(path);
    for (command, inputs) in READS {
        for input in inputs {
            let mut names = vec![(*input).to_owned(), format!("./../{}/{input}", folder_name(path))];
            let extra = [path.join("hard"), path.join("soft")];
            fs::hard_link(path.join(input), &extra[0]).unwrap();
            names.push("hard".to_owned());
            #[cfg(unix)]
            {
                std::os::unix::fs::symlink(path.join(input), &extra[1]).unwrap();
                names.push("soft".to_owned());
            }
            for name in names {
                for (flag, _) in ANSWERS.iter().filter(|(flag, _)| *flag != "--plot") {
                    if command.contains("swing.csv free.csv") {
                        continue;
                    }
                    let said = refusal(path, &format!("{command} {flag} {name} --force"));
                    assert!(said.contains("never overwritten"), "{command} {flag} {name}: {said}");
                }
            }
            extra.iter().filter(|p| p.symlink_metadata().is_ok()).for_each(|p| fs::remove_file(p).unwrap());
        }
    }
    assert_eq!(contents(path), before);
}

fn folder_name(path: &Path) -> String {
    path.file_name().unwrap().to_string_lossy().into_owned()
}

#[test]
fn tables_pictures_and_simulations_are_no_inputs_either() {
    let folder = folder();
    let path = folder.path();
    fs::copy(path.join("swing.csv"), path.join("swing.svg")).unwrap();
    fs::copy(path.join("swing.csv"), path.join("out.csv.rows")).unwrap();
    fs::create_dir(path.join("runs")).unwrap();
    fs::copy(path.join("sweep.csv"), path.join("runs/one.csv")).unwrap();
    let before = contents(path);
    for line in [
        "ringdown swing.csv swing.svg --table swing.csv --force",
        "ringdown swing.csv out.csv.rows --table out.csv --force",
        "ringdown swing.csv swing.svg --plot swing.svg --force",
        "ringdown swing.svg --plot swing.svg --force",
        "resonance sweep.csv --reference free.csv --table free.csv --force",
        "resonance runs --drive 2 --json runs/one.csv --force",
        "simulate driven --frequency-hz 1 --q 20 --friction-displacement 0 --duration 1 --rate-hz 9 \
         --drive-file swing.csv --out swing.csv --force",
        "simulate driven --frequency-hz 1 --q 20 --friction-displacement 0 --duration 1 --rate-hz 9 \
         --drive-file swing.csv --out new.csv --json swing.csv --force",
    ] {
        let said = refusal(path, line);
        assert!(said.contains("never overwritten"), "{line}: {said}");
    }
    assert_eq!(contents(path), before);
    // Nor does standard output.
    #[cfg(unix)]
    {
        let file = fs::OpenOptions::new().append(true).open(path.join("swing.csv")).unwrap();
        let status = slipfit().current_dir(path).args(["ringdown", "swing.csv"]).output().unwrap().status;
        assert!(status.success());
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("slipfit"));
        let status = command.current_dir(path).args(["ringdown", "swing.csv"]).stdout(file).status();
        assert_eq!(status.unwrap().code(), Some(2));
        assert_eq!(contents(path), before);
    }
}

/// A map is recognised by its first bytes, whatever its name, even one with the extension of an output.
#[test]
fn no_output_of_a_map_is_its_input() {
    let folder = folder();
    let path = folder.path();
    fs::create_dir(path.join("blocks")).unwrap();
    for (name, flags) in [
        ("stack.csv", "--table stack.csv"),
        ("stack.arrow", "--table ./stack.arrow"),
        ("stack.svg", "--plot stack.svg"),
        ("stack.png", "--plot stack.png"),
        ("blocks/rows-0-2.arrow", "--resume blocks"),
    ] {
        fs::rename(path.join("stack.npy"), path.join(name)).unwrap();
        let before = fs::read(path.join(name)).unwrap();
        let mut inputs = vec![name.to_owned()];
        fs::hard_link(path.join(name), path.join("hard")).unwrap();
        inputs.push("hard".to_owned());
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(path.join(name), path.join("soft")).unwrap();
            inputs.push("soft".to_owned());
        }
        for input in inputs {
            let said = refusal(path, &format!("map {input} --dt 0.02 {flags} --force"));
            assert!(said.contains("never overwritten"), "{input} {flags}: {said}");
        }
        assert_eq!(fs::read(path.join(name)).unwrap(), before);
        for link in ["hard", "soft"] {
            fs::remove_file(path.join(link)).ok();
        }
        fs::rename(path.join(name), path.join("stack.npy")).unwrap();
    }
    let said = refusal(path, "map stack.npy --dt 0.02 --table blocks/rows-0-2.arrow --resume blocks");
    assert!(said.contains("are the same file"), "{said}");
}

#[test]
fn a_block_of_a_map_replaces_no_file_of_others() {
    let folder = folder();
    let path = folder.path();
    fs::create_dir(path.join("blocks")).unwrap();
    let block = path.join("blocks/rows-0-2.arrow");
    let line = "map stack.npy --dt 0.02 --resume blocks --table out.arrow";
    let theirs = root().join("validation/reference/writers/pyarrow_plain_V5.arrow");
    for foreign in [FOREIGN.as_bytes().to_vec(), fs::read(theirs).unwrap()] {
        fs::write(&block, &foreign).unwrap();
        let said = refusal(path, line);
        assert!(said.contains("was not written by slipfit"), "{said}");
        assert_eq!(fs::read(&block).unwrap(), foreign);
        assert!(!path.join("out.arrow").exists());
    }
    done(path, &format!("{line} --force"));
    let made = fs::read(&block).unwrap();
    done(path, line);
    // A full disk leaves the old block, of other numbers, whole.
    #[cfg(target_os = "linux")]
    {
        let program = assert_cmd::cargo::cargo_bin!("slipfit");
        let other = line.replace("--dt 0.02", "--dt 0.03");
        let script = format!("trap '' XFSZ; ulimit -f 0; exec {} {other}", program.display());
        let limited = Command::new("sh").current_dir(path).args(["-c", &script]).output().unwrap();
        let said = String::from_utf8_lossy(&limited.stderr);
        assert_eq!(limited.status.code(), Some(2), "{said}");
        assert!(said.contains("cannot be written"), "{said}");
        assert_eq!(fs::read(&block).unwrap(), made);
        assert_eq!(fs::read_dir(path.join("blocks")).unwrap().count(), 1);
    }
}

#[test]
fn two_outputs_are_two_files() {
    let folder = folder();
    let path = folder.path();
    let before = contents(path);
    for line in [
        "ringdown swing.csv --json out --csv out",
        "ringdown swing.csv --json out --html ./out",
        "levels levels.csv --md out.svg --plot out.svg",
        "series series.toml --latex out --json out",
        "ringdown swing.csv free.csv --table out.svg.csv --plot out.svg.csv",
        &format!("{DECAY} --out out.csv --json out.csv"),
    ] {
        refusal(path, line);
    }
    let said = refusal(path, "ringdown swing.csv --json out --csv out");
    assert!(said.contains("--json out and --csv out are the same file"), "{said}");
    assert_eq!(contents(path), before);
}

/// All outputs: the command up to the path, and the name of the file.
fn outputs() -> Vec<(String, String)> {
    let mut all = Vec::new();
    for command in ["ringdown swing.csv", "resonance sweep.csv", "levels levels.csv", "series series.toml"] {
        for (flag, ending) in ANSWERS {
            all.push((format!("{command} {flag}"), format!("out.{ending}")));
        }
    }
    all.push(("ringdown swing.csv --plot".to_owned(), "out.png".to_owned()));
    for command in ["ringdown swing.csv free.csv", "resonance sweep.csv free.csv"] {
        for ending in ["csv", "json", "md", "tex", "parquet"] {
            all.push((format!("{command} --table"), format!("out.{ending}")));
        }
    }
    for ending in ["csv", "wav", "parquet", "npy"] {
        all.push((format!("{DECAY} --out"), format!("out.{ending}")));
    }
    for (flag, ending) in
        [("--table", "csv"), ("--table", "npy"), ("--table", "arrow"), ("--plot", "svg"), ("--plot", "png")]
    {
        all.push((format!("map stack.npy --dt 0.02 {flag}"), format!("out.{ending}")));
    }
    all.push((format!("{DECAY} --out new.csv --json"), "out.json".to_owned()));
    all
}

#[test]
fn a_file_of_others_is_kept_and_an_own_one_replaced() {
    let folder = folder();
    let path = folder.path();
    for (command, name) in outputs() {
        let (line, file) = (format!("{command} {name}"), path.join(&name));
        fs::write(&file, FOREIGN).unwrap();
        let said = refusal(path, &line);
        assert!(said.contains("was not written by slipfit"), "{line}: {said}");
        assert!(said.contains("--force"), "{line}: {said}");
        assert_eq!(fs::read_to_string(&file).unwrap(), FOREIGN, "{line}");
        done(path, &format!("{line} --force"));
        let first = fs::read(&file).unwrap();
        assert_ne!(first, FOREIGN.as_bytes(), "{line}");
        // A NumPy array has no room for a mark.
        if !name.ends_with(".npy") {
            done(path, &line);
        }
        fs::write(&file, "").unwrap();
        done(path, &line);
        fs::remove_file(&file).unwrap();
        done(path, &line);
        fs::remove_file(&file).unwrap();
    }
    let left: Vec<_> = contents(path).into_iter().map(|(p, _)| folder_name(&p)).collect();
    assert_eq!(
        left,
        ["free.csv", "levels.csv", "new.csv", "series.toml", "stack.npy", "sweep.csv", "swing.csv"]
    );
}

#[test]
fn folders_of_figures_and_manual_pages_keep_files_of_others() {
    let folder = tempfile::tempdir().unwrap();
    for (command, name) in [
        ("atlas --q-points 3 --beta-points 2", "atlas.png"),
        ("atlas --q-points 3 --beta-points 2", "atlas.csv"),
        ("paper", "paper.md"),
        ("paper", "fig2_d.csv"),
        ("man", "slipfit-simulate-decay.1"),
    ] {
        let out = folder.path().join(name);
        fs::create_dir(&out).unwrap();
        fs::write(out.join(name), FOREIGN).unwrap();
        let line = format!("{command} --out {}", out.display());
        refusal(folder.path(), &line);
        assert_eq!(contents(&out), [(out.join(name), FOREIGN.as_bytes().to_vec())], "{line}");
        done(folder.path(), &format!("{line} --force"));
        done(folder.path(), &line);
        assert!(contents(&out).len() > 2, "{line}");
    }
}

#[cfg(unix)]
#[test]
fn links_lead_to_the_file_and_permissions_stay() {
    use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _, symlink};
    let folder = folder();
    let path = folder.path();
    fs::create_dir(path.join("results")).unwrap();
    symlink("results/answer.json", path.join("link.json")).unwrap();
    for _ in 0..2 {
        // At first the link leads nowhere, later to a file.
        done(path, "ringdown swing.csv --json link.json");
        assert!(path.join("link.json").symlink_metadata().unwrap().is_symlink());
        let answer = path.join("results/answer.json");
        assert!(fs::read_to_string(&answer).unwrap().contains("slipfit/ringdown-1"));
        fs::set_permissions(&answer, fs::Permissions::from_mode(0o640)).unwrap();
    }
    let mode = |name: &str| fs::metadata(path.join(name)).unwrap().mode() & 0o777;
    assert_eq!(mode("results/answer.json"), 0o640);
    done(path, "ringdown swing.csv --json new.json");
    fs::write(path.join("plain"), "").unwrap();
    assert_eq!(mode("new.json"), mode("plain"), "as any new file");
    symlink("circle", path.join("circle")).unwrap();
    refusal(path, "ringdown swing.csv --json circle");
    refusal(path, "ringdown swing.csv --json results");
    refusal(path, "ringdown swing.csv --json nowhere/answer.json");
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_written_to_as_they_are() {
    let folder = folder();
    let path = folder.path();
    done(path, "ringdown swing.csv --json /dev/null --csv /dev/null");
    let output = run(path, "ringdown swing.csv --json /dev/stdout --quiet");
    assert!(String::from_utf8_lossy(&output.stdout).contains("slipfit/ringdown-1"));
    if !Path::new("/dev/full").exists() {
        return;
    }
    for (flag, _) in ANSWERS.iter().filter(|(flag, _)| *flag != "--plot") {
        let said = refusal(path, &format!("levels levels.csv {flag} /dev/full"));
        assert!(said.contains("cannot be written"), "{flag}: {said}");
    }
    let status = Command::new("mkfifo").arg(path.join("pipe")).status();
    if status.is_ok_and(|s| s.success()) {
        let reader = std::thread::spawn({
            let pipe = path.join("pipe");
            move || fs::read_to_string(pipe).unwrap()
        });
        done(path, "levels levels.csv --json pipe");
        assert!(reader.join().unwrap().contains("slipfit/levels-1"));
    }
}

/// No room on the disk for the new file: a limit on the size of any file, with its signal ignored.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_the_old_file_whole() {
    let folder = folder();
    let path = folder.path();
    let program = assert_cmd::cargo::cargo_bin!("slipfit");
    for (command, name) in outputs() {
        let line = format!("{command} {name} --force");
        done(path, &line);
        let old = fs::read(path.join(&name)).unwrap();
        fs::remove_file(path.join("new.csv")).ok();
        // No room at all: even the shortest output does not fit.
        let script = format!("trap '' XFSZ; ulimit -f 0; exec {} {line}", program.display());
        let limited = Command::new("sh").current_dir(path).args(["-c", &script]).output().unwrap();
        let said = String::from_utf8_lossy(&limited.stderr);
        assert_eq!(limited.status.code(), Some(2), "{line}: {said}");
        assert!(said.contains("cannot be written"), "{line}: {said}");
        assert_eq!(fs::read(path.join(&name)).unwrap(), old, "{line}");
        let litter = contents(path).into_iter().map(|(p, _)| folder_name(&p)).find(|n| n.starts_with('.'));
        assert_eq!(litter, None, "{line}");
        fs::remove_file(path.join(&name)).unwrap();
        fs::remove_file(path.join(format!("{name}.rows"))).ok();
    }
}

#[cfg(unix)]
#[test]
fn a_kill_while_writing_leaves_the_old_file_whole() {
    let folder = folder();
    let path = folder.path();
    done(path, &format!("{DECAY} --out out.csv"));
    let old = fs::read(path.join("out.csv")).unwrap();
    let long = DECAY.replace("--duration 20", "--duration 1e6");
    let half_written = || {
        let found = contents(path).into_iter().filter(|(p, _)| folder_name(p).starts_with(".slipfit-"));
        found.map(|(p, bytes)| (p, bytes.len())).max_by_key(|(_, length)| *length)
    };
    for signal in ["-KILL", "-INT"] {
        let mut child = Command::new(assert_cmd::cargo::cargo_bin!("slipfit"))
            .current_dir(path)
            .args(long.split_whitespace())
            .args(["--out", "out.csv"])
            .spawn()
            .unwrap();
        while half_written().is_none_or(|(_, length)| length <= 100_000) {
            assert!(child.try_wait().unwrap().is_none(), "too quick to be killed");
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        assert_eq!(fs::read(path.join("out.csv")).unwrap(), old, "untouched while the new one is written");
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
        child.wait().unwrap();
        assert_eq!(fs::read(path.join("out.csv")).unwrap(), old, "{signal}");
        match half_written() {
            // After SIGKILL only the next run can clean up, and it waits for a minute.
            Some((litter, _)) => {
                assert_eq!(signal, "-KILL");
                let file = fs::OpenOptions::new().write(true).open(litter).unwrap();
                file.set_len(0).unwrap();
                let long_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(3600);
                file.set_modified(long_ago).unwrap();
            }
            None => assert_eq!(signal, "-INT"),
        }
    }
    assert_eq!(half_written(), None, "the later run removed what was left");
}

#[test]
fn one_run_a_table() {
    let folder = folder();
    let path = folder.path();
    let rows = path.join("out.csv.rows");
    fs::write(&rows, "").unwrap();
    let held = fs::OpenOptions::new().write(true).open(&rows).unwrap();
    held.lock().unwrap();
    let said = refusal(path, "ringdown swing.csv free.csv --table out.csv");
    assert!(said.contains("another run is writing it"), "{said}");
    assert!(!path.join("out.csv").exists());
    drop(held);
    done(path, "ringdown swing.csv free.csv --table out.csv");
    assert!(!rows.exists());
    // Started at the same time, each run ends with a whole table or is refused.
    for _ in 0..5 {
        let start = || {
            let mut command = Command::new(assert_cmd::cargo::cargo_bin!("slipfit"));
            command.current_dir(path).args(["ringdown", "swing.csv", "free.csv", "--table", "out.csv"]);
            command.stderr(Stdio::null()).spawn().unwrap()
        };
        let codes: Vec<_> = [start(), start()].map(|mut c| c.wait().unwrap().code()).into();
        assert!(codes.contains(&Some(0)), "{codes:?}");
        assert!(codes.iter().all(|c| [Some(0), Some(2)].contains(c)), "{codes:?}");
        assert_eq!(fs::read_to_string(path.join("out.csv")).unwrap().lines().count(), 3);
        assert!(!rows.exists());
    }
}

#[test]
fn resume_goes_on_with_its_own_table_only() {
    let folder = folder();
    let path = folder.path();
    for name in ["out.csv", "out.csv.rows"] {
        fs::write(path.join(name), FOREIGN).unwrap();
        for resume in ["", "--resume"] {
            let said = refusal(path, &format!("ringdown swing.csv free.csv --table out.csv {resume}"));
            assert!(said.contains("was not written by slipfit"), "{name}: {said}");
        }
        assert_eq!(fs::read_to_string(path.join(name)).unwrap(), FOREIGN);
        fs::remove_file(path.join(name)).unwrap();
    }
}
