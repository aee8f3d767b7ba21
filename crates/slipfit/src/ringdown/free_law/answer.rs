//! The model-free loss law as reported.

use crate::Quantity;
use crate::answer::columns::columns;

/// Loss against amplitude without a model: a smooth curve with its confidence band, its limit at vanishing
/// amplitude and its slope there.
///
/// ```text
/// dA/dt = -g(A),      g(A) -> a0 + a1 A   for A -> 0
/// ```
///
/// The curve is a line with a random curvature whose magnitude is estimated from the data, so that it bends
/// no more than they require. The band covers the true loss with 95 % probability on average over the curve;
/// where the loss bends sharply the coverage is lower, elsewhere it is higher. Below
/// [`lowest_amplitude`](Self::lowest_amplitude) the curve is extrapolated, as nearly straight as it is above.
///
/// Limits: one mode, a loss that depends on the amplitude alone, at least twelve amplitudes.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FreeLaw {
    /// Loss per cycle against amplitude, from zero to the largest amplitude measured. Per second if the
    /// frequency is not known.
    #[cfg_attr(feature = "serde", serde(serialize_with = "free_columns::serialize"))]
    #[cfg_attr(feature = "schema", schemars(with = "free_columns::Columns"))]
    pub curve: Vec<FreeLossPoint>,
    /// Loss of amplitude per second at vanishing amplitude: the sliding part, `a0`. Never negative; the
    /// interval is that of Feldman and Cousins (1998).
    pub limit: Quantity,
    /// The friction displacement corresponding to that limit, `x_F = pi a0/(2 omega)`; `None` if the
    /// frequency is not known.
    pub friction_displacement: Option<Quantity>,
    /// Slope of the loss at vanishing amplitude, 1/s: the viscous part, `a1`. Negative if the loss increases
    /// towards rest.
    pub slope: Quantity,
    /// Smallest amplitude measured, signal unit, but at least its standard error; below it the curve is
    /// extrapolated.
    pub lowest_amplitude: f64,
    /// Effective number of parameters of the curve: 2 for a straight line.
    pub effective_parameters: f64,
    /// Whether the loss was constrained to increase with the amplitude.
    pub rising: bool,
}

impl FreeLaw {
    /// The curve with its band at a given amplitude, linearly interpolated between its points; `None` below
    /// zero and above the largest amplitude measured.
    ///
    /// ```
    /// use slipfit::ringdown::{LawOption, Options, analyse};
    /// use slipfit::{Oscillator, Record, motion::decay::FreeDecay};
    ///
    /// let decay = FreeDecay::from_rest(&Oscillator::kinematic(6.0, 0.03, 0.002)?, 0.5)?;
    /// let time: Vec<f64> = (0..2000).map(|i| 0.02 * i as f64).collect();
    /// let noise = |i: usize| 1e-3 * (7.7 * (i * i) as f64).sin();
    /// let angle = time.iter().enumerate().map(|(i, &t)| decay.displacement(t) + noise(i)).collect();
    /// let mut options = Options::default();
    /// options.law = Some(LawOption::Free);
    /// let law = analyse(&Record::new(time, angle)?, &options)?.free_law.expect("asked for");
    /// // a0 + a1 A over a cycle, a0 = 2 omega x_F/pi.
    /// let here = law.at(0.2).expect("measured");
    /// let truth = (2.0 * 6.0 * 0.002 / 3.1416 + 0.03 * 0.2) * 6.2832 / 6.0;
    /// assert!(here.low_95 < truth);
    /// assert!(truth < here.high_95);
    /// # Ok::<(), slipfit::Error>(())
    /// ```
    pub fn at(&self, amplitude: f64) -> Option<FreeLossPoint> {
        let right = self.curve.partition_point(|p| p.amplitude < amplitude);
        let b = self.curve.get(right)?;
        let a = &self.curve[right.saturating_sub(1)];
        if !(amplitude >= a.amplitude) {
            return None;
        }
        let width = b.amplitude - a.amplitude;
        let u = if width > 0.0 { (amplitude - a.amplitude) / width } else { 0.0 };
        let between = |of: fn(&FreeLossPoint) -> f64| of(a) + u * (of(b) - of(a));
        Some(FreeLossPoint {
            amplitude,
            loss_per_cycle: between(|p| p.loss_per_cycle),
            low_95: between(|p| p.low_95),
            high_95: between(|p| p.high_95),
        })
    }
}

/// A point of the model-free law.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FreeLossPoint {
    /// Amplitude, signal unit.
    pub amplitude: f64,
    /// Amplitude lost per cycle, signal unit.
    pub loss_per_cycle: f64,
    /// Lower end of its 95 % band.
    pub low_95: f64,
    /// Upper end of its 95 % band.
    pub high_95: f64,
}

columns! {
    free_columns of crate::ringdown::FreeLossPoint {
        amplitude: f64, loss_per_cycle: f64, low_95: f64, high_95: f64,
    }
}
