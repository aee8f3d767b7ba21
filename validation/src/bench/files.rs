//! Benchmarks of reading: large text files, and many files.

use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

use super::contest::{Contestant, Process, Timing, race};
use super::report::{Row, three_digits};
use super::signal::Signal;
use super::{Against, Bench, faster};
use crate::Failure;
use crate::places::{command, peer};

/// Rows of a text of one gigabyte.
const GIGABYTE: usize = 48_000_000;
const FILES: usize = 1000;
const FILES_PER_SECOND: f64 = 2500.0;

/// A process that prints the duration of its work, without its start-up, on its last line.
struct SelfTimed(Command);

impl Contestant for SelfTimed {
    fn take(&mut self, _: usize) -> Result<Timing, Failure> {
        let output = self.0.output()?;
        let said = String::from_utf8_lossy(&output.stdout);
        let seconds = said.lines().last().and_then(|line| line.trim().parse().ok());
        let Some(seconds) = seconds.filter(|_| output.status.success()) else {
            let why = String::from_utf8_lossy(&output.stderr);
            return Err(format!("{:?} printed no time: {why}", self.0).into());
        };
        Ok(Timing { seconds, estimates: Vec::new(), errors: Vec::new() })
    }
}

/// A process that writes a table with one line per file.
struct TableWriter(Command, PathBuf);

impl Contestant for TableWriter {
    fn take(&mut self, _: usize) -> Result<Timing, Failure> {
        let begun = Instant::now();
        let output = self.0.output()?;
        let seconds = begun.elapsed().as_secs_f64();
        let lines = std::fs::read_to_string(&self.1)?.lines().count();
        if !output.status.success() || lines != FILES + 1 {
            return Err(format!("{lines} lines: {}", String::from_utf8_lossy(&output.stderr)).into());
        }
        Ok(Timing { seconds, estimates: Vec::new(), errors: Vec::new() })
    }
}

impl Bench {
    /// Times the first reading in a process, as a command does it, on all cores and on one core, and the best of
    /// several readings, for which polars' allocator has kept its memory.
    pub(super) fn text_beside_polars(&self) -> Result<Vec<Row>, Failure> {
        let file = self.long_csv()?;
        let megabytes = std::fs::metadata(&file)?.len() as f64 / 1e6;
        let contest = |times: &str, pinned: bool| -> Result<(Timing, Timing), Failure> {
            let mut own = start(std::env::current_exe()?, pinned);
            own.args(["bench", "--read"]).arg(&file).arg(times);
            let mut polars = start(&self.python, pinned);
            polars.arg(peer("read_polars.py")).arg(&file).arg(times);
            if pinned {
                polars.env("POLARS_MAX_THREADS", "1");
                own.env("RAYON_NUM_THREADS", "1");
            }
            let best = race(self.rounds, &mut [&mut SelfTimed(own), &mut SelfTimed(polars)])?;
            Ok((best[0].clone(), best[1].clone()))
        };
        let speed = |timing: &Timing| megabytes / timing.seconds;
        let mut rows = Vec::new();
        let ways = [
            ("all cores, first reading", "1", false),
            ("one core, first reading", "1", true),
            ("one core, best of five", "5", true),
        ];
        for (work, times, pinned) in ways {
            let (own, polars) = match contest(times, pinned) {
                Ok(both) => both,
                // There is no `taskset` on other systems.
                Err(_) if pinned && !cfg!(target_os = "linux") => continue,
                Err(failure) => return Err(failure),
            };
            let ratio = speed(&own) / speed(&polars);
            rows.push(Row {
                line: 'm',
                work: format!("text read, {megabytes:.0} MB, {work}"),
                ours: format!("{} MB/s", three_digits(speed(&own))),
                peer: "polars `read_csv`",
                theirs: format!("{} MB/s", three_digits(speed(&polars))),
                ratio: three_digits(ratio),
                asked: (times == "1").then(|| ("≥ 1".into(), ratio >= 1.0)),
                apart: None,
            });
        }
        Ok(rows)
    }

    pub(super) fn memory_of_a_gigabyte(&self) -> Result<Vec<Row>, Failure> {
        let file = self.folder.join("waveform_1GB.csv");
        Signal::waveform(GIGABYTE)?.write_csv(&file)?;
        let megabytes = std::fs::metadata(&file)?.len() as f64 / 1e6;
        let peak = self.peak_of(&file);
        std::fs::remove_file(&file)?;
        let peak = peak?;
        Ok(vec![Row {
            line: 'n',
            work: format!("memory, command on a text of {megabytes:.0} MB"),
            ours: format!("{:.0} MB", peak / 1e6),
            peer: "the text itself",
            theirs: format!("{megabytes:.0} MB"),
            ratio: three_digits(peak / 1e6 / megabytes),
            asked: Some(("≤ 1 GB".into(), peak <= 1e9)),
            apart: None,
        }])
    }

    pub(super) fn many_files(&self) -> Result<Vec<Row>, Failure> {
        let folder = self.folder.join("many");
        std::fs::create_dir_all(&folder)?;
        let signal = Signal::waveform(5_000)?;
        for i in 0..FILES {
            signal.write_csv(&folder.join(format!("{i:04}.csv")))?;
        }
        let mut paths: Vec<_> =
            std::fs::read_dir(&folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
        paths.sort();
        let mut slipfit = command(&self.slipfit);
        let table = self.folder.join("many.csv");
        slipfit.arg("ringdown").args(&paths).arg("--table").arg(&table);
        let mut script = command(&self.python);
        script.arg(peer("many_files.py")).args(&paths);
        let rounds = self.rounds.min(2);
        let best = race(rounds, &mut [&mut TableWriter(slipfit, table), &mut Process(script)])?;
        let against = Against { peer: "SciPy script, a process a core", at_least: Some(8.0) };
        let mut row = faster('o', "1000 files of 5 k rows, all cores", &best[0], &against, &best[1], None);
        let rate = |timing: &Timing| format!("{} files/s", three_digits(FILES as f64 / timing.seconds));
        (row.ours, row.theirs) = (rate(&best[0]), rate(&best[1]));
        let enough = FILES as f64 / best[0].seconds >= FILES_PER_SECOND;
        let text = format!("≥ {FILES_PER_SECOND} files/s, ≥ 8");
        row.asked = row.asked.map(|(_, faster)| (text, faster && enough));
        Ok(vec![row])
    }
}

/// A program, restricted to one core if `pinned`.
fn start(program: impl AsRef<std::ffi::OsStr>, pinned: bool) -> Command {
    if !pinned {
        return command(program);
    }
    let mut start = command("taskset");
    start.args(["--cpu-list", "0"]).arg(program);
    start
}
