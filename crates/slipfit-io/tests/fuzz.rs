//! Randomly changed files of every format: no panic, no hang, and memory limited to a few times the input.
//!
//! The test runs for a moment, or for the number of files given by `SLIPFIT_FUZZ_FILES`, without coverage;
//! `cargo xtask fuzz` is guided by coverage, with one target per format. Seeds are the fixtures in
//! `validation/reference/formats`. Failing inputs are written to `target/fuzz` and named.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use peak_alloc::PeakAlloc;
use slipfit_io::{Format, ReadOptions, read_from, read_tables, read_tables_from};

#[global_allocator]
static PEAK: PeakAlloc = PeakAlloc;

/// Longer than any file of this size may take, even on a busy machine.
const HANGS_AFTER: Duration = Duration::from_secs(60);
/// Memory that may be requested in addition to a multiple of the input: windows of the readers.
const WINDOWS: usize = 24 << 20;
/// Deflate packs a thousandfold, so packed formats may request more.
fn most_times(format: Format) -> usize {
    match format {
        Format::Gzip | Format::Zip | Format::Npz | Format::Xlsx | Format::Ods | Format::Mat5 => 12_000,
        // The number of samples that bytes of silence can represent.
        Format::Flac | Format::Mp3 | Format::Mp4 | Format::Ogg | Format::Aac => 30_000,
        // Zstandard encodes 128 KiB by four bytes; LZF, deflate and shuffle can be combined.
        Format::Arrow => 1 << 15,
        Format::Hdf5 => 4000,
        _ => 400,
    }
}

/// Seeds in addition to the fixtures, for formats and compressions that these do not contain.
const WRITERS: &[&str] = &[
    "constant_zstd.feather",
    "polars_zstd.arrow",
    "pyarrow_decimal_bytes.parquet",
    "h5py_lzf_latest.h5",
    "pandas_table.h5",
    "pandas_stamps.ods",
    #[cfg(feature = "sound")]
    "sound.flac",
    #[cfg(feature = "sound")]
    "sound.m4a",
    #[cfg(feature = "sound")]
    "sound.aac",
    #[cfg(feature = "sound")]
    "sound.mp3",
    #[cfg(feature = "sound")]
    "sound.ogg",
];

struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// Edge values of lengths and counts.
const EDGES: [u64; 12] =
    [0, 1, 7, 0x7f, 0x80, 0xff, 0x7fff, 0xffff, 0x7fff_ffff, 0xffff_ffff, 0x7fff_ffff_ffff_ffff, u64::MAX];

/// One to eight changes of a file, some of them with parts of another file.
fn mutated(seed: &[u8], other: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..=random.below(8) {
        if bytes.is_empty() {
            return bytes;
        }
        // Files break mostly in their headers: half of the damage is done there.
        let reach = if random.below(2) == 0 { bytes.len().min(512) } else { bytes.len() };
        let at = random.below(reach);
        match random.below(9) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = random.next() as u8,
            2 | 3 => {
                let edge = EDGES[random.below(EDGES.len())].to_le_bytes();
                let width = [1, 2, 4, 8][random.below(4)].min(bytes.len() - at);
                bytes[at..at + width].copy_from_slice(&edge[..width]);
                if random.below(4) == 0 {
                    bytes[at..at + width].reverse();
                }
            }
            4 => bytes.truncate(random.below(bytes.len()) + 1),
            5 => {
                let end = (at + random.below(64) + 1).min(bytes.len());
                bytes.drain(at..end);
            }
            6 => {
                let end = (at + random.below(256) + 1).min(bytes.len());
                let copy = bytes[at..end].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, copy);
            }
            7 => {
                let from = random.below(other.len());
                let part = &other[from..(from + random.below(128) + 1).min(other.len())];
                let end = (at + part.len()).min(bytes.len());
                bytes.splice(at..end, part.iter().copied());
            }
            _ => {
                let digits: &[u8] =
                    [b"9999999999".as_slice(), b"-1", b"1e400", b"NaN", b";", b"\"", b"\n"][random.below(7)];
                bytes.splice(at..at, digits.iter().copied());
            }
        }
    }
    bytes
}

/// Reads bytes as a record and as tables.
fn target(bytes: &[u8]) {
    let options = ReadOptions { rate_hz: Some(50.0), ..Default::default() };
    let _ = read_from(bytes, "fuzzed", &ReadOptions::default());
    let _ = read_from(bytes, "fuzzed", &options);
    let _ = read_tables_from(bytes, "fuzzed", 10_000);
}

/// The current case, for the watch.
#[derive(Default)]
struct Watch {
    started: AtomicU64,
    case: Mutex<(String, Vec<u8>)>,
}

fn keep(name: &str, bytes: &[u8]) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../target/fuzz/failures");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// Suppresses message and backtrace for a decoder whose panics are errors: symbols take more memory than files.
fn quiet_where_guarded() {
    let loud = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !slipfit_io::panic_becomes_error() {
            loud(info);
        }
    }));
}

/// Runs for a time, or for a number of files if one is given.
fn run(time: Duration, files: Option<u64>) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../validation/reference/");
    let formats = std::fs::read_dir(format!("{folder}formats")).unwrap().map(|e| e.unwrap().path());
    let mut seeds: Vec<(String, Format, Vec<u8>)> = formats
        .chain(WRITERS.iter().map(|name| PathBuf::from(format!("{folder}writers/{name}"))))
        .filter(|p| !p.extension().is_some_and(|e| e == "py" || e == "md"))
        .map(|p: PathBuf| {
            let format = read_tables(&p, 1).unwrap().format;
            (name(&p), format, std::fs::read(&p).unwrap())
        })
        .collect();
    seeds.sort_by(|a, b| a.0.cmp(&b.0));
    quiet_where_guarded();
    let start = Instant::now();
    let watch = Arc::new(Watch::default());
    let watched = Arc::clone(&watch);
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let since = watched.started.load(Ordering::Relaxed);
            let now = start.elapsed().as_millis() as u64;
            if since > 0 && now > since + HANGS_AFTER.as_millis() as u64 {
                let (name, bytes) = &*watched.case.lock().unwrap();
                let path = keep(&format!("hang-{name}"), bytes);
                let _ = writeln!(std::io::stderr(), "HANGS: {}", path.display());
                std::process::abort();
            }
        }
    });
    let mut random = Random(0x2545_f491_4f6c_dd1c);
    let mut counts = vec![0_u64; seeds.len()];
    let mut worst = vec![0_usize; seeds.len()];
    while files.map_or(start.elapsed() < time, |files| counts.iter().sum::<u64>() < files) {
        for i in 0..seeds.len() {
            let (name, format, seed) = &seeds[i];
            let others: Vec<&Vec<u8>> = seeds.iter().filter(|s| s.1 == *format).map(|s| &s.2).collect();
            let bytes = mutated(seed, others[random.below(others.len())], &mut random);
            *watch.case.lock().unwrap() = (name.clone(), bytes.clone());
            watch.started.store(start.elapsed().as_millis() as u64 + 1, Ordering::Relaxed);
            PEAK.reset_peak_usage();
            let before = PEAK.current_usage();
            let panicked = std::panic::catch_unwind(|| target(&bytes)).is_err();
            let peak = PEAK.peak_usage() - before;
            watch.started.store(0, Ordering::Relaxed);
            counts[i] += 1;
            worst[i] = worst[i].max(peak);
            if panicked {
                panic!("panics: {}", keep(&format!("panic-{name}"), &bytes).display());
            }
            if peak > most_times(*format) * bytes.len() + WINDOWS {
                panic!(
                    "{peak} bytes for {}: {}",
                    bytes.len(),
                    keep(&format!("memory-{name}"), &bytes).display()
                );
            }
        }
    }
    for ((name, format, seed), (count, worst)) in seeds.iter().zip(counts.iter().zip(&worst)) {
        let line = format!(
            "{count:>8} runs of {name} ({}, {} bytes), peak {worst} bytes",
            format.name(),
            seed.len()
        );
        let _ = writeln!(std::io::stderr(), "{line}");
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap().to_string_lossy().into_owned()
}

#[test]
fn changed_files_are_read_or_refused() {
    let files = std::env::var("SLIPFIT_FUZZ_FILES").ok();
    run(Duration::from_secs(5), files.map(|number| number.parse().unwrap()));
}

/// A case found by fuzzing.
#[test]
fn columns_outside_of_a_parquet_file_are_refused() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../validation/reference/formats");
    let bytes = std::fs::read(Path::new(folder).join("snappy.parquet")).unwrap();
    for at in bytes.len().saturating_sub(900)..bytes.len() - 8 {
        for value in [0x7f, 0x80, 0xff] {
            let mut copy = bytes.clone();
            copy[at] = value;
            target(&copy);
        }
    }
}

/// Inputs that reached most of the readers, and inputs that once broke one.
#[test]
fn every_file_of_the_corpora_is_read_or_refused() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus");
    let mut count = 0;
    for target_folder in std::fs::read_dir(folder).unwrap() {
        for file in std::fs::read_dir(target_folder.unwrap().path()).unwrap() {
            target(&std::fs::read(file.unwrap().path()).unwrap());
            count += 1;
        }
    }
    assert!(count > 0, "no corpus in {folder}");
}
