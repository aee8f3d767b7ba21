//! Resonance curves from exact motion, good and bad, and the real ones where they are at hand.
#![allow(clippy::print_stderr, reason = "a skipped test says so")]

use slipfit::resonance::{Answer, Curve, DriveAmplitude, DriveSource, Method, Options, analyse};
use slipfit::ringdown::{Calibration, LossModel};
use slipfit::steady::{Phasor, scan};
use slipfit::{Error, Oscillator};
use std::f64::consts::PI;
use std::path::PathBuf;

/// Sum of twelve even numbers: as good as normal, deviation 1.
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

fn off(answer: &Answer, name: &str, truth: f64) -> f64 {
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
    assert_eq!((a.model, a.drive_source), (LossModel::ViscousSliding, DriveSource::Known));
    assert!(a.sliding.detected && a.sentence().contains("excluded"), "{}", a.sentence());
    for (name, truth) in
        [("natural_frequency_hz", 1.0), ("decay_rate_per_s", PI / 50.0), ("friction_displacement", 0.4)]
    {
        assert!(off(&a, name, truth).abs() < 4.0, "{name} {:?}", a.parameter(name));
    }
    // 0.4 mm times 1 N/mm.
    assert!((a.parameter("coulomb_force").unwrap().value - 0.4).abs() < 0.01);
    let line = a.force_line.as_ref().unwrap();
    assert!((line.friction_displacement.value - 0.4).abs() < 0.02);
    // Without friction the ghost is higher.
    assert!(a.fit.friction_free(1.0).norm() > 1.5 * a.fit.response(1.0).norm());

    let (hz, z) = sweep(&oscillator(60.0, 0.0), [0.95, 1.05], 81, 0.05, 2);
    let mut options = Options::default();
    options.reference = Some(Curve::complex(hz, z).unit("mm").build().unwrap());
    let a = analyse(&curve, &options).unwrap();
    assert_eq!(a.drive_source, DriveSource::Reference);
    for (name, truth) in [("drive_amplitude", 1.0), ("friction_displacement", 0.4)] {
        assert!(off(&a, name, truth).abs() < 4.0, "{name} {:?}", a.parameter(name));
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
    assert!(off(&a, "friction_displacement", 0.7).abs() < 4.0, "{:?}", a.parameter("friction_displacement"));
    assert!(off(&a, "decay_rate_per_s", PI / 5.0).abs() < 4.0);
}

#[test]
fn the_shape_alone_gives_a_wide_interval_that_holds_the_truth() {
    let truth = 0.2 * 4.0 / PI;
    let held = (1..=40)
        .filter(|&seed| {
            let (hz, z) = sweep(&oscillator(50.0, 0.2), [0.95, 1.05], 61, 0.2, 1000 * seed);
            let amplitude = z.iter().map(|z| z.norm()).collect();
            let a = analyse(&Curve::builder(hz, amplitude).build().unwrap(), &Options::default()).unwrap();
            let beta = a.parameter("friction_ratio").unwrap();
            assert!(codes(&a).contains(&"shape_alone"), "{:?}", codes(&a));
            beta.interval_95[0] <= truth && truth <= beta.interval_95[1]
        })
        .count();
    // Of 40 intervals of 95 % fewer than 34 hold with a probability of 0.3 %.
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
    assert!(off(&a, "friction_displacement", 0.3).abs() < 4.0);
}

#[test]
fn the_papers_inversion_comes_with_its_bias() {
    let (hz, z) = sweep(&oscillator(200.0, 0.3), [0.99, 1.01], 81, 0.01, 6);
    let curve = Curve::complex(hz, z).build().unwrap();
    let mut options = known();
    options.method = Method::Paper;
    let a = analyse(&curve, &options).unwrap();
    let paper = a.paper.unwrap();
    let found = a.parameter("friction_displacement").unwrap().value;
    // The bias foretold is the one made.
    assert!((found / 0.3 - 1.0 - paper.friction_bias.unwrap()).abs() < 0.02, "{found} {paper:?}");
    assert!(codes(&a).contains(&"paper_bias"));
    options.drive_amplitude = None;
    assert!(matches!(analyse(&curve, &options), Err(Error::MissingParameter { .. })));
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

fn real(name: &str) -> Option<Vec<Vec<f64>>> {
    let default = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("SLIPFIT_REAL_DATA").map_or(default, PathBuf::from);
    let path = folder.join("sweep").join(name);
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: {} is not here", path.display());
        return None;
    };
    let rows = text.lines().skip(1);
    Some(rows.map(|l| l.split(',').map(|v| v.trim().parse().unwrap_or(f64::NAN)).collect()).collect())
}

fn column(rows: &[Vec<f64>], k: usize) -> Vec<f64> {
    rows.iter().map(|r| r[k]).collect()
}

#[test]
fn the_pohl_wheel_agrees_with_its_ring_down() {
    let Some(rows) = real("pohl_forced_400mA.csv") else { return };
    let phase = column(&rows, 2).iter().map(|p| p.to_radians()).collect();
    let curve =
        Curve::builder(column(&rows, 0), column(&rows, 1)).phase_rad(phase).unit("rad").build().unwrap();
    let a = analyse(&curve, &Options::default()).unwrap();
    let within = |name: &str, low: f64, high: f64| {
        let v = a.parameter(name).unwrap().value;
        assert!((low..=high).contains(&v), "{name} = {v}");
    };
    within("natural_frequency_hz", 0.5208, 0.5218);
    within("decay_rate_per_s", 0.203, 0.213);
    within("friction_displacement", 1.6e-3, 3.4e-3);
    within("drive_amplitude", 0.061, 0.064);
}

#[test]
fn the_torsion_pendulum_has_its_q_and_the_wheel_its_jump() {
    if let Some(rows) = real("torsion_forced.csv") {
        let phase = column(&rows, 2).iter().map(|p| p.to_radians()).collect();
        let curve = Curve::builder(column(&rows, 0), column(&rows, 1)).phase_rad(phase).build().unwrap();
        let a = analyse(&curve, &Options::default()).unwrap();
        let q = a.parameter("q_factor").unwrap();
        assert!((q.value - 61.0).abs() < 4.0, "{q:?}");
        assert!((a.parameter("natural_frequency_hz").unwrap().value - 0.9565).abs() < 1e-3);
    }
    if let Some(rows) = real("wheel_period_amplitude_jump.csv") {
        let hz = column(&rows, 0).iter().map(|t| 1.0 / t).collect();
        let a = analyse(&Curve::builder(hz, column(&rows, 1)).build().unwrap(), &Options::default()).unwrap();
        assert!(codes(&a).contains(&"jump"), "{:?}", codes(&a));
    }
}
