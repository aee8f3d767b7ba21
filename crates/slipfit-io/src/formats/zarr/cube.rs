//! The numbers of an array.

use std::fs;
use std::io;
use std::ops::Range;
use std::path::PathBuf;

use super::codec::Codec;
use crate::error::ReadProblem;
use crate::tables::binary::Stored;

/// An array of three dimensions; its chunks are read on demand.
pub(crate) struct Cube {
    pub(super) folder: PathBuf,
    pub(super) shape: [usize; 3],
    /// Lengths of a chunk.
    pub(super) chunk: [usize; 3],
    /// Steps from one number of a chunk to the next, along each axis.
    pub(super) strides: [usize; 3],
    pub(super) stored: Stored,
    /// Value of missing chunks.
    pub(super) fill: f64,
    /// Separator of the indices of a chunk in the name of its file, and the prefix of that name.
    pub(super) separator: char,
    pub(super) prefix: &'static str,
    /// In the order in which they are applied on writing.
    pub(super) codecs: Vec<Codec>,
}

pub(super) fn refused(reason: String) -> ReadProblem {
    ReadProblem::NoStack { reason }
}

impl Cube {
    /// The numbers within a range along an axis.
    pub(crate) fn part(&self, axis: usize, range: Range<usize>) -> Result<Vec<f64>, ReadProblem> {
        let mut wanted = self.shape.map(|length| 0..length);
        wanted[axis] = range;
        let count = wanted.iter().try_fold(1_usize, |n, part| n.checked_mul(part.len()));
        let mut values = Vec::new();
        // A description may state any shape.
        let held = count.filter(|count| values.try_reserve_exact(*count).is_ok());
        let count = held.ok_or_else(|| refused("a part of it is larger than memory".to_owned()))?;
        values.resize(count, self.fill);
        let [i, j, k] = [0, 1, 2].map(|a| self.over(a, &wanted[a]));
        for place in i.flat_map(|i| {
            let k = k.clone();
            j.clone().flat_map(move |j| k.clone().map(move |k| [i, j, k]))
        }) {
            if let Some(bytes) = self.bytes(place)? {
                self.copy(&bytes, place, &wanted, &mut values);
            }
        }
        Ok(values)
    }

    /// The chunks along an axis that overlap a range.
    fn over(&self, axis: usize, part: &Range<usize>) -> Range<usize> {
        if part.is_empty() {
            0..0
        } else {
            part.start / self.chunk[axis]..part.end.div_ceil(self.chunk[axis])
        }
    }

    /// A chunk as its numbers are stored; `None` if nothing was written.
    fn bytes(&self, place: [usize; 3]) -> Result<Option<Vec<u8>>, ReadProblem> {
        let name = place.map(|p| p.to_string()).join(&self.separator.to_string());
        let name = format!("{}{name}", self.prefix);
        let size = self.chunk.iter().product::<usize>() * self.stored.bytes;
        let unpacked = match fs::read(self.folder.join(&name)) {
            Ok(packed) => {
                self.codecs.iter().rev().try_fold(packed, |packed, codec| codec.undo(&packed, size))
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => Err(error),
        };
        match unpacked {
            Ok(bytes) if bytes.len() == size => Ok(Some(bytes)),
            Ok(bytes) => Err(format!("{} bytes where its description says {size}", bytes.len())),
            Err(error) => Err(error.to_string()),
        }
        .map_err(|reason| {
            ReadProblem::Io(io::Error::new(io::ErrorKind::InvalidData, format!("chunk {name}: {reason}")))
        })
    }

    /// Copies the numbers of a chunk to their positions in the requested part.
    fn copy(&self, bytes: &[u8], place: [usize; 3], wanted: &[Range<usize>; 3], values: &mut [f64]) {
        let first = [0, 1, 2].map(|a| place[a] * self.chunk[a]);
        let both = [0, 1, 2].map(|a| {
            let end = first[a].saturating_add(self.chunk[a]).min(wanted[a].end);
            wanted[a].start.max(first[a])..end
        });
        let [_, columns, depth] = [0, 1, 2].map(|a| wanted[a].len());
        let [s0, s1, s2] = self.strides;
        for i in both[0].clone() {
            for j in both[1].clone() {
                let row = ((i - wanted[0].start) * columns + j - wanted[1].start) * depth;
                let from = (i - first[0]) * s0 + (j - first[1]) * s1;
                for k in both[2].clone() {
                    let at = (from + (k - first[2]) * s2) * self.stored.bytes;
                    values[row + k - wanted[2].start] = self.stored.read(&bytes[at..]);
                }
            }
        }
    }
}
