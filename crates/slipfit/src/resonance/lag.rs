//! Lag of the points behind the frequency: each retains a part of the one measured before it.

use super::bias::centred;
use super::criteria::LagCriteria;
use super::problem::Problem;
use super::response::{BG_IM, BG_RE, COUNT, DELAY, DRAG, DUFFING, FLOOR, Modelled, OFFSET, OMEGA};
use crate::inference::least_squares::{Fit, LeastSquares, Normal, minimise, newton_step};
use crate::inference::noise::NoiseModel;
use crate::motion::steady::Phasor;

/// A low-pass filter through which the points are read one after another.
///
/// Point `i` is `y_i = z_i + q (y_(i-1) - z_i)` instead of `z_i`, with `q = e^(-T/tau)` of an instrument, or
/// `q = e^(-(delta + i (omega - omega_0)) T)` of the resonator itself, which rings at its own frequency.
#[derive(Clone, Copy)]
struct LowPass {
    resonator: bool,
    /// Time between two points over the relaxation time.
    step: f64,
}

/// Shift of the natural frequency due to a lag, rad/s, if the residuals show a lag.
///
/// Most of a lag is a shift of the frequency, which cannot be detected in a single sweep. The part that the parameters
/// do not absorb is one direction of the residuals for each low-pass filter. If a larger lag was fitted by an
/// instrument term or the Duffing term, the lag is fitted in its place.
///
/// `neighbour_noise` is the noise of a point from differences of the residuals.
pub(super) fn shift(
    problem: &Problem,
    fit: &Fit,
    noise: NoiseModel,
    neighbour_noise: f64,
    c: &LagCriteria,
) -> Option<f64> {
    let (gain, shift) = residual_lag(problem, fit, noise, c)?;
    // If the residuals are more than noise, a lag must reduce them to the noise, because other causes look somewhat
    // like a lag.
    let most = if noise.variance_inflation > 1.0 {
        c.noise_variances * neighbour_noise * neighbour_noise * noise.observations
    } else {
        fit.rss
    };
    if gain > c.least_gain && fit.rss - gain * noise.residual_variance(fit) < most {
        return Some(shift);
    }
    let extra = [BG_RE, BG_IM, DELAY, DRAG, DUFFING, OFFSET, FLOOR];
    let free: Vec<usize> = fit.free.iter().copied().filter(|k| !extra.contains(k)).collect();
    if free.len() == fit.free.len() && noise.variance_inflation == 1.0 {
        return None;
    }
    let mut plain = fit.parameters.clone();
    extra.iter().filter(|k| fit.free.contains(k)).for_each(|&k| plain[k] = 0.0);
    let problem = &problem.with(&free);
    let plain = minimise(problem, &plain, &free)?;
    let white = NoiseModel { variance_inflation: 1.0, ..noise };
    let bic = |fit: &Fit, more: usize| white.bic(fit.rss, fit.free.len() + more);
    let mut best = (bic(fit, 0) - c.margin, None);
    for resonator in [false, true] {
        let mut lagging = plain.clone();
        for step in steps(c) {
            let Some(found) = fit_with_lag(problem, &lagging, LowPass { resonator, step }) else { break };
            lagging = found;
            if bic(&lagging, 1) < best.0 && lagging.rss < most {
                best = (bic(&lagging, 1), Some(fit.parameters[OMEGA] - lagging.parameters[OMEGA]));
            }
        }
    }
    best.1
}

fn steps(c: &LagCriteria) -> impl Iterator<Item = f64> {
    (0..c.steps).map(|k| c.longest_step * c.finer.powi(k as i32))
}

/// Decrease of the sum of squares by the most likely lag, in variances of a point, and the resulting shift of
/// `omega_0`, both to first order.
fn residual_lag(problem: &Problem, fit: &Fit, noise: NoiseModel, c: &LagCriteria) -> Option<(f64, f64)> {
    let (b, p) = (&problem.main, &fit.parameters);
    let still = centred(problem, p)?;
    let modelled = modelled(problem, p)?;
    let mut sums = Normal::zeros(COUNT);
    let mut best = (0.0, 0.0);
    for (resonator, step) in [false, true].into_iter().flat_map(|r| steps(c).map(move |step| (r, step))) {
        let contribution = LowPass { resonator, step }.contribution(problem, p, &modelled)?;
        let mut lagging = still.clone();
        let mut product = 0.0;
        for (i, contribution) in contribution.iter().enumerate() {
            let left = b.data[i] - still.main.data[i];
            product += b.weight[i] * (contribution.re * left.re + contribution.im * left.im);
            lagging.main.data[i] += contribution;
        }
        if !(product > 0.0 && lagging.normal(p, &mut sums)) {
            continue;
        }
        let Some(taken) = newton_step(&sums, &fit.free) else { continue };
        let of_free = || fit.free.iter().zip(&taken);
        let square = sums.rss - of_free().map(|(&k, s)| sums.jtr[k] * s).sum::<f64>();
        let gain = product * product / square / noise.residual_variance(fit);
        if square > c.least_seen * sums.rss && gain > best.0 {
            let by_omega = of_free().find(|(k, _)| **k == OMEGA).map_or(0.0, |(_, s)| *s);
            best = (gain, product / square * by_omega);
        }
    }
    Some(best)
}

/// The fit with a lag, from a fit without one or with a weaker one: the effect of the lag is subtracted from the
/// points, in two iterations.
fn fit_with_lag(problem: &Problem, from: &Fit, lag: LowPass) -> Option<Fit> {
    let mut fit = from.clone();
    for _ in 0..2 {
        let mut without = problem.clone();
        let contribution =
            lag.contribution(problem, &fit.parameters, &modelled(problem, &fit.parameters)?)?;
        without.main.data.iter_mut().zip(contribution).for_each(|(z, contribution)| *z -= contribution);
        fit = minimise(&without, &fit.parameters, &fit.free)?;
    }
    Some(fit)
}

fn modelled(problem: &Problem, p: &[f64]) -> Option<Vec<Modelled>> {
    problem.predict(p, false).into_iter().collect()
}

impl LowPass {
    /// Contribution of the lag to the reading of each point.
    fn contribution(self, problem: &Problem, p: &[f64], modelled: &[Modelled]) -> Option<Vec<Phasor>> {
        let b = &problem.main;
        let at = problem.response(p, false);
        let mut order: Vec<usize> = (0..b.len()).collect();
        order.sort_by_key(|&i| b.index[i]);
        let mut contribution = vec![Phasor::default(); b.len()];
        let mut last = modelled[*order.first()?].oscillator;
        for i in order {
            let m = &modelled[i];
            let detuning = b.omega[i] - problem.centre - p[OMEGA];
            let turn = if self.resonator { self.step * detuning / at.delta } else { 0.0 };
            last = m.oscillator + (last - m.oscillator) * Phasor::from_polar((-self.step).exp(), -turn);
            let rotated = (m.value - at.background_at(b.omega[i])) / m.oscillator;
            let value = m.value + (last - m.oscillator) * rotated;
            contribution[i] = b.reading(i, &Modelled { value, ..*m }) - b.reading(i, m);
        }
        Some(contribution)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Curve, Options, analyse};
    use crate::answer::Warning;
    use crate::motion::steady::{Phasor, scan};
    use crate::noise::jitter;
    use crate::{Oscillator, Parameter};

    /// Ratio of the natural frequency to the true one, and its shift by a lag if one is reported; `kept` is the part of
    /// the previous point that each point retains.
    fn analysed(seed: u64, x_f: f64, kept: f64, down: bool, phases: bool) -> (f64, Option<f64>) {
        let o = Oscillator::builder()
            .frequency_hz(1.0)
            .q_factor(200.0)
            .friction_displacement(x_f)
            .build()
            .unwrap();
        let mut hz: Vec<f64> = (0..61).map(|i| 0.985 + 0.0005 * f64::from(i)).collect();
        if down {
            hz.reverse();
        }
        let still: Vec<Phasor> = hz.iter().map(|f| scan::reading(&o, 1.0, *f).unwrap().fundamental).collect();
        let mut last = still[0];
        let seen = still.iter().enumerate().map(|(i, z)| {
            last = z + (last - z) * kept;
            last + Phasor::new(jitter(i, 2 * seed), jitter(i, 2 * seed + 1)) * 0.2
        });
        let seen: Vec<Phasor> = seen.collect();
        let curve = if phases {
            Curve::complex(hz, seen)
        } else {
            Curve::builder(hz, seen.iter().map(|z| z.norm()).collect())
        };
        let answer = analyse(&curve.build().unwrap(), &Options::default()).unwrap();
        let lag = answer.warnings.iter().find_map(|w| match w {
            Warning::Lag { shift_hz } => Some(*shift_hz),
            _ => None,
        });
        (answer.parameter(Parameter::NaturalFrequency).unwrap().value - 1.0, lag)
    }

    #[test]
    fn a_low_pass_is_named_with_the_shift_that_it_brings() {
        for (seed, x_f, down) in (0..12).flat_map(|s| [(s, 0.0, false), (s, 0.2, true)]) {
            let (off, lag) = analysed(seed, x_f, 0.6, down, true);
            let shift = lag.unwrap_or_else(|| panic!("no lag in curve {seed}, {x_f}"));
            assert!((shift / off - 1.0).abs() < 0.5, "{seed} {x_f}: {shift} {off}");
        }
    }

    #[test]
    fn points_that_do_not_lag_are_not_said_to() {
        let cases = (0..40).flat_map(|s| [(s, 0.0, true), (s, 0.2, true), (s, 0.0, false), (s, 0.3, false)]);
        let named = cases.filter(|&(seed, x_f, phases)| analysed(seed, x_f, 0.0, false, phases).1.is_some());
        assert_eq!(named.count(), 0);
    }
}
