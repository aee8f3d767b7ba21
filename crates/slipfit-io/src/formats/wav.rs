//! Sound files: RIFF WAVE and RF64 with integer or float samples of any depth.

use std::io::{BufReader, Read, Seek, SeekFrom};

use crate::{
    columns::head::Head,
    error::ReadProblem,
    format::Format,
    input::Input,
    report::Skipped,
    tables::binary::{Kind, Stored},
    tables::table::{BATCH, Batch, Sink, TableSource},
};

/// A sound: one column per channel, relative to full scale.
pub(crate) struct Sound {
    input: Input,
    head: Head,
    spec: Spec,
    /// Offset of the samples, and their length in bytes.
    start: u64,
    length: u64,
}

/// How a sample is stored.
#[derive(Debug, Clone, Copy)]
struct Spec {
    float: bool,
    /// Bytes of one sample of one channel.
    bytes: usize,
    channels: usize,
    rate_hz: u32,
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes)
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u32_at(bytes, at)) | u64::from(u32_at(bytes, at + 4)) << 32
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    bytes.get(at..at + 2).and_then(|b| b.try_into().ok()).map_or(0, u16::from_le_bytes)
}

impl Spec {
    fn of(chunk: &[u8]) -> Result<Self, ReadProblem> {
        if chunk.len() < 16 {
            return Err(Format::Wav.broken("its format chunk is too short"));
        }
        let (mut coding, bits) = (u16_at(chunk, 0), u16_at(chunk, 14));
        if coding == 0xfffe && chunk.len() >= 26 {
            // The extensible form names the coding in the first bytes of its GUID.
            coding = u16_at(chunk, 24);
        }
        let float = match coding {
            1 => false,
            3 => true,
            other => {
                return Err(Format::Wav.broken(format!("samples in coding {other:#06x}, not PCM or float")));
            }
        };
        let (channels, block) = (usize::from(u16_at(chunk, 2)), usize::from(u16_at(chunk, 12)));
        if channels == 0 || block == 0 || block % channels != 0 {
            return Err(Format::Wav.broken(format!("{channels} channels in blocks of {block} bytes")));
        }
        let spec = Self { float, bytes: block / channels, channels, rate_hz: u32_at(chunk, 4) };
        let known = if float { matches!(spec.bytes, 4 | 8) } else { (1..=8).contains(&spec.bytes) };
        if !known || usize::from(bits) > 8 * spec.bytes {
            return Err(Format::Wav.broken(format!("samples of {bits} bits in {} bytes", spec.bytes)));
        }
        if spec.rate_hz == 0 {
            return Err(Format::Wav.broken("a sampling rate of zero"));
        }
        Ok(spec)
    }

    /// The values of one channel, which begins at offset `at` in each block.
    fn values(self, blocks: &[u8], block: usize, at: usize, into: &mut Vec<f64>) {
        let blocks = blocks.chunks_exact(block);
        match (self.float, self.bytes) {
            // Nearly all sounds have this form, which justifies a loop without branches.
            (false, 2) => {
                into.extend(blocks.map(|b| f64::from(i16::from_le_bytes([b[at], b[at + 1]])) / 32768.0));
            }
            _ => into.extend(blocks.map(|b| self.value(&b[at..at + self.bytes]))),
        }
    }

    /// One sample relative to full scale. Samples are aligned to the upper end of their container, so that its size
    /// alone determines the scale.
    fn value(self, bytes: &[u8]) -> f64 {
        let stored = |kind| Stored { kind, bytes: self.bytes, big_endian: false }.read(bytes);
        match (self.float, self.bytes) {
            (true, _) => stored(Kind::Float),
            // Eight-bit samples are unsigned with an offset of 128.
            (false, 1) => (stored(Kind::Unsigned) - 128.0) / 128.0,
            (false, bytes) => stored(Kind::Signed) / 2f64.powi(8 * bytes as i32 - 1),
        }
    }
}

impl Sound {
    /// Reads the header.
    pub(crate) fn open(mut input: Input) -> Result<Self, ReadProblem> {
        let size = input.seek(SeekFrom::End(0)).map_err(ReadProblem::Io)?;
        input.seek(SeekFrom::Start(0)).map_err(ReadProblem::Io)?;
        let mut riff = [0; 12];
        input.read_exact(&mut riff).map_err(|_| Format::Wav.broken("it ends in its header"))?;
        let (mut at, mut spec, mut wide) = (12_u64, None, None);
        loop {
            let mut header = [0; 8];
            if input.read_exact(&mut header).is_err() {
                return Err(Format::Wav.broken("it ends before its samples"));
            }
            let id = &header[..4];
            let mut length = u64::from(u32_at(&header, 4));
            at += 8;
            match id {
                b"data" => {
                    let spec: Spec = spec.ok_or_else(|| Format::Wav.broken("samples before their format"))?;
                    if length == u64::from(u32::MAX) {
                        // RF64 stores the size separately; recorders that were interrupted store it nowhere.
                        length = wide.unwrap_or(size - at.min(size));
                    }
                    let head = Head::of_channels(spec.channels, f64::from(spec.rate_hz));
                    let mut sound = Self { input, head, spec, start: at, length };
                    sound.account(size);
                    return Ok(sound);
                }
                b"fmt " | b"ds64" => {
                    // Known chunks are short; a length field may have any value.
                    let mut chunk = vec![0; length.min(64) as usize];
                    let n = read_up_to(&mut input, &mut chunk)?;
                    if id == b"ds64" {
                        wide = Some(u64_at(&chunk, 8)).filter(|_| n >= 16);
                    } else {
                        spec = Some(Spec::of(&chunk[..n])?);
                    }
                }
                _ => {}
            }
            at = at.saturating_add(length).saturating_add(length & 1);
            if at > size {
                return Err(Format::Wav.broken("it ends before its samples"));
            }
            input.seek(SeekFrom::Start(at)).map_err(ReadProblem::Io)?;
        }
    }

    /// Notes data that the header promises and the file does not contain.
    fn account(&mut self, size: u64) {
        let there = size.saturating_sub(self.start);
        let notes = &mut self.head.notes;
        if self.length > there {
            // A recorder that lost power leaves a header with too large a size.
            notes.push(
                format!(
                    "the sound ends early: {there} bytes of samples where its header names {}",
                    self.length
                )
                .into(),
            );
            self.length = there;
        }
    }
}

fn read_up_to(input: &mut Input, buffer: &mut [u8]) -> Result<usize, ReadProblem> {
    let mut n = 0;
    while n < buffer.len() {
        match input.read(&mut buffer[n..]).map_err(ReadProblem::Io)? {
            0 => break,
            more => n += more,
        }
    }
    Ok(n)
}

impl TableSource for Sound {
    fn heads(&self) -> Vec<&Head> {
        vec![&self.head]
    }

    fn scan(&mut self, _: usize, wanted: &[usize], sink: Sink<'_>) -> Result<Vec<Skipped>, ReadProblem> {
        let Spec { bytes, channels, .. } = self.spec;
        let block = bytes * channels;
        self.input.seek(SeekFrom::Start(self.start)).map_err(ReadProblem::Io)?;
        let mut reader = BufReader::with_capacity(1 << 16, (&mut self.input).take(self.length));
        let rows = BATCH.min((1 << 22) / block).max(1);
        let mut buffer = vec![0; rows * block];
        let mut columns: Vec<Vec<f64>> = vec![Vec::with_capacity(rows); wanted.len()];
        loop {
            let mut filled = 0;
            while filled < buffer.len() {
                match reader.read(&mut buffer[filled..]).map_err(ReadProblem::Io)? {
                    0 => break,
                    n => filled += n,
                }
            }
            let whole = filled / block;
            for (column, &channel) in columns.iter_mut().zip(wanted) {
                column.clear();
                self.spec.values(&buffer[..whole * block], block, channel * bytes, column);
            }
            let batch: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            if whole > 0 && !sink(Batch::of(&batch)) || filled < buffer.len() {
                return Ok(Vec::new());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{ReadError, ReadOptions, Reading, TimeSource, read_from};

    fn ring(i: i32) -> f64 {
        (-0.001 * f64::from(i)).exp() * (0.3 * f64::from(i)).cos()
    }

    /// A sound of 400 samples; each further channel is half as loud.
    fn sound(coding: u16, bytes_each: u16, channels: u16, wide: bool) -> Vec<u8> {
        let mut samples = Vec::new();
        for i in 0..400 {
            for channel in 0..channels {
                let value = ring(i) / f64::from(channel + 1);
                let full_scale = 2f64.powi(8 * i32::from(bytes_each) - 1) - 1.0;
                match (coding, bytes_each) {
                    (3, 8) => samples.extend(value.to_le_bytes()),
                    (3, _) => samples.extend((value as f32).to_le_bytes()),
                    (_, 1) => samples.push((value * full_scale + 128.0) as u8),
                    _ => samples.extend(&((value * full_scale) as i64).to_le_bytes()[..bytes_each.into()]),
                }
            }
        }
        let mut bytes = if wide { b"RF64" } else { b"RIFF" }.to_vec();
        bytes.extend(u32::MAX.to_le_bytes());
        bytes.extend(b"WAVE");
        if wide {
            bytes.extend(b"ds64");
            bytes.extend(28_u32.to_le_bytes());
            bytes.extend(0_u64.to_le_bytes());
            bytes.extend((samples.len() as u64).to_le_bytes());
            bytes.extend([0; 12]);
        }
        let block = channels * bytes_each;
        bytes.extend(b"LIST\x03\0\0\0abc\0fmt \x10\0\0\0");
        bytes.extend([coding.to_le_bytes(), channels.to_le_bytes()].concat());
        bytes.extend([8000_u32.to_le_bytes(), (8000 * u32::from(block)).to_le_bytes()].concat());
        bytes.extend([block.to_le_bytes(), (8 * bytes_each).to_le_bytes()].concat());
        bytes.extend(b"data");
        bytes.extend(if wide { u32::MAX } else { samples.len() as u32 }.to_le_bytes());
        bytes.extend(samples);
        bytes.extend(b"tail of tags");
        bytes
    }

    fn read(bytes: &[u8], options: &ReadOptions) -> Result<Reading, ReadError> {
        read_from(bytes, "bell.wav", options)
    }

    #[test]
    fn sounds_are_read_in_parts_of_full_scale() {
        for (coding, bytes_each, wide) in [
            (1, 1, false),
            (1, 2, true),
            (1, 3, false),
            (1, 4, false),
            (3, 4, false),
            (3, 8, false),
            (3, 8, true),
        ] {
            let bytes = sound(coding, bytes_each, 1, wide);
            let reading = read(&bytes, &ReadOptions::default()).unwrap();
            assert_eq!((reading.record.len(), reading.report.bytes), (400, bytes.len() as u64));
            assert_eq!(reading.report.time, Some(TimeSource::Rate(8000.0)));
            // Two steps of the converter: one by truncation, one because the upper end of the scale is missing.
            let tolerance = match (coding, bytes_each) {
                (3, 8) => 0.0,
                (3, _) => 1e-7,
                _ => 2.0 * 2f64.powi(1 - 8 * i32::from(bytes_each)),
            };
            for (i, value) in reading.record.signal().iter().enumerate() {
                assert!((value - ring(i as i32)).abs() <= tolerance, "{coding}, {bytes_each}: sample {i}");
            }
        }
    }

    #[test]
    fn a_channel_is_chosen_by_number_or_name() {
        let bytes = sound(1, 2, 2, false);
        let first = read(&bytes, &ReadOptions::default()).unwrap();
        assert!((first.record.signal()[0] - 1.0).abs() < 1e-4);
        let offered = first.report.notes.iter().any(|n| n.text.contains("2 channels") && n.hints.len() == 1);
        assert!(offered, "{:?}", first.report.notes);
        for name in ["2", "channel 2"] {
            let second = ReadOptions { signal: Some(name.into()), ..Default::default() };
            assert!((read(&bytes, &second).unwrap().record.signal()[0] - 0.5).abs() < 1e-4);
        }
        let third = ReadOptions { signal: Some("3".into()), ..Default::default() };
        let message = read(&bytes, &third).unwrap_err().to_string();
        assert!(message.starts_with("bell.wav: signal = 3: no such column; the columns are"), "{message}");
    }

    #[test]
    fn a_sound_cut_short_is_read_as_far_as_it_goes() {
        let bytes = sound(1, 2, 1, false);
        let reading = read(&bytes[..bytes.len() - 213], &ReadOptions::default()).unwrap();
        assert_eq!(reading.record.len(), 299);
        assert!(reading.report.notes[0].text.starts_with("the sound ends early"));
    }
}
