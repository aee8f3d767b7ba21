//! Compressed sound of phones and recorders: AAC, ALAC, MP3, Vorbis and FLAC, decoded packet by packet.

use std::io::Cursor;
use std::sync::Arc;

use symphonia::core::{
    codecs::audio::{AudioDecoder, AudioDecoderOptions},
    errors::Error,
    formats::{FormatOptions, FormatReader, TrackType, probe::Hint},
    io::MediaSourceStream,
    meta::MetadataOptions,
    packet::Packet,
};

use crate::{
    columns::head::Head,
    error::ReadProblem,
    format::Format,
    report::Skipped,
    tables::guard,
    tables::table::{Batch, Sink, TableSource},
};

/// Maximum number of samples per packed byte: FLAC writes 4096 equal samples as ten bytes.
const MOST_EXPANSION: usize = 1024;
/// Number of samples that any file may unpack to.
const SMALL: usize = 1 << 22;
/// Codecs that reproduce every sample exactly.
const LOSSLESS: [&str; 2] = ["flac", "alac"];

/// A compressed sound in memory: one column per channel, relative to full scale.
pub(crate) struct PackedSound {
    bytes: Arc<[u8]>,
    format: Format,
    head: Head,
}

/// A sound being decoded.
struct Running {
    reader: Box<dyn FormatReader>,
    decoder: Box<dyn AudioDecoder>,
    track: u32,
    format: Format,
}

/// Successive samples with interleaved channels; empty if the packet is corrupt.
struct Piece {
    samples: Vec<f64>,
    channels: usize,
    rate_hz: u32,
    /// Frames of a packet that could not be decoded.
    lost: usize,
}

impl Running {
    fn open(bytes: &Arc<[u8]>, format: Format) -> Result<Self, ReadProblem> {
        let decode = || {
            let stream = MediaSourceStream::new(Box::new(Cursor::new(Arc::clone(bytes))), Default::default());
            let (hint, options, about) = (Hint::new(), FormatOptions::default(), MetadataOptions::default());
            let reader = symphonia::default::get_probe().probe(&hint, stream, options, about)?;
            let track = reader.default_track(TrackType::Audio);
            let track = track.ok_or(Error::Unsupported("it has no sound that is known"))?;
            let parameters = track.codec_params.as_ref().and_then(|p| p.audio());
            let parameters = parameters.ok_or(Error::Unsupported("the codec of its sound is not known"))?;
            let options = AudioDecoderOptions::default();
            let decoder = symphonia::default::get_codecs().make_audio_decoder(parameters, &options)?;
            Ok((track.id, decoder, reader))
        };
        let (track, decoder, reader) = guard::guarded(format, decode, |e: Error| format.broken(e))?;
        Ok(Self { reader, decoder, track, format })
    }

    /// The samples of the next packet; `None` at the end, or if the file ends early.
    fn next(&mut self) -> Result<Option<Piece>, ReadProblem> {
        let format = self.format;
        let decode = || loop {
            let packet: Packet = match self.reader.next_packet() {
                Ok(Some(packet)) if packet.track_id == self.track => packet,
                Ok(Some(_)) => continue,
                Ok(None) => return Ok(None),
                Err(Error::IoError(e)) if e.kind() == std::io::ErrorKind::UnexpectedEof => return Ok(None),
                Err(error) => return Err(error),
            };
            return match self.decoder.decode(&packet) {
                Ok(sound) => {
                    let mut samples = Vec::new();
                    sound.copy_to_vec_interleaved(&mut samples);
                    let (channels, rate_hz) = (sound.num_planes(), sound.spec().rate());
                    Ok(Some(Piece { samples, channels, rate_hz, lost: 0 }))
                }
                Err(Error::DecodeError(_)) => {
                    // A packet of any of these codecs contains no more.
                    let lost = usize::try_from(packet.dur.get()).unwrap_or(0).min(1 << 16);
                    Ok(Some(Piece { samples: Vec::new(), channels: 0, rate_hz: 0, lost }))
                }
                Err(error) => Err(error),
            };
        };
        guard::guarded(format, decode, |e: Error| format.broken(e))
    }
}

impl PackedSound {
    /// Decodes the first packet.
    pub(crate) fn open(bytes: Vec<u8>, format: Format) -> Result<Self, ReadProblem> {
        let bytes: Arc<[u8]> = bytes.into();
        let mut running = Running::open(&bytes, format)?;
        let first = loop {
            match running.next()? {
                Some(piece) if piece.channels > 0 && piece.rate_hz > 0 => break piece,
                Some(_) => {}
                None => return Err(format.broken("it ends before its samples")),
            }
        };
        let mut head = Head::of_channels(first.channels, f64::from(first.rate_hz));
        let codec = running.decoder.codec_info().short_name;
        head.lossy = !LOSSLESS.contains(&codec);
        if head.lossy {
            head.notes.push(
                format!(
                    "the sound was compressed with loss ({codec}): weak signals next to the loudest may be \
                     missing"
                )
                .into(),
            );
        }
        Ok(Self { bytes, format, head })
    }
}

impl TableSource for PackedSound {
    fn heads(&self) -> Vec<&Head> {
        vec![&self.head]
    }

    fn scan(&mut self, _: usize, wanted: &[usize], sink: Sink<'_>) -> Result<Vec<Skipped>, ReadProblem> {
        let channels = self.head.names.len();
        let mut running = Running::open(&self.bytes, self.format)?;
        let mut left = self.bytes.len().saturating_mul(MOST_EXPANSION).max(SMALL);
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); wanted.len()];
        let (mut lost, mut first_lost, mut rows) = (0_u64, 0, 0_u64);
        while let Some(piece) = running.next()? {
            if piece.lost > 0 {
                first_lost = if lost == 0 { rows + 1 } else { first_lost };
                lost += piece.lost as u64;
            } else if piece.channels != channels {
                return Err(self.format.broken("the number of its channels changes"));
            }
            let frames = piece.lost.max(piece.samples.len() / channels);
            let Some(rest) = left.checked_sub(frames * channels) else {
                return Err(self.format.broken("it holds more samples than its bytes can"));
            };
            left = rest;
            for (column, &channel) in columns.iter_mut().zip(wanted) {
                column.clear();
                // A corrupt packet keeps its place in time.
                column.resize(piece.lost, f64::NAN);
                column.extend(piece.samples.iter().skip(channel).step_by(channels));
            }
            rows += frames as u64;
            let batch: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            if frames > 0 && !sink(Batch::of(&batch)) {
                break;
            }
        }
        let reason = "a packet of the sound is broken".to_owned();
        Ok(if lost > 0 { vec![Skipped { reason, rows: lost, first_row: first_lost }] } else { Vec::new() })
    }
}
