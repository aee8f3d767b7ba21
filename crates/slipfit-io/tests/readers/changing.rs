//! Files that change while they are read give an answer about what was read, or an error.

use slipfit_io::{ReadOptions, ReadProblem, read_from, read_watched};
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::PathBuf;

fn file(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("slipfit-{}-{name}", std::process::id()))
}

fn rows(from: u32, to: u32) -> String {
    (from..to).map(|i| format!("{},{}\n", 0.01 * f64::from(i), (0.1 * f64::from(i)).sin())).collect()
}

#[test]
fn a_growing_text_is_read_to_an_end_and_hashed_as_far() {
    let path = file("growing.csv");
    fs::write(&path, format!("t (s),x (m)\n{}", rows(0, 300))).unwrap();
    let mut rest = 3;
    let read = read_watched(&path, &ReadOptions::default(), &mut |_| {
        if rest > 0 {
            rest -= 1;
            let from = 300 + 100 * (3 - rest);
            let mut file = OpenOptions::new().append(true).open(&path).unwrap();
            file.write_all(rows(from, from + 100).as_bytes()).unwrap();
        }
    })
    .unwrap();
    let whole = fs::read(&path).unwrap();
    fs::remove_file(&path).unwrap();
    let part = &whole[..read.report.bytes as usize];
    let again = read_from(part, "part", &ReadOptions::default()).unwrap();
    assert_eq!(again.report.sha256, read.report.sha256);
    assert_eq!(again.record, read.record);
    assert!(read.record.len() > 300);
}

#[test]
fn a_file_read_in_pieces_must_not_change() {
    let path = file("changing.wav");
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: 1000,
        bits_per_sample: 32,
        sample_format: hound::SampleFormat::Float,
    };
    let mut writer = hound::WavWriter::create(&path, spec).unwrap();
    (0..5000).for_each(|i| writer.write_sample((0.1 * i as f32).sin()).unwrap());
    writer.finalize().unwrap();
    let mut last = 0;
    let error = read_watched(&path, &ReadOptions::default(), &mut |bytes| {
        // The end is reached when no more bytes arrive: the hash is complete, the samples have not been read yet.
        if bytes == last {
            OpenOptions::new().append(true).open(&path).unwrap().write_all(b"more").unwrap();
        }
        last = bytes;
    })
    .unwrap_err();
    fs::remove_file(&path).unwrap();
    assert!(matches!(error.problem, ReadProblem::Changed), "{error}");
}
