//! Fit of one model, without comparison or intervals.

use super::block::Block;
use super::criteria::SearchCriteria;
use super::problem::Problem;
use super::response::{DELTA, OMEGA, PHASE, X_0, X_F};
use super::search::{best, starts};
use super::{Curve, peak, start};
use crate::Error;
use crate::inference::least_squares::{LeastSquares, descend, minimise_until, one_step};
use std::f64::consts::TAU;

/// The exact response fitted to a curve; standard errors for white residuals, without limits on the parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveFit {
    /// Natural frequency, Hz, and its standard error.
    pub natural_frequency_hz: [f64; 2],
    /// Decay rate delta, 1/s.
    pub decay_rate_per_s: [f64; 2],
    /// Friction displacement `x_F`, response unit.
    pub friction_displacement: [f64; 2],
    /// Drive amplitude `x_0`, response unit; its standard error is zero if it was given.
    pub drive_amplitude: [f64; 2],
    /// Phase offset, rad; zero without phases.
    pub phase_offset_rad: [f64; 2],
    /// Root mean square of the residuals (of a quadrature if complex).
    pub residual_rms: f64,
    /// Whether the fit converged to its tolerance.
    pub converged: bool,
}

/// Number of points with which a fit begins.
const FIRST_POINTS: usize = 56;
/// Accuracy of the fit to those points and to all points, in standard errors; the last step found is applied.
const FIRST_ACCURACY: f64 = 0.1;
const FINAL_ACCURACY: f64 = 0.01;

/// Fits the exact fundamental with viscous damping and sliding friction only: no models are compared, no instrument
/// term except the phase offset is tried, no interval is computed. Start values are derived from the curve.
///
/// `drive_amplitude` fixes `x_0`; otherwise `x_0` is fitted.
///
/// # Errors
/// [`Error::TooFewPoints`], [`Error::NoResonance`] or [`Error::NoFit`] as for [`analyse`](super::analyse);
/// [`Error::Parameter`] for a drive that is not positive.
///
/// ```
/// use slipfit::{Oscillator, resonance::{Curve, fit}, motion::steady::scan};
/// let o = Oscillator::builder().frequency_hz(1.0).q_factor(40.0).friction_displacement(0.3).build()?;
/// let mut points = (Vec::new(), Vec::new());
/// for i in 0..41 {
///     let r = scan::reading(&o, 1.0, 0.9 + 0.005 * f64::from(i))?;
///     points.0.push(r.frequency_hz);
///     points.1.push(r.fundamental);
/// }
/// let found = fit(&Curve::complex(points.0, points.1).build()?, Some(1.0))?;
/// assert!((found.friction_displacement[0] - 0.3).abs() < 1e-6);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn fit(curve: &Curve, drive_amplitude: Option<f64>) -> Result<CurveFit, Error> {
    if let Some(x_0) = drive_amplitude {
        crate::model::oscillator::above_zero("drive_amplitude", x_0)?;
    }
    let mut main = Block::new(curve);
    let peak = peak::find(&main).ok_or(Error::NoResonance { reason: "every amplitude is zero" })?;
    // This number of points within the peak gives start values as good as all points do.
    let within = main.omega.iter().filter(|w| (**w - peak.omega).abs() < peak.half_width).count();
    let stride = (main.len() / FIRST_POINTS).min(within / 8).max(1);
    let mut few = (stride > 1).then(|| main.thinned(stride));
    let linear = start::linear(few.as_ref().unwrap_or(&main), &peak, true);
    if linear.is_some_and(|(_, conjugated)| conjugated) {
        for z in main.data.iter_mut().chain(few.iter_mut().flat_map(|few| &mut few.data)) {
            *z = z.conj();
        }
    }
    // A fixed drive has no column of its own.
    let used: Vec<usize> = [(OMEGA, true), (DELTA, true), (X_0, drive_amplitude.is_none()), (X_F, true)]
        .into_iter()
        .chain([(PHASE, main.complex)])
        .filter_map(|(k, free)| free.then_some(k))
        .collect();
    let free = used.clone();
    let problem = Problem::new(main, peak.omega, used);
    if problem.observations() as usize <= free.len() {
        return Err(Error::TooFewPoints { points: problem.main.len(), parameters: free.len() });
    }
    let fixed = drive_amplitude.is_some();
    // With phases the solution of the linear balance is close to the minimum.
    let near = linear.and_then(|(s, _)| {
        let mut start = start::parameters(&s, drive_amplitude);
        let mut stepped = None;
        if let Some(few) = few {
            let few = Problem { main: few, used: problem.used.clone(), reference: None, ..problem };
            let (near, sums, _) = descend(&few, &start, &free, FIRST_ACCURACY, true)?;
            stepped = one_step(&problem, &few, &sums, &near, &free, FINAL_ACCURACY);
            start = near;
        }
        stepped
            .or_else(|| minimise_until(&problem, &start, &free, FINAL_ACCURACY, true))
            .filter(|f| f.converged)
    });
    let found = near
        .or_else(|| {
            let all = starts(&problem.main, &peak, linear.map(|(s, _)| s), drive_amplitude, fixed);
            best(&problem, &all, &free, &SearchCriteria::default())
        })
        .ok_or(Error::NoFit { reason: "no resonance curve with viscous and sliding loss could be fitted" })?;
    let n = problem.observations();
    let sigma = (found.rss / (n - free.len() as f64).max(1.0)).sqrt();
    let one = |k: usize, offset: f64, factor: f64| {
        [(found.parameters[k] + offset) * factor, found.unit_std(k) * sigma * factor]
    };
    Ok(CurveFit {
        natural_frequency_hz: one(OMEGA, problem.centre, 1.0 / TAU),
        decay_rate_per_s: one(DELTA, 0.0, 1.0),
        friction_displacement: one(X_F, 0.0, 1.0),
        drive_amplitude: one(X_0, 0.0, 1.0),
        phase_offset_rad: one(PHASE, 0.0, 1.0),
        residual_rms: (found.rss / n).sqrt(),
        converged: found.converged,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::steady::Phasor;
    use crate::motion::steady::fundamental::{Point, fundamental};
    use crate::noise::jitter;

    /// The fit ends at the minimum over all points, however few passes it takes.
    #[test]
    fn steps_saved_leave_next_to_nothing() {
        let mut most = 0.0f64;
        for (q, beta, noise) in
            [(50.0, 0.3, 1e-3), (8.0, 0.1, 1e-2), (1e4, 0.8, 3e-3), (200.0, 0.0, 0.1), (30.0, 0.6, 0.2)]
        {
            let (omega_0, delta) = (TAU, TAU / (2.0 * q));
            let x_f = std::f64::consts::FRAC_PI_4 * beta;
            let hz: Vec<f64> = (0..401).map(|i| 1.0 + (f64::from(i) / 40.0 - 5.0) * delta / TAU).collect();
            for seed in 0..10 {
                let z = hz.iter().enumerate().map(|(i, f)| {
                    let at =
                        Point { omega: TAU * f, omega_0, detuning: TAU * (f - 1.0), delta, x_0: 1.0, x_f };
                    let (a, b) = (jitter(i, seed), jitter(i, seed + 100));
                    fundamental(&at).unwrap().value + Phasor::new(a, b) * (noise * q * (1.0 - beta))
                });
                let curve = Curve::complex(hz.clone(), z.collect()).build().unwrap();
                let quick = fit(&curve, None).unwrap();
                let main = Block::new(&curve);
                let peak = peak::find(&main).unwrap();
                let used = vec![OMEGA, DELTA, X_0, X_F, PHASE];
                let problem = Problem::new(main, peak.omega, used.clone());
                let begin = starts(&problem.main, &peak, None, None, false);
                let whole = best(&problem, &begin, &used, &SearchCriteria::default()).unwrap();
                for (k, [value, error]) in
                    [(DELTA, quick.decay_rate_per_s), (X_F, quick.friction_displacement)]
                {
                    most = most.max((value - whole.parameters[k]).abs() / error);
                }
            }
        }
        assert!(most < 0.03, "{most} standard errors");
    }
}
