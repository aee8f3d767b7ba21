//! A sampled signal together with the extremes of its pieces.

use crate::numeric::extremes;
use std::borrow::Cow;
use std::ops::{Deref, Range};
use std::sync::{Arc, OnceLock};

/// Number of samples in a piece.
pub(crate) const PIECE: usize = 1024;

/// Samples of a signal. Scales, clipping and clipped crests depend on the extremes, which are found in one pass
/// over the samples.
#[derive(Debug, Clone)]
pub(crate) struct SampledSignal<'a> {
    values: Cow<'a, [f64]>,
    pieces: OnceLock<Arc<[(f64, f64)]>>,
}

impl<'a> SampledSignal<'a> {
    pub(crate) fn new(values: impl Into<Cow<'a, [f64]>>) -> Self {
        Self { values: values.into(), pieces: OnceLock::new() }
    }

    /// Minimum and maximum of each [`PIECE`] samples.
    pub(crate) fn extremes_of_pieces(&self) -> &[(f64, f64)] {
        self.pieces.get_or_init(|| self.values.chunks(PIECE).map(extremes).collect())
    }

    /// Minimum and maximum of all samples.
    pub(crate) fn extremes(&self) -> (f64, f64) {
        let pieces = self.extremes_of_pieces().iter();
        pieces.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (low, high)| (a.min(*low), b.max(*high)))
    }

    /// The first sample at an extreme of all samples, from an index on.
    pub(crate) fn next_extreme(&self, from: usize) -> Option<usize> {
        let (low, high) = self.extremes();
        let pieces = self.extremes_of_pieces().iter().enumerate().skip(from / PIECE);
        let reached = pieces.filter(|(_, piece)| piece.0 == low || piece.1 == high);
        let mut starts = reached.map(|(k, _)| (k * PIECE).max(from));
        starts.find_map(|start| {
            let end = (start / PIECE + 1) * PIECE;
            let piece = &self.values[start..end.min(self.values.len())];
            piece.iter().position(|x| *x == low || *x == high).map(|k| start + k)
        })
    }

    pub(crate) fn borrowed(&self) -> SampledSignal<'_> {
        SampledSignal { values: Cow::Borrowed(&self.values), pieces: self.pieces.clone() }
    }

    /// A range of the samples.
    pub(crate) fn part(&self, range: Range<usize>) -> Self {
        if range == (0..self.values.len()) {
            return self.clone();
        }
        Self::new(part_of(&self.values, range))
    }
}

impl Deref for SampledSignal<'_> {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.values
    }
}

/// A range of a column.
pub(crate) fn part_of<'a>(column: &Cow<'a, [f64]>, range: Range<usize>) -> Cow<'a, [f64]> {
    match column {
        Cow::Borrowed(all) => Cow::Borrowed(&all[range]),
        Cow::Owned(all) => Cow::Owned(all[range].to_vec()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::jitter;

    #[test]
    fn extremes_are_found_in_every_piece() {
        let mut values: Vec<f64> = (0..3 * PIECE + 7).map(|i| jitter(i, 3)).collect();
        let n = values.len();
        for (i, level) in [(PIECE - 1, 9.0), (PIECE, 9.0), (2 * PIECE + 5, -9.0), (n - 1, 9.0)] {
            values[i] = level;
        }
        let signal = SampledSignal::new(values);
        assert_eq!(signal.extremes(), (-9.0, 9.0));
        let mut found = Vec::new();
        while let Some(next) = signal.next_extreme(found.last().map_or(0, |last| last + 1)) {
            found.push(next);
        }
        assert_eq!(found, [PIECE - 1, PIECE, 2 * PIECE + 5, n - 1]);
        assert_eq!(signal.next_extreme(n), None);
        assert_eq!(signal.part(PIECE + 1..n - 1).extremes().0, -9.0);
        assert!(signal.part(PIECE + 1..n - 1).extremes().1 < 9.0);
        assert_eq!(signal.borrowed().next_extreme(0), Some(PIECE - 1));
    }
}
