//! Slope and threshold from drive levels and amplitudes.

use super::answer::{Answer, Breakaway, Diagnostics, LevelPoint};
use super::branch::MovingBranch;
use super::breakaway::{breakaway, undecided};
use super::criteria::{Criteria, LevelCriteria};
use super::exact_motion::{QualityFactor, with_exact_motion};
use super::level_row::LEAST_Q;
use super::plateau::OffsetKind;
use super::quantities::{Calibrated, LineQuantities, inverse};
use super::sorted::SortedLevels;
use super::{Levels, Options};
use crate::answer::calibration::{Calibration, physical};
use crate::answer::{Parameter, Parameters, Warning};
use crate::{Error, Quantity};
use std::f64::consts::TAU;

/// Slope and threshold of the amplitude at resonance as a function of the drive level.
///
/// By eq. (9) of Vitorino, Vieira and Rodrigues,
///
/// ```text
/// R_0 = Q (x_0 - 4F/(pi k)) = Q x_0 - (4/pi) Q x_F       above the threshold, else next to nothing
/// ```
///
/// which the exact motion follows to `2 (x_F/R_0)²` at high Q. If Q is known, the exact amplitude at the undamped
/// resonance, including motion with stops, is fitted instead of the line, so that Q and friction are also valid at low
/// Q and next to the threshold. The levels are split into a stuck and a moving branch if that describes them best; the
/// moving branch gives slope and threshold, the split gives the breakaway. Without errors of the levels, constant noise
/// and noise that grows with the amplitude are both taken into account by their restricted likelihood; given errors are
/// accepted unless the levels scatter more. The reading of the detector where the mass sticks, its zero or its noise,
/// is subtracted from every level. Loss proportional to the square of the amplitude bends the line,
/// `y + c y² = slope (drive - threshold)`, a compressive detector nearly as `y + c y³`. If the levels show a bend,
/// slope and threshold are averages over both curves, weighted by their probabilities; otherwise they are averages over
/// the line and the first curve, with intervals that contain those of both.
///
/// Units: amplitudes in one unit, drive levels in another or the same. Q and the friction displacement are reported if
/// both units are lengths or both are angles
/// ([`DisplacementUnit::gain`](crate::model::displacement::DisplacementUnit::gain)), or if [`Options::drive_gain`] or
/// [`Options::q_factor`] is given, unless that Q is below 1/2, which no resonance has.
///
/// Limits: each level must be measured at its own resonance and in the steady state; one oscillator.
///
/// # Errors
/// [`Error::Parameter`] for an option out of range; [`Error::NoFit`] if fewer than three levels move, if the line does
/// not rise, if its slope is not determined, or if the numbers span too wide a range for a line.
///
/// ```
/// use slipfit::Parameter;
/// use slipfit::levels::{Levels, Options, analyse};
/// let drive: Vec<f64> = (1..=12).map(|i| 0.1 * f64::from(i)).collect();
/// // Q = 40, threshold 0.35, a little noise.
/// let amplitude = drive.iter().enumerate().map(|(i, x)| {
///     (40.0 * (x - 0.35)).max(0.0) + 0.02 * ((i * 7 % 5) as f64)
/// }).collect();
/// let levels = Levels::builder(drive, amplitude).unit("mm").drive_unit("mm").build()?;
/// let answer = analyse(&levels, &Options::default())?;
/// let q = answer.parameter(Parameter::QFactor).expect("one unit for both");
/// assert!((q.value - 40.0).abs() < 1.0);
/// assert!(answer.detected);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn analyse(levels: &Levels, options: &Options) -> Result<Answer, Error> {
    analyse_with(levels, options, &Criteria::default())
}

/// [`analyse`] with user-defined thresholds.
///
/// # Errors
/// As [`analyse`].
pub fn analyse_with(levels: &Levels, options: &Options, criteria: &Criteria) -> Result<Answer, Error> {
    check(options)?;
    let sorted = SortedLevels::of(levels);
    let branch = MovingBranch::of(&sorted, criteria).ok_or(Error::NoFit {
        reason: "fewer than three levels move, or the amplitude does not rise with the drive",
    })?;
    let branch = match QualityFactor::of(levels, options) {
        Some(q) => with_exact_motion(branch, &sorted, q, criteria),
        None => branch,
    };
    let found = LineQuantities::of(&branch, levels, criteria);
    if found.slope.value < criteria.levels.least_slope * found.slope.std_error {
        return Err(Error::NoFit {
            reason: "the amplitudes bend so strongly, or are so few, that their slope over the drive is not determined",
        });
    }
    let calibrated = found.calibrated(levels, options);
    let found = found.with_error_of_q(options);
    let points = points(&sorted, &branch, &criteria.levels);
    let undecided = undecided(&points, &branch, &criteria.levels);
    let breakaway = breakaway(&points, &branch, &undecided, &criteria.levels);
    let undecided = undecided.iter().filter(|undecided| **undecided).count();
    let stuck = points.iter().filter(|p| !p.moving).count();
    let answer = Answer {
        parameters: parameters(&found, calibrated.as_ref(), levels, options),
        p_value: found.p_value,
        detected: found.p_value < criteria.inference.detected,
        correlation: found.correlation,
        loss_correlation: calibrated.as_ref().map_or(0.0, |c| c.loss_correlation),
        diagnostics: Diagnostics {
            points: points.len(),
            moving: points.len() - stuck - undecided,
            stuck,
            undecided,
            residual_rms: branch.residual_rms,
            bend_p_value: branch.bend.0,
        },
        warnings: warnings(levels, &branch, &found, breakaway, calibrated.is_some(), &criteria.levels),
        breakaway,
        points,
        unit: levels.unit().to_owned(),
        drive_unit: levels.drive_unit().to_owned(),
        frequency_hz: options.frequency_hz,
        fit: branch.drawn,
    };
    // A quality factor that is not positive was too small to be represented.
    let vanished = calibrated.is_some_and(|c| !(c.q.value > 0.0));
    if vanished || !is_finite(&answer) {
        return Err(Error::NoFit {
            reason: "the levels are too large, too small or too far apart for a line",
        });
    }
    Ok(answer)
}

fn parameters(
    found: &LineQuantities,
    calibrated: Option<&Calibrated>,
    levels: &Levels,
    options: &Options,
) -> Parameters {
    let mut parameters = Parameters::default();
    parameters.set(Parameter::Slope, found.slope.clone());
    parameters.set(Parameter::Threshold, found.threshold.clone());
    let Some(Calibrated { q, x_f, .. }) = calibrated else { return parameters };
    parameters.set(Parameter::QFactor, q.clone());
    parameters.set(Parameter::FRICTION_DISPLACEMENT, x_f.clone());
    let hz = options.frequency_hz;
    let delta = hz.map(|hz| inverse(q, std::f64::consts::PI * hz, "1/s"));
    if let Some(delta) = &delta {
        parameters.set(Parameter::DECAY_RATE, delta.clone());
    }
    if let Some(calibration) = options.calibration {
        // The friction force follows from a stiffness without a frequency; the damping does not.
        let unknown = Quantity::normal(f64::NAN, f64::NAN, "1/s");
        let (omega_0, delta) = (TAU * hz.unwrap_or(f64::NAN), delta.unwrap_or(unknown));
        for (parameter, quantity) in physical(calibration, omega_0, levels.unit(), &delta, x_f) {
            if hz.is_some() || parameter == Parameter::CoulombForce {
                parameters.set(parameter, quantity);
            }
        }
    }
    parameters
}

fn points(sorted: &SortedLevels, branch: &MovingBranch, c: &LevelCriteria) -> Vec<LevelPoint> {
    let point = |i: usize| {
        let std_error = branch.fit.variance[i].sqrt();
        // In the exact motion friction holds the mass, and its reading does not contradict that.
        let held = branch.drawn.exact_q.is_some()
            && branch.expected[i] == 0.0
            && branch.motion[i] <= c.expected_errors * std_error;
        LevelPoint {
            index: sorted.order[i],
            drive: sorted.drive[i],
            amplitude: sorted.amplitude[i],
            std_error,
            fitted: branch.drawn.amplitude(sorted.drive[i]),
            moving: !branch.line.sticks[i] && !held,
        }
    };
    (0..sorted.order.len()).map(point).collect()
}

fn warnings(
    levels: &Levels,
    branch: &MovingBranch,
    found: &LineQuantities,
    breakaway: Option<Breakaway>,
    is_calibrated: bool,
    c: &LevelCriteria,
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if levels.not_finite() > 0 {
        warnings.push(Warning::Dropped { not_finite: levels.not_finite(), zero_frequency: 0 });
    }
    let moving = branch.line.moving_levels();
    if levels.std_error().is_none() && moving <= c.few_levels {
        warnings.push(Warning::FewLevels { moving });
    }
    let lowest = levels.drive().iter().copied().fold(f64::INFINITY, f64::min);
    if found.threshold.value > 0.0 && lowest > found.threshold.value {
        warnings.push(Warning::ThresholdExtrapolated { ratio: lowest / found.threshold.value });
    }
    let (p_value, falling) = branch.bend;
    let straight = p_value >= c.not_straight;
    if !straight {
        warnings.push(Warning::NotStraight { p_value, falling });
    }
    if let Some((plateau, kind)) = branch.plateau {
        warnings.push(Warning::LevelPlateau {
            reading: plateau.reading,
            levels: plateau.levels,
            in_squares: kind == OffsetKind::Quadrature,
            unit: levels.unit().to_owned(),
        });
    }
    // Not explained by a bend.
    if found.p_above_zero < c.above_zero && straight {
        let (reading, unit) = (branch.fit.parameters[0], levels.unit().to_owned());
        warnings.push(Warning::AboveZero { reading, p_value: found.p_above_zero, unit });
    }
    if !is_calibrated {
        warnings.push(Warning::DriveUncalibrated);
    }
    if let Some(b) = breakaway
        && let Some(stuck_at) = b.stuck_above_threshold
        && stuck_at >= b.moving_from
    {
        let unit = levels.drive_unit().to_owned();
        warnings.push(Warning::Hysteresis { stuck_at, moving_at: b.moving_from, unit });
    }
    warnings
}

/// Whether all numbers of an answer are finite; upper limits of quantities inverse to Q may be infinite.
fn is_finite(answer: &Answer) -> bool {
    let d = &answer.diagnostics;
    let figures = [answer.p_value, answer.correlation, d.residual_rms, d.bend_p_value].into_iter();
    let of_points = answer.points.iter().flat_map(|p| [p.std_error, p.fitted]);
    let of_parameters = answer
        .parameters
        .iter()
        .flat_map(|(_, q)| [q.value, q.std_error, q.unbounded_value, q.interval_95[0]]);
    let measured =
        [Parameter::Slope, Parameter::Threshold, Parameter::QFactor, Parameter::FRICTION_DISPLACEMENT];
    let highest = measured.iter().filter_map(|p| Some(answer.parameters.get(*p)?.interval_95[1]));
    figures.chain(of_points).chain(of_parameters).chain(highest).all(f64::is_finite)
}

fn check(options: &Options) -> Result<(), Error> {
    if let Some(hz) = options.frequency_hz {
        crate::model::oscillator::above_zero("frequency_hz", hz)?;
    }
    for (name, pair) in [("drive_gain", options.drive_gain), ("q_factor", options.q_factor)] {
        if let Some([value, std_error]) = pair {
            crate::model::oscillator::above_zero(name, value)?;
            crate::model::oscillator::at_least_zero(name, std_error)?;
        }
    }
    if let Some([q, _]) = options.q_factor
        && q <= LEAST_Q
    {
        return Err(Error::Parameter { name: "q_factor", value: q, range: "q_factor > 0.5 (underdamped)" });
    }
    if options.drive_gain.is_some() && options.q_factor.is_some() {
        return Err(Error::ConflictingParameters { first: "drive_gain", second: "q_factor" });
    }
    options.calibration.map_or(Ok(()), Calibration::check)?;
    if matches!(options.calibration, Some(Calibration::Mass { .. })) && options.frequency_hz.is_none() {
        return Err(Error::MissingParameter {
            name: "frequency_hz",
            hint: "the forces are calculated from the mass with it",
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::steady::scan;
    use crate::noise::jitter;
    use crate::{Calibration, Oscillator};
    use std::f64::consts::FRAC_PI_4;

    fn exact(q: f64, x_f: f64, drive: &[f64], noise: f64) -> Levels {
        let o =
            Oscillator::builder().frequency_hz(2.0).q_factor(q).friction_displacement(x_f).build().unwrap();
        let amplitude = drive
            .iter()
            .enumerate()
            .map(|(i, &d)| {
                let r = if d > 0.0 { scan::reading(&o, d, 2.0).unwrap().amplitude() } else { 0.0 };
                (r + noise * (((i * 7919) % 101) as f64 / 50.0 - 1.0)).abs()
            })
            .collect();
        Levels::builder(drive.to_vec(), amplitude).unit("mm").drive_unit("mm").build().unwrap()
    }

    /// Four readings at each of six levels, all moving. Formerly in a third of such records the lowest level was
    /// classified as stuck and counted as four levels that read a plateau; 22 of 100 thresholds were off by more than
    /// four standard errors.
    #[test]
    fn repeated_readings_stick_or_move_together() {
        let (mut held, mut runs) = (0, 0);
        for seed in 0..30 {
            for threshold in [0.05, 0.1, 0.15] {
                let drive: Vec<f64> = (0..24).map(|i| f64::from(i / 4 + 1) / 6.0).collect();
                let reading = |(i, x): (usize, &f64)| 10.0 * (x - threshold) + 0.03 * jitter(i, seed);
                let amplitude: Vec<f64> = drive.iter().enumerate().map(reading).collect();
                let levels = Levels::builder(drive, amplitude).build().unwrap();
                let answer = analyse(&levels, &Options::default()).unwrap();
                assert_eq!(answer.diagnostics.stuck % 4, 0, "{threshold} {seed}");
                assert!(!answer.warnings.iter().any(|w| w.code() == "level_plateau"), "{threshold} {seed}");
                let [low, high] = answer.parameter(Parameter::Threshold).unwrap().interval_95;
                held += usize::from(low <= threshold && threshold <= high);
                runs += 1;
            }
        }
        assert!(held >= runs * 90 / 100, "{held} of {runs}");
    }

    /// With a given Q, friction follows from the intercept: its interval covers the true value, and its correlation
    /// with the decay rate is due to the error of Q.
    #[test]
    fn a_given_q_leaves_intervals_that_hold_the_friction() {
        let drive: Vec<f64> = (0..8).map(|i| 0.6 + 0.2 * f64::from(i)).collect();
        let (q, threshold, noise) = (40.0, 0.5, 0.3);
        let truth = FRAC_PI_4 * threshold;
        let options = Options { q_factor: Some([q, 0.4]), frequency_hz: Some(2.0), ..Options::default() };
        let held = (0..400).filter(|&seed| {
            let assumed = q + 0.4 * jitter(seed, 9);
            let level = |(i, d): (usize, &f64)| q * (d - threshold) + noise * jitter(8 * seed + i, 10);
            let amplitude: Vec<f64> = drive.iter().enumerate().map(level).collect();
            let levels = Levels::builder(drive.clone(), amplitude).unit("mm").build().unwrap();
            let options = Options { q_factor: Some([assumed, 0.4]), ..options.clone() };
            let a = analyse(&levels, &options).unwrap();
            let [low, high] = a.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap().interval_95;
            (low..=high).contains(&truth)
        });
        let part = held.count() as f64 / 400.0;
        assert!((0.92..=0.98).contains(&part), "{part}");
        // Without any noise the error of Q is the whole error, to the last bit.
        let a = analyse(&exact(q, 0.4, &drive, 1e-6), &options).unwrap();
        let x_f = a.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap();
        assert!((0.0..=1.0).contains(&a.loss_correlation), "{}", a.loss_correlation);
        assert!(x_f.std_error >= x_f.value * 0.4 / q);
    }

    #[test]
    fn a_stiffness_gives_the_friction_force_without_a_frequency_and_a_mass_asks_for_one() {
        let levels = exact(100.0, 0.4, &[0.6, 0.7, 0.8, 0.9], 0.0);
        let stiffness = Calibration::Stiffness { value: 10.0, std_error: 0.1 };
        let a = analyse(&levels, &Options { calibration: Some(stiffness), ..Options::default() }).unwrap();
        let force = a.parameter(Parameter::CoulombForce).unwrap();
        assert!((force.value / 4e-3 - 1.0).abs() < 1e-3, "{force:?}");
        assert!(force.std_error > 0.99e-2 * force.value);
        assert!(a.parameter(Parameter::ViscousCoefficient).is_none());
        let mass = Calibration::Mass { value: 1.0, std_error: 0.0 };
        let refused = analyse(&levels, &Options { calibration: Some(mass), ..Options::default() });
        assert!(matches!(refused, Err(Error::MissingParameter { .. })), "{refused:?}");
    }

    #[test]
    fn a_calibration_below_zero_is_refused() {
        let levels = exact(100.0, 0.4, &[0.6, 0.7, 0.8, 0.9], 0.0);
        for calibration in [
            Calibration::Stiffness { value: 0.0, std_error: 0.0 },
            Calibration::Mass { value: -1.0, std_error: 0.0 },
            Calibration::Mass { value: 1.0, std_error: f64::NAN },
        ] {
            let options = Options { calibration: Some(calibration), ..Options::default() };
            let refused = analyse(&levels, &options);
            assert!(matches!(refused, Err(Error::Parameter { .. })), "{refused:?}");
        }
    }

    /// A Q whose interval includes zero gives no upper limit for the decay rate and the damping.
    #[test]
    fn a_vague_q_leaves_the_decay_rate_open() {
        let drive: Vec<f64> = (1..=20).map(|i| 0.1 * f64::from(i)).collect();
        let calibration = Some(Calibration::Mass { value: 2.0, std_error: 0.1 });
        let options = Options {
            frequency_hz: Some(2.0),
            q_factor: Some([50.0, 40.0]),
            calibration,
            ..Options::default()
        };
        let a = analyse(&exact(50.0, 0.4, &drive, 0.05), &options).unwrap();
        for parameter in [Parameter::DECAY_RATE, Parameter::ViscousCoefficient] {
            let q = a.parameter(parameter).unwrap();
            assert!(q.interval_95[0] > 0.0 && q.interval_95[0] < q.value, "{q:?}");
            assert!(q.interval_95[1].is_infinite() && q.value.is_finite(), "{q:?}");
        }
    }

    #[test]
    fn exact_levels_give_q_threshold_and_breakaway() {
        let drive: Vec<f64> = (1..=20).map(|i| 0.1 * f64::from(i)).collect();
        let options = Options { frequency_hz: Some(2.0), ..Options::default() };
        let a = analyse(&exact(50.0, 0.4, &drive, 0.05), &options).unwrap();
        let of = |parameter| a.parameter(parameter).unwrap();
        assert!((of(Parameter::QFactor).value - 50.0).abs() < 0.5, "{:?}", of(Parameter::QFactor));
        assert!((of(Parameter::FRICTION_DISPLACEMENT).value - 0.4).abs() < 0.01);
        assert!((of(Parameter::DECAY_RATE).value - TAU / 50.0).abs() < 2e-3);
        let b = a.breakaway.unwrap();
        // The threshold 4 x_F/pi = 0.509 lies between 0.5 and 0.6.
        assert!(b.stuck_below.unwrap() < 0.55, "{b:?}");
        assert!(b.moving_from > 0.5, "{b:?}");
        assert!(a.detected, "{:?}", a.warnings);
        assert!(a.warnings.is_empty(), "{:?}", a.warnings);
    }

    /// A level just above the threshold that is not part of the line. Formerly it was counted as moving, while the
    /// breakaway stated that the mass moves from the next level.
    #[test]
    fn counts_and_breakaway_say_the_same_of_a_level_beside_the_threshold() {
        let (mut seen, mut neither) = (0, 0);
        for seed in 0..40 {
            let drive: Vec<f64> = (2..=24).map(|i| 0.5 * f64::from(i)).collect();
            let at = |(i, d): (usize, &f64)| {
                let moving = 24.0 * (d - 1.914f64).max(0.0);
                (moving + 0.5 * jitter(i, 2 * seed)).hypot(0.5 * jitter(i, 2 * seed + 1))
            };
            let amplitude: Vec<f64> = drive.iter().enumerate().map(at).collect();
            let a =
                analyse(&Levels::builder(drive, amplitude).build().unwrap(), &Options::default()).unwrap();
            let (d, b) = (a.diagnostics, a.breakaway.unwrap());
            assert_eq!(d.moving + d.stuck + d.undecided, 23);
            assert_eq!(
                d.moving,
                a.points.iter().filter(|p| p.drive >= b.moving_from).count(),
                "{seed}: {b:?}"
            );
            let stuck = a.points.iter().filter(|p| b.stuck_below.is_some_and(|stuck| p.drive <= stuck));
            assert_eq!(d.stuck, stuck.count(), "{seed}: {b:?}");
            seen += usize::from(b.moving_from == 2.0);
            neither += d.undecided;
        }
        assert!(seen > 0 && neither > 0, "{seen} {neither}");
    }

    #[test]
    fn levels_on_a_line_to_the_last_digit_have_no_uncertainty() {
        let drive: Vec<f64> = (0..4).map(f64::from).collect();
        let amplitude = drive.iter().map(|d| (d - 1.0f64).max(0.0)).collect();
        let a = analyse(&Levels::builder(drive, amplitude).build().unwrap(), &Options::default()).unwrap();
        let threshold = a.parameter(Parameter::Threshold).unwrap();
        assert!(threshold.interval_95.iter().all(|v| (v - 1.0).abs() < 1e-6), "{threshold:?}");
    }

    #[test]
    fn levels_beyond_what_numbers_hold_are_refused() {
        let drive = vec![1e-300, 2e-300, 3e-300, 4e-300];
        let levels = Levels::builder(drive, vec![1e300, 2.1e300, 2.9e300, 4e300]).build().unwrap();
        assert!(matches!(analyse(&levels, &Options::default()), Err(Error::NoFit { .. })));
    }

    /// Levels raised, then lowered: stuck up to 0.8 on the way up, moving down to the threshold.
    #[test]
    fn levels_raised_and_lowered_are_told_apart_by_what_they_do() {
        let up: Vec<f64> = (1..=20).map(|i| 0.1 * f64::from(i)).collect();
        let drive: Vec<f64> = up.iter().chain(up.iter().rev()).copied().collect();
        let still = exact(50.0, 0.4, &drive, 0.05);
        let moves = |i: usize, d: f64| if i < 20 { d > 0.85 } else { d > 0.55 };
        let stuck = |i: usize| 0.02 + 0.001 * (i % 7) as f64;
        let amplitude = drive.iter().enumerate();
        let amplitude =
            amplitude.map(|(i, &d)| if moves(i, d) { still.amplitude()[i] } else { stuck(i) }).collect();
        let levels = Levels::builder(drive, amplitude).unit("mm").drive_unit("mm").build().unwrap();
        let a = analyse(&levels, &Options::default()).unwrap();
        assert!((a.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap().value - 0.4).abs() < 0.01);
        let b = a.breakaway.unwrap();
        assert!((b.moving_from - 0.6).abs() < 1e-9, "{b:?}");
        assert!((b.stuck_above_threshold.unwrap() - 0.8).abs() < 1e-9, "{b:?}");
        assert!((b.static_ratio_at_least.unwrap() - 2.0).abs() < 0.05, "{b:?}");
        assert!(a.warnings.iter().any(|w| w.code() == "hysteresis"), "{:?}", a.warnings);
        for p in &a.points {
            assert_eq!(p.moving, p.amplitude > 1.0, "{p:?}");
        }
    }

    /// Levels raised only: the mass moves from 0.9, far above the threshold of its line.
    #[test]
    fn a_mass_that_stuck_beyond_the_threshold_is_seen_without_a_way_back() {
        let drive: Vec<f64> = (1..=20).map(|i| 0.1 * f64::from(i)).collect();
        let free = exact(50.0, 0.4, &drive, 0.05);
        let amplitude = drive.iter().zip(free.amplitude());
        let amplitude = amplitude.map(|(&d, &a)| if d > 0.85 { a } else { 0.02 }).collect();
        let levels = Levels::builder(drive, amplitude).unit("mm").drive_unit("mm").build().unwrap();
        let a = analyse(&levels, &Options::default()).unwrap();
        assert!((a.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap().value - 0.4).abs() < 0.01);
        let b = a.breakaway.unwrap();
        assert_eq!(b.stuck_above_threshold, b.stuck_below);
        assert!((b.moving_from - 0.9).abs() < 1e-9, "{b:?}");
        assert!((b.stuck_below.unwrap() - 0.8).abs() < 1e-9, "{b:?}");
    }

    #[test]
    fn without_friction_the_threshold_is_an_upper_limit() {
        let drive: Vec<f64> = (1..=15).map(|i| 0.1 * f64::from(i)).collect();
        let a = analyse(&exact(50.0, 0.0, &drive, 0.2), &Options::default()).unwrap();
        let t = a.parameter(Parameter::Threshold).unwrap();
        assert!(!a.detected, "{t:?}");
        assert!(t.interval_95[0] == 0.0, "{t:?}");
        assert!(t.interval_95[1] > 0.0, "{t:?}");
    }

    #[test]
    fn a_drive_in_volts_gives_no_q_and_says_so() {
        // A gain of 1 mm/V over Q = 100, and the friction of a threshold of half a volt.
        let drive = [1.0, 2.0, 3.0, 4.0];
        let base = drive.map(|volts| 0.01 * volts);
        let amplitude = exact(100.0, FRAC_PI_4 * 0.005, &base, 0.0).amplitude().to_vec();
        let volts = Levels::builder(drive.to_vec(), amplitude);
        let volts = volts.unit("mm").drive_unit("V").build().unwrap();
        let a = analyse(&volts, &Options::default()).unwrap();
        assert!(a.parameter(Parameter::QFactor).is_none());
        assert!(a.warnings.iter().any(|w| w.code() == "drive_uncalibrated"));
        let options = Options { q_factor: Some([100.0, 1.0]), ..Options::default() };
        let a = analyse(&volts, &options).unwrap();
        assert!(
            (a.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap().value - FRAC_PI_4 * 0.005).abs() < 1e-9
        );
    }

    /// A slope of 0.02 between two voltages is not a Q of 0.02; between two lengths Q follows from the ratio of their
    /// units.
    #[test]
    fn one_unit_is_a_gain_where_it_is_a_length_or_an_angle() {
        let levels = |unit: &str, drive_unit: &str, slope: f64| {
            let drive: Vec<f64> = (0..8).map(|i| 1.0 + 0.5 * f64::from(i)).collect();
            let amplitude =
                drive.iter().enumerate().map(|(i, d)| slope * (d - 0.5) * (1.0 + 1e-4 * jitter(i, 3)));
            let amplitude = amplitude.collect();
            let levels = Levels::builder(drive, amplitude).unit(unit).drive_unit(drive_unit).build().unwrap();
            analyse(&levels, &Options::default()).unwrap()
        };
        for [unit, drive_unit] in [["V", "V"], ["Vrms", "Vrms"], ["\u{221a}mW", "\u{221a}mW"], ["", ""]] {
            for slope in [0.02, 50.0] {
                let a = levels(unit, drive_unit, slope);
                assert!(a.parameter(Parameter::QFactor).is_none(), "{unit}");
                assert!(a.parameter(Parameter::FRICTION_DISPLACEMENT).is_none(), "{unit}");
                assert!(a.warnings.iter().any(|w| w.code() == "drive_uncalibrated"), "{unit}");
            }
        }
        for (unit, drive_unit, slope) in
            [("cm", "mm", 5.0), ("mm", "mm", 50.0), ("nm", "mm", 50e6), ("mrad", "rad", 5e4)]
        {
            let a = levels(unit, drive_unit, slope);
            let of = |parameter| a.parameter(parameter).unwrap().value;
            assert!((of(Parameter::QFactor) / 50.0 - 1.0).abs() < 1e-3, "{unit} of {drive_unit}");
            let x_f = FRAC_PI_4 * 0.5 * slope / 50.0;
            assert!(
                (of(Parameter::FRICTION_DISPLACEMENT) / x_f - 1.0).abs() < 1e-2,
                "{unit} of {drive_unit}"
            );
        }
        let a = levels("nm", "mm", 50.0);
        assert!(a.parameter(Parameter::QFactor).is_none());
        assert!(a.warnings.iter().any(|w| w.code() == "drive_uncalibrated"));
    }

    #[test]
    fn a_q_without_a_resonance_is_refused() {
        let levels = exact(100.0, 0.4, &[0.6, 0.7, 0.8, 0.9], 0.0);
        for q in [0.1, 0.5] {
            let options = Options { q_factor: Some([q, 0.0]), ..Options::default() };
            let refused = analyse(&levels, &options);
            assert!(matches!(refused, Err(Error::Parameter { name: "q_factor", .. })), "{q}: {refused:?}");
        }
    }

    /// Amplitudes that determine no slope at small amplitudes; formerly it was reported as 0 ± 3e8 and as 2e13 ± 3e19.
    #[test]
    fn a_slope_is_determined_or_refused() {
        let shapes: [fn(f64) -> f64; 4] = [
            |d| (d - 0.2).max(0.0).sqrt(),
            |d| (d - 0.2).max(0.0).cbrt(),
            |d| (3.0 * d).tanh(),
            |d| (1.0 + 100.0 * d).ln(),
        ];
        let mut refused = 0;
        for shape in shapes {
            for count in [6, 8, 12, 20] {
                for (noise, seed) in [(1e-4, 1), (1e-2, 2), (1e-4, 3), (1e-2, 4)] {
                    let drive: Vec<f64> = (1..=count).map(|i| f64::from(i) / f64::from(count)).collect();
                    let read = |(i, d): (usize, &f64)| (shape(*d) + noise * jitter(i, seed)).abs();
                    let amplitude = drive.iter().enumerate().map(read).collect();
                    let levels = Levels::builder(drive, amplitude).build().unwrap();
                    match analyse(&levels, &Options::default()) {
                        Ok(answer) => {
                            let slope = answer.parameter(Parameter::Slope).unwrap();
                            assert!(slope.std_error < 10.0 * slope.value, "{count} {noise}: {slope:?}");
                        }
                        Err(Error::NoFit { .. }) => refused += 1,
                        Err(other) => panic!("{other}"),
                    }
                }
            }
        }
        assert!((1..=32).contains(&refused), "{refused} of 64");
    }

    #[test]
    fn what_does_not_rise_is_refused() {
        let flat = Levels::builder(vec![1.0, 2.0, 3.0, 4.0], vec![3.0, 2.0, 1.0, 0.5]).build().unwrap();
        assert!(analyse(&flat, &Options::default()).is_err());
    }
}
