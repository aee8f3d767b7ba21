//! The fingerprint of a file, taken while it is read.

use std::{fmt::Write as _, io};

use sha2::{Digest, Sha256};

/// Told how many bytes have been read so far.
pub(crate) type Watch<'a> = &'a mut dyn FnMut(u64);

/// A reader that hashes and counts what passes through it.
pub(crate) struct Hashing<'a, R> {
    inner: R,
    watch: Option<Watch<'a>>,
    hash: Sha256,
    bytes: u64,
    /// What a growing file gets after its end was met is not read any more.
    ended: bool,
}

impl<'a, R: io::Read> Hashing<'a, R> {
    pub(crate) fn new(inner: R, watch: Option<Watch<'a>>) -> Self {
        Self { inner, watch, hash: Sha256::new(), bytes: 0, ended: false }
    }

    /// SHA-256 in hexadecimal, and the number of bytes.
    pub(crate) fn finish(self) -> (String, u64) {
        (hexadecimal(&self.hash.finalize()), self.bytes)
    }
}

pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::with_capacity(64), |mut hex, byte| {
        // Writing to a String cannot fail.
        let _ = write!(hex, "{byte:02x}");
        hex
    })
}

impl<R: io::Read> io::Read for Hashing<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.ended {
            return Ok(0);
        }
        let n = self.inner.read(buffer)?;
        self.ended = n == 0 && !buffer.is_empty();
        self.hash.update(&buffer[..n]);
        self.bytes += n as u64;
        if let Some(watch) = &mut self.watch {
            watch(self.bytes);
        }
        Ok(n)
    }
}
