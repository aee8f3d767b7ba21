//! Resonance curves from exact motion, good and bad, and measured ones if available.
#![allow(clippy::print_stderr, reason = "a skipped test says so")]

use slipfit::Calibration;
use slipfit::LossModel;
use slipfit::Parameter;
use slipfit::motion::steady::{Phasor, scan};
use slipfit::resonance::{Answer, Curve, DriveAmplitude, DriveSource, Method, Options, analyse};
use slipfit::{Error, Oscillator};
use std::f64::consts::PI;

/// Sum of twelve uniform numbers: close to normal, standard deviation 1.
struct Normal(u64);

impl Normal {
    fn next(&mut self) -> f64 {
        let mut even = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| even()).sum::<f64>() - 6.0
    }
}

fn oscillator(q: f64, x_f: f64) -> Oscillator {
    Oscillator::builder().frequency_hz(1.0).q_factor(q).friction_displacement(x_f).build().expect("in range")
}

/// Exact lock-in readings with noise, x_0 = 1.
fn sweep(
    o: &Oscillator,
    [low, high]: [f64; 2],
    points: u32,
    noise: f64,
    seed: u64,
) -> (Vec<f64>, Vec<Phasor>) {
    let mut n = Normal(seed);
    (0..points)
        .map(|i| {
            let hz = low + (high - low) * f64::from(i) / f64::from(points - 1);
            let z = scan::reading(o, 1.0, hz).expect("damped").fundamental;
            (hz, z + Phasor::new(noise * n.next(), noise * n.next()))
        })
        .unzip()
}

fn known() -> Options {
    let mut options = Options::default();
    options.drive_amplitude = Some(DriveAmplitude { value: 1.0, std_error: 0.0 });
    options
}

fn off(answer: &Answer, name: Parameter, truth: f64) -> f64 {
    let q = answer.parameter(name).expect("always reported");
    (q.unbounded_value - truth) / q.std_error
}

fn codes(answer: &Answer) -> Vec<&'static str> {
    answer.warnings.iter().map(|w| w.code()).collect()
}

#[test]
fn an_exact_curve_is_taken_apart_with_the_drive_known_or_from_a_reference() {
    let (hz, z) = sweep(&oscillator(50.0, 0.4), [0.93, 1.07], 81, 0.05, 1);
    let curve = Curve::complex(hz, z).unit("mm").build().unwrap();
    let mut options = known();
    options.calibration = Some(Calibration::Stiffness { value: 1000.0, std_error: 0.0 });
    let a = analyse(&curve, &options).unwrap();
    assert_eq!((a.model, a.drive_source), (LossModel::VISCOUS_SLIDING, DriveSource::Known));
    assert!(a.sliding.detected, "{:?}", a.sliding);
    for (name, truth) in [
        (Parameter::NaturalFrequency, 1.0),
        (Parameter::DECAY_RATE, PI / 50.0),
        (Parameter::FRICTION_DISPLACEMENT, 0.4),
    ] {
        assert!(off(&a, name, truth).abs() < 4.0, "{name} {:?}", a.parameter(name));
    }
    // 0.4 mm times 1 N/mm.
    assert!((a.parameter(Parameter::CoulombForce).unwrap().value - 0.4).abs() < 0.01);
    let line = a.force_line.as_ref().unwrap();
    assert!((line.friction_displacement.value - 0.4).abs() < 0.02);
    // Without friction the reference curve is higher.
    assert!(a.fit.friction_free(1.0).norm() > 1.5 * a.fit.response(1.0).norm());

    let (hz, z) = sweep(&oscillator(60.0, 0.0), [0.95, 1.05], 81, 0.05, 2);
    let mut options = Options::default();
    options.reference = Some(Curve::complex(hz, z).unit("mm").build().unwrap());
    let a = analyse(&curve, &options).unwrap();
    assert_eq!(a.drive_source, DriveSource::Reference);
    for (name, truth) in [(Parameter::DriveAmplitude, 1.0), (Parameter::FRICTION_DISPLACEMENT, 0.4)] {
        assert!(off(&a, name, truth).abs() < 4.0, "{name} {:?}", a.parameter(name));
    }
}

/// Simulated curves without noise: rounding shows no lag, background or delay, and the fit converges.
#[test]
fn an_exact_curve_is_described_without_a_warning() {
    let cases = [
        (10.0, 0.1, 201),
        (100.0, 0.0, 41),
        (100.0, 0.0, 2001),
        (100.0, 0.4, 201),
        (100.0, 0.4, 2001),
        (5000.0, 0.4, 41),
    ];
    for (q, x_f, points) in cases {
        let o = oscillator(q, x_f);
        let (hz, z) = sweep(&o, [1.0 - 1.0 / q, 1.0 + 1.0 / q], points, 0.0, 0);
        for options in [Options::default(), known()] {
            let curve = Curve::complex(hz.clone(), z.clone()).build().unwrap();
            let a = analyse(&curve, &options).unwrap();
            assert_eq!(codes(&a), [""; 0], "{q} {x_f}");
            assert!(a.comparison.iter().find(|c| c.model == a.model).unwrap().converged, "{q} {x_f}");
            let delta = a.parameter(Parameter::DECAY_RATE).unwrap().value;
            assert!((delta / o.decay_rate_per_s() - 1.0).abs() < 1e-9, "{q} {x_f}: {delta}");
            let found = a.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap().value;
            assert!((found - x_f).abs() < 1e-9, "{q} {x_f}: {found}");
        }
    }
}

/// Neighbouring points of a dense curve are averaged before fitting only as far as the noise hides the resulting
/// error.
#[test]
fn dense_curves_hold_the_truth_at_any_noise() {
    let (q, x_f) = (100.0, 0.4);
    let o = oscillator(q, x_f);
    for (points, noise) in [(2001, 1e-5), (5001, 1e-4), (5001, 0.03)] {
        let (hz, z) = sweep(&o, [0.96, 1.04], points, noise, u64::from(points));
        let curve = Curve::complex(hz, z).build().unwrap();
        let a = analyse(&curve, &known()).unwrap();
        assert_eq!(codes(&a), [""; 0], "{points} points, noise {noise}");
        for (name, truth) in
            [(Parameter::FRICTION_DISPLACEMENT, x_f), (Parameter::DECAY_RATE, o.decay_rate_per_s())]
        {
            assert!(off(&a, name, truth).abs() < 4.0, "{points}, {noise}: {:?}", a.parameter(name));
        }
    }
}

#[test]
fn amplitudes_and_curves_with_stops_do_as_well() {
    let o = oscillator(5.0, 0.7);
    let (hz, z) = sweep(&o, [0.5, 1.8], 61, 0.003, 3);
    let amplitude = z.iter().map(|z| z.norm()).collect();
    let curve = Curve::builder(hz, amplitude).build().unwrap();
    let a = analyse(&curve, &known()).unwrap();
    assert!(a.diagnostics.points_with_stops > 10);
    assert!(
        off(&a, Parameter::FRICTION_DISPLACEMENT, 0.7).abs() < 4.0,
        "{:?}",
        a.parameter(Parameter::FRICTION_DISPLACEMENT)
    );
    assert!(off(&a, Parameter::DECAY_RATE, PI / 5.0).abs() < 4.0);
}

#[test]
fn the_shape_alone_gives_a_wide_interval_that_holds_the_truth() {
    let truth = 0.2 * 4.0 / PI;
    let held = (1..=40)
        .filter(|&seed| {
            let (hz, z) = sweep(&oscillator(50.0, 0.2), [0.95, 1.05], 61, 0.2, 1000 * seed);
            let amplitude = z.iter().map(|z| z.norm()).collect();
            let a = analyse(&Curve::builder(hz, amplitude).build().unwrap(), &Options::default()).unwrap();
            let beta = a.parameter(Parameter::FrictionRatio).unwrap();
            assert!(codes(&a).contains(&"shape_alone"), "{:?}", codes(&a));
            beta.interval_95[0] <= truth && truth <= beta.interval_95[1]
        })
        .count();
    // Of 40 intervals of 95 %, fewer than 34 cover the true value with a probability of 0.3 %.
    assert!(held >= 34, "{held}");
}

#[test]
fn background_delay_and_turned_phases_are_found_and_said() {
    let (hz, z) = sweep(&oscillator(50.0, 0.3), [0.93, 1.07], 121, 0.02, 5);
    let bent: Vec<Phasor> = hz
        .iter()
        .zip(&z)
        .map(|(f, z)| {
            (z * Phasor::from_polar(1.0, 0.4 - 2.0 * PI * (f - 1.0) * 0.5) + Phasor::new(1.5, -2.0)).conj()
        })
        .collect();
    let a = analyse(&Curve::complex(hz, bent).build().unwrap(), &known()).unwrap();
    let codes = codes(&a);
    for code in ["phase_sign", "background", "delay"] {
        assert!(codes.contains(&code), "{code}: {codes:?}");
    }
    let delay = a.instrument.delay_s.as_ref().unwrap();
    assert!((delay.value - 0.5).abs() < 0.05, "{delay:?}");
    assert!(off(&a, Parameter::FRICTION_DISPLACEMENT, 0.3).abs() < 4.0);
}

#[test]
fn background_and_delay_are_told_in_either_order() {
    // The height is 100; the delays turn the phase by 0.04, 0.4 and 1.3 across half the sweep.
    let (hz, z) = sweep(&oscillator(200.0, 0.35), [0.98, 1.02], 201, 0.1, 9);
    for (turn, size) in [(0.04, 0.3), (0.04, 2.0), (0.4, 0.3), (0.4, 2.0), (1.3, 0.3), (1.3, 2.0)] {
        let delay_s = turn / (2.0 * PI * 0.02);
        for delayed in [false, true] {
            let background = Phasor::from_polar(size * 110.0, 2.5);
            let bent = hz.iter().zip(&z).map(|(f, z)| {
                let late = Phasor::from_polar(1.0, -2.0 * PI * f * delay_s);
                if delayed { (z + background) * late } else { z * late + background }
            });
            let a = analyse(&Curve::complex(hz.clone(), bent.collect()).build().unwrap(), &known()).unwrap();
            let said =
                format!("{turn} {size} {delayed}: {:?}", a.parameter(Parameter::FRICTION_DISPLACEMENT));
            assert!(off(&a, Parameter::FRICTION_DISPLACEMENT, 0.35).abs() < 4.0, "{said}");
            assert!(off(&a, Parameter::DECAY_RATE, PI / 200.0).abs() < 4.0, "{said}");
            let found = a.instrument.delay_s.as_ref().unwrap();
            assert!((found.value - delay_s).abs() < 5.0 * found.std_error, "{said} {found:?}");
            assert_eq!(a.instrument.background_delayed, delayed, "{said}");
        }
    }
}

#[test]
fn the_papers_inversion_comes_with_its_bias() {
    let (hz, z) = sweep(&oscillator(200.0, 0.3), [0.99, 1.01], 81, 0.01, 6);
    let curve = Curve::complex(hz, z).build().unwrap();
    let mut options = known();
    options.method = Method::Paper;
    let a = analyse(&curve, &options).unwrap();
    let paper = a.paper.unwrap();
    let found = a.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap().value;
    // The predicted bias is the actual one.
    assert!((found / 0.3 - 1.0 - paper.friction_bias.unwrap()).abs() < 0.02, "{found} {paper:?}");
    assert!(codes(&a).contains(&"paper_bias"));
    // Shares of the loss agree with the reported numbers.
    let ratio = a.parameter(Parameter::FrictionRatio).unwrap().value;
    assert!((a.sliding.share_at_highest - ratio).abs() < 0.05, "{:?} {ratio}", a.sliding);
    options.drive_amplitude = None;
    assert!(matches!(analyse(&curve, &options), Err(Error::MissingParameter { .. })));
}

/// The residuals are those of the Lorentzian whose parameters are reported; earlier they were those of the exact
/// motion, a fifth of that.
#[test]
fn the_residuals_beside_the_papers_numbers_are_those_of_its_lorentzian() {
    for phases in [true, false] {
        let (hz, z) = sweep(&oscillator(200.0, 0.3), [0.985, 1.015], 121, 0.05, 6);
        let measured: Vec<f64> = z.iter().map(|z| z.norm()).collect();
        let curve = if phases {
            Curve::complex(hz.clone(), z).build().unwrap()
        } else {
            Curve::builder(hz.clone(), measured.clone()).build().unwrap()
        };
        let mut options = known();
        let exact = analyse(&curve, &options).unwrap();
        options.method = Method::Paper;
        let a = analyse(&curve, &options).unwrap();
        // Eq. (14) with the numbers of the answer: eqs. (12) and (13) give its Q_f and x_f, with a = 4/3.
        let of = |name| a.parameter(name).unwrap().value;
        let (q, beta) = (of(Parameter::QFactor), of(Parameter::FrictionRatio));
        let q_f = q * (1.0 - 0.75 * beta);
        let x_f = (1.0 - beta) / (1.0 - 0.75 * beta);
        let by_hand = |hz: f64| {
            let r = hz / of(Parameter::NaturalFrequency);
            x_f / (1.0 - r * r).hypot(r / q_f)
        };
        let squares: f64 = hz.iter().zip(&measured).map(|(f, m)| (m - by_hand(*f)).powi(2)).sum();
        let rms = (squares / 118.0).sqrt();
        assert!((a.diagnostics.residual_rms / rms - 1.0).abs() < 1e-3, "{rms} {:?}", a.diagnostics);
        assert!(rms > 3.0 * exact.diagnostics.residual_rms, "{rms} {:?}", exact.diagnostics);
        assert!(a.diagnostics.residual_ratio() > 3.0 && a.diagnostics.residual_excess > 1.0);
        for p in &a.points {
            let fitted = by_hand(p.frequency_hz);
            assert!((p.fitted_amplitude / fitted - 1.0).abs() < 1e-6, "{p:?} {fitted}");
            assert!((p.residual - (p.amplitude - p.fitted_amplitude)).abs() < 1e-12, "{p:?}");
            assert!((a.fit.response(p.frequency_hz).norm() / fitted - 1.0).abs() < 1e-6, "{p:?}");
            assert_eq!((p.residual_across, p.phase_rad.is_some()), (0.0, phases));
        }
        // Without friction the base drives an oscillator with the reported Q.
        let peak = a.fit.friction_free(of(Parameter::NaturalFrequency)).norm();
        assert!((peak / q - 1.0).abs() < 1e-6, "{peak} {q}");
        assert_eq!(a.comparison, exact.comparison);
    }
}

#[test]
fn bad_curves_are_refused_or_flagged() {
    let o = oscillator(50.0, 0.2);
    let (hz, z) = sweep(&o, [0.95, 1.05], 61, 0.02, 7);
    let part = |range: std::ops::Range<usize>| {
        Curve::complex(hz[range.clone()].to_vec(), z[range].to_vec()).build().unwrap()
    };
    assert!(matches!(analyse(&part(0..3), &known()), Err(Error::TooFewPoints { .. })));
    if let Ok(a) = analyse(&part(0..25), &known()) {
        assert!(codes(&a).contains(&"one_flank"), "{:?}", codes(&a));
    }
    let mut flat = known();
    flat.band_hz = Some([5.0, 6.0]);
    assert!(matches!(analyse(&part(0..61), &flat), Err(Error::NoResonance { .. })));
    let zero = Curve::builder(vec![1.0, 2.0, 3.0, 4.0, 5.0], vec![0.0; 5]).build().unwrap();
    assert!(matches!(analyse(&zero, &known()), Err(Error::NoResonance { .. })));
    // Two lines.
    let two: Vec<f64> =
        hz.iter().zip(&z).map(|(f, z)| z.norm() + 20.0 * 2e-3 / (f - 1.035f64).hypot(2e-3)).collect();
    let a = analyse(&Curve::builder(hz.clone(), two).build().unwrap(), &Options::default()).unwrap();
    assert!(codes(&a).contains(&"second_peak"), "{:?}", codes(&a));
    // A reference of another resonator.
    let other = Oscillator::builder().frequency_hz(1.4).q_factor(50.0).build().unwrap();
    let (hz, z) = sweep(&other, [1.3, 1.5], 61, 0.02, 8);
    let mut options = Options::default();
    options.reference = Some(Curve::complex(hz, z).build().unwrap());
    let a = analyse(&part(0..61), &options).unwrap();
    assert!(codes(&a).contains(&"reference_differs"), "{:?}", codes(&a));
}

/// The curve with a background of this part of the peak, at this angle.
fn raised(z: &[Phasor], relative: f64, degrees: f64) -> Vec<Phasor> {
    let peak = z.iter().map(|z| z.norm()).fold(0.0, f64::max);
    z.iter().map(|z| z + Phasor::from_polar(relative * peak, degrees.to_radians())).collect()
}

#[test]
fn a_large_crosstalk_keeps_its_phases() {
    let o = oscillator(500.0, 0.15);
    for (relative, degrees) in [(0.12, 300.0), (0.2, 120.0), (0.5, 0.0), (1.0, 90.0), (3.0, 200.0)] {
        let (hz, z) = sweep(&o, [0.992, 1.008], 161, 1.0, 11);
        let z = raised(&z, relative, degrees);
        let amplitude = z.iter().map(|z| z.norm()).collect();
        let phase = z.iter().map(|z| z.arg()).collect();
        let parts = Curve::complex(hz.clone(), z).build().unwrap();
        let polar = Curve::builder(hz, amplitude).phase_rad(phase).build().unwrap();
        for curve in [parts, polar] {
            let a = analyse(&curve, &Options::default()).unwrap();
            assert!(!codes(&a).contains(&"phases_ignored"), "{relative}: {:?}", codes(&a));
            assert!(a.instrument.background.is_some(), "{relative}: {:?}", codes(&a));
            assert!(a.sliding.detected, "{relative}: {:?}", codes(&a));
            assert!(a.instrument.delay_s.is_none(), "{relative}: {:?}", a.instrument);
            for (name, truth) in [(Parameter::FRICTION_DISPLACEMENT, 0.15), (Parameter::DriveAmplitude, 1.0)]
            {
                assert!(off(&a, name, truth).abs() < 4.0, "{relative} {name}: {:?}", a.parameter(name));
            }
        }
    }
}

/// The residual of a fit that follows only the background is small compared with the highest amplitude.
#[test]
fn a_narrow_line_on_a_high_background_is_found() {
    let o = oscillator(400.0, 0.0);
    for (seed, angle) in [(41, 0.3), (42, 1.9), (43, 3.7), (44, 5.2)] {
        // 2 % of the height of the line, Q x_0.
        let (hz, mut z) = sweep(&o, [0.9, 1.1], 401, 8.0, seed);
        z.iter_mut().for_each(|z| *z += Phasor::from_polar(0.6 * 400.0, angle));
        let answer =
            analyse(&Curve::complex(hz, z).build().expect("fits"), &Options::default()).expect("fits");
        assert!(codes(&answer).contains(&"background"), "{angle}: {:?}", codes(&answer));
        let f_0 = answer.parameter(Parameter::NaturalFrequency).expect("always reported");
        assert!((f_0.value - 1.0).abs() < 3e-4, "{angle}: {f_0:?}");
        assert!(!answer.sliding.detected, "{angle}");
    }
}

#[test]
fn folded_phases_are_left_aside_and_real_and_imaginary_parts_never() {
    let (hz, z) = sweep(&oscillator(50.0, 0.3), [0.93, 1.07], 121, 0.02, 12);
    let amplitude: Vec<f64> = z.iter().map(|z| z.norm()).collect();
    let folded = z.iter().map(|z| (3.0 * z.arg()).sin().abs()).collect();
    let a = analyse(&Curve::builder(hz.clone(), amplitude).phase_rad(folded).build().unwrap(), &known());
    let a = a.unwrap();
    assert!(codes(&a).contains(&"phases_ignored"), "{:?}", codes(&a));
    assert!(off(&a, Parameter::FRICTION_DISPLACEMENT, 0.3).abs() < 4.0);
    let folded = z.iter().map(|z| Phasor::from_polar(z.norm(), (3.0 * z.arg()).sin().abs())).collect();
    let a = analyse(&Curve::complex(hz, folded).build().unwrap(), &known()).unwrap();
    assert!(!codes(&a).contains(&"phases_ignored"), "{:?}", codes(&a));
}

#[test]
fn a_delay_of_many_turns_is_found() {
    let (hz, z) = sweep(&oscillator(500.0, 0.15), [0.992, 1.008], 161, 1.0, 13);
    for (turns, background) in [(0.3, 0.3), (1.0, 0.0), (3.0, 0.0), (-3.0, 0.4)] {
        let delay = turns / 0.016;
        let turned: Vec<Phasor> = hz
            .iter()
            .zip(raised(&z, 0.0, 0.0))
            .map(|(f, z)| z * Phasor::from_polar(1.0, -2.0 * PI * (f - 1.0) * delay))
            .collect();
        let curve = Curve::complex(hz.clone(), raised(&turned, background, 70.0)).build().unwrap();
        for asked in [None, Some(true)] {
            let mut options = Options::default();
            options.terms.delay = asked;
            let a = analyse(&curve, &options).unwrap();
            let found = a.instrument.delay_s.as_ref().unwrap();
            assert!((found.value - delay).abs() < 4.0 * found.std_error, "{turns}: {found:?} {delay}");
            assert!(off(&a, Parameter::FRICTION_DISPLACEMENT, 0.15).abs() < 4.0, "{turns} {asked:?}");
        }
    }
}

#[test]
fn what_holds_no_line_is_no_resonance() {
    let hz: Vec<f64> = (0..201).map(|i| 0.95 + 5e-4 * f64::from(i)).collect();
    let mut n = Normal(14);
    let noise: Vec<f64> = hz.iter().map(|_| (5.0 + n.next()).abs()).collect();
    let parts: Vec<Phasor> = hz.iter().map(|_| Phasor::new(n.next(), n.next())).collect();
    let mut spike = noise.clone();
    spike[80] += 200.0;
    let of = |a: Vec<f64>| analyse(&Curve::builder(hz.clone(), a).build().unwrap(), &Options::default());
    for (what, answer) in [
        ("constant", of(vec![3.0; hz.len()])),
        ("noise", of(noise)),
        ("spike", of(spike)),
        ("complex noise", analyse(&Curve::complex(hz.clone(), parts).build().unwrap(), &Options::default())),
    ] {
        assert!(matches!(answer, Err(Error::NoResonance { .. })), "{what}: {answer:?}");
    }
    // A line eight times as high as the noise is a resonance.
    let (hz, z) = sweep(&oscillator(50.0, 0.0), [0.93, 1.07], 201, 6.0, 15);
    assert!(analyse(&Curve::complex(hz, z).build().unwrap(), &Options::default()).is_ok());
}

#[test]
fn a_drive_that_changes_from_point_to_point_is_no_jump() {
    let o = oscillator(500.0, 0.15);
    let (hz, _) = sweep(&o, [0.992, 1.008], 161, 0.0, 1);
    let mut n = Normal(16);
    let alternating: Vec<f64> = (0..hz.len()).map(|i| if i % 2 == 0 { 1.0 } else { 0.6 }).collect();
    let once: Vec<f64> = (0..hz.len()).map(|i| if i < 85 { 1.0 } else { 0.6 }).collect();
    for (drive, mean) in [(alternating, 0.8 + 0.2 / 161.0), (once, 0.6 + 0.4 * 85.0 / 161.0)] {
        let z: Vec<Phasor> = hz
            .iter()
            .zip(&drive)
            .map(|(f, level)| {
                scan::reading(&o, *level, *f).unwrap().fundamental + Phasor::new(n.next(), n.next())
            })
            .collect();
        let amplitude: Vec<f64> = z.iter().map(|z| z.norm()).collect();
        let parts = Curve::complex(hz.clone(), z).drive(drive.clone()).build().unwrap();
        let amplitudes = Curve::builder(hz.clone(), amplitude).drive(drive).build().unwrap();
        for curve in [parts, amplitudes] {
            let a = analyse(&curve, &Options::default()).unwrap();
            for code in ["jump", "second_peak", "few_points_in_line"] {
                assert!(!codes(&a).contains(&code), "{:?}", codes(&a));
            }
            assert!((a.mean_drive.unwrap() - mean).abs() < 1e-9);
            assert!(
                off(&a, Parameter::DriveAmplitude, mean).abs() < 4.0,
                "{:?}",
                a.parameter(Parameter::DriveAmplitude)
            );
            let widths = a.diagnostics.line_widths;
            assert!((4.5..8.0).contains(&widths), "{widths}");
        }
    }
}

/// `(1 - (omega/omega_0)² + lean A²) A` and the losses balanced with a drive of 1, on the branch nearest to the
/// previous amplitude.
fn bent(f: f64, q: f64, x_f: f64, lean: f64, drag: f64, before: f64) -> (f64, Phasor) {
    let parts =
        |a: f64| Phasor::new((1.0 - f * f + lean * a * a) * a, f * a / q + 4.0 * x_f / PI + drag * a * a);
    let excess = |a: f64| parts(a).norm_sqr() - 1.0;
    let grid = |i: usize| 1.2 * q * i as f64 / 20_000.0;
    let mut best = (f64::INFINITY, 0.0);
    for i in 1..20_000 {
        let (mut low, mut high) = (grid(i), grid(i + 1));
        if excess(low) * excess(high) > 0.0 {
            continue;
        }
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if excess(low) * excess(middle) <= 0.0 { high = middle } else { low = middle }
        }
        if (low - before).abs() < best.0 {
            best = ((low - before).abs(), low);
        }
    }
    (best.1, best.1 / parts(best.1))
}

fn bent_sweep(hz: &[f64], x_f: f64, lean: f64, drag: f64, noise: f64, n: &mut Normal) -> Vec<Phasor> {
    let mut before = 0.0;
    hz.iter()
        .map(|&f| {
            let (a, z) = bent(f, 100.0, x_f, lean, drag, before);
            before = a;
            z + Phasor::new(noise * n.next(), noise * n.next())
        })
        .collect()
}

#[test]
fn drag_is_a_loss_and_no_misfit() {
    let hz: Vec<f64> = (0..101).map(|i| 0.97 + 6e-4 * f64::from(i)).collect();
    let z = bent_sweep(&hz, 0.1, 0.0, 5e-5, 0.1, &mut Normal(17));
    let a = analyse(&Curve::complex(hz, z).build().unwrap(), &Options::default()).unwrap();
    assert_eq!(a.model, LossModel::VISCOUS_SLIDING_DRAG);
    assert!(!codes(&a).iter().any(|c| ["model_misfit", "delay", "background", "leaning"].contains(c)));
    let d = &a.diagnostics;
    assert!(d.residual_excess < 1.2, "{d:?}");
    assert!((d.residual_rms / d.noise_rms - 1.0).abs() < 0.2, "{d:?}");
    assert!(
        (off(&a, Parameter::DRAG_RATE, 5e-5 * PI)).abs() < 4.0,
        "{:?}",
        a.parameter(Parameter::DRAG_RATE)
    );
    assert!(off(&a, Parameter::FRICTION_DISPLACEMENT, 0.1).abs() < 4.0);
}

/// Drag and a nonlinear spring belong to the oscillator, with the contact or without it.
#[test]
fn curve_and_reference_share_drag_and_duffing_term() {
    let hz: Vec<f64> = (0..81).map(|i| 0.97 + 7.5e-4 * f64::from(i)).collect();
    for (lean, drag, x_f, term) in [
        (0.0, 5e-5, 0.2, Parameter::DRAG_RATE),
        (0.0, 5e-5, 0.6, Parameter::DRAG_RATE),
        (2e-7, 0.0, 0.2, Parameter::DuffingCoefficient),
    ] {
        let mut n = Normal(23);
        let curve = bent_sweep(&hz, x_f, lean, drag, 0.2, &mut n);
        let reference = bent_sweep(&hz, 0.0, lean, drag, 0.2, &mut n);
        let [curve, reference] = [curve, reference].map(|z| Curve::complex(hz.clone(), z).build().unwrap());
        let mut options = Options::default();
        options.reference = Some(reference);
        let a = analyse(&curve, &options).unwrap();
        assert!(a.parameter(term).is_some(), "{lean} {drag} {x_f}: {:?}", a.model);
        for (name, truth) in [
            (Parameter::DECAY_RATE, PI / 100.0),
            (Parameter::FRICTION_DISPLACEMENT, x_f),
            (Parameter::DriveAmplitude, 1.0),
            (Parameter::NaturalFrequency, 1.0),
        ] {
            assert!(off(&a, name, truth).abs() < 4.0, "{lean} {drag} {x_f}: {name} {:?}", a.parameter(name));
        }
        assert!(
            !codes(&a).iter().any(|c| ["model_misfit", "reference_slides"].contains(c)),
            "{:?}",
            codes(&a)
        );
    }
}

#[test]
fn a_jump_at_another_place_up_than_down_is_seen() {
    let mut hz: Vec<f64> = (0..101).map(|i| 0.97 + 6e-4 * f64::from(i)).collect();
    let mut n = Normal(18);
    let mut z = bent_sweep(&hz, 0.1, 6e-6, 0.0, 0.1, &mut n);
    let down: Vec<f64> = hz.iter().rev().copied().collect();
    z.extend(bent_sweep(&down, 0.1, 6e-6, 0.0, 0.1, &mut n));
    hz.extend(down);
    let amplitude: Vec<f64> = z.iter().map(|z| z.norm()).collect();
    let parts = Curve::complex(hz.clone(), z).build().unwrap();
    for curve in [parts, Curve::builder(hz, amplitude).build().unwrap()] {
        let a = analyse(&curve, &Options::default()).unwrap();
        assert!(codes(&a).contains(&"jump"), "{:?}", codes(&a));
        assert!(!codes(&a).contains(&"second_peak"), "{:?}", codes(&a));
        assert!(
            a.warnings
                .iter()
                .any(|w| w.to_string().contains("different frequencies in upward and downward sweeps"))
        );
        // The plotted curve stays on one branch: it falls once.
        let drawn: Vec<f64> = (0..600).map(|i| a.fit.response(0.971 + 1e-4 * f64::from(i)).norm()).collect();
        let jumps = drawn.windows(2).filter(|w| (w[1] - w[0]).abs() > 15.0).count();
        assert!(jumps <= 1, "{jumps}");
    }
}

#[test]
fn second_peaks_are_looked_for_beside_the_background() {
    // A Fano shape is one line.
    let (hz, z) = sweep(&oscillator(500.0, 0.1), [0.985, 1.015], 201, 0.5, 19);
    let fano = Curve::complex(hz.clone(), raised(&z, 1.0, 0.0)).build().unwrap();
    let a = analyse(&fano, &Options::default()).unwrap();
    assert!(!codes(&a).contains(&"second_peak"), "{:?}", codes(&a));
    assert!(!codes(&a).contains(&"jump"), "{:?}", codes(&a));
    // Two lines on a background five times as high.
    let two: Vec<Phasor> =
        hz.iter().zip(&z).map(|(f, z)| z + Phasor::new(0.3, 0.0) / Phasor::new(f - 1.011, -1e-3)).collect();
    let a =
        analyse(&Curve::complex(hz, raised(&two, 5.0, 40.0)).build().unwrap(), &Options::default()).unwrap();
    assert!(codes(&a).contains(&"second_peak"), "{:?}", codes(&a));
}

#[test]
fn amplitudes_on_a_background_have_intervals_that_hold_the_truth() {
    let o = oscillator(500.0, 0.15);
    let beta = 0.15 * 4.0 / PI;
    let held = (1..=20)
        .filter(|&seed| {
            let (hz, z) = sweep(&o, [0.992, 1.008], 161, 1.0, 3000 * seed);
            let amplitude = raised(&z, 0.2, 300.0).iter().map(|z| z.norm()).collect();
            let a = analyse(&Curve::builder(hz, amplitude).build().unwrap(), &Options::default()).unwrap();
            let said = a.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
            assert!(!codes(&a).contains(&"leaning"), "{said}");
            assert!(
                !codes(&a).contains(&"background")
                    || said.contains("amplitudes alone do not separate it from friction")
            );
            let q = a.parameter(Parameter::FrictionRatio).unwrap();
            let x_0 = a.parameter(Parameter::DriveAmplitude).unwrap();
            q.interval_95[0] <= beta
                && beta <= q.interval_95[1]
                && x_0.interval_95[0] <= 1.0
                && 1.0 <= x_0.interval_95[1]
        })
        .count();
    // Of 20 intervals of 95 %, fewer than 16 cover the true value with a probability of 0.3 %.
    assert!(held >= 16, "{held}");
}
