//! The steps of the analysis of a resonance curve.

use super::block::Block;
use super::criteria::Criteria;
use super::fitted_models::FittedModels;
use super::free_gain::free_gain;
use super::peak;
use super::prepared::PreparedCurve;
use super::work::Work;
use super::{Answer, Curve, Options, assemble, lost_curvature, measured_columns};
use crate::Error;

/// Separates viscous from sliding loss in a resonance curve.
///
/// The response of the oscillator `m x'' + gamma x' + k x + F sgn(x') = k x_0 cos(omega t)` is computed exactly at
/// every frequency (in closed form if the mass never stops, otherwise from the motion with its stops), and its
/// fundamental, as measured by a lock-in amplifier, is compared with the points: with amplitudes, or with real and
/// imaginary part if there is a phase. Its leading term is eq. (8) of Vitorino, Vieira and Rodrigues, *Effect of
/// sliding friction in harmonic oscillators*; their effective Lorentzian, eq. (14), is reported in addition, with its
/// bias for this curve.
///
/// All loss models (viscous, sliding, drag and their sums) are compared on the same points. A phase offset is always
/// fitted if there are phases. Background and delay are included if this lowers the BIC, with the autocorrelation taken
/// into account, by a margin; a warning states it. In either case the other sets of these terms widen the intervals
/// according to their weights. A Duffing term is added if it lowers the BIC by 14; in either case the fit with the
/// other choice widens the intervals in the same way. Noise that grows with the amplitude is estimated from the
/// residuals, unless the curve has errors of its own; errors and drives of the points that the residuals contradict are
/// not used, with a warning.
///
/// The height of a curve is `Q x_0 (1 - 4 x_F/(pi x_0))`: if the drive amplitude `x_0` is known
/// ([`Options::drive_amplitude`], or a friction-free [`Options::reference`]), friction and Q follow from height and
/// width. Otherwise they follow from the shape alone; the interval shows with what accuracy.
///
/// Units: frequencies in Hz; `x_0`, `x_F` in the unit of the response.
///
/// If the standard error of `x_F` exceeds a fifth of `x_0`, the bias of least squares is corrected to second order (M.
/// J. Box, J. R. Stat. Soc. B 33, 171, 1971) in `delta`, `x_F`, `x_0` and their ratio; the intervals are those of the
/// profile in either case.
///
/// Limits: one mode; static friction equal to kinetic friction; a steady curve (a sweep that is slow compared with the
/// decay); drag and the Duffing term are of leading order in the amplitude.
///
/// # Errors
/// [`Error::Parameter`] for an option out of range, [`Error::TooFewPoints`] if there are fewer points than free
/// parameters plus one, [`Error::DoesNotHold`] for a constant or a noise floor in the amplitudes of points with phases,
/// or a delay of points without phases, [`Error::NoResonance`] or [`Error::NoFit`] if there is no result. A poor fit is
/// not an error but an [`Answer`] with warnings.
///
/// ```
/// use slipfit::Parameter;
/// use slipfit::resonance::{Curve, DriveAmplitude, Options, analyse};
/// use slipfit::motion::steady::scan;
///
/// let o = slipfit::Oscillator::builder().frequency_hz(1.0).q_factor(50.0).friction_displacement(0.3).build()?;
/// let mut noise = 7.7f64;
/// let mut jitter = || { noise = (noise * 997.0).fract(); 0.02 * (noise - 0.5) };
/// let (mut hz, mut z) = (Vec::new(), Vec::new());
/// for i in 0..81 {
///     let r = scan::reading(&o, 1.0, 0.9 + 0.0025 * f64::from(i))?;
///     hz.push(r.frequency_hz);
///     z.push(r.fundamental + slipfit::motion::steady::Phasor::new(jitter(), jitter()));
/// }
/// let curve = Curve::complex(hz, z).unit("mm").build()?;
/// let mut options = Options::default();
/// options.drive_amplitude = Some(DriveAmplitude { value: 1.0, std_error: 0.0 });
/// let answer = analyse(&curve, &options)?;
/// let x_f = answer.parameter(Parameter::FRICTION_DISPLACEMENT).expect("always reported");
/// assert!((x_f.value - 0.3).abs() < 0.01);
/// assert!(answer.sliding.detected);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn analyse(curve: &Curve, options: &Options) -> Result<Answer, Error> {
    analyse_with(curve, options, &Criteria::default())
}

const SEARCH_CUT: &str = "no resonance curve could be fitted within the limit of work";

/// [`analyse`] with user-defined thresholds.
///
/// # Errors
/// As [`analyse`].
pub fn analyse_with(curve: &Curve, options: &Options, criteria: &Criteria) -> Result<Answer, Error> {
    options.check()?;
    let terms = options.terms;
    let constant = "the points have phases, and a constant added to the response is a background";
    let noise = "the points have phases, and their noise averages to zero";
    let delay = "the points have no phases, and a delay changes nothing else";
    for (asked, method, complex, why) in [
        (terms.amplitude_offset, "a constant offset of every amplitude", true, constant),
        (terms.noise_floor, "a noise floor in every amplitude", true, noise),
        (terms.delay, "a delay", false, delay),
    ] {
        if asked == Some(true) && curve.is_complex() == complex {
            return Err(Error::DoesNotHold { method, why });
        }
    }
    let used = match options.band_hz {
        Some(band) => curve.within(band),
        None => curve.clone(),
    };
    if used.is_empty() {
        return Err(Error::NoResonance { reason: "no point lies in the band asked for" });
    }
    let work = Work::limited(criteria.search.work(used.len()));
    analyse_within(curve, &used, options, criteria, &work)
}

/// [`analyse_with`] for the points in use; the work is counted in `work`.
pub(super) fn analyse_within(
    curve: &Curve,
    used: &Curve,
    options: &Options,
    criteria: &Criteria,
    work: &Work,
) -> Result<Answer, Error> {
    let block = |curve: &Curve| Block { work: work.clone(), ..Block::new(curve) };
    let errors_known = used.std_error().is_some();
    let fit = |main: Block, spikes: usize| {
        let mut curve = PreparedCurve::new(main, options.reference.as_ref().map(block), options, criteria)?;
        let best = |curve: &PreparedCurve| measured_columns::best_fit(curve, options, criteria, errors_known);
        let mut fitted = best(&curve)?;
        for _ in 0..criteria.preparation.group_rounds {
            let corrected = lost_curvature::corrected(&curve, &fitted, criteria.preparation.group_errors);
            let Some(corrected) = corrected.filter(|_| !work.was_cut()) else { break };
            let Ok(better) = best(&corrected) else { break };
            (curve, fitted) = (corrected, better);
        }
        Ok((curve, FittedModels { spikes, ..fitted }))
    };
    let mut main = block(used);
    let mut found = fit(main.clone(), 0);
    // A glitch far above the peak hides the peak.
    for spikes in 1..=main.len() / criteria.residuals.outlier_part.max(1) {
        let Err(Error::NoResonance { .. }) = found else { break };
        let Some(fewer) = peak::without_spike(&main, &criteria.residuals) else { break };
        main = fewer;
        found = fit(main.clone(), spikes).or(found);
    }
    let (prepared, mut fitted) =
        found.map_err(|error| if work.was_cut() { Error::NoFit { reason: SEARCH_CUT } } else { error })?;
    if options.reference.is_some() || options.drive_amplitude.is_some() {
        let known = errors_known && fitted.set_aside.errors.is_none();
        let alone = PreparedCurve { reference: None, ..prepared };
        fitted.free_gain =
            work.within(criteria.search.share, || free_gain(&fitted, alone, options, criteria, known));
    }
    // Work is reserved for the intervals, whatever the search used.
    work.renew(criteria.search.interval_part);
    assemble::answer(curve, used, options, &fitted, criteria)
}

#[cfg(test)]
mod tests {
    use super::super::Terms;
    use super::*;
    use crate::motion::steady::{Phasor, scan};
    use crate::noise::jitter;

    #[test]
    fn terms_that_the_points_cannot_have_are_refused() {
        let hz: Vec<f64> = (0..41).map(|i| 0.95 + 0.0025 * f64::from(i)).collect();
        let z = hz.iter().map(|f| Phasor::new(1.0 - f * f, 0.02 * f).inv()).collect();
        let with_phases = Curve::complex(hz.clone(), z).build().expect("valid");
        let amplitudes = (0..hz.len()).map(|i| with_phases.response().amplitude(i)).collect();
        let without = Curve::builder(hz, amplitudes).build().expect("valid");
        type Term = fn(&mut Terms) -> &mut Option<bool>;
        let terms = |of: Term, asked: bool| {
            let mut options = Options::default();
            *of(&mut options.terms) = Some(asked);
            options
        };
        let cases: [(Term, &Curve); 3] = [
            (|t| &mut t.amplitude_offset, &with_phases),
            (|t| &mut t.noise_floor, &with_phases),
            (|t| &mut t.delay, &without),
        ];
        for (of, curve) in cases {
            let refused = analyse(curve, &terms(of, true));
            assert!(matches!(refused, Err(Error::DoesNotHold { .. })), "{refused:?}");
            assert!(analyse(curve, &terms(of, false)).is_ok());
        }
    }

    /// Curve of a resonance with a quality factor of 100 without friction, each point transformed by `read`.
    fn seen(points: usize, noise: f64, read: impl Fn(usize, Phasor) -> Phasor) -> (Vec<f64>, Vec<Phasor>) {
        let o = crate::Oscillator::builder().frequency_hz(1.0).q_factor(100.0).build().unwrap();
        let hz: Vec<f64> = (0..points).map(|i| 0.97 + 0.06 * i as f64 / (points - 1) as f64).collect();
        let z = hz.iter().enumerate().map(|(i, f)| {
            let noise = Phasor::new(jitter(i, 5), jitter(i, 6)) * noise;
            read(i, scan::reading(&o, 1.0, *f).unwrap().fundamental + noise)
        });
        let z = z.collect();
        (hz, z)
    }

    #[test]
    fn a_glitch_above_the_peak_is_left_out() {
        for glitches in [&[5][..], &[5, 44]] {
            let (hz, z) = seen(61, 0.5, |i, z| if glitches.contains(&i) { z * 40.0 } else { z });
            let curve = Curve::builder(hz, z.iter().map(|z| z.norm()).collect()).build().unwrap();
            let answer = analyse(&curve, &Options::default()).unwrap();
            let q = answer.parameter(crate::Parameter::QFactor).unwrap();
            assert!((q.value - 100.0).abs() < 4.0 * q.std_error, "{q:?}");
            assert_eq!(answer.diagnostics.left_out, glitches.len());
            assert_eq!(answer.diagnostics.points, 61 - glitches.len());
        }
    }

    #[test]
    fn no_friction_is_claimed_of_a_curve_that_is_cut_off() {
        let mut sure = 0;
        for share in [0.7, 0.75, 0.8, 0.85, 0.9] {
            let (hz, z) = seen(401, 0.5, |_, z| z / z.norm() * z.norm().min(100.0 * share));
            let answer = analyse(&Curve::complex(hz, z).build().unwrap(), &Options::default()).unwrap();
            sure += usize::from(answer.sliding.p_value < 0.01);
            assert!(!answer.sliding.detected, "{share}");
        }
        // Otherwise friction would be detected by chance.
        assert!(sure > 0);
    }

    /// A clipped curve looks like drag, with which the viscous loss may become negative.
    #[test]
    fn values_and_table_are_those_of_one_fit() {
        let known = crate::resonance::DriveAmplitude { value: 1.0, std_error: 0.0 };
        let options = Options { drive_amplitude: Some(known), ..Options::default() };
        for share in [0.6, 0.65, 0.7, 0.75, 0.8, 0.85] {
            let (hz, z) = seen(61, 0.1, |_, z| z / z.norm() * z.norm().min(100.0 * share));
            let amplitudes = z.iter().map(|z| z.norm()).collect();
            let answer = analyse(&Curve::builder(hz, amplitudes).build().unwrap(), &options).unwrap();
            let row = answer.comparison.iter().find(|c| c.model == answer.model).unwrap();
            for parameter in [crate::Parameter::DECAY_RATE, crate::Parameter::FRICTION_DISPLACEMENT] {
                let value = answer.parameter(parameter).unwrap();
                let of_row = row.values.get(parameter).unwrap();
                assert!(
                    (of_row - value.value).abs() < 0.5 * value.std_error,
                    "{share}: {value:?} in a row of {of_row}"
                );
            }
            let x_f = answer.parameter(crate::Parameter::FRICTION_DISPLACEMENT).unwrap();
            assert!(x_f.interval_95[0] == 0.0 || answer.sliding.p_value < 0.1, "{share}: {x_f:?}");
            let delta = answer.parameter(crate::Parameter::DECAY_RATE).unwrap().value;
            let none = answer.warnings.iter().any(|w| w.code() == "no_viscous_loss");
            assert_eq!(none, delta == 0.0 && answer.model != crate::LossModel::VISCOUS_SLIDING);
        }
    }

    #[test]
    fn a_delay_below_zero_is_no_delay() {
        let delayed = |delay: f64| {
            let (hz, z) =
                seen(101, 0.1, |i, z| z * Phasor::from_polar(1.0, -delay * 0.06 * i as f64 / 100.0));
            let curve = Curve::complex(hz, z).build().unwrap();
            let options =
                Options { terms: Terms { delay: Some(true), ..Terms::default() }, ..Options::default() };
            let codes: Vec<_> =
                analyse(&curve, &options).unwrap().warnings.iter().map(|w| w.code()).collect();
            ["delay", "negative_delay"].map(|code| codes.contains(&code))
        };
        assert_eq!(delayed(5.0), [true, false]);
        assert_eq!(delayed(-5.0), [false, true]);
    }

    /// A drive given 10 % too large led to friction of a fifth of the loss, p < 1e-12, and a background of 7 %.
    #[test]
    fn a_drive_that_contradicts_the_shape_of_the_curve_is_named() {
        let (hz, z) = seen(121, 0.5, |_, z| z);
        for (given, differs) in [(1.0, false), (1.1, true), (1.414, true), (0.9, true)] {
            let known = crate::resonance::DriveAmplitude { value: given, std_error: 0.0 };
            let options = Options { drive_amplitude: Some(known), ..Options::default() };
            let answer = analyse(&Curve::complex(hz.clone(), z.clone()).build().unwrap(), &options).unwrap();
            let codes: Vec<_> = answer.warnings.iter().map(|w| w.code()).collect();
            assert!(!answer.sliding.detected, "{given}: {codes:?}");
            assert_eq!(codes.contains(&"drive_differs"), differs, "{given}: {codes:?}");
        }
    }

    /// Curve and reference of amplitudes, the reference measured with another gain.
    #[test]
    fn a_reference_at_another_gain_is_named() {
        let o =
            crate::Oscillator::builder().frequency_hz(1.0).q_factor(100.0).friction_displacement(0.4).build();
        let o = o.unwrap();
        let answered = |gain: f64, seed: u64| {
            let (hz, free) = seen(121, 0.1, |_, z| z * gain);
            let read = |(i, f): (usize, &f64)| {
                let noise = Phasor::new(jitter(i, 2 * seed + 7), jitter(i, 2 * seed + 8)) * 0.1;
                (scan::reading(&o, 1.0, *f).unwrap().fundamental + noise).norm()
            };
            let amplitudes = hz.iter().enumerate().map(read).collect();
            let reference =
                Curve::builder(hz.clone(), free.iter().map(|z| z.norm()).collect()).build().unwrap();
            let options = Options { reference: Some(reference), ..Options::default() };
            let answer = analyse(&Curve::builder(hz, amplitudes).build().unwrap(), &options).unwrap();
            let named = answer.warnings.iter().any(|w| w.code() == "reference_gain");
            (named, answer.parameter(crate::Parameter::FRICTION_DISPLACEMENT).unwrap().clone())
        };
        for seed in 0..5 {
            let (named, x_f) = answered(1.0, seed);
            assert!(!named && x_f.std_error < 0.01, "{seed}: {x_f:?}");
            for gain in [0.7, 1.4] {
                let (named, x_f) = answered(gain, seed);
                assert!(
                    named && (x_f.interval_95[0]..=x_f.interval_95[1]).contains(&0.4),
                    "{gain}, {seed}: {x_f:?}"
                );
            }
        }
    }
}
