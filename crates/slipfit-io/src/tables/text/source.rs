//! Moving window over the bytes of a file, in an encoding that contains ASCII.

use std::io::{self, Read};

use encoding_rs::{Decoder, Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

/// Number of bytes requested from the file at once.
const CHUNK: usize = 256 << 10;

/// A window over a file.
pub(super) struct Source<R> {
    reader: R,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    ended: bool,
    decoder: Option<Decoder>,
    raw: Vec<u8>,
}

/// Bytes removed from a window.
pub(super) struct Taken {
    buffer: Vec<u8>,
    taken: std::ops::Range<usize>,
}

impl Taken {
    pub(super) fn bytes(&self) -> &[u8] {
        &self.buffer[self.taken.clone()]
    }

    /// The memory, for reuse.
    pub(super) fn memory(self) -> Vec<u8> {
        self.buffer
    }
}

impl<R: Read> Source<R> {
    pub(super) fn new(reader: R) -> Self {
        Self { reader, buffer: Vec::new(), start: 0, end: 0, ended: false, decoder: None, raw: Vec::new() }
    }

    /// The bytes in the window.
    pub(super) fn window(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// Whether the window reaches the end of the file.
    pub(super) fn ended(&self) -> bool {
        self.ended
    }

    /// Moves the beginning of the window forward.
    pub(super) fn consume(&mut self, bytes: usize) {
        self.start = (self.start + bytes).min(self.end);
    }

    /// Removes the first `bytes` of the window; `spare` is memory for the remaining ones.
    pub(super) fn take(&mut self, bytes: usize, spare: Vec<u8>) -> Taken {
        let buffer = std::mem::replace(&mut self.buffer, spare);
        let taken = self.start..self.start + bytes;
        let rest = &buffer[taken.end..self.end];
        if self.buffer.len() < rest.len() {
            self.buffer.resize(rest.len(), 0);
        }
        self.buffer[..rest.len()].copy_from_slice(rest);
        (self.start, self.end) = (0, rest.len());
        Taken { buffer, taken }
    }

    /// Extends the window to `bytes` or to the end of the file.
    pub(super) fn fill(&mut self, bytes: usize) -> io::Result<()> {
        if self.start > 0 {
            self.buffer.copy_within(self.start..self.end, 0);
            self.end -= self.start;
            self.start = 0;
        }
        while self.end < bytes && !self.ended {
            if self.decoder.is_some() { self.read_decoded()? } else { self.read_plain(bytes)? }
        }
        Ok(())
    }

    /// Detects the encoding from the window, which must be the beginning of the file, and makes the window
    /// ASCII-compatible.
    pub(super) fn detect_encoding(&mut self) -> &'static Encoding {
        let window = self.window();
        let (encoding, mark) = Encoding::for_bom(window).unwrap_or((utf16_without_mark(window), 0));
        self.consume(mark);
        if encoding == UTF_8 {
            // Numbers are the same in both encodings; only names differ.
            return if valid_utf8(self.window()) { UTF_8 } else { WINDOWS_1252 };
        }
        let raw = self.window().to_vec();
        (self.start, self.end) = (0, 0);
        let mut decoder = encoding.new_decoder_without_bom_handling();
        self.decode(&mut decoder, &raw, self.ended);
        self.decoder = Some(decoder);
        encoding
    }

    fn read_plain(&mut self, bytes: usize) -> io::Result<()> {
        if self.buffer.len() < self.end + CHUNK {
            self.buffer.resize((self.end + CHUNK).max(bytes), 0);
        }
        let n = read(&mut self.reader, &mut self.buffer[self.end..])?;
        self.end += n;
        self.ended = n == 0;
        Ok(())
    }

    fn read_decoded(&mut self) -> io::Result<()> {
        let mut raw = std::mem::take(&mut self.raw);
        raw.resize(CHUNK, 0);
        let n = read(&mut self.reader, &mut raw)?;
        self.ended = n == 0;
        if let Some(mut decoder) = self.decoder.take() {
            self.decode(&mut decoder, &raw[..n], n == 0);
            self.decoder = Some(decoder);
        }
        self.raw = raw;
        Ok(())
    }

    fn decode(&mut self, decoder: &mut Decoder, mut raw: &[u8], last: bool) {
        loop {
            let room = decoder.max_utf8_buffer_length(raw.len()).unwrap_or(CHUNK).clamp(16, 4 * CHUNK);
            if self.buffer.len() < self.end + room {
                self.buffer.resize(self.end + room, 0);
            }
            let (result, read, written, _) = decoder.decode_to_utf8(raw, &mut self.buffer[self.end..], last);
            self.end += written;
            raw = &raw[read..];
            if result == encoding_rs::CoderResult::InputEmpty {
                return;
            }
        }
    }
}

fn read(reader: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    loop {
        match reader.read(buffer) {
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            other => return other,
        }
    }
}

/// UTF-16 of mostly ASCII text has a zero in every second byte.
fn utf16_without_mark(window: &[u8]) -> &'static Encoding {
    let head = &window[..window.len().min(512) & !1];
    let zeros = |odd: usize| head.iter().skip(odd).step_by(2).filter(|b| **b == 0).count();
    let half = head.len() / 2;
    match (zeros(0), zeros(1)) {
        (0, odd) if odd > 0 && odd * 10 >= half * 9 => UTF_16LE,
        (even, 0) if even > 0 && even * 10 >= half * 9 => UTF_16BE,
        _ => UTF_8,
    }
}

fn valid_utf8(window: &[u8]) -> bool {
    // A character split by the end of the window is not an error.
    match std::str::from_utf8(window) {
        Ok(_) => true,
        Err(e) => e.error_len().is_none(),
    }
}
