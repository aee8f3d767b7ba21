//! The one way in.

use super::amplitude_fit;
use super::assemble::{self, Evidence};
use super::fits::Described;
use super::lead_in;
use super::measure::{self, LEAST_CYCLES, Measured, Samples};
use super::short::short;
use super::waveform_fit;
use super::{Answer, Options};
use crate::numeric::extremes;
use crate::{Error, Record, SignalKind};
use std::borrow::Cow;
use std::f64::consts::TAU;

/// Tells viscous from sliding loss in a record of a decaying oscillation.
///
/// Finds the free decay, follows amplitude and phase along it, fits the loss
/// models `dA/dt = -(a0 + a1 A + a2 A²)` (sliding, viscous, drag) and weighs
/// them against each other. Where the record shows the motion itself, every
/// sample is compared with the exact motion, whose turning points obey
///
/// ```text
/// |X_n| + C = e^(-n pi delta/omega_d) (|X_0| + C),   C = x_F coth(pi delta / 2 omega_d)
/// ```
///
/// The paper's eq. (16) has the leading order `C = 4F/(pi gamma omega_0)` of it
/// (Vitorino, Vieira and Rodrigues, *Effect of sliding friction in harmonic
/// oscillators*), short by 2 % at Q = 2. Where frequency or phase wander more
/// than the exact motion allows, the amplitudes of short stretches are fitted
/// instead, phase left free.
///
/// Units: times in s; displacements, `x_F` and amplitudes in the record's
/// unit. For a velocity or acceleration record the "displacements" are those
/// times `omega` or `omega²`.
///
/// Limits: one mode (others are reported, [`Options::band_hz`] isolates one);
/// at least one and a half cycles above the noise; drag is treated on the
/// average of a cycle, exact for Q well above one.
///
/// # Errors
/// [`Error::Parameter`] for an option out of range, [`Error::NoOscillation`],
/// [`Error::NotARingDown`] or [`Error::NoFit`] where there is nothing to answer.
/// A fit that merely disappoints is an [`Answer`] with warnings.
///
/// ```
/// use slipfit::{Oscillator, Parameter, Record, motion::decay::FreeDecay, ringdown};
///
/// let oscillator = Oscillator::kinematic(6.0, 0.03, 0.002)?; // rad/s, 1/s, rad
/// let decay = FreeDecay::from_rest(&oscillator, 0.5)?;
/// let time: Vec<f64> = (0..2000).map(|i| 0.02 * i as f64).collect();
/// let angle: Vec<f64> = time.iter().enumerate()
///     .map(|(i, &t)| decay.displacement(t) + 1e-3 * (7.7 * (i * i) as f64).sin())
///     .collect();
/// let record = Record::new(time, angle)?.with_unit("rad");
/// let answer = ringdown::analyse(&record, &ringdown::Options::default())?;
/// let x_f = answer.parameter(Parameter::FRICTION_DISPLACEMENT).expect("always reported");
/// assert!((x_f.value - 0.002).abs() < 1e-4);
/// assert!(answer.sliding.detected);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn analyse(record: &Record, options: &Options) -> Result<Answer, Error> {
    options.check()?;
    let mut samples = Samples::of(record, options)?;
    if let Some(band) = options.band_hz
        && oscillates(record.kind())
    {
        samples.signal = Cow::Owned(measure::band_passed(&samples, band));
    }
    within_reach(&samples)?;
    let bare = !oscillates(record.kind());
    let found = if bare {
        amplitudes(record, &samples, options)
    } else {
        followed(&mut samples, options).and_then(|m| oscillation(record, &samples, options, m))
    };
    let (measured, described) = match found {
        Err(refusal) if measure::is_position(record.kind()) && refusal_of_length(&refusal) => {
            short(&samples).ok_or(refusal)?
        }
        found => found?,
    };
    let cycles = cycles(&measured);
    let evidence =
        Evidence { record, options, samples: &samples, measured: &measured, described: &described, cycles };
    assemble::answer(&evidence)
}

/// Amplitudes recorded as such, or a lock-in's outputs.
fn amplitudes<'a>(
    record: &Record,
    samples: &'a Samples,
    options: &Options,
) -> Result<(Measured, Described<'a>), Error> {
    let mut measured = match record.kind() {
        SignalKind::Envelope => measure::envelope(samples, options)?,
        _ => measure::lock_in(samples, options)?,
    };
    let described = amplitude_fit::fit_amplitudes(&mut measured, options)?;
    Ok((measured, described))
}

/// Amplitudes of short stretches; where the decay is a small part of the record, of shorter ones
/// about it, since their length follows the record's: a stretch must not see the law bend.
fn followed(samples: &mut Samples, options: &Options) -> Result<Measured, Error> {
    let coarse_hz = measure::frequency(samples, options)?;
    let measured = measure::oscillation(samples, options, coarse_hz)?;
    if let Some(range) = measured.closer(samples, coarse_hz) {
        let part = samples.part(range);
        if let Ok(closer) = measure::oscillation(&part, options, coarse_hz) {
            *samples = part;
            return Ok(closer);
        }
    }
    Ok(measured)
}

/// The motion itself: from amplitudes of short stretches to every sample.
fn oscillation<'a>(
    record: &Record,
    samples: &'a Samples,
    options: &Options,
    mut measured: Measured,
) -> Result<(Measured, Described<'a>), Error> {
    let mut rough = amplitude_fit::fit_amplitudes(&mut measured, options)?;
    if options.start_s.is_none() && lead_in::trim_lead_in(&rough, &mut measured) {
        rough = amplitude_fit::fit_amplitudes(&mut measured, options)?;
    }
    if options.end_s.is_none()
        && let Some(time_s) = amplitude_fit::change_of_law(&rough, &measured)
    {
        measured.points.retain(|b| b.time_s < time_s);
        measured.stretch.end_reason = super::segment::OTHER_LAW;
        measured.stretch.slow_tail = false;
        measured.stretch.disturbed = false;
        rough = amplitude_fit::fit_amplitudes(&mut measured, options)?;
    }
    let cycles = cycles(&measured);
    if cycles < LEAST_CYCLES {
        return Err(Error::NotARingDown {
            cycles,
            needed: LEAST_CYCLES,
            reason: "too strongly damped or too short a record",
        });
    }
    if options.band_hz.is_some() {
        // A band leaves no noise inside a block to measure: what the law leaves is the noise.
        measured.noise_rms *= rough.excess.sqrt();
        rough.excess = 1.0;
        return Ok((measured, rough));
    }
    if !measure::is_position(record.kind()) || options.lockin.is_some() {
        return Ok((measured, rough));
    }
    let exact = waveform_fit::fit_samples(samples, &measured, &rough).filter(|w| holds(w, &measured));
    let found = (measured, exact.unwrap_or(rough));
    if options.start_s.is_some() || found.0.stretch.start_reason != super::segment::LEAD_IN {
        return Ok(found);
    }
    Ok(lead_in::from_the_first_sample(samples, options, &found.0)
        .or_else(|| lead_in::past_the_lead_in(samples, options, &found))
        .unwrap_or(found))
}

/// Squares of squares are summed: outside these scales they leave the range of numbers.
fn within_reach(samples: &Samples) -> Result<(), Error> {
    const REACH: std::ops::RangeInclusive<f64> = 1e-60..=1e60;
    let spread = |v: &[f64]| {
        let (low, high) = extremes(v);
        low.abs().max(high.abs()).max(v[0] - low).max(high - v[0])
    };
    let signal = spread(&samples.signal).max(samples.quadrature.as_deref().map_or(0.0, spread));
    if [signal, samples.duration()].iter().all(|v| REACH.contains(v)) {
        return Ok(());
    }
    Err(Error::NoFit {
        reason: "signal or duration lie beyond 1e-60 to 1e60, where powers leave the range of numbers; \
                 choose another unit",
    })
}

fn refusal_of_length(refusal: &Error) -> bool {
    matches!(refusal, Error::NotARingDown { .. } | Error::NoFit { .. } | Error::NoOscillation { .. })
}

fn oscillates(kind: SignalKind) -> bool {
    !matches!(kind, SignalKind::Envelope | SignalKind::LockIn)
}

fn cycles(measured: &Measured) -> f64 {
    // Spans end at the last sample of their blocks: the steps between blocks count as well.
    let points = &measured.points;
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return 0.0 };
    let spans: f64 = points.iter().map(|b| b.span_s).sum();
    let turns: f64 = points.iter().map(|b| b.span_s * b.omega / TAU).sum();
    let whole = last.time_s + 0.5 * last.span_s - (first.time_s - 0.5 * first.span_s);
    if spans > 0.0 { turns / spans * whole } else { 0.0 }
}

/// Whether the exact waveform describes the samples down to their noise.
fn holds(described: &Described, measured: &Measured) -> bool {
    let Some(best) = described.comparison.preferred() else { return false };
    let variance = described.comparison.noise.residual_variance(&best.bounded);
    variance <= 1.3 * measured.noise_rms.powi(2)
}
