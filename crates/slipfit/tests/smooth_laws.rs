//! Speed-dependent friction, integrated, against closed forms where they exist.

#![cfg(feature = "smooth-laws")]
#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use proptest::prelude::*;
use slipfit::Oscillator;
use slipfit::decay::{Envelope, drag_rate};
use slipfit::simulate::smooth::{SmoothMotion, drag, power, stribeck};
use slipfit::simulate::{Drive, Event, EventKind, Motion};

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
    let envelope = Envelope::of(&o, drag_rate(c, 1.0, 1.0), 1.0).unwrap();
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
    assert!(drag(-1.0).is_err() && power(1.0, 0.0).is_err() && stribeck(0.1, 0.0).is_err());
    assert!(motion.with_tolerance(0.1).is_err());
}

#[test]
fn a_stribeck_law_can_excite_by_itself_where_coulomb_cannot() {
    // A belt would be needed for a limit cycle; free, weakening only slows the decay.
    let o = Oscillator::kinematic(1.0, 0.0, 0.05).unwrap();
    let run = |drop: f64| {
        let law = stribeck(drop, 0.05).unwrap();
        let mut m = SmoothMotion::new(&o, law, Drive::none(), 0.0, 1.0, 0.0).unwrap();
        all(&mut m, 200.0)
    };
    let (coulomb, weak) = (run(0.0), run(0.03));
    assert!(weak.len() > coulomb.len());
    assert_eq!(weak.last().unwrap().kind, EventKind::Rest);
    // At speed friction is 0.02, so a half cycle takes a little more than twice that.
    let lost = weak[0].position.abs() - weak[1].position.abs();
    assert!(lost > 0.04 && lost < 0.05, "{lost}");
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
        // 2 delta v = law: part of the damping moved from the oscillator into the law.
        let moved = 2.0 * delta * share;
        let mut other =
            SmoothMotion::new(&build(delta * (1.0 - share)), move |v| moved * v, drive, 0.0, x, 0.0).unwrap();
        let expected: Vec<Event> = exact.events(40.0).collect();
        let found = all(&mut other, 40.0);
        prop_assert_eq!(expected.len(), found.len());
        for (e, f) in expected.iter().zip(&found) {
            prop_assert_eq!(e.kind, f.kind);
            // A stop short of a release, or a release on a crest, magnifies what came before.
            prop_assert!((e.position - f.position).abs() < 1e-9, "{e:?} {f:?}");
            prop_assert!((e.time_s - f.time_s).abs() < 1e-6, "{e:?} {f:?}");
        }
    }
}
