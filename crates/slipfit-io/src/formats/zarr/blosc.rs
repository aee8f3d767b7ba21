//! Blosc 1, with which zarr-python packed chunks by default before version 3: separately packed blocks, whose bytes are
//! sorted by significance. The format is described in c-blosc's `README_CHUNK_FORMAT.rst`.

use std::io;

use super::unpack::{zlib, zstd};

const HEADER: usize = 16;
/// Flags of a chunk.
const SHUFFLED: u8 = 1;
const PLAIN: u8 = 2;
const BITS_SHUFFLED: u8 = 4;
const UNSPLIT: u8 = 16;
/// A block of at least this many numbers, each of at most this many bytes, is packed byte by byte.
const SPLIT_FROM: usize = 128;
const MOST_SPLITS: usize = 16;

pub(super) fn unpacked(packed: &[u8], size: usize) -> io::Result<Vec<u8>> {
    let broken = || io::Error::new(io::ErrorKind::InvalidData, "broken Blosc");
    let word = |at: usize| {
        let bytes = packed.get(at..at.checked_add(4)?)?;
        usize::try_from(u32::from_le_bytes(bytes.try_into().ok()?)).ok()
    };
    let header = packed.get(..HEADER).ok_or_else(broken)?;
    let (flags, width) = (header[2], usize::from(header[3]).max(1));
    let [length, block] = [4, 8].map(|at| word(at).unwrap_or_default());
    if length != size || block == 0 && length > 0 {
        return Err(broken());
    }
    if flags & PLAIN != 0 {
        return Ok(packed.get(HEADER..HEADER + length).ok_or_else(broken)?.to_vec());
    }
    if flags & BITS_SHUFFLED != 0 {
        return Err(io::Error::other("Blosc with sorted bits is not read"));
    }
    let mut bytes = Vec::new();
    for (number, first) in (0..length).step_by(block.max(1)).enumerate() {
        let here = block.min(length - first);
        let split =
            flags & UNSPLIT == 0 && width <= MOST_SPLITS && block / width >= SPLIT_FROM && here == block;
        let splits = if split { width } else { 1 };
        let mut at = word(HEADER + 4 * number).ok_or_else(broken)?;
        let mut block_bytes = Vec::new();
        for _ in 0..splits {
            let count = word(at).ok_or_else(broken)?;
            let part = packed.get(at + 4..(at + 4).saturating_add(count)).ok_or_else(broken)?;
            block_bytes.extend(part_of_block(flags >> 5, part, here / splits)?);
            at += 4 + count;
        }
        if block_bytes.len() != here {
            return Err(broken());
        }
        if flags & SHUFFLED != 0 {
            bytes.extend(unshuffled(&block_bytes, width))
        } else {
            bytes.extend(block_bytes)
        }
    }
    Ok(bytes)
}

/// A part that compression would have lengthened is stored uncompressed.
fn part_of_block(packing: u8, part: &[u8], size: usize) -> io::Result<Vec<u8>> {
    if part.len() == size {
        return Ok(part.to_vec());
    }
    match packing {
        1 => lz4_flex::block::decompress(part, size).map_err(io::Error::other),
        3 => zlib(part, size),
        4 => zstd(part, size),
        _ => Err(io::Error::other("Blosc with BloscLZ or Snappy is not read; lz4, zlib and zstd are")),
    }
}

/// Restores numbers from all their first bytes, all their second bytes and so on; an incomplete number is left at the
/// end.
fn unshuffled(shuffled: &[u8], width: usize) -> impl Iterator<Item = u8> {
    let count = shuffled.len() / width;
    let numbers =
        (0..count).flat_map(move |number| (0..width).map(move |byte| shuffled[byte * count + number]));
    numbers.chain(shuffled[count * width..].iter().copied())
}
