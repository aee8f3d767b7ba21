//! A measured resonance curve.

use super::criteria::RUN_POINTS;
use crate::Error;
use crate::error::POSITIVE;
use crate::motion::steady::Phasor;
use std::f64::consts::TAU;

/// Measured response at each frequency.
#[derive(Debug, Clone, PartialEq)]
pub enum Response {
    /// Amplitudes only, not negative.
    Amplitude(Vec<f64>),
    /// Amplitude and phase: `x = Re Z e^(i omega t)` with `t = 0` at the maximum of the drive.
    Complex(Vec<Phasor>),
}

impl Response {
    /// Amplitude of point `i`.
    pub fn amplitude(&self, i: usize) -> f64 {
        match self {
            Response::Amplitude(a) => a[i],
            Response::Complex(z) => z[i].norm(),
        }
    }

    fn len(&self) -> usize {
        match self {
            Response::Amplitude(a) => a.len(),
            Response::Complex(z) => z.len(),
        }
    }

    fn is_finite(&self, i: usize) -> bool {
        match self {
            Response::Amplitude(a) => a[i].is_finite(),
            Response::Complex(z) => z[i].re.is_finite() && z[i].im.is_finite(),
        }
    }

    fn pick(&self, keep: &[usize]) -> Self {
        match self {
            Response::Amplitude(a) => Response::Amplitude(keep.iter().map(|&i| a[i]).collect()),
            Response::Complex(z) => Response::Complex(keep.iter().map(|&i| z[i]).collect()),
        }
    }
}

/// Direction of the frequency during a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum RunDirection {
    /// Increasing.
    Up,
    /// Decreasing.
    Down,
    /// Neither: the points were taken in no order.
    Unordered,
}

/// Consecutive points measured in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// First point of the run, in the order of measurement.
    pub first: usize,
    /// Number of points.
    pub points: usize,
    /// Direction.
    pub direction: RunDirection,
}

/// Points that were left out when the curve was built.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Points with a frequency, response, drive or standard error that is not finite.
    pub not_finite: usize,
    /// Points at zero frequency, which have no phase and no period.
    pub zero_frequency: usize,
}

/// Amplitude, or amplitude and phase, versus frequency; points in the order of measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    frequency_hz: Vec<f64>,
    response: Response,
    drive: Option<Vec<f64>>,
    std_error: Option<Vec<f64>>,
    unit: String,
    runs: Vec<Run>,
    dropped: Dropped,
    separate_phase: bool,
}

/// Builds a [`Curve`] and checks it.
#[derive(Debug, Clone)]
pub struct CurveBuilder {
    frequency_hz: Vec<f64>,
    response: Response,
    phase_rad: Option<Vec<f64>>,
    drive: Option<Vec<f64>>,
    std_error: Option<Vec<f64>>,
    unit: String,
    separate_phase: bool,
}

impl Curve {
    /// Starts from frequencies and amplitudes.
    ///
    /// ```
    /// use slipfit::resonance::Curve;
    /// let curve = Curve::builder(vec![0.9, 1.0, 1.1], vec![0.2, 1.0, 0.2])
    ///     .phase_rad(vec![-0.2, -1.6, -2.9])
    ///     .unit("mm")
    ///     .build()?;
    /// assert!(curve.is_complex());
    /// # Ok::<(), slipfit::Error>(())
    /// ```
    pub fn builder(frequency_hz: Vec<f64>, amplitude: Vec<f64>) -> CurveBuilder {
        CurveBuilder {
            frequency_hz,
            response: Response::Amplitude(amplitude),
            phase_rad: None,
            drive: None,
            std_error: None,
            unit: String::new(),
            separate_phase: false,
        }
    }

    /// Starts from frequencies and complex responses.
    pub fn complex(frequency_hz: Vec<f64>, response: Vec<Phasor>) -> CurveBuilder {
        CurveBuilder { response: Response::Complex(response), ..Self::builder(frequency_hz, Vec::new()) }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.frequency_hz.len()
    }

    /// Whether there is no point at all (never, once built).
    pub fn is_empty(&self) -> bool {
        self.frequency_hz.is_empty()
    }

    /// Frequencies, Hz, in the order of measurement.
    pub fn frequency_hz(&self) -> &[f64] {
        &self.frequency_hz
    }

    /// Responses, in the order of measurement.
    pub fn response(&self) -> &Response {
        &self.response
    }

    /// Whether there is a phase.
    pub fn is_complex(&self) -> bool {
        matches!(self.response, Response::Complex(_))
    }

    /// Whether the phases were measured separately from the amplitudes and may be wrapped or belong to another
    /// quantity; this is not possible for real and imaginary parts.
    pub(crate) fn has_separate_phase(&self) -> bool {
        self.separate_phase
    }

    /// Drive level of each point, in any unit, if it was recorded.
    pub fn drive(&self) -> Option<&[f64]> {
        self.drive.as_deref()
    }

    /// Standard error of each point (of each quadrature if complex), if known.
    pub fn std_error(&self) -> Option<&[f64]> {
        self.std_error.as_deref()
    }

    /// Unit of the response, plain text.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// Up and down sweeps in the order of measurement.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Points left out when the curve was built.
    pub fn dropped(&self) -> Dropped {
        self.dropped
    }

    /// The points with frequencies in this band, in Hz.
    pub(crate) fn within(&self, [low, high]: [f64; 2]) -> Self {
        let keep: Vec<usize> =
            (0..self.len()).filter(|&i| (low..=high).contains(&self.frequency_hz[i])).collect();
        let chosen = |v: &Vec<f64>| keep.iter().map(|&i| v[i]).collect::<Vec<f64>>();
        let frequency_hz = chosen(&self.frequency_hz);
        Self {
            runs: runs(&frequency_hz),
            frequency_hz,
            response: self.response.pick(&keep),
            drive: self.drive.as_ref().map(chosen),
            std_error: self.std_error.as_ref().map(chosen),
            unit: self.unit.clone(),
            dropped: self.dropped,
            separate_phase: self.separate_phase,
        }
    }
}

impl CurveBuilder {
    /// Phase of the response, rad, wrapped or not.
    #[must_use]
    pub fn phase_rad(mut self, phase_rad: Vec<f64>) -> Self {
        self.phase_rad = Some(phase_rad);
        self
    }

    /// States that the phases of complex responses were measured separately from their amplitudes: they are ignored if
    /// they fit no resonance although the amplitudes do.
    #[must_use]
    pub fn separate_phase(mut self) -> Self {
        self.separate_phase = true;
        self
    }

    /// Drive level of each point, in any unit; the fitted drive is proportional to it point by point.
    #[must_use]
    pub fn drive(mut self, drive: Vec<f64>) -> Self {
        self.drive = Some(drive);
        self
    }

    /// Standard error of each point, in the unit of the response; of each quadrature if complex.
    #[must_use]
    pub fn std_error(mut self, std_error: Vec<f64>) -> Self {
        self.std_error = Some(std_error);
        self
    }

    /// Unit of the response.
    #[must_use]
    pub fn unit(mut self, unit: impl Into<String>) -> Self {
        self.unit = unit.into();
        self
    }

    /// Checks and builds. Points that are not finite or at zero frequency are left out and counted
    /// ([`Curve::dropped`]).
    ///
    /// # Errors
    /// [`Error::Length`] for columns of different length; [`Error::FrequencyNegative`]; [`Error::PointOutOfRange`] for
    /// a negative amplitude, or a drive or standard error that is not positive; [`Error::TooFewSamples`] if no point is
    /// left.
    pub fn build(self) -> Result<Curve, Error> {
        let n = self.frequency_hz.len();
        let lengths = [
            ("response", Some(self.response.len())),
            ("phase_rad", self.phase_rad.as_ref().map(Vec::len)),
            ("drive", self.drive.as_ref().map(Vec::len)),
            ("std_error", self.std_error.as_ref().map(Vec::len)),
        ];
        for (name, found) in lengths {
            if let Some(found) = found.filter(|&found| found != n) {
                return Err(Error::Length { name, found, expected: n });
            }
        }
        let mut dropped = Dropped::default();
        let mut keep = Vec::with_capacity(n);
        let columns = [&self.phase_rad, &self.drive, &self.std_error];
        for i in 0..n {
            let finite = |c: &&Option<Vec<f64>>| c.as_ref().is_none_or(|v| v[i].is_finite());
            // The frequency must also be finite in rad/s.
            let has_frequency = (TAU * self.frequency_hz[i]).is_finite();
            if !has_frequency || !self.response.is_finite(i) || !columns.iter().all(finite) {
                dropped.not_finite += 1;
            } else if self.frequency_hz[i] == 0.0 {
                dropped.zero_frequency += 1;
            } else {
                keep.push(i);
            }
        }
        let point = |name, index, value, range| Error::PointOutOfRange { name, index, value, range };
        for &i in &keep {
            if self.frequency_hz[i] < 0.0 {
                return Err(Error::FrequencyNegative { index: i, value: self.frequency_hz[i] });
            }
            if let Response::Amplitude(a) = &self.response
                && a[i] < 0.0
            {
                return Err(point("amplitude", i, a[i], "the non-negative numbers"));
            }
            for (name, column) in [("drive", &self.drive), ("std_error", &self.std_error)] {
                if let Some(v) = column
                    && v[i] <= 0.0
                {
                    return Err(point(name, i, v[i], POSITIVE));
                }
            }
        }
        if keep.is_empty() {
            return Err(Error::TooFewSamples { found: 0, needed: 1 });
        }
        let chosen = |v: &Vec<f64>| keep.iter().map(|&i| v[i]).collect::<Vec<f64>>();
        let response = match (self.response.pick(&keep), &self.phase_rad) {
            (Response::Amplitude(a), Some(phase)) => Response::Complex(
                a.iter().zip(chosen(phase)).map(|(&r, phase)| Phasor::from_polar(r, phase)).collect(),
            ),
            (response, _) => response,
        };
        let frequency_hz = chosen(&self.frequency_hz);
        Ok(Curve {
            runs: runs(&frequency_hz),
            frequency_hz,
            response,
            drive: self.drive.as_ref().map(chosen),
            std_error: self.std_error.as_ref().map(chosen),
            unit: self.unit,
            dropped,
            separate_phase: self.separate_phase || self.phase_rad.is_some(),
        })
    }
}

/// Divides the points into runs up and down.
fn runs(frequency_hz: &[f64]) -> Vec<Run> {
    let n = frequency_hz.len();
    let mut list: Vec<Run> = Vec::new();
    let mut first = 0;
    while first < n {
        let mut direction = RunDirection::Unordered;
        let mut end = first + 1;
        while end < n {
            let step = frequency_hz[end] - frequency_hz[end - 1];
            let here = if step >= 0.0 { RunDirection::Up } else { RunDirection::Down };
            if step != 0.0 {
                if direction == RunDirection::Unordered {
                    direction = here;
                } else if direction != here {
                    break;
                }
            }
            end += 1;
        }
        list.push(Run { first, points: end - first, direction });
        first = end;
    }
    let long = list.iter().filter(|r| r.points >= RUN_POINTS).map(|r| r.points).sum::<usize>();
    if list.len() > 1 && 2 * long < n {
        return vec![Run { first: 0, points: n, direction: RunDirection::Unordered }];
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_points_are_counted_and_wrong_ones_named() {
        let c = Curve::builder(vec![0.0, 1.0, f64::NAN, 2.0], vec![1.0, 1.0, 1.0, f64::INFINITY]);
        let c = c.build().unwrap();
        assert_eq!((c.len(), c.dropped()), (1, Dropped { not_finite: 2, zero_frequency: 1 }));
        let e = Curve::builder(vec![1.0, -2.0], vec![1.0, 1.0]).build().unwrap_err();
        assert_eq!(e, Error::FrequencyNegative { index: 1, value: -2.0 });
        let e = Curve::builder(vec![1.0, 2.0], vec![1.0, -1.0]).build().unwrap_err();
        assert!(matches!(e, Error::PointOutOfRange { name: "amplitude", index: 1, .. }));
        assert!(Curve::builder(vec![1.0], vec![1.0, 2.0]).build().is_err());
        assert!(Curve::builder(vec![0.0], vec![1.0]).build().is_err());
    }

    #[test]
    fn up_and_down_are_two_runs_and_noise_in_the_order_is_none() {
        let up: Vec<f64> = (1..9).map(f64::from).collect();
        let mut both = up.clone();
        both.extend(up.iter().rev());
        let directions = |f: &[f64]| runs(f).iter().map(|r| r.direction).collect::<Vec<_>>();
        assert_eq!(directions(&up), [RunDirection::Up]);
        assert_eq!(directions(&both), [RunDirection::Up, RunDirection::Down]);
        assert_eq!(directions(&[3.0, 1.0, 4.0, 1.5, 9.0, 2.0]), [RunDirection::Unordered]);
        assert_eq!(runs(&both).iter().map(|r| r.points).sum::<usize>(), both.len());
    }
}
