//! Unpacking of compressed bytes within a memory budget.

use std::io::{self, Cursor, Read};

use zip::ZipArchive;

/// An archive in memory.
pub(crate) type Archive = ZipArchive<Cursor<Vec<u8>>>;

/// Memory that packed bytes may request, whatever they claim: a file of one megabyte can unpack to a thousand.
pub(crate) const BUDGET: usize = 1 << 30;

/// All bytes that `reader` unpacks.
///
/// # Errors
/// As `reader`, or more bytes than the budget.
pub(crate) fn unpack(reader: impl Read) -> io::Result<Vec<u8>> {
    unpack_within(reader, BUDGET)
}

fn unpack_within(reader: impl Read, most: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.take(most as u64 + 1).read_to_end(&mut bytes)?;
    if bytes.len() > most {
        let reason = format!("it unpacks to more than {} MB; unpack it first", most >> 20);
        return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_bomb_ends_at_the_budget() {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        packed.write_all(&vec![0; 3 << 20]).unwrap();
        let packed = packed.finish().unwrap();
        assert!(packed.len() < 10_000);
        let unpacked = |most| unpack_within(flate2::read::GzDecoder::new(&packed[..]), most);
        assert_eq!(unpacked(3 << 20).unwrap().len(), 3 << 20);
        let error = unpacked((3 << 20) - 1).unwrap_err().to_string();
        assert!(error.contains("unpacks to more than"), "{error}");
    }
}
