//! `cargo xtask bench`: typical work of users, compared with the tools they would use instead.

mod batch;
mod contest;
mod files;
mod motion;
mod ours;
mod report;
mod resonance;
mod signal;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use contest::{Contestant, Peer, Process, Several, Task, Timing, race};
use report::{Row, duration, three_digits};
use signal::{Signal, friction_displacement};

use crate::Failure;
use crate::places::{command, peer, programs, write_page};

struct Choices {
    /// A Python interpreter with the peers' packages.
    python: PathBuf,
    write: bool,
    only: String,
    rounds: usize,
}

/// What every line of the table needs.
struct Bench {
    python: PathBuf,
    slipfit: PathBuf,
    /// Folder for the files that the contestants read.
    folder: PathBuf,
    rounds: usize,
}

/// One requirement: the peer to compare with, and the required speed ratio.
struct Against {
    peer: &'static str,
    at_least: Option<f64>,
}

/// Runs the selected lines and prints the table.
pub(crate) fn run(arguments: &[String]) -> Result<ExitCode, Failure> {
    if let [first, rest @ ..] = arguments
        && first == "--read"
    {
        return ours::read_alone(rest);
    }
    let choices = choices(arguments)?;
    let programs = programs()?;
    let bench = Bench {
        python: choices.python,
        slipfit: programs.join("slipfit").with_extension(std::env::consts::EXE_EXTENSION),
        folder: programs.with_file_name("bench"),
        rounds: choices.rounds,
    };
    std::fs::create_dir_all(&bench.folder)?;
    let mut rows = Vec::new();
    let mut failed = false;
    for line in choices.only.chars() {
        eprintln!("measuring {line} …");
        let measured = match line {
            'a' => bench.waveform_fit(),
            'b' => bench.analysis(),
            'c' => bench.envelope_fit(),
            'd' => bench.whole_command(),
            'e' => bench.text_read(),
            'f' => bench.memory(),
            'g' => bench.free_motion(),
            'h' => bench.dense_motion(),
            'i' => bench.stick_slip(),
            'j' => bench.cost_per_event(),
            'k' => bench.streaming_memory(),
            'l' => bench.resonance_fit(),
            'm' => bench.text_beside_polars(),
            'n' => bench.memory_of_a_gigabyte(),
            'o' => bench.many_files(),
            'p' => bench.batches(),
            _ => bench.short_analyses(),
        };
        match measured {
            Ok(measured) => rows.extend(measured),
            Err(failure) => {
                eprintln!("error: line {line} could not be measured: {failure}");
                failed = true;
            }
        }
    }
    println!("{}", report::table(&rows));
    if failed {
        return Ok(ExitCode::FAILURE);
    }
    if choices.write {
        write_page("benchmarks.md", &report::page(&rows, choices.rounds)?)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn choices(arguments: &[String]) -> Result<Choices, Failure> {
    const LINES: &str = "abcdefghijklmnopq";
    let mut choices = Choices { python: "python3".into(), write: false, only: LINES.into(), rounds: 7 };
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        match word.as_str() {
            "--python" => choices.python = words.next().ok_or("--python needs an interpreter")?.into(),
            "--write" => choices.write = true,
            "--only" => {
                let chosen = words.next().ok_or("--only needs lines of the table, e.g. a,c")?;
                choices.only = chosen.chars().filter(|&c| c != ',').collect();
                if let Some(other) = choices.only.chars().find(|&c| !LINES.contains(c)) {
                    return Err(format!("--only {chosen}: there is no line `{other}`, only a to q").into());
                }
            }
            "--rounds" => {
                let count = words.next().ok_or("--rounds needs a number")?;
                choices.rounds = count.parse().map_err(|error| format!("--rounds {count}: {error}"))?;
            }
            other => return Err(format!("`{other}` is not an option of bench; see cargo xtask help").into()),
        }
    }
    if choices.write && choices.only != LINES {
        return Err("--write needs the whole table: leave out --only".into());
    }
    Ok(choices)
}

impl Bench {
    fn waveform_fit(&self) -> Result<Vec<Row>, Failure> {
        let signal = Signal::waveform(10_000)?;
        let against = [
            Against { peer: "SciPy `curve_fit`, Jacobian as in a textbook", at_least: Some(40.0) },
            Against { peer: "SciPy `curve_fit`, Jacobian sharing parts", at_least: Some(40.0) },
        ];
        let peers = self.waveform_peers(&signal)?;
        self.fits(
            'a',
            "fit, 10 k samples, 6 parameters",
            &signal,
            ours::waveform_fit(&signal),
            &against,
            peers,
        )
    }

    fn analysis(&self) -> Result<Vec<Row>, Failure> {
        let signal = Signal::waveform(1_000_000)?;
        let against = [
            Against { peer: "one SciPy `curve_fit`, Jacobian as in a textbook", at_least: Some(100.0) },
            Against { peer: "one SciPy `curve_fit`, Jacobian sharing parts", at_least: Some(100.0) },
        ];
        let peers = self.waveform_peers(&signal)?;
        self.fits('b', "whole analysis, 1 M samples", &signal, ours::analysis(&signal)?, &against, peers)
    }

    /// Analyses of records as short as those of a batch, on one core. The mean of many is taken because about one in
    /// thirty needs, by chance, an additional search.
    fn short_analyses(&self) -> Result<Vec<Row>, Failure> {
        let mut rows = Vec::new();
        for (samples, work, most) in [
            (512, "whole analysis, 512 samples, one core, mean of 300 records", 100e-6),
            (5_000, "whole analysis, 5 k samples, one core, mean of 300 records", 400e-6),
        ] {
            let signals: Vec<Signal> = (0..SHORT_RECORDS)
                .map(|number| Signal::waveform_of(samples, number))
                .collect::<Result<_, _>>()?;
            let signal = &signals[0];
            let against = [
                Against { peer: "one SciPy `curve_fit`, Jacobian as in a textbook", at_least: None },
                Against { peer: "one SciPy `curve_fit`, Jacobian sharing parts", at_least: None },
            ];
            let peers = self.waveform_peers(signal)?;
            let own = Several { task: ours::analyses(&signals)?, times: signals.len() };
            let (seconds, measured) = self.timed_fits('q', work, signal, own, &against, peers)?;
            let asked = Some((format!("≤ {}", duration(most)), seconds <= most));
            rows.extend(measured.into_iter().map(|row| Row { asked: asked.clone(), ..row }));
        }
        Ok(rows)
    }

    fn waveform_peers(&self, signal: &Signal) -> Result<Vec<Peer>, Failure> {
        let data = self.doubles(signal)?;
        let start = signal.waveform_start();
        let peer = |way: &str| Peer::start(&self.python, "waveform_fit.py", words(&[way, &data], &start));
        Ok(vec![peer("plain")?, peer("shared")?])
    }

    fn envelope_fit(&self) -> Result<Vec<Row>, Failure> {
        let signal = Signal::envelope(512);
        let data = self.doubles(&signal)?;
        let start = signal.envelope_start();
        let peer = |who: &str| Peer::start(&self.python, "envelope_fit.py", words(&[who, &data], &start));
        let against = [
            Against { peer: "SciPy `curve_fit`", at_least: Some(250.0) },
            Against { peer: "SciPy `curve_fit`, Jacobian", at_least: None },
            Against { peer: "lmfit", at_least: Some(1000.0) },
        ];
        let peers = vec![peer("curve_fit")?, peer("curve_fit_jacobian")?, peer("lmfit")?];
        let own = ours::envelope_fit(&signal);
        self.fits('c', "fit, 512 amplitudes, 3 parameters", &signal, own, &against, peers)
    }

    fn whole_command(&self) -> Result<Vec<Row>, Failure> {
        let file = self.folder.join("waveform_5k.csv");
        Signal::waveform(5_000)?.write_csv(&file)?;
        let mut slipfit = command(&self.slipfit);
        slipfit.arg("ringdown").arg(&file);
        let mut script = command(&self.python);
        script.arg(peer("ringdown_script.py")).arg(&file);
        script.env("PYTHONPYCACHEPREFIX", self.folder.join("pycache"));
        let best = race(self.rounds, &mut [&mut Process(slipfit), &mut Process(script)])?;
        let against = Against { peer: "SciPy script", at_least: Some(30.0) };
        Ok(vec![faster('d', "command, CSV of 5 k rows", &best[0], &against, &best[1], None)])
    }

    fn text_read(&self) -> Result<Vec<Row>, Failure> {
        let file = self.long_csv()?;
        let megabytes = std::fs::metadata(&file)?.len() as f64 / 1e6;
        let own = time_alone(self.rounds, &mut ours::text_read(&file))?;
        // NumPy takes long enough for one turn to suffice.
        let data = file.to_string_lossy().into_owned();
        let theirs = time_alone(0, &mut Peer::start(&self.python, "read_text.py", [data])?)?;
        let speed = |timing: &Timing| megabytes / timing.seconds;
        let show = |timing: &Timing| format!("{} MB/s", three_digits(speed(timing)));
        Ok(vec![Row {
            line: 'e',
            work: format!("text read, {megabytes:.0} MB"),
            ours: show(&own),
            peer: "NumPy `loadtxt`",
            theirs: show(&theirs),
            ratio: three_digits(speed(&own) / speed(&theirs)),
            asked: Some(("≥ 300 MB/s".into(), speed(&own) >= 300.0)),
            apart: None,
        }])
    }

    fn memory(&self) -> Result<Vec<Row>, Failure> {
        let peak = self.peak_of(&self.long_csv()?)?;
        let samples = LONG as f64 * 16.0;
        Ok(vec![Row {
            line: 'f',
            work: "memory, command on 10 M samples".into(),
            ours: format!("{:.0} MB", peak / 1e6),
            peer: "the samples themselves",
            theirs: format!("{:.0} MB", samples / 1e6),
            ratio: three_digits(peak / samples),
            asked: Some(("≤ 3".into(), peak <= 3.0 * samples)),
            apart: None,
        }])
    }

    /// Peak resident memory of the command on a file, in bytes.
    fn peak_of(&self, file: &Path) -> Result<f64, Failure> {
        let mut script = command(&self.python);
        script.arg(peer("peak_memory.py")).arg(&self.slipfit).arg("ringdown").arg(file);
        let output = script.output()?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into());
        }
        let text = String::from_utf8_lossy(&output.stdout);
        Ok(text.trim().parse().map_err(|_| format!("`{text}` is no number of bytes"))?)
    }

    /// Times slipfit's work against the peers' and compares the fitted losses.
    fn fits(
        &self,
        line: char,
        work: &str,
        signal: &Signal,
        own: Task,
        against: &[Against],
        peers: Vec<Peer>,
    ) -> Result<Vec<Row>, Failure> {
        Ok(self.timed_fits(line, work, signal, own, against, peers)?.1)
    }

    /// The same, with the seconds that slipfit's work took.
    fn timed_fits(
        &self,
        line: char,
        work: &str,
        signal: &Signal,
        mut own: impl Contestant,
        against: &[Against],
        mut peers: Vec<Peer>,
    ) -> Result<(f64, Vec<Row>), Failure> {
        let mut contestants: Vec<&mut dyn Contestant> = vec![&mut own];
        contestants.extend(peers.iter_mut().map(|peer| peer as &mut dyn Contestant));
        let best = race(self.rounds, &mut contestants)?;
        let (own, theirs) = best.split_first().ok_or("nobody ran")?;
        for (against, theirs) in against.iter().zip(theirs) {
            found_the_decay(signal, against.peer, theirs)?;
        }
        let rows = against.iter().zip(theirs).map(|(against, theirs)| {
            faster(line, work, own, against, theirs, difference(signal, own, theirs))
        });
        Ok((own.seconds, rows.collect()))
    }

    fn doubles(&self, signal: &Signal) -> Result<String, Failure> {
        let path = self.folder.join(format!("signal_{}.f64", signal.values.len()));
        signal.write_doubles(&path)?;
        Ok(path.to_string_lossy().into_owned())
    }

    fn long_csv(&self) -> Result<PathBuf, Failure> {
        let file = self.folder.join("waveform_10M.csv");
        Signal::waveform(LONG)?.write_csv(&file)?;
        Ok(file)
    }
}

/// Number of records of line q.
const SHORT_RECORDS: u64 = 300;

/// Rows of the long file: about 200 MB.
const LONG: usize = 10_000_000;

fn words(first: &[&str], numbers: &[f64]) -> Vec<String> {
    first.iter().map(ToString::to_string).chain(numbers.iter().map(ToString::to_string)).collect()
}

fn time_alone(rounds: usize, contestant: &mut dyn Contestant) -> Result<Timing, Failure> {
    let best = race(rounds, &mut [contestant])?;
    best.into_iter().next().ok_or_else(|| "nobody ran".into())
}

fn faster(
    line: char,
    work: &str,
    own: &Timing,
    against: &Against,
    theirs: &Timing,
    apart: Option<f64>,
) -> Row {
    let ratio = theirs.seconds / own.seconds;
    let asked = against.at_least.map(|least| (format!("≥ {least:.0}"), ratio >= least));
    Row {
        line,
        work: work.into(),
        ours: duration(own.seconds),
        peer: against.peer,
        theirs: duration(theirs.seconds),
        ratio: three_digits(ratio),
        asked,
        apart: apart.map(|apart| format!("{apart:.2} σ")),
    }
}

/// Checks that a peer found the decay: if it ended in a wrong minimum, its time would be meaningless.
fn found_the_decay(signal: &Signal, peer: &str, timing: &Timing) -> Result<(), Failure> {
    let truth = [signal.truth.offset_amplitude, signal.truth.decay_rate_per_s];
    for (at, truth) in (1..).zip(truth) {
        let (value, error) = match (timing.estimates.get(at), timing.errors.get(at)) {
            (Some(&value), Some(&error)) => (value, error),
            _ => return Err(format!("{peer} told too few estimates").into()),
        };
        // Ten standard errors: random scatter stays within five, and the averaged model adds less than one.
        if !((value - truth).abs() < 10.0 * error && error < truth) {
            return Err(format!("{peer} found {value} ± {error} where {truth} was put in").into());
        }
    }
    Ok(())
}

/// Difference of decay rate or of friction displacement, whichever is larger, in units of the peer's standard errors.
/// The peer's estimates begin with A, C, delta.
fn difference(signal: &Signal, own: &Timing, theirs: &Timing) -> Option<f64> {
    let &[_, c, delta, ..] = theirs.estimates.as_slice() else { return None };
    let &[_, c_error, delta_error, ..] = theirs.errors.as_slice() else { return None };
    let &[own_delta, own_x_f] = own.estimates.as_slice() else { return None };
    let x_f = |c| friction_displacement(c, delta, signal.truth.omega());
    let by_rate = (own_delta - delta) / delta_error;
    let by_friction = (own_x_f - x_f(c)) / x_f(c_error);
    Some(by_rate.abs().max(by_friction.abs()))
}
