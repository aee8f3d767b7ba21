//! Every measured file is read correctly or refused with a reason; damaged copies of each give an answer or a clear
//! error, with memory limited to a few times the input.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use peak_alloc::PeakAlloc;
use slipfit::Parameter;
use slipfit::SignalKind;
use slipfit::ringdown::{Options, analyse};
use slipfit_io::{Format, ReadOptions, TimeSource, read, read_from, read_tables, read_tables_from};

slipfit_real_data::tests! {
    every_real_file_is_read_or_refused_with_a_reason,
    the_beam_hit_by_a_hammer_is_flagged_and_its_mode_found_in_a_band,
    a_workbook_of_a_few_cycles_is_too_short,
    damaged_real_files_are_read_or_refused,
}

#[global_allocator]
static PEAK: PeakAlloc = PeakAlloc;

/// One test measures memory while all others wait.
static ALONE: Mutex<()> = Mutex::new(());

fn alone() -> std::sync::MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// Writes to stderr directly: the output of macros is hidden in a passing test.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Every measured file.
fn real_files() -> Vec<PathBuf> {
    let mut files = Vec::new();
    for folder in ["ringdown", "sweep", "sweep/pohl_forced_400mA_raw"] {
        let entries = std::fs::read_dir(slipfit_real_data::path(folder)).unwrap();
        files.extend(entries.map(|e| e.unwrap().path()).filter(|p| p.is_file()));
    }
    files.sort();
    files
}

fn name(path: &Path) -> String {
    path.file_name().unwrap().to_string_lossy().into_owned()
}

/// Expected outcome for a file: a record with this number of samples and this signal, or a refusal with this message.
enum Outcome {
    Record { samples: usize, signal: &'static str, unit: &'static str },
    Refused(&'static str),
}
use Outcome::{Record, Refused};

/// Outcomes of the files that the text tests do not cover.
#[rustfmt::skip]
const OUTCOMES: &[(&str, Format, Outcome)] = &[
    ("bell_440hz.wav", Format::Wav, Record { samples: 1_177_856, signal: "channel 1", unit: "" }),
    ("bolted_beam_hammer.mat", Format::Mat5, Record { samples: 65_536, signal: "acc", unit: "" }),
    ("bicycle_fork.mat", Format::Mat5, Record { samples: 30_000, signal: "data", unit: "" }),
    ("ptibbets_idf_wah.mat", Format::Mat5, Record { samples: 17_847, signal: "PendPos", unit: "" }),
    ("highrate5_Test001.lvm", Format::Text, Record { samples: 51_200, signal: "Acceleration_1", unit: "m/s^2" }),
    ("lynch_acc.csv", Format::Text, Record { samples: 406, signal: "column 5 `x`", unit: "" }),
    ("giosue_senza.txt", Format::Text, Record { samples: 1806, signal: "Pos B", unit: "au" }),
    ("pisa_quadrifilar.txt", Format::Text, Refused("no column could be the signal")),
    ("phyphox_five_sheets.xls", Format::Xls, Record { samples: 484, signal: "Rotation z", unit: "rad/s" }),
    ("bolted_beam_force_levels.mat", Format::Mat5, Refused("no column of times")),
    ("quartz_impedance.xlsx", Format::Xlsx, Refused("no column of times")),
    ("akiyama_tuning_fork_nanonis.dat", Format::Text, Refused("no column of times")),
    ("torsion_forced.csv", Format::Text, Refused("no column of times")),
    ("pohl_forced_400mA.csv", Format::Text, Refused("no column of times")),
];

fn every_real_file_is_read_or_refused_with_a_reason() {
    let _alone = alone();
    let mut lines =
        vec!["| file | format | tables | what came of it |".to_owned(), "|---|---|---|---|".to_owned()];
    for path in real_files() {
        let tables = read_tables(&path, usize::MAX).unwrap_or_else(|e| panic!("{e}"));
        assert!(tables.tables.iter().all(|t| t.rows() > 1), "{}", path.display());
        assert_eq!(tables.bytes, std::fs::metadata(&path).unwrap().len());
        let shape: Vec<String> =
            tables.tables.iter().take(6).map(|t| format!("{} × {}", t.rows(), t.columns.len())).collect();
        let reading = read(&path, &ReadOptions::default());
        let said = match &reading {
            Ok(reading) => {
                let (record, report) = (&reading.record, &reading.report);
                assert!(record.signal().iter().all(|v| v.is_finite()));
                assert!(record.len() >= 8);
                let answer = match analyse(record, &Options::default()) {
                    Ok(answer) => {
                        let codes: Vec<&str> =
                            answer.warnings.iter().map(slipfit::answer::Warning::code).collect();
                        format!(
                            "{}, {:.4} Hz; {}",
                            answer.model,
                            answer.parameter(Parameter::Frequency).map_or(f64::NAN, |f| f.value),
                            codes.join(", ")
                        )
                    }
                    Err(error) => format!("no ring-down: {error}"),
                };
                format!(
                    "record of {} samples, {}: {answer}",
                    record.len(),
                    report.column("signal").unwrap().why
                )
            }
            Err(error) => {
                assert!(!error.problem.to_string().is_empty());
                format!("refused: {}", error.problem)
            }
        };
        lines.push(format!(
            "| {} | {} | {} | {} |",
            name(&path),
            tables.format.name(),
            shape.join(", "),
            said.replace('|', "/")
        ));
        if let Some((file, format, outcome)) = OUTCOMES.iter().find(|(f, ..)| *f == name(&path)) {
            assert_eq!(tables.format, *format, "{file}");
            match (outcome, &reading) {
                (Record { samples, signal, unit }, Ok(reading)) => {
                    assert!(
                        *samples == 0 || reading.record.len() == *samples,
                        "{file}: {}",
                        reading.record.len()
                    );
                    assert!(
                        reading.report.column("signal").unwrap().why.contains(signal),
                        "{file}: {}",
                        reading.report.column("signal").unwrap().why
                    );
                    assert_eq!(reading.record.unit(), *unit, "{file}");
                }
                (Refused(reason), Err(error)) => assert!(error.to_string().contains(reason), "{error}"),
                (_, found) => panic!("{file}: {found:?}"),
            }
        }
    }
    say(&lines.join("\n"));
}

fn the_beam_hit_by_a_hammer_is_flagged_and_its_mode_found_in_a_band() {
    let _alone = alone();
    let path = slipfit_real_data::path("ringdown/bolted_beam_hammer.mat");
    let reading = read(&path, &ReadOptions::default()).unwrap();
    assert!(matches!(reading.report.time, Some(TimeSource::Column(_))), "{:?}", reading.report.time);
    assert!((1.0 / reading.record.clock_report().median_step_s / 12_800.0 - 1.0).abs() < 1e-3);
    assert_eq!(reading.record.kind(), SignalKind::Acceleration);
    let whole = analyse(&reading.record, &Options::default()).unwrap();
    let codes: Vec<&str> = whole.warnings.iter().map(slipfit::answer::Warning::code).collect();
    assert!(codes.contains(&"several_modes"), "{codes:?}");
    let mut band = Options::default();
    band.band_hz = Some([70.0, 90.0]);
    let mode = analyse(&reading.record, &band).unwrap();
    let frequency = mode.parameter(Parameter::Frequency).unwrap().value;
    assert!((80.0..81.0).contains(&frequency), "{frequency}");
    let tau_s = (mode.segment.end_s - mode.segment.start_s) / mode.diagnostics.decay_times;
    assert!((0.99..=1.21).contains(&tau_s), "{tau_s}");
}

/// Warnings of the analysis of a sheet of the phone's workbook.
fn doubts(path: &Path, sheet: &str) -> Vec<&'static str> {
    let options = ReadOptions { sheet: Some(sheet.into()), ..Default::default() };
    let reading = read(path, &options).unwrap();
    assert_eq!(reading.report.sheet, sheet);
    let answer = analyse(&reading.record, &Options::default()).unwrap();
    answer.warnings.iter().map(slipfit::answer::Warning::code).collect()
}

fn a_workbook_of_a_few_cycles_is_too_short() {
    let _alone = alone();
    let path = slipfit_real_data::path("ringdown/phyphox_five_sheets.xls");
    // Its raw data contain seven cycles with hardly any decay, its autocorrelation three.
    let unasked = read(&path, &ReadOptions::default()).unwrap();
    assert_eq!(unasked.report.sheet, "Raw Data");
    assert!(doubts(&path, "Raw Data").contains(&"not_separable"));
    assert!(doubts(&path, "Autocorrelation").contains(&"too_few_cycles"));
}

/// Random numbers for the positions of damage, the same on every machine.
struct Seeded(u64);

impl Seeded {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n.max(1) as u64) as usize
    }
}

/// Reads damaged bytes in every possible way; returns the peak memory in excess of the initial use.
fn survive(bytes: &[u8], name: &str, rows: usize) -> f64 {
    PEAK.reset_peak_usage();
    let before = PEAK.current_usage();
    for options in [ReadOptions::default(), ReadOptions { rate_hz: Some(100.0), ..Default::default() }] {
        if let Err(error) = read_from(bytes, name, &options) {
            assert!(error.to_string().starts_with(name), "{error}");
            assert!(error.to_string().len() > name.len() + 4, "{error}");
        }
    }
    let _ = read_tables_from(bytes, name, rows);
    (PEAK.peak_usage() - before) as f64
}

/// Bytes allowed in addition to a multiple of the input: windows of the readers.
const WINDOWS: f64 = 24e6;
/// Text with one digit per cell becomes eight bytes per cell, twice while the vector grows; packed files are larger
/// unpacked.
const TIMES: f64 = 40.0;

/// Length of text or sound that is damaged if time is short: the beginning is decisive.
const BEGINNING: usize = 32 << 10;

fn damaged(path: &Path, truncated: usize, flipped: usize) {
    let whole = std::fs::read(path).unwrap();
    let is_seekable =
        !matches!(path.extension().and_then(|e| e.to_str()), Some("csv" | "txt" | "dat" | "wav"));
    let bytes = if is_seekable { &whole[..] } else { &whole[..whole.len().min(BEGINNING)] };
    let mut seeded = Seeded(0x9e37_79b9_7f4a_7c15 ^ bytes.len() as u64);
    let check = |damaged: &[u8]| {
        let peak = survive(damaged, &name(path), 1000);
        let allowed = TIMES * whole.len() as f64 + WINDOWS;
        assert!(peak <= allowed, "{}: {peak} bytes for {}", path.display(), damaged.len());
    };
    for _ in 0..truncated {
        check(&bytes[..seeded.below(bytes.len())]);
    }
    for _ in 0..flipped {
        let mut copy = bytes.to_vec();
        let at = seeded.below(copy.len());
        copy[at] ^= 1 << seeded.below(8);
        check(&copy);
    }
}

/// Copies of a file share the available time: large files are damaged less often.
fn share(path: &Path, most: usize) -> usize {
    let size = std::fs::metadata(path).unwrap().len() as usize;
    (most * (40 << 10) / size.max(40 << 10)).max(most / 60).max(1)
}

fn damaged_real_files_are_read_or_refused() {
    let _alone = alone();
    for path in real_files() {
        damaged(&path, share(&path, 20), share(&path, 60));
    }
}
