//! The table of results and the page around it.

use std::process::Command;

use crate::Failure;
use crate::places::{peer, root};

/// One line of the table.
pub(super) struct Row {
    pub(super) line: char,
    pub(super) work: String,
    pub(super) ours: String,
    pub(super) peer: &'static str,
    pub(super) theirs: String,
    pub(super) ratio: String,
    /// The requirement, and whether it is met.
    pub(super) asked: Option<(String, bool)>,
    /// Largest difference between the answers, with its unit.
    pub(super) apart: Option<String>,
}

/// A duration with three digits.
pub(super) fn duration(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s >= 1.0 => (s, "s"),
        s if s >= 1e-3 => (s * 1e3, "ms"),
        s => (s * 1e6, "µs"),
    };
    format!("{} {unit}", three_digits(value))
}

/// A number with three significant digits; integer digits are never dropped.
pub(super) fn three_digits(value: f64) -> String {
    let decimals = if value >= 100.0 {
        0
    } else if value >= 10.0 {
        1
    } else {
        2
    };
    format!("{value:.decimals$}")
}

/// The Markdown table.
pub(super) fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "| | work | slipfit | peer | takes | ratio | asked | met | apart |\n|---|---|--:|---|--:|--:|--:|---|--:|\n",
    );
    for row in rows {
        let (asked, met) = match &row.asked {
            Some((asked, met)) => (asked.as_str(), if *met { "yes" } else { "**no**" }),
            None => ("", ""),
        };
        let apart = row.apart.as_deref().unwrap_or_default();
        let Row { line, work, ours, peer, theirs, ratio, .. } = row;
        text += &format!(
            "| {line} | {work} | {ours} | {peer} | {theirs} | {ratio} | {asked} | {met} | {apart} |\n"
        );
    }
    text
}

/// The page kept in `docs/benchmarks.md`.
pub(super) fn page(rows: &[Row], rounds: usize) -> Result<String, Failure> {
    let requirements = std::fs::read_to_string(peer("requirements.txt"))?;
    let versions = requirements.lines().collect::<Vec<_>>().join(", ").replace("==", " ");
    Ok(format!(
        "# Speed and memory

Written by `cargo xtask bench --write`, on {machine}; {rustc}; {versions}.

{table}
All contestants work on the same numbers and take turns; the best of {rounds} rounds counts. Times depend on
the machine, ratios much less. *apart* is the largest difference between slipfit's and the peer's viscous and
sliding loss, in the peer's standard errors: that both did the same work. The peers fit the averaged decay, eq. (15)
and (16) of the paper, slipfit the exact one, so the two need not agree to the last digit. Of **g** to **i** it is the
difference of the last positions, `x_0 = 1`.

- **a** a 10 k-sample waveform, 100 cycles, 1 % noise: amplitude, phase, frequency, decay rate, friction
  displacement, offset. SciPy's model and Jacobian once as a textbook has them, once sharing all they can.
- **b** slipfit's whole analysis of a 1 M-sample waveform (finding the decay, all models, all intervals) against
  one SciPy fit of one model that is given its start values.
- **c** a 512-sample amplitude trace: amplitude, decay rate, friction displacement.
- **d** the command on a CSV of 5 k rows, from process start to printed answer, against a SciPy script that
  reads, fits one model and prints.
- **e** reading a two-column CSV of 10 M rows.
- **f** greatest resident memory of the command on that file, over 16 bytes a sample.
- **g** `omega_0 = 1`, `delta = x_F = 1e-4` from `x = 1`: every turning point of 1000 cycles, by the closed form and by
  the machine that takes any drive; heyoka at its default tolerance, the precision of a double.
- **h** the same decay on an even grid; slipfit shares it among all cores, heyoka takes one.
- **i** base driven at `0.3 omega_0` with `delta = 0.05`, `x_F = 0.5`, `x_S = 0.65`: two slips and two stops a cycle. With
  `x_S = x_F` heyoka loses events, and there is nothing to compare.
- **j** the event machine, time per event at the end of a run of 1e7 events and in its first hundred.
- **k** greatest resident memory of `slipfit simulate driven` writing text, a thousand times more of it or not.
- **l** the exact response at 401 frequencies, amplitude and phase, 1 to 2 % noise, `Q = 50`, `beta = 0.3`: natural
  frequency, decay rate, friction displacement, drive amplitude, phase offset. SciPy fits the same closed form in NumPy
  without derivatives, from start values a tenth off the truth; slipfit finds its own. lmfit fits three parameters
  of a Lorentzian, which knows no friction, to the squared amplitude.
- **m** the text of **e** again, into times and values: slipfit also hashes it (SHA-256) and checks its clock. *First
  reading*: each reading in a process of its own, as a command does it, the start of the process not counted. *One core*:
  the process pinned to it, polars with one thread. *Best of five*: readings one after the other in one process; polars'
  allocator keeps the memory of the one before, slipfit's gives it back.
- **n** greatest resident memory of the command on a text of one gigabyte.
- **o** ring-downs of 5 k rows each, from process start to the finished table, against the script of **d** as a function
  called by as many processes as there are cores.
- **p** `fit_batch` on a table of 1 GB (0.5 GB) of traces like that of **c** in memory, one thread: parameters, errors,
  intervals, p-value and friction displacement of each. The peer fits one trace again and again. The sum reads the same
  memory once and does nothing with it.
- **q** as **b**, of records as short as those of a batch, the mean of 300 with noise of their own each (one in thirty or so shows by chance what takes a search of its own): everything that `slipfit::ringdown::analyse` answers, beside one fit.

The scripts of the peers are in `validation/peers`.

{browser}",
        machine = machine(),
        rustc = rustc_version(),
        table = table(rows),
        browser = include_str!("browser.md"),
    ))
}

fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpuinfo.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let name = model.map_or(std::env::consts::ARCH, |(_, name)| name.trim());
    format!("{cores} cores ({name}), {}", std::env::consts::OS)
}

fn rustc_version() -> String {
    let output = Command::new("rustc").arg("--version").current_dir(root()).output();
    let words = output.map(|output| String::from_utf8_lossy(&output.stdout).into_owned()).unwrap_or_default();
    words.split_whitespace().take(2).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_choose_their_unit_and_keep_three_digits() {
        assert_eq!(duration(1.5), "1.50 s");
        assert_eq!(duration(0.0123), "12.3 ms");
        assert_eq!(duration(456.7e-6), "457 µs");
        assert_eq!(duration(0.78e-6), "0.78 µs");
    }

    #[test]
    fn a_line_that_misses_what_was_asked_says_so() {
        let row = Row {
            line: 'a',
            work: "fit".into(),
            ours: "1.00 ms".into(),
            peer: "SciPy",
            theirs: "8.00 ms".into(),
            ratio: "8.00".into(),
            asked: Some(("≥ 40".into(), false)),
            apart: Some("0.02 σ".into()),
        };
        let text = table(&[row]);
        assert!(
            text.ends_with("| a | fit | 1.00 ms | SciPy | 8.00 ms | 8.00 | ≥ 40 | **no** | 0.02 σ |\n"),
            "{text}"
        );
    }

    #[test]
    fn the_page_names_the_peers_versions_and_the_rounds() {
        let text = page(&[], 5).unwrap();
        assert!(text.contains("scipy "), "{text}");
        assert!(!text.contains("=="), "{text}");
        assert!(text.contains("the best of 5 rounds counts"), "{text}");
    }
}
