//! The exact steady motion compared with forty-digit references, and with itself by other methods.

#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use proptest::prelude::*;
use slipfit::Oscillator;
use slipfit::motion::simulate::{Drive, Motion};
use slipfit::motion::steady::exact::ClosedForm;
use slipfit::motion::steady::orbit::{OrbitOptions, PeriodicOrbit};
use slipfit::motion::steady::{HarmonicDrive, Method, SolutionMethod, SteadyState, solve};
use std::f64::consts::PI;

const STEADY: &str = include_str!("../reference/motion/steady.txt");

#[test]
fn the_closed_form_has_all_its_digits() {
    let mut count = 0;
    for line in STEADY.lines().filter(|l| !l.starts_with('#')) {
        let row: Vec<f64> = line.split_whitespace().map(|w| w.parse().unwrap()).collect();
        let [delta, x_f, omega, turn, fundamental, phi, lag] = row[..] else { panic!("{line}") };
        let o = Oscillator::kinematic(1.0, delta, x_f).unwrap();
        let drive = HarmonicDrive::new(1.0, omega).unwrap();
        let closed = ClosedForm::new(&o, &drive).unwrap();
        assert!(closed.holds(), "{line}");
        let state = SteadyState::new(&o, &drive, Method::Exact).unwrap();
        // Near beta = 1 the amplitude is a difference of larger numbers.
        let lost = 1.0 + 1.0 / (delta.max(1e-12) * turn).min(1.0);
        assert!((closed.amplitude() / turn - 1.0).abs() < 2e-14 * lost, "{line} {}", closed.amplitude());
        assert!((state.harmonic(1).norm() / fundamental - 1.0).abs() < 2e-14 * lost, "{line}");
        assert!(
            (closed.fundamental_phase() - phi).abs() < 1e-14 * lost,
            "{line} {}",
            closed.fundamental_phase()
        );
        assert!((state.phase_lag() - lag).abs() < 1e-13, "{line} {}", state.phase_lag());
        count += 1;
    }
    assert_eq!(count, 11);
}

#[test]
fn the_printed_values_of_the_design_are_met_to_all_digits() {
    for (beta, omega, turn, fundamental, phi) in [
        (0.5, 0.97, 11.710597420, 11.711559, 0.01140),
        (0.9, 0.97, 4.205794275, 4.213011, 0.05705),
        (0.9, 1.00, 4.999167695, 5.004554, 0.04497),
        (0.9, 1.01, 4.543802247, 4.549452, 0.04843),
        (0.8, 1.03, 5.939079777, 5.942308, 0.03160),
    ] {
        let o = Oscillator::physical(1.0, 0.02, 1.0, beta * PI / 4.0).unwrap();
        let closed = ClosedForm::new(&o, &HarmonicDrive::new(1.0, omega).unwrap()).unwrap();
        assert!((closed.amplitude() - turn).abs() <= 5.1e-10);
        assert!((closed.harmonic(1).norm() - fundamental).abs() <= 5.1e-7);
        assert!((closed.fundamental_phase() - phi).abs() <= 5.1e-6);
    }
}

#[test]
fn the_three_ways_agree_with_and_without_stops() {
    for (q, x_f, x_s, omega) in
        [(50.0, 0.5, 0.5, 0.97), (5.0, 0.3, 0.3, 1.1), (10.0, 0.4, 0.55, 0.4), (3.0, 0.6, 0.6, 0.25)]
    {
        let o = Oscillator::builder()
            .omega_0(1.0)
            .q_factor(q)
            .friction_displacement(x_f)
            .static_displacement(x_s)
            .build()
            .unwrap();
        let drive = HarmonicDrive::new(1.0, omega).unwrap();
        let found = solve(&o, &drive).unwrap();
        let orbit = PeriodicOrbit::find(&o, &drive, OrbitOptions::default()).unwrap();
        let settled = (400.0 * q * omega / 2.0 / PI).ceil().min(3000.0) * drive.period_s();
        let mut long = Motion::new(&o, Drive::harmonic(1.0, omega).unwrap(), 0.0, 0.0, 0.0).unwrap();
        for i in 0..50 {
            let t = drive.period_s() * f64::from(i) / 50.0;
            let (x, v) = found.state.state(t);
            let (y, w) = orbit.state(t);
            let s = long.state_at(settled + t).unwrap();
            let size = found.state.amplitude();
            // The settling time is itself rounded to a double: its phase is accurate to 1e-12.
            assert!((x - y).abs() < 1e-12 * size, "{q} {omega} {x} {y}");
            assert!((v - w).abs() < 1e-12 * size, "{q} {omega} {x} {y}");
            assert!((x - s.position).abs() < 1e-10 * size, "{q} {omega} {x} {s:?}");
        }
        assert!(found.residual < 1e-12);
        assert_eq!(found.method == SolutionMethod::ClosedForm, orbit.stops() == 0);
        // A motion reached by settling is stable; the multipliers must show it.
        assert!(orbit.is_stable(), "{:?}", orbit.multipliers());
        if orbit.stops() > 0 {
            assert!(orbit.multipliers().iter().any(|m| m.norm() < 1e-12));
        }
    }
}

#[test]
fn multipliers_are_the_rate_at_which_a_disturbance_dies() {
    let o = Oscillator::kinematic(1.0, 0.02, 0.3).unwrap();
    let drive = HarmonicDrive::new(1.0, 1.05).unwrap();
    let orbit = PeriodicOrbit::find(&o, &drive, OrbitOptions::default()).unwrap();
    let (x, v) = orbit.start();
    let tone = Drive::harmonic(1.0, 1.05).unwrap();
    let run = |dx: f64, dv: f64| {
        let s =
            Motion::new(&o, tone.clone(), 0.0, x + dx, v + dv).unwrap().state_at(drive.period_s()).unwrap();
        (s.position, s.velocity)
    };
    let h = 1e-6;
    let ((a, c), (al, cl)) = (run(h, 0.0), run(-h, 0.0));
    let ((b, d), (bl, dl)) = (run(0.0, h), run(0.0, -h));
    let m = [[(a - al) / 2.0 / h, (b - bl) / 2.0 / h], [(c - cl) / 2.0 / h, (d - dl) / 2.0 / h]];
    let exact = Motion::new(&o, tone.clone(), 0.0, x, v).unwrap().tangent(drive.period_s()).matrix;
    for i in 0..2 {
        for j in 0..2 {
            assert!((m[i][j] - exact[i][j]).abs() < 1e-8, "{m:?} {exact:?}");
        }
    }
    let product = (orbit.multipliers()[0] * orbit.multipliers()[1]).re;
    assert!((product - (m[0][0] * m[1][1] - m[0][1] * m[1][0])).abs() < 1e-8);
}

#[test]
fn the_jacobian_through_stops_and_releases_is_the_difference_quotient() {
    let o = Oscillator::builder()
        .omega_0(1.0)
        .q_factor(8.0)
        .friction_displacement(0.4)
        .static_displacement(0.5)
        .build()
        .unwrap();
    let tone = Drive::harmonic(1.0, 0.45).unwrap();
    let until = 25.0;
    let run = |x: f64, v: f64| Motion::new(&o, tone.clone(), 0.0, x, v).unwrap().state_at(until).unwrap();
    let (x, v, h) = (1.3, 0.4, 1e-6);
    let m = Motion::new(&o, tone.clone(), 0.0, x, v).unwrap().tangent(until).matrix;
    let (p, n) = (run(x + h, v), run(x - h, v));
    assert!(((p.position - n.position) / 2.0 / h - m[0][0]).abs() < 1e-7, "{m:?}");
    assert!(((p.velocity - n.velocity) / 2.0 / h - m[1][0]).abs() < 1e-7, "{m:?}");
    let (p, n) = (run(x, v + h), run(x, v - h));
    assert!(((p.position - n.position) / 2.0 / h - m[0][1]).abs() < 1e-7, "{m:?}");
    assert!(((p.velocity - n.velocity) / 2.0 / h - m[1][1]).abs() < 1e-7, "{m:?}");
}

fn oscillator(q: f64, beta: f64, ratio: f64) -> Oscillator {
    let x_f = beta * PI / 4.0;
    Oscillator::builder()
        .omega_0(1.0)
        .q_factor(q)
        .friction_displacement(x_f)
        .static_displacement(x_f * ratio)
        .build()
        .unwrap()
}

fn settled() -> impl Strategy<Value = (Oscillator, HarmonicDrive)> {
    let q = prop_oneof![0.6..5.0f64, (0.7..4.0f64).prop_map(|e| 10f64.powf(e))];
    let omega = prop_oneof![0.1..0.6f64, 0.6..1.4f64, 1.4..5.0f64];
    (q, omega, 0.0..1.4f64, 1.0..1.3f64).prop_map(|(q, omega, beta, ratio)| {
        (oscillator(q, beta, ratio), HarmonicDrive::new(1.0, omega).unwrap())
    })
}

/// Whether the exact motion from rest ends up repeating after two to eight cycles but not after one.
fn settles_to_several_cycles(o: &Oscillator, drive: &HarmonicDrive) -> bool {
    let tone = Drive::harmonic(drive.amplitude(), drive.omega()).unwrap();
    let mut motion = Motion::new(o, tone, 0.0, 0.0, 0.0).unwrap();
    let mut after = |n: u32| motion.state_at(f64::from(8000 + n) * drive.period_s()).unwrap().position;
    let then = after(0);
    let first = (1..=8).find(|&n| (after(n) - then).abs() < 1e-9);
    first.is_some_and(|n| n > 1)
}

/// Cases whose search from rest ends in no orbit although one exists: the map over a cycle is discontinuous.
#[test]
fn an_orbit_out_of_reach_from_rest_is_found_from_elsewhere() {
    for (q, omega, beta, ratio) in [
        (1_207.567_735_436_991, 0.338_688_884_449_387_7, 0.154_610_010_873_875_3, 1.271_086_052_486_754_7),
        (3.951_406_791_731_078_4, 0.160_393_265_296_958_38, 0.642_215_956_898_669_6, 1.280_834_157_482_826_1),
        (5_226.911_807_052_796, 0.353_629_214_774_222_27, 0.158_070_031_773_426_66, 1.294_211_232_306_874_8),
        (20.303_693_479_594_283, 0.221_815_308_062_745_38, 0.410_109_327_982_281_17, 1.239_678_022_382_067_6),
    ] {
        let o = oscillator(q, beta, ratio);
        let drive = HarmonicDrive::new(1.0, omega).unwrap();
        let from_rest = OrbitOptions { start: Some((0.0, 0.0)), ..OrbitOptions::default() };
        assert!(PeriodicOrbit::find(&o, &drive, from_rest).is_err());
        let orbit = PeriodicOrbit::find(&o, &drive, OrbitOptions::default()).unwrap();
        let (x, v) = orbit.start();
        let tone = Drive::harmonic(1.0, omega).unwrap();
        let mut motion = Motion::new(&o, tone, 0.0, x, v).unwrap();
        let s = motion.state_at(drive.period_s()).unwrap();
        assert!((s.position - x).abs() < 1e-11, "{q} {omega}");
        assert!((s.velocity - v).abs() < 1e-11, "{q} {omega}");
    }
}

#[test]
fn a_motion_of_several_cycles_is_told_from_one_that_was_not_found() {
    let o = oscillator(16.662_404_280_988_763, 0.414_177_308_074_037_1, 1.223_973_468_818_350_1);
    let drive = HarmonicDrive::new(1.0, 0.198_242_711_705_676_4).unwrap();
    assert!(settles_to_several_cycles(&o, &drive));
    let error = solve(&o, &drive).unwrap_err().to_string();
    assert!(error.contains("only after two cycles"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn in_an_exact_motion_the_drive_works_exactly_what_is_lost((o, drive) in settled()) {
        let found = solve(&o, &drive);
        if found.is_err() && settles_to_several_cycles(&o, &drive) {
            return Ok(());
        }
        prop_assert!(found.is_ok(), "{found:?}");
        let found = found.unwrap();
        let loss = found.state.loss();
        let scale = found.state.amplitude().max(1e-3);
        prop_assert!(loss.viscous >= 0.0);
        prop_assert!(loss.sliding >= 0.0);
        prop_assert!(loss.drag == 0.0);
        prop_assert!((loss.total() - found.state.work()).abs() < 1e-9 * scale * (1.0 + scale), "{:?} {loss:?} {}", found.method, found.state.work());
    }

    #[test]
    fn where_the_closed_form_holds_it_solves_its_equation((o, drive) in settled(), at in 0.0..1.0f64) {
        let Ok(s) = SteadyState::new(&o, &drive, Method::Exact) else { return Ok(()) };
        let (t, h) = (at * drive.period_s(), 1e-3 / (1.0 + drive.omega()));
        let (x, v) = s.state(t);
        let turns = s.turning_points();
        let far = turns.iter().all(|p| {
            let gap = (p.0 - t).rem_euclid(drive.period_s());
            gap > 3.0 * h && gap < drive.period_s() - 3.0 * h
        });
        prop_assume!(far);
        let f = |k: f64| s.velocity(t + k * h);
        let a = (f(-2.0) - f(2.0) + 8.0 * (f(1.0) - f(-1.0))) / (12.0 * h);
        let base = (drive.omega() * t).cos();
        let expected = base - x - o.friction_displacement() * v.signum() - 2.0 * o.decay_rate_per_s() * v;
        let size = s.amplitude() * (1.0 + drive.omega().powi(2)) + 1.0;
        prop_assert!((a - expected).abs() < 1e-8 * size, "{a} {expected}");
    }
}

#[test]
fn from_q_0_6_to_1e7_and_beta_0_past_1_a_steady_motion_is_always_found() {
    for q in [0.6, 1.0, 3.0, 10.0, 100.0, 1e4, 1e7] {
        for beta in [0.0, 0.01, 0.3, 0.7, 0.95, 0.999, 1.0, 1.1, 1.2, 1.27, 1.28, 2.0] {
            for detuning in [0.2, 1.0 / 3.0, 0.9, 1.0 - 1.0 / q, 1.0, 1.0 + 0.3 / q, 1.2, 3.0] {
                if detuning <= 0.0 {
                    continue;
                }
                let o = Oscillator::builder()
                    .omega_0(2.0)
                    .q_factor(q)
                    .friction_displacement(beta * PI / 4.0)
                    .build()
                    .unwrap();
                let drive = HarmonicDrive::new(1.0, 2.0 * detuning).unwrap();
                let found = solve(&o, &drive);
                assert!(found.is_ok(), "Q {q} beta {beta} omega {detuning}: {found:?}");
                let found = found.unwrap();
                let x = found.state.amplitude();
                assert!(x.is_finite(), "Q {q} beta {beta} omega {detuning}: {found:?}");
                assert!(found.residual < 1e-9, "Q {q} beta {beta} omega {detuning}: {found:?}");
                // Beyond beta = 4/pi static friction exceeds the drive: nothing moves from rest.
                assert_eq!(
                    found.method == SolutionMethod::FullStick,
                    beta * PI / 4.0 >= 1.0,
                    "Q {q} beta {beta} {detuning}"
                );
                assert!((found.method == SolutionMethod::FullStick) == (x == 0.0));
            }
        }
    }
}
