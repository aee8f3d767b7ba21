//! The record for drawing, with zoom and selection of a window.

use slipfit::Record;
use slipfit::ringdown::Answer;
use slipfit_report::plot::decimate;

/// Columns of a screen, times the zoom up to which every extreme is shown.
const COLUMNS: usize = 4000;

/// Samples of a record and the fit at their times.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Instants, s.
    pub time_s: Vec<f64>,
    /// The signal, in its unit; for a lock-in its modulus.
    pub signal: Vec<f64>,
    /// The fitted motion, in the same unit; NaN outside the fitted segment.
    pub fitted: Vec<f64>,
}

impl Trace {
    pub(crate) fn new(record: &Record, answer: &Answer) -> Self {
        let value = |i: usize| match record.quadrature() {
            Some(quadrature) => record.signal()[i].hypot(quadrature[i]),
            None => record.signal()[i],
        };
        let points = (0..record.len()).map(|i| [record.time_s(i), value(i)]);
        let drawn = decimate(points, [record.time_s(0), record.time_s(record.len() - 1)], COLUMNS);
        let [start, end] = answer.fit.range_s();
        let fitted = |&[t, _]: &[f64; 2]| {
            if (start..=end).contains(&t) { answer.fit.signal_at(t) } else { f64::NAN }
        };
        Self {
            time_s: drawn.iter().map(|p| p[0]).collect(),
            signal: drawn.iter().map(|p| p[1]).collect(),
            fitted: drawn.iter().map(fitted).collect(),
        }
    }
}
