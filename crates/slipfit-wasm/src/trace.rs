//! The record as it is drawn, to zoom in and to drag a window over.

use slipfit::Record;
use slipfit::ringdown::Answer;
use slipfit_report::plot::decimate;

/// Columns of a screen times the zoom that still shows every extreme.
const COLUMNS: usize = 4000;

/// Samples of a record and the fit at their instants.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Instants, s.
    pub time_s: Vec<f64>,
    /// The signal, in its unit; of a lock-in its modulus.
    pub signal: Vec<f64>,
    /// The fitted motion, in that unit; NaN outside the fitted stretch.
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
