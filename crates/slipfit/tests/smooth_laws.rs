//! Integrated speed-dependent friction compared with closed forms where they exist.

#![cfg(feature = "smooth-laws")]
#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use proptest::prelude::*;
use slipfit::Oscillator;
use slipfit::motion::decay::{AmplitudeLaw, drag_rate};
use slipfit::motion::simulate::smooth::{SmoothMotion, drag, power, stribeck};
use slipfit::motion::simulate::{Drive, Event, EventKind, Friction, Harmonic, Motion};

fn all<F: Fn(f64) -> f64>(motion: &mut SmoothMotion<F>, until: f64) -> Vec<Event> {
    std::iter::from_fn(|| motion.next_event(until).unwrap()).collect()
}

#[test]
fn sliding_and_drag_turn_where_the_first_integral_says() {
    // Undamped otherwise, moving up: d(v²)/dx = -2 w² (x + x_F + c v²), linear in v².
    let (w, c, x_f) = (1.7f64, 0.3f64, 0.002f64);
    let o = Oscillator::kinematic(w, 0.0, x_f).unwrap();
    let mut motion = SmoothMotion::new(&o, drag(c).unwrap(), Drive::none(), 0.0, -2.0, 0.0).unwrap();
    let events = all(&mut motion, 60.0);
    let mut from: f64 = 2.0;
    let k = 2.0 * w * w * c;
    for e in &events {
        // v² = K e^(-k x) - (x + x_F)/c + w²·2/k² ... zero at -from and at the next turn.
        let part = |x: f64| 2.0 * w * w * (1.0 / (k * k) - (x + x_f) / k);
        let constant = -part(-from) * (-k * from).exp();
        let square = |x: f64| constant * (-k * x).exp() + part(x);
        let (mut low, mut high) = (-from + 0.5 * (from - x_f).max(1e-9), from);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if square(middle) > 0.0 { low = middle } else { high = middle }
        }
        assert!((e.position.abs() - low.abs()).abs() < 1e-11, "{e:?} {low}");
        from = e.position.abs();
    }
    assert!(events.len() > 15);
    assert_eq!(events.last().unwrap().kind, EventKind::Rest);
}

#[test]
fn a_weak_drag_follows_the_slow_envelope() {
    let o = Oscillator::physical(1.0, 1e-3, 1.0, 2e-4).unwrap();
    let c = 1e-3;
    let envelope = AmplitudeLaw::of(&o, drag_rate(c, 1.0, 1.0), 1.0).unwrap();
    let mut motion = SmoothMotion::new(&o, drag(c).unwrap(), Drive::none(), 0.0, 1.0, 0.0).unwrap();
    let events = all(&mut motion, 500.0);
    assert!(events.len() > 150);
    for e in &events {
        assert!((e.position.abs() - envelope.amplitude(e.time_s)).abs() < 2e-3 * e.position.abs(), "{e:?}");
    }
}

#[test]
fn a_closure_that_is_not_finite_is_an_error() {
    let o = Oscillator::kinematic(1.0, 0.01, 0.0).unwrap();
    let mut motion = SmoothMotion::new(&o, |_| f64::NAN, Drive::none(), 0.0, 1.0, 0.0).unwrap();
    assert!(motion.next_event(10.0).is_err());
    assert!(drag(-1.0).is_err());
    assert!(power(1.0, 0.0).is_err());
    assert!(stribeck(0.1, 0.0).is_err());
    assert!(motion.with_tolerance(0.1).is_err());
}

#[test]
fn a_stribeck_law_can_excite_by_itself_where_coulomb_cannot() {
    // A limit cycle would need a moving belt; in free motion, weakening only slows the decay.
    let o = Oscillator::kinematic(1.0, 0.0, 0.05).unwrap();
    let run = |drop: f64| {
        let law = stribeck(drop, 0.05).unwrap();
        let mut m = SmoothMotion::new(&o, law, Drive::none(), 0.0, 1.0, 0.0).unwrap();
        all(&mut m, 200.0)
    };
    let (coulomb, weak) = (run(0.0), run(0.03));
    assert!(weak.len() > coulomb.len());
    assert_eq!(weak.last().unwrap().kind, EventKind::Rest);
    // At speed the friction is 0.02, so a half cycle loses a little more than twice that.
    let lost = weak[0].position.abs() - weak[1].position.abs();
    assert!((0.04..=0.05).contains(&lost), "{lost}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn without_a_law_or_with_a_viscous_one_the_closed_form_is_met(
        q in 2.0..200.0f64, x_f in 0.01..0.6f64, ratio in 1.0..1.3f64, omega in 0.2..3.0f64,
        x in -2.0..2.0f64, share in 0.0..1.0f64, off in 5.0..30.0f64,
    ) {
        let delta = 0.5 / q;
        let build = |delta: f64| Oscillator::builder().omega_0(1.0).decay_rate_per_s(delta)
            .friction_displacement(x_f).static_displacement(x_f * ratio).build().unwrap();
        let drive = Drive::harmonic(1.0, omega).unwrap().until(off).unwrap();
        let mut exact = Motion::new(&build(delta), drive.clone(), 0.0, x, 0.0).unwrap();
        // 2 delta v = law: part of the damping is moved from the oscillator to the law.
        let moved = 2.0 * delta * share;
        let mut other =
            SmoothMotion::new(&build(delta * (1.0 - share)), move |v| moved * v, drive, 0.0, x, 0.0).unwrap();
        let expected: Vec<Event> = exact.events(40.0).collect();
        let found = all(&mut other, 40.0);
        prop_assert_eq!(expected.len(), found.len());
        for (e, f) in expected.iter().zip(&found) {
            prop_assert_eq!(e.kind, f.kind);
            // A stop just before a release, or a release at a crest, magnifies earlier errors.
            prop_assert!((e.position - f.position).abs() < 1e-9, "{e:?} {f:?}");
            prop_assert!((e.time_s - f.time_s).abs() < 1e-6, "{e:?} {f:?}");
        }
    }
}

#[test]
fn asymmetric_friction_agrees_with_the_closed_form() {
    let drive = Drive::harmonic(1.0, 0.7).unwrap();
    for (kinetic, holding) in [([0.3, 0.1], [0.4, 0.1]), ([0.05, 0.5], [0.05, 0.7]), ([0.0, 0.3], [0.2, 0.3])]
    {
        let friction = Friction::asymmetric(kinetic, holding).unwrap();
        // Viscous damping entirely in the oscillator, and entirely in the law.
        let damped = Oscillator::kinematic(1.0, 0.06, 0.2).unwrap();
        let bare = Oscillator::kinematic(1.0, 0.0, 0.2).unwrap();
        let mut exact = Motion::with_friction(&damped, friction, drive.clone(), 0.0, 0.6, 0.0).unwrap();
        let law = |v: f64| 0.12 * v;
        let mut other =
            SmoothMotion::with_friction(&bare, friction, law, drive.clone(), 0.0, 0.6, 0.0).unwrap();
        let (a, b): (Vec<_>, Vec<_>) = (exact.events(80.0).collect(), all(&mut other, 80.0));
        assert!(a.len() > 10, "{kinetic:?} {} {}", a.len(), b.len());
        assert!(a.len() == b.len(), "{kinetic:?} {} {}", a.len(), b.len());
        for (e, f) in a.iter().zip(&b) {
            assert_eq!(e.kind, f.kind);
            assert!((e.position - f.position).abs() < 1e-10, "{e:?} {f:?}");
            assert!((e.time_s - f.time_s).abs() < 1e-8, "{e:?} {f:?}");
        }
    }
}

#[test]
fn two_turns_close_together_are_both_found() {
    // A second harmonic whose velocity barely exceeds that of the first: the mass turns and turns back, after a time
    // that vanishes as the strength approaches the value at which the pair appears.
    let o = Oscillator::kinematic(1.0, 0.02, 0.0).unwrap();
    let drive = |strength: f64| {
        let tones = [
            Harmonic { amplitude: 1.0, omega: 0.2, phase: 0.0 },
            Harmonic { amplitude: strength, omega: 0.6, phase: 0.3 },
        ];
        Drive::harmonics(0.0, &tones).unwrap()
    };
    let exact = |strength: f64| -> Vec<Event> {
        Motion::new(&o, drive(strength), 0.0, 0.9, 0.0).unwrap().events(90.0).collect()
    };
    let (mut none, mut some) = (0.0, 0.1);
    let before = exact(none).len();
    assert!(exact(some).len() > before);
    for _ in 0..50 {
        let middle = 0.5 * (none + some);
        if exact(middle).len() == before { none = middle } else { some = middle }
    }
    let mut last = f64::INFINITY;
    for above in [1e-2, 1e-3, 1e-4, 1e-6, 1e-8] {
        let a = exact(some + above);
        let mut other = SmoothMotion::new(&o, |_| 0.0, drive(some + above), 0.0, 0.9, 0.0).unwrap();
        let b = all(&mut other, 90.0);
        assert_eq!(a.len(), b.len(), "{above}");
        for (e, f) in a.iter().zip(&b) {
            assert!((e.position - f.position).abs() < 1e-9, "{e:?} {f:?}");
        }
        let least = b.windows(2).map(|w| w[1].time_s - w[0].time_s).fold(f64::INFINITY, f64::min);
        assert!(least < last, "{least} {last}");
        last = least;
    }
    assert!(last < 1e-3, "{last}");
}

/// For every kind of drive, the closed form is compared with an integration that shares only the drive with it.
#[test]
fn every_drive_agrees_with_its_integration() {
    let tones = [
        Harmonic { amplitude: 0.7, omega: 0.9, phase: 0.3 },
        Harmonic { amplitude: 0.4, omega: 2.7, phase: 1.0 },
        Harmonic { amplitude: 0.2, omega: 0.31, phase: 2.0 },
    ];
    let grid: Vec<f64> = (0..400).map(|i| 0.17 * f64::from(i)).collect();
    let wave = grid.iter().map(|t| (0.8 * t).sin() + 0.3 * (2.3 * t).cos()).collect();
    let drives = [
        ("tones", Drive::harmonics(0.1, &tones).unwrap()),
        ("sampled", Drive::sampled(grid, wave).unwrap()),
        ("slow sweep up", Drive::chirp(1.0, 0.8, 1.2, 0.0, 60.0).unwrap()),
        ("sweep down", Drive::chirp(1.0, 3.0, 0.2, 5.0, 50.0).unwrap()),
        ("fast sweep", Drive::chirp(1.0, 0.2, 8.0, 0.0, 20.0).unwrap()),
        ("off at any phase", Drive::harmonic(2.0, 1.0).unwrap().until(17.3).unwrap()),
        ("steps", Drive::harmonic(1.0, 1.0).unwrap().then(9.0, Drive::hold(0.7).unwrap()).unwrap()),
    ];
    for (name, drive) in drives {
        for (delta, x_f, x_s) in [(0.02, 0.1, 0.1), (0.1, 0.35, 0.45), (0.6, 0.2, 0.2), (0.0, 0.05, 0.05)] {
            let o = Oscillator::builder()
                .omega_0(1.0)
                .decay_rate_per_s(delta)
                .friction_displacement(x_f)
                .static_displacement(x_s)
                .build()
                .unwrap();
            let mut exact = Motion::new(&o, drive.clone(), 0.0, 0.4, 0.2).unwrap();
            let mut other = SmoothMotion::new(&o, |_| 0.0, drive.clone(), 0.0, 0.4, 0.2).unwrap();
            let (a, b): (Vec<_>, Vec<_>) = (exact.events(60.0).collect(), all(&mut other, 60.0));
            let kinds = |e: &[Event]| e.iter().map(|e| e.kind).collect::<Vec<_>>();
            assert_eq!(kinds(&a), kinds(&b), "{name} {delta}");
            for (e, f) in a.iter().zip(&b) {
                assert!((e.position - f.position).abs() < 2e-10, "{name} {delta} {e:?} {f:?}");
                assert!((e.time_s - f.time_s).abs() < 1e-8, "{name} {delta} {e:?} {f:?}");
            }
        }
    }
}
