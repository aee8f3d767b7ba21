//! An interrupt ends any computation with exit status 130 and leaves no half-written file.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Complex noise over frequency, in which the search for a resonance continues to its limit.
fn noise(path: &Path, seed: u64) {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let mut text = String::from("frequency (Hz),amplitude (V)\n");
    for i in 0..400 {
        text += &format!("{},{}\n", 10.0 + 0.05 * f64::from(i), (next() + next()).abs() + 1e-3);
    }
    fs::write(path, text).unwrap();
}

fn start(folder: &Path, arguments: &[&str]) -> Child {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("slipfit"));
    command.current_dir(folder).args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().unwrap()
}

/// Interrupts it once it `computes`; returns the exit status and the time until the end.
fn interrupt(mut child: Child, computes: impl Fn(Duration) -> bool) -> (Option<i32>, Duration) {
    let started = Instant::now();
    while !computes(started.elapsed()) && started.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(10));
    }
    assert!(child.try_wait().unwrap().is_none(), "too quick to be interrupted");
    let sent = Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let code = child.wait().unwrap().code();
    (code, sent.elapsed())
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn one_long_analysis_ends_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let files: Vec<String> = (0..24).map(|i| format!("{i:02}.csv")).collect();
    files.iter().enumerate().for_each(|(i, f)| noise(&folder.path().join(f), i as u64));
    let manifest: String =
        files.iter().map(|f| format!("[[measurement]]\nsweep = \"{f}\"\ncondition = \"{f}\"\n")).collect();
    fs::write(folder.path().join("all.toml"), manifest).unwrap();
    let before = names(folder.path());
    let child = start(folder.path(), &["series", "all.toml", "--json", "out.json", "--html", "out.html"]);
    let (code, took) = interrupt(child, |since| since > Duration::from_millis(500));
    assert_eq!(code, Some(130), "after {took:?}");
    assert_eq!(names(folder.path()), before);
}

#[test]
fn a_table_of_long_analyses_ends_and_goes_on_later() {
    let folder = tempfile::tempdir().unwrap();
    let files: Vec<String> = (0..24).map(|i| format!("{i:02}.csv")).collect();
    files.iter().enumerate().for_each(|(i, f)| noise(&folder.path().join(f), i as u64));
    let mut arguments = vec!["resonance"];
    arguments.extend(files.iter().map(String::as_str));
    arguments.extend(["--table", "out.csv", "--resume"]);
    let rows = folder.path().join("out.csv.rows");
    let (code, took) = interrupt(start(folder.path(), &arguments), |_| rows.exists());
    assert_eq!(code, Some(130), "after {took:?}");
    let left = names(folder.path());
    assert!(left.iter().all(|n| files.contains(n) || n == "out.csv" || n == "out.csv.rows"), "{left:?}");
    assert!(left.contains(&"out.csv.rows".to_owned()), "the rows that are done: {left:?}");
}

fn ends_at_once((code, took): (Option<i32>, Duration)) {
    assert_eq!(code, Some(130), "after {took:?}");
}

#[test]
fn a_long_record_and_a_map_end_too() {
    let folder = tempfile::tempdir().unwrap();
    // Amplitudes after a low-pass filter, whose inversion is the slowest analysis of one record.
    let mut state = 7u64;
    let mut text = String::from("t (s),x (mm)\n");
    for i in 0..200_000 {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let noise = (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        let t = 1e-4 * f64::from(i);
        text += &format!("{t:.6},{:.5}\n", (-0.2 * t).exp() - 0.01 * t + 0.02 * noise);
    }
    fs::write(folder.path().join("long.csv"), text).unwrap();
    let before = names(folder.path());
    let low_pass = ["--kind", "envelope", "--lockin-time-constant", "0.05", "--lockin-order", "4"];
    let outputs = ["--law", "free", "--html", "out.html", "--json", "out.json"];
    let arguments = [&["ringdown", "long.csv"], &low_pass[..], &outputs].concat();
    let child = start(folder.path(), &arguments);
    ends_at_once(interrupt(child, |since| since > Duration::from_millis(150)));
    assert_eq!(names(folder.path()), before);
    // A stack of 300 x 300 decays of 512 samples, analysed one by one.
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (300, 300, 512), }\n";
    let mut stack = b"\x93NUMPY\x01\x00".to_vec();
    stack.extend((header.len() as u16).to_le_bytes());
    stack.extend(header.bytes());
    for pixel in 0..90_000u32 {
        let rate = 0.01 + 1e-7 * pixel as f32;
        stack
            .extend((0..512).flat_map(|i| ((-rate * i as f32).exp() * (0.7 * i as f32).cos()).to_le_bytes()));
    }
    fs::write(folder.path().join("stack.npy"), stack).unwrap();
    let before = names(folder.path());
    let map = ["map", "stack.npy", "--dt", "1e-3", "--kind", "displacement", "--method", "analyse"];
    let line = [&map[..], &["--table", "out.csv", "--plot", "out.svg"]].concat();
    ends_at_once(interrupt(start(folder.path(), &line), |since| since > Duration::from_millis(500)));
    assert_eq!(names(folder.path()), before);
    // The same with blocks to keep; no half-written block is left.
    let line = [&map[..], &["--table", "out.csv", "--resume", "blocks"]].concat();
    ends_at_once(interrupt(start(folder.path(), &line), |since| since > Duration::from_millis(500)));
    let blocks = names(&folder.path().join("blocks"));
    assert!(blocks.iter().all(|name| name.starts_with("rows-")), "{blocks:?}");
    assert!(!folder.path().join("out.csv").exists());
}
