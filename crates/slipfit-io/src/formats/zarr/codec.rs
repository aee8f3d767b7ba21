//! Compression of chunks.

use std::io;

use super::{blosc, unpack};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Codec {
    Gzip,
    Zlib,
    Zstd,
    Blosc,
}

impl Codec {
    pub(super) fn named(name: &str) -> Option<Self> {
        match name {
            "gzip" => Some(Self::Gzip),
            "zlib" => Some(Self::Zlib),
            "zstd" => Some(Self::Zstd),
            "blosc" => Some(Self::Blosc),
            _ => None,
        }
    }

    /// Unpacked bytes, `size` of them; one byte more indicates a chunk that is larger.
    pub(super) fn undo(self, packed: &[u8], size: usize) -> io::Result<Vec<u8>> {
        match self {
            Self::Gzip => unpack::gzip(packed, size),
            Self::Zlib => unpack::zlib(packed, size),
            Self::Zstd => unpack::zstd(packed, size),
            Self::Blosc => blosc::unpacked(packed, size),
        }
    }
}
