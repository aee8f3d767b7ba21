//! `cargo xtask fuzz`: coverage-guided fuzzing with files of every format and numbers for every analysis.
//!
//! The targets are in `fuzz/targets`, one per format or analysis, driven by libFuzzer. The seeds are in
//! `validation/reference` and `fuzz/corpus`; inputs found are kept in `target/fuzz`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::Failure;
use crate::places::{self, cargo, command, root, target};

/// Flags for libFuzzer's coverage with the stable compiler; arithmetic overflow counts as a failure.
const FLAGS: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares -Coverflow-checks -Ccodegen-units=8";

/// The targets and their seeds: file names in [`SEEDS`] that contain one of these texts. Analyses need no seeds: any
/// bytes are numbers.
const TARGETS: [(&str, &[&str]); 30] = [
    ("arrow", &[".arrow", ".feather"]),
    ("capstone", &["capstone"]),
    ("gzip", &[".gz"]),
    ("hdf5", &[".h5", "matlab73"]),
    ("json", &[".json"]),
    ("keysight", &["keysight"]),
    ("klipper", &["klipper"]),
    ("labone", &["labone"]),
    ("levels", &[]),
    ("mat5", &["cells.mat", "integers.mat", "packed.mat", "struct.mat", "vectors.mat"]),
    ("moku", &["moku"]),
    ("nanonis", &["nanonis"]),
    ("nanosurf", &[".nid"]),
    ("npy", &[".npy"]),
    ("npz", &[".npz"]),
    ("ods", &[".ods"]),
    ("parquet", &[".parquet"]),
    ("phyphox_text", &["phyphox_"]),
    ("phyphox_zip", &["phyphox.zip"]),
    ("resonance", &[]),
    ("ringdown", &[]),
    ("series", &[]),
    ("siglent", &["siglent"]),
    ("touchstone", &[".s1p", ".s2p"]),
    ("tracker_text", &["tracker_"]),
    ("tracker_trk", &[".trk"]),
    ("vernier", &["vernier"]),
    ("wav", &[".wav"]),
    ("xls", &["sheets.xls"]),
    ("xlsx", &["sheets.xlsx"]),
];

/// Folders of the seeds.
const SEEDS: [&str; 2] = ["validation/reference/formats", "validation/reference/writers"];

/// The analyses, and the maximum number of bytes from which their numbers are made: each is a choice, and long inputs
/// are slow.
const ANALYSES: [&str; 4] = ["levels", "resonance", "ringdown", "series"];
const MOST_CHOICES: usize = 400;

/// An input that takes longer is reported as a hang; no file of this size takes that long even on a busy machine.
const HANGS_AFTER_S: u32 = 30;
const MOST_MEMORY_MB: u32 = 2048;
/// What `--keep` stores of a target's corpus in the repository: number of inputs, and total bytes.
const CORPUS_LIMITS: (usize, u64) = (40, 32 << 10);

struct Options {
    minutes: f64,
    /// Number of inputs after which a target ends before its time.
    runs: Option<u64>,
    /// Number of targets run at once.
    jobs: usize,
    seed: u32,
    only: Option<Vec<String>>,
    keep: bool,
}

impl Options {
    fn of(arguments: &[String]) -> Result<Self, Failure> {
        let jobs = std::thread::available_parallelism().map_or(1, usize::from);
        let mut options = Self { minutes: 10.0, runs: None, jobs, seed: 1, only: None, keep: false };
        let mut rest = arguments.iter();
        while let Some(flag) = rest.next() {
            let mut value = || rest.next().ok_or(format!("{flag} needs a value"));
            match flag.as_str() {
                "--minutes" => options.minutes = value()?.parse()?,
                "--runs" => options.runs = Some(value()?.parse()?),
                "--jobs" => options.jobs = value()?.parse::<usize>()?.max(1),
                "--seed" => options.seed = value()?.parse()?,
                "--only" => options.only = Some(value()?.split(',').map(str::to_owned).collect()),
                "--keep" => options.keep = true,
                other => return Err(format!("unknown option {other}").into()),
            }
        }
        Ok(options)
    }

    fn targets(&self) -> Result<Vec<(&'static str, &'static [&'static str])>, Failure> {
        let Some(only) = &self.only else { return Ok(TARGETS.to_vec()) };
        let find = |name: &String| {
            let known = TARGETS.iter().find(|t| t.0 == name);
            known.copied().ok_or_else(|| {
                let names = TARGETS.map(|t| t.0).join(", ");
                format!("no target `{name}`; there are {names}").into()
            })
        };
        only.iter().map(find).collect()
    }
}

/// Builds the targets and gives each its share of the minutes. As many run at once as there are cores, or as `--jobs`
/// says; `--runs` ends each after that many inputs, `--only` selects some of them.
pub(crate) fn run(arguments: &[String]) -> Result<ExitCode, Failure> {
    let options = Options::of(arguments)?;
    let targets = options.targets()?;
    let folder = target()?.join("fuzz");
    let programs = build(&folder)?;
    let jobs = options.jobs;
    let seconds = (60.0 * options.minutes * jobs as f64 / targets.len() as f64).ceil().max(1.0);
    let (next, failed) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    println!("{} targets, {seconds:.0} s each, {jobs} at once", targets.len());
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| {
                while let Some(&(name, seeds)) = targets.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let target = Target { name, seeds, folder: &folder, program: programs.join(name) };
                    match target.fuzz(seconds, &options) {
                        Ok(line) => println!("{line}"),
                        Err(error) => {
                            println!("{name}: {error}");
                            failed.lock().unwrap_or_else(|e| e.into_inner()).push(name);
                        }
                    }
                }
            });
        }
    });
    if options.keep {
        for &(name, seeds) in &targets {
            Target { name, seeds, folder: &folder, program: programs.join(name) }.keep()?;
        }
    }
    let failed = failed.into_inner().unwrap_or_else(|e| e.into_inner());
    if failed.is_empty() {
        return Ok(ExitCode::SUCCESS);
    }
    println!("failed: {}", failed.join(", "));
    Ok(ExitCode::FAILURE)
}

/// Builds the instrumented programs and returns their folder.
fn build(folder: &Path) -> Result<PathBuf, Failure> {
    let output = command("rustc").arg("-vV").output()?;
    let said = String::from_utf8(output.stdout)?;
    let host = said.lines().find_map(|l| l.strip_prefix("host: ")).ok_or("rustc names no host")?;
    // With the host named explicitly as target, build scripts and macros are not instrumented.
    places::run(
        cargo()
            .args(["build", "--release", "--package", "slipfit-fuzz", "--bins", "--target", host])
            .arg("--target-dir")
            .arg(folder)
            .env("RUSTFLAGS", FLAGS)
            .env("CARGO_PROFILE_RELEASE_LTO", "off"),
    )?;
    Ok(folder.join(host).join("release"))
}

struct Target<'a> {
    name: &'static str,
    seeds: &'static [&'static str],
    folder: &'a Path,
    program: PathBuf,
}

impl Target<'_> {
    /// The seed folders of the target.
    fn seeds(&self) -> Result<Vec<PathBuf>, Failure> {
        let seeds = self.folder.join("seeds").join(self.name);
        fs::create_dir_all(&seeds)?;
        for folder in SEEDS {
            for entry in fs::read_dir(root().join(folder))? {
                let path = entry?.path();
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                if self.seeds.iter().any(|part| name.contains(part)) {
                    fs::copy(&path, seeds.join(name))?;
                }
            }
        }
        let mut folders = vec![seeds];
        folders.extend(Some(self.kept()).filter(|kept| kept.is_dir()));
        Ok(folders)
    }

    fn found(&self) -> PathBuf {
        self.folder.join("corpus").join(self.name)
    }

    fn kept(&self) -> PathBuf {
        root().join("fuzz/corpus").join(self.name)
    }

    /// Runs the target for this time and summarises it in one line.
    fn fuzz(&self, seconds: f64, options: &Options) -> Result<String, Failure> {
        let (found, failures) = (self.found(), self.folder.join("failures"));
        fs::create_dir_all(&found)?;
        fs::create_dir_all(&failures)?;
        let prefix = failures.join(format!("{}-", self.name));
        let output = command(&self.program)
            .args([
                format!("-max_total_time={seconds:.0}"),
                format!("-timeout={HANGS_AFTER_S}"),
                format!("-rss_limit_mb={MOST_MEMORY_MB}"),
                format!("-seed={}", options.seed),
                format!("-artifact_prefix={}", prefix.display()),
                "-print_final_stats=1".into(),
            ])
            .args(options.runs.map(|runs| format!("-runs={runs}")))
            .args(ANALYSES.contains(&self.name).then(|| format!("-max_len={MOST_CHOICES}")))
            .arg(&found)
            .args(self.seeds()?)
            .output()?;
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        fs::write(self.folder.join(format!("{}.log", self.name)), &said)?;
        let number = |what: &str| {
            let line = said.lines().find_map(|l| l.strip_prefix("stat::")?.strip_prefix(what));
            line.map_or("?", |l| l.trim_start_matches(':').trim()).to_owned()
        };
        let covered = said.lines().rev().find_map(|l| l.split(" cov: ").nth(1)?.split(' ').next());
        let line = format!(
            "{}: {} inputs, {} places of the code, {} MB and {} s at most",
            self.name,
            number("number_of_executed_units"),
            covered.unwrap_or("?"),
            number("peak_rss_mb"),
            number("slowest_unit_time_sec"),
        );
        if output.status.success() {
            return Ok(line);
        }
        let reason = said.lines().find(|l| l.contains("panicked at") || l.contains("ERROR: libFuzzer"));
        let after = reason.and_then(|r| said.lines().skip_while(|l| *l != r).nth(1)).unwrap_or_default();
        let file = said.lines().find_map(|l| l.split("Test unit written to ").nth(1)).unwrap_or("no file");
        Err(format!("{} {after}\n    {file}", reason.unwrap_or("stopped without a word")).into())
    }

    /// Copies a selection of the inputs that together reach all covered code into the repository.
    fn keep(&self) -> Result<(), Failure> {
        let merged = self.folder.join("merged").join(self.name);
        if merged.is_dir() {
            fs::remove_dir_all(&merged)?;
        }
        fs::create_dir_all(&merged)?;
        let mut merge = command(&self.program);
        merge.args(["-set_cover_merge=1", "-max_len=2048"]).arg(&merged).arg(self.found());
        places::run(merge.args(self.seeds()?).stderr(std::process::Stdio::null()))?;
        let mut files = Vec::new();
        for entry in fs::read_dir(&merged)? {
            let entry = entry?;
            files.push((entry.metadata()?.len(), entry.path()));
        }
        files.sort();
        let kept = self.kept();
        if kept.is_dir() {
            fs::remove_dir_all(&kept)?;
        }
        fs::create_dir_all(&kept)?;
        let mut total = 0;
        // Takes inputs of all lengths.
        for (bytes, path) in files.iter().step_by(files.len().div_ceil(CORPUS_LIMITS.0).max(1)) {
            total += bytes;
            if total > CORPUS_LIMITS.1 {
                break;
            }
            fs::copy(path, kept.join(path.file_name().unwrap_or_default()))?;
        }
        Ok(())
    }
}
