//! Timing of contestants in turn, so that other load on the machine affects all of them.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;

use crate::Failure;
use crate::places::command;

/// Mean time of one repetition, and the estimates if the peer returns any.
#[derive(Clone)]
pub(super) struct Timing {
    pub(super) seconds: f64,
    pub(super) estimates: Vec<f64>,
    pub(super) errors: Vec<f64>,
}

/// A contestant that does the work `repetitions` times and is timed.
pub(super) trait Contestant {
    fn take(&mut self, repetitions: usize) -> Result<Timing, Failure>;
}

/// The best turn of each contestant over the rounds. Quick work is repeated so that a turn lasts about 50 ms.
pub(super) fn race(rounds: usize, contestants: &mut [&mut dyn Contestant]) -> Result<Vec<Timing>, Failure> {
    let mut best = Vec::with_capacity(contestants.len());
    let mut repetitions = Vec::with_capacity(contestants.len());
    for contestant in contestants.iter_mut() {
        let first = contestant.take(1)?;
        repetitions.push((0.05 / first.seconds.max(1e-9)).clamp(1.0, 1e5) as usize);
        best.push(first);
    }
    for _ in 0..rounds {
        for (at, contestant) in contestants.iter_mut().enumerate() {
            let timing = contestant.take(repetitions[at])?;
            if timing.seconds < best[at].seconds {
                best[at] = timing;
            }
        }
    }
    Ok(best)
}

/// A function of our own; it returns its estimates.
pub(super) struct Task<'a>(pub(super) Box<dyn FnMut() -> Result<Vec<f64>, Failure> + 'a>);

impl Contestant for Task<'_> {
    fn take(&mut self, repetitions: usize) -> Result<Timing, Failure> {
        let begun = Instant::now();
        let mut estimates = Vec::new();
        for _ in 0..repetitions {
            estimates = std::hint::black_box((self.0)()?);
        }
        let seconds = begun.elapsed().as_secs_f64() / repetitions as f64;
        Ok(Timing { seconds, estimates, errors: Vec::new() })
    }
}

/// A task that does the work `times` times per call.
pub(super) struct Several<'a> {
    pub(super) task: Task<'a>,
    pub(super) times: usize,
}

impl Contestant for Several<'_> {
    fn take(&mut self, repetitions: usize) -> Result<Timing, Failure> {
        let timing = self.task.take(repetitions.div_ceil(self.times))?;
        Ok(Timing { seconds: timing.seconds / self.times as f64, ..timing })
    }
}

/// A whole process, from its start to its end.
pub(super) struct Process(pub(super) Command);

impl Contestant for Process {
    fn take(&mut self, repetitions: usize) -> Result<Timing, Failure> {
        let begun = Instant::now();
        for _ in 0..repetitions {
            let output = self.0.output()?;
            if !output.status.success() || output.stdout.is_empty() {
                let said = String::from_utf8_lossy(&output.stderr);
                return Err(format!("{:?} gave no answer: {said}", self.0).into());
            }
        }
        let seconds = begun.elapsed().as_secs_f64() / repetitions as f64;
        Ok(Timing { seconds, estimates: Vec::new(), errors: Vec::new() })
    }
}

/// A Python script that waits for requests; see `validation/peers/serve.py`.
pub(super) struct Peer {
    script: String,
    child: Child,
    questions: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Peer {
    pub(super) fn start(
        interpreter: &Path,
        script: &str,
        arguments: impl IntoIterator<Item = String>,
    ) -> Result<Peer, Failure> {
        let mut call = command(interpreter);
        call.arg("-B").arg(crate::places::peer(script)).args(arguments);
        let mut child = call.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let questions = child.stdin.take();
        let answers = BufReader::new(child.stdout.take().ok_or("the peer has no output")?);
        let mut peer = Peer { script: script.to_owned(), child, questions, answers };
        match peer.line()?.as_str() {
            "ready" => Ok(peer),
            other => Err(format!("{script} said `{other}` where `ready` was expected").into()),
        }
    }

    fn line(&mut self) -> Result<String, Failure> {
        let mut line = String::new();
        if self.answers.read_line(&mut line)? == 0 {
            return Err(format!("{} ended without an answer", self.script).into());
        }
        Ok(line.trim_end().to_owned())
    }
}

impl Contestant for Peer {
    fn take(&mut self, repetitions: usize) -> Result<Timing, Failure> {
        let questions = self.questions.as_mut().ok_or("the peer has no input")?;
        writeln!(questions, "{repetitions}")?;
        questions.flush()?;
        let line = self.line()?;
        let numbers: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        let numbers = numbers.map_err(|error| format!("{}: {error} in `{line}`", self.script))?;
        let (&seconds, rest) = numbers.split_first().ok_or("the peer answered an empty line")?;
        let (estimates, errors) = rest.split_at(rest.len() / 2);
        Ok(Timing { seconds, estimates: estimates.to_vec(), errors: errors.to_vec() })
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // Closing its input ends the script; a peer that hangs is killed.
        self.questions = None;
        if !matches!(self.child.try_wait(), Ok(Some(_))) {
            std::thread::sleep(std::time::Duration::from_millis(200));
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}
