//! Unpacking of streams up to a size, plus one byte if there is more.

use std::io::{self, Read};

use flate2::read::{MultiGzDecoder, ZlibDecoder};

fn all(unpacking: impl Read, size: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    unpacking.take(size as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

pub(super) fn gzip(packed: &[u8], size: usize) -> io::Result<Vec<u8>> {
    all(MultiGzDecoder::new(packed), size)
}

pub(super) fn zlib(packed: &[u8], size: usize) -> io::Result<Vec<u8>> {
    all(ZlibDecoder::new(packed), size)
}

#[cfg(feature = "zstd")]
pub(super) fn zstd(packed: &[u8], size: usize) -> io::Result<Vec<u8>> {
    all(zstd::stream::read::Decoder::new(packed)?, size)
}

#[cfg(not(feature = "zstd"))]
pub(super) fn zstd(_: &[u8], _: usize) -> io::Result<Vec<u8>> {
    Err(io::Error::other("Zstandard is not part of this build"))
}
