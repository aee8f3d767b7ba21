//! Fingerprint of a file, computed while the file is read.

use std::{fmt::Write as _, io};

use sha2::{Digest, Sha256};

/// Receives the number of bytes read so far.
pub(crate) type Watch<'a> = &'a mut dyn FnMut(u64);

/// The hash of what has been read so far, or the known hash of everything.
enum Hash {
    Taken(Sha256),
    Known(String),
}

/// A reader that hashes and counts what passes through it.
pub(crate) struct Hashing<'a, R> {
    inner: R,
    watch: Option<Watch<'a>>,
    hash: Hash,
    bytes: u64,
    /// Whether the end was reached: data appended to a growing file afterwards are not read.
    ended: bool,
}

impl<'a, R: io::Read> Hashing<'a, R> {
    pub(crate) fn new(inner: R, watch: Option<Watch<'a>>) -> Self {
        Self { inner, watch, hash: Hash::Taken(Sha256::new()), bytes: 0, ended: false }
    }

    /// For bytes that have already been hashed: `sha256` in hexadecimal.
    pub(crate) fn known(self, sha256: Option<String>) -> Self {
        Self { hash: sha256.map_or(self.hash, Hash::Known), ..self }
    }

    /// SHA-256 in hexadecimal, and the number of bytes.
    pub(crate) fn finish(self) -> (String, u64) {
        let sha256 = match self.hash {
            Hash::Taken(hash) => hexadecimal(&hash.finalize()),
            Hash::Known(sha256) => sha256,
        };
        (sha256, self.bytes)
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
        if let Hash::Taken(hash) = &mut self.hash {
            hash.update(&buffer[..n]);
        }
        self.bytes += n as u64;
        if let Some(watch) = &mut self.watch {
            watch(self.bytes);
        }
        Ok(n)
    }
}
