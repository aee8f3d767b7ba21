//! A trace in each pixel of an image.

use crate::error::Error;
use crate::options::{Options, Signal};
use arrow_array::{ArrayRef, FixedSizeListArray, Float64Array, RecordBatch};
use arrow_schema::{DataType, Field};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Maximum number of bytes of traces held at a time.
const BLOCK: usize = 1 << 26;

/// An array of three axes, one of them time, divided into blocks of rows of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    shape: [usize; 3],
    time: usize,
}

impl Grid {
    /// The grid of an array with time along axis 0, 1 or 2.
    ///
    /// # Errors
    /// [`Error::Option`] for another axis, or for an array without pixels or samples.
    ///
    /// ```
    /// use slipfit_batch::Grid;
    /// let grid = Grid::new([4, 3, 200], 2)?;
    /// assert_eq!((grid.pixels(), grid.samples()), ([4, 3], 200));
    /// assert_eq!(grid.blocks().collect::<Vec<_>>(), [0..4]);
    /// # Ok::<(), slipfit_batch::Error>(())
    /// ```
    pub fn new(shape: [usize; 3], time: usize) -> Result<Self, Error> {
        let refuse = |option, problem| Err(Error::Option { option, problem });
        if time > 2 {
            return refuse("axis", format!("{time}: a stack has the axes 0, 1 and 2"));
        }
        if shape.contains(&0) {
            return refuse("stack", format!("an array of {shape:?} has no pixels or no samples"));
        }
        if i32::try_from(shape[time]).is_err() {
            return refuse("stack", format!("{} samples in a pixel are more than a list holds", shape[time]));
        }
        Ok(Self { shape, time })
    }

    /// Numbers of rows and columns of pixels: the axes that are not time, in their order.
    pub fn pixels(&self) -> [usize; 2] {
        match self.time {
            0 => [self.shape[1], self.shape[2]],
            1 => [self.shape[0], self.shape[2]],
            _ => [self.shape[0], self.shape[1]],
        }
    }

    /// Number of samples of a trace.
    pub fn samples(&self) -> usize {
        self.shape[self.time]
    }

    /// The axis along which blocks are cut: the first that is not time.
    pub fn cut(&self) -> usize {
        usize::from(self.time == 0)
    }

    /// Rows of pixels of each block: some tens of megabytes of traces, at least one row.
    pub fn blocks(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let [rows, columns] = self.pixels();
        let row = columns.saturating_mul(self.samples()).saturating_mul(8);
        let step = (BLOCK / row.max(1)).max(1);
        (0..rows).step_by(step).map(move |first| first..rows.min(first.saturating_add(step)))
    }

    /// The traces of a block, one after the other, from the block's values in the order of the array (C order).
    ///
    /// # Errors
    /// [`Error::Option`] if the number of values is not that of `rows` rows.
    pub fn traces(&self, rows: usize, values: Vec<f64>) -> Result<Vec<f64>, Error> {
        let mut shape = self.shape;
        shape[self.cut()] = rows;
        if shape.iter().try_fold(1_usize, |n, d| n.checked_mul(*d)) != Some(values.len()) {
            let problem = format!("{} numbers do not form a block of {shape:?}", values.len());
            return Err(Error::Option { option: "stack", problem });
        }
        if self.time == 2 {
            return Ok(values);
        }
        let strides = [shape[1] * shape[2], shape[2], 1];
        let [outer, inner] = match self.time {
            0 => [1, 2],
            _ => [0, 2],
        };
        let mut traces = Vec::with_capacity(values.len());
        for y in 0..shape[outer] {
            for x in 0..shape[inner] {
                let first = y * strides[outer] + x * strides[inner];
                traces.extend((0..self.samples()).map(|t| values[first + t * strides[self.time]]));
            }
        }
        Ok(traces)
    }
}

/// Returns one row of answer for each pixel of a block, in the order of its traces, with the columns of
/// [`fit_batch`](crate::fit_batch).
///
/// The column that the options name as the signal is made of `traces`; every trace has `samples` samples.
///
/// # Errors
/// As [`fit_batch_until`](crate::fit_batch_until).
pub fn fit_pixels(
    traces: Vec<f64>,
    samples: usize,
    options: &Options,
    cancelled: &AtomicBool,
) -> Result<RecordBatch, Error> {
    let name = match &options.signal {
        Signal::Amplitude(name) | Signal::Oscillation(name, _) => name.clone(),
        Signal::LockIn(..) => {
            let problem = "a map has one number per sample; X and Y are two".to_owned();
            return Err(Error::Option { option: "signal", problem });
        }
    };
    let size = i32::try_from(samples).map_err(|_| Error::Option {
        option: "stack",
        problem: format!("{samples} samples in a pixel are more than a list holds"),
    })?;
    let item = Arc::new(Field::new("item", DataType::Float64, true));
    let lists = FixedSizeListArray::try_new(item, size, Arc::new(Float64Array::from(traces)), None)?;
    let batch = RecordBatch::try_from_iter([(name, Arc::new(lists) as ArrayRef)])?;
    crate::fit_batch_until(&batch, options, cancelled)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_all_rows_once_and_stay_small() {
        let grid = Grid::new([1000, 700, 512], 2).unwrap();
        let blocks: Vec<_> = grid.blocks().collect();
        assert!(blocks.windows(2).all(|pair| pair[0].end == pair[1].start));
        assert_eq!((blocks[0].start, blocks.last().unwrap().end), (0, 1000));
        assert!(blocks.iter().all(|block| block.len() * 700 * 512 * 8 <= BLOCK));
        // A row larger than a block forms a block of its own.
        assert_eq!(Grid::new([3, 1 << 20, 64], 2).unwrap().blocks().count(), 3);
    }

    #[test]
    fn time_may_be_any_axis() {
        // The number at (y, x, t) is 100 y + 10 x + t.
        let wanted: Vec<f64> = (0..3)
            .flat_map(|y| (0..2).flat_map(move |x| (0..4).map(move |t| f64::from(100 * y + 10 * x + t))))
            .collect();
        for time in 0..3 {
            let full: Vec<usize> = match time {
                0 => vec![4, 3, 2],
                1 => vec![3, 4, 2],
                _ => vec![3, 2, 4],
            };
            let grid = Grid::new([full[0], full[1], full[2]], time).unwrap();
            assert_eq!(grid.pixels(), [3, 2]);
            let mut values = Vec::new();
            for a in 0..full[0] {
                for b in 0..full[1] {
                    for c in 0..full[2] {
                        let (y, x, t) = match time {
                            0 => (b, c, a),
                            1 => (a, c, b),
                            _ => (a, b, c),
                        };
                        values.push((100 * y + 10 * x + t) as f64);
                    }
                }
            }
            assert_eq!(grid.traces(3, values.clone()).unwrap(), wanted, "time along {time}");
            assert!(grid.traces(2, values).is_err());
        }
        assert!(Grid::new([3, 2, 4], 3).is_err());
        assert!(Grid::new([3, 0, 4], 2).is_err());
    }
}
