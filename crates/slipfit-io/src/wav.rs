//! Sound files: RIFF WAVE with integer or float samples.

use std::io::{BufReader, Read};

use hound::{SampleFormat, WavReader};
use slipfit::{Record, SignalKind};

use crate::{
    Format, ReadOptions, ReadProblem,
    report::{ColumnInfo, ColumnTaken, ReadReport, Reading, TimeSource},
};

/// Reads one channel of a sound file, in parts of full scale.
pub(crate) fn read(reader: impl Read, options: &ReadOptions) -> Result<Reading, ReadProblem> {
    for (flag, given) in [("--time", options.time.is_some()), ("--quadrature", options.quadrature.is_some())]
    {
        if given {
            return Err(ReadProblem::Conflict(flag, "a sound file"));
        }
    }
    // Samples are taken out two bytes at a time.
    let mut sound = WavReader::new(BufReader::with_capacity(1 << 16, reader)).map_err(problem)?;
    let spec = sound.spec();
    let channels = usize::from(spec.channels).max(1);
    let channel = channel(options.signal.as_deref(), channels)?;
    let rate_hz = options.rate_hz.unwrap_or(f64::from(spec.sample_rate));
    let mut samples = Samples { values: Vec::new(), channel, channels, next: 0 };
    let mut notes = Vec::new();
    let ended = match spec.sample_format {
        SampleFormat::Float => sound.samples::<f32>().try_for_each(|s| s.map(|s| samples.push(f64::from(s)))),
        SampleFormat::Int => {
            let full_scale = 2f64.powi(i32::from(spec.bits_per_sample) - 1);
            sound.samples::<i32>().try_for_each(|s| s.map(|s| samples.push(f64::from(s) / full_scale)))
        }
    };
    if let Err(error) = ended {
        // A recorder that lost power leaves a header that promises too much.
        notes.push(format!("the sound ends early: {error}"));
    }
    if channels > 1 {
        notes.push(format!(
            "the sound has {channels} channels; number {} was read, --signal reads another",
            channel + 1
        ));
    }
    let rows_read = samples.values.len() as u64;
    let column =
        |number: usize| ColumnInfo { number, header: format!("channel {number}"), unit: String::new() };
    let label = format!("channel {}", channel + 1);
    let record = Record::uniform(rate_hz, samples.values).map_err(|error| match error {
        slipfit::Error::ConstantSignal { value } => {
            ReadProblem::ConstantSignal { column: label.clone(), value }
        }
        slipfit::Error::TooFewSamples { found, needed } => {
            ReadProblem::TooFewRows { read: found, needed, column: label.clone(), skipped: String::new() }
        }
        other => ReadProblem::Record(other),
    })?;
    let kind = options.kind.unwrap_or(SignalKind::Displacement);
    let unit = options.signal_unit.clone().unwrap_or_default();
    let why = if options.signal.is_some() { "asked for" } else { "the sound" };
    let report = ReadReport {
        path: String::new(),
        format: Format::Wav,
        sha256: String::new(),
        bytes: 0,
        rows_read,
        skipped: Vec::new(),
        dialect: None,
        time: TimeSource::Rate(rate_hz),
        signal: ColumnTaken {
            column: column(channel + 1),
            unit: unit.clone(),
            why: format!("{label}: {why}"),
        },
        quadrature: None,
        kind,
        columns: (1..=channels).map(column).collect(),
        tables: 1,
        table: 1,
        runs: 1,
        run: 1,
        named_values: Vec::new(),
        notes,
    };
    Ok(Reading { record: record.with_kind(kind).with_unit(unit), report })
}

/// Keeps the samples of one channel.
struct Samples {
    values: Vec<f64>,
    channel: usize,
    channels: usize,
    next: usize,
}

impl Samples {
    fn push(&mut self, value: f64) {
        if self.next == self.channel {
            self.values.push(value);
        }
        self.next = (self.next + 1) % self.channels;
    }
}

/// Index of the channel asked for; the first by default.
fn channel(wanted: Option<&str>, channels: usize) -> Result<usize, ReadProblem> {
    let Some(wanted) = wanted else { return Ok(0) };
    let number = wanted.trim().to_lowercase();
    match number.trim_start_matches("channel").trim().parse::<usize>() {
        Ok(number) if (1..=channels).contains(&number) => Ok(number - 1),
        _ => Err(ReadProblem::UnknownColumn {
            flag: "--signal",
            wanted: wanted.to_owned(),
            columns: if channels == 1 { "channel 1".to_owned() } else { format!("channels 1 to {channels}") },
        }),
    }
}

fn problem(error: hound::Error) -> ReadProblem {
    match error {
        hound::Error::IoError(error) => ReadProblem::Io(error),
        other => ReadProblem::Broken { format: Format::Wav, reason: other.to_string() },
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use hound::{WavSpec, WavWriter};
    use proptest::prelude::*;

    use super::*;
    use crate::{ReadError, read_from};

    fn ring(i: i32) -> f64 {
        (-0.001 * f64::from(i)).exp() * (0.3 * f64::from(i)).cos()
    }

    fn sound(bits_per_sample: u16, sample_format: SampleFormat, channels: u16) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let spec = WavSpec { channels, sample_rate: 8000, bits_per_sample, sample_format };
        let mut writer = WavWriter::new(&mut bytes, spec).unwrap();
        for i in 0..400 {
            for channel in 0..channels {
                let value = ring(i) / f64::from(channel + 1);
                if sample_format == SampleFormat::Float {
                    writer.write_sample(value as f32).unwrap();
                } else {
                    let full_scale = 2f64.powi(i32::from(bits_per_sample) - 1) - 1.0;
                    writer.write_sample((value * full_scale) as i32).unwrap();
                }
            }
        }
        writer.finalize().unwrap();
        bytes.into_inner()
    }

    fn read(bytes: &[u8], options: &ReadOptions) -> Result<Reading, ReadError> {
        read_from(bytes, "bell.wav", options)
    }

    #[test]
    fn sounds_are_read_in_parts_of_full_scale() {
        for (bits, format) in [
            (8, SampleFormat::Int),
            (16, SampleFormat::Int),
            (24, SampleFormat::Int),
            (32, SampleFormat::Int),
            (32, SampleFormat::Float),
        ] {
            let bytes = sound(bits, format, 1);
            let reading = read(&bytes, &ReadOptions::default()).unwrap();
            assert_eq!((reading.record.len(), reading.report.bytes), (400, bytes.len() as u64));
            assert_eq!(reading.report.time, TimeSource::Rate(8000.0));
            // Two steps of the converter: one is cut off, one is the missing end of the scale.
            let tolerance =
                if format == SampleFormat::Float { 1e-7 } else { 2.0 * 2f64.powi(1 - i32::from(bits)) };
            for (i, value) in reading.record.signal().iter().enumerate() {
                assert!((value - ring(i as i32)).abs() <= tolerance, "{bits} bits, sample {i}");
            }
        }
    }

    #[test]
    fn a_channel_is_chosen_by_number() {
        let bytes = sound(16, SampleFormat::Int, 2);
        assert!((read(&bytes, &ReadOptions::default()).unwrap().record.signal()[0] - 1.0).abs() < 1e-4);
        let second = ReadOptions { signal: Some("2".into()), ..Default::default() };
        assert!((read(&bytes, &second).unwrap().record.signal()[0] - 0.5).abs() < 1e-4);
        let third = ReadOptions { signal: Some("3".into()), ..Default::default() };
        let message = read(&bytes, &third).unwrap_err().to_string();
        assert_eq!(message, "bell.wav: --signal 3: no such column; there are channels 1 to 2");
    }

    #[test]
    fn a_sound_cut_short_is_read_as_far_as_it_goes() {
        let bytes = sound(16, SampleFormat::Int, 1);
        let reading = read(&bytes[..bytes.len() - 201], &ReadOptions::default()).unwrap();
        assert_eq!(reading.record.len(), 299);
        assert!(reading.report.notes[0].starts_with("the sound ends early"));
    }

    proptest! {
        #[test]
        fn mutated_sounds_are_read_or_refused(
            changes in prop::collection::vec((0..60usize, any::<u8>()), 0..8),
            length in 12..900usize,
        ) {
            let mut bytes = sound(16, SampleFormat::Int, 1);
            for (at, byte) in changes {
                bytes[at] = byte;
            }
            let _ = read(&bytes[..length.min(bytes.len())], &ReadOptions::default());
        }
    }
}
