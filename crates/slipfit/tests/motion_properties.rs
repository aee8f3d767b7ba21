//! Properties of every motion, tested with random oscillators.

#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use proptest::prelude::*;
use slipfit::Oscillator;
use slipfit::motion::decay::FreeDecay;
use slipfit::motion::simulate::{Drive, Event, EventKind, Friction, Harmonic, Motion, State};

/// 10 000 cases when built for release, fewer otherwise; `SLIPFIT_CASES` overrides.
fn cases() -> ProptestConfig {
    let default = if cfg!(debug_assertions) { 1000 } else { 10_000 };
    let cases = std::env::var("SLIPFIT_CASES").ok().and_then(|v| v.parse().ok()).unwrap_or(default);
    ProptestConfig {
        cases,
        failure_persistence: None,
        max_global_rejects: 10 * cases,
        ..ProptestConfig::default()
    }
}

fn quality() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(f64::INFINITY), 3 => 0.6..5.0f64, 4 => (0.7..7.0f64).prop_map(|e| 10f64.powf(e))]
}

fn oscillator() -> impl Strategy<Value = Oscillator> {
    let friction = prop_oneof![1 => Just(0.0), 3 => 1e-3..0.3f64, 2 => 0.3..1.2f64];
    let ratio = prop_oneof![Just(1.0), 1.0..1.5f64];
    (0.3..30.0f64, quality(), friction, ratio).prop_map(|(omega_0, q, x_f, ratio)| {
        Oscillator::builder()
            .omega_0(omega_0)
            .q_factor(q)
            .friction_displacement(x_f)
            .static_displacement(x_f * ratio)
            .build()
            .expect("in range")
    })
}

/// Frequency in units of omega_0, from far below to far above.
fn tuning() -> impl Strategy<Value = f64> {
    prop_oneof![0.05..0.5f64, 0.5..1.5f64, Just(1.0), Just(1.0 / 3.0), 1.5..6.0f64]
}

fn drive(o: &Oscillator, kind: u8, r: [f64; 4]) -> Drive {
    let w = o.omega_0();
    match kind {
        0 => Drive::none(),
        1 => Drive::harmonic(1.0, r[0] * w).unwrap(),
        2 => Drive::harmonics(
            0.1,
            &[
                Harmonic { amplitude: 0.6, omega: r[0] * w, phase: 6.0 * r[1] },
                Harmonic { amplitude: 0.4, omega: (0.1 + 3.0 * r[2]) * w, phase: 6.0 * r[3] },
            ],
        )
        .unwrap(),
        3 => {
            let t: Vec<f64> = (0..60).map(|i| (f64::from(i) + 0.3 * r[1]) * (0.05 + r[2]) / w).collect();
            let u = t.iter().map(|t| (r[0] * w * t + r[3]).sin()).collect();
            Drive::sampled(t, u).unwrap()
        }
        4 => Drive::chirp(1.0, r[0] * w, (0.2 + 2.0 * r[1]) * w, 0.0, 60.0 / w).unwrap(),
        _ => Drive::harmonic(1.0, r[0] * w).unwrap().until((1.0 + 20.0 * r[1]) / w).unwrap(),
    }
}

fn any_drive() -> impl Strategy<Value = (u8, [f64; 4])> {
    (0..6u8, tuning(), [0.0..1.0f64, 0.0..1.0, 0.0..1.0])
        .prop_map(|(kind, w, [a, b, c])| (kind, [w, a, b, c]))
}

fn energy(o: &Oscillator, s: &State) -> f64 {
    let v = s.velocity / o.omega_0();
    0.5 * (v * v + s.position * s.position)
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn closed_form_and_event_machine_agree_on_free_decays(
        o in oscillator(), x in -3.0..3.0f64, v in -3.0..3.0f64, rest in any::<bool>(),
    ) {
        let v = if rest { 0.0 } else { v * o.omega_0() };
        let decay = FreeDecay::from_state(&o, 0.0, x, v).unwrap();
        let mut motion = Motion::new(&o, Drive::none(), 0.0, x, v).unwrap();
        let until = 100.0 / o.omega_0();
        let events: Vec<Event> = motion.clone().events(until).collect();
        let first = usize::from(rest);
        for (e, p) in events.iter().zip(decay.turning_points().skip(first)) {
            prop_assert!((e.position - p.position).abs() < 1e-13 * 5.0, "{e:?} {p:?}");
            prop_assert!((e.time_s - p.time_s).abs() < 1e-13 * until);
        }
        if let Some(stop) = decay.stop() && stop.time_s < until * (1.0 - 1e-9) && stop.index > 0 {
            // A mass that stops exactly at the border of the zone may be judged either way.
            let margin = (stop.position.abs() - o.static_displacement()).abs();
            prop_assume!(margin > 1e-12);
            prop_assert_eq!(events.last().map(|e| e.kind), Some(EventKind::Rest));
        }
        for i in 0..50 {
            let t = until * f64::from(i) / 50.0;
            let (s, (y, w)) = (motion.state_at(t).unwrap(), decay.state(t));
            prop_assert!((s.position - y).abs() < 1e-12 * 5.0, "{s:?} {y}");
            prop_assert!((s.velocity - w).abs() < 1e-12 * 5.0 * o.omega_0());
        }
    }

    #[test]
    fn nothing_is_ever_not_a_number_and_events_are_in_order(
        o in oscillator(), d in any_drive(), x in -3.0..3.0f64, v in -3.0..3.0f64,
    ) {
        let mut motion = Motion::new(&o, drive(&o, d.0, d.1), 0.0, x, v * o.omega_0()).unwrap();
        let mut between = motion.clone();
        let (mut last, mut stuck, mut count) = (0.0, false, 0);
        let mut direction = motion.direction();
        for e in motion.events(60.0 / o.omega_0()) {
            prop_assert!(e.position.is_finite(), "{e:?}");
            prop_assert!(e.time_s.is_finite(), "{e:?}");
            prop_assert!(e.velocity.is_finite(), "{e:?}");
            prop_assert!(e.time_s >= last, "{e:?} after {last}");
            match e.kind {
                EventKind::Release => {
                    prop_assert!(stuck, "{e:?}");
                    prop_assert!(e.direction != 0.0, "{e:?}");
                }
                EventKind::Turn => {
                    prop_assert!(!stuck, "{e:?}");
                    prop_assert!(e.direction != 0.0, "{e:?}");
                }
                EventKind::Stop | EventKind::Rest => {
                    prop_assert!(!stuck, "{e:?}");
                    prop_assert!(e.direction == 0.0, "{e:?}");
                }
                _ => {}
            }
            if e.kind != EventKind::DriveChange {
                prop_assert_eq!(e.velocity, 0.0);
            }
            if e.direction == 0.0 {
                prop_assert!((e.drive - e.position).abs() <= o.static_displacement() + 1e-15);
            }
            // No turning point is missed: between events the velocity keeps its sign.
            for i in 1..8 {
                let t = last + (e.time_s - last) * f64::from(i) / 8.0;
                if t > last && t < e.time_s {
                    let v = between.state_at(t).unwrap().velocity;
                    prop_assert!(v * direction >= -1e-14 * o.omega_0());
                    prop_assert!((direction != 0.0 || v == 0.0));
                }
            }
            direction = e.direction;
            stuck = e.direction == 0.0;
            last = e.time_s;
            count += 1;
            prop_assert!(count < 10_000, "chatter at {e:?}");
        }
    }

    #[test]
    fn a_motion_with_a_past_turns_where_one_without_does(
        o in oscillator(), w in tuning(), x in -3.0..3.0f64, phase in 0.0..6.3f64,
    ) {
        // The search for the end of a slip starts from the duration of the previous one; a new motion has none.
        let tone = Harmonic { amplitude: 1.0, omega: w * o.omega_0(), phase };
        let drive = Drive::harmonics(0.0, &[tone]).unwrap();
        let mut motion = Motion::new(&o, drive.clone(), 0.0, x, 0.0).unwrap();
        let until = 200.0 / o.omega_0();
        let mut fresh: Option<Motion> = None;
        for _ in 0..60 {
            let Some(e) = motion.next_event(until) else { break };
            if let Some(mut fresh) = fresh.take() {
                let other = fresh.next_event(2.0 * until);
                prop_assert!(other.is_some(), "{e:?}");
                let f = other.unwrap();
                prop_assert!((e.time_s - f.time_s).abs() < 1e-7 / o.omega_0(), "{e:?} {f:?}");
                prop_assert!((e.position - f.position).abs() < 1e-9, "{e:?} {f:?}");
            }
            if e.kind == EventKind::Turn {
                fresh = Some(Motion::new(&o, drive.clone(), e.time_s, e.position, 0.0).unwrap());
                // Exactly at the border of the zone it may be judged either way.
                let margin = ((e.drive - e.position).abs() - o.static_displacement()).abs();
                if margin < 1e-9 { fresh = None; }
            }
        }
    }

    #[test]
    fn motion_solves_its_equation(
        o in oscillator(), d in any_drive(), x in -3.0..3.0f64, v in -3.0..3.0f64, when in 0.01..50.0f64,
    ) {
        let drive = drive(&o, d.0, d.1);
        let mut motion = Motion::new(&o, drive.clone(), 0.0, x, v * o.omega_0()).unwrap();
        let w = o.omega_0();
        let (t, h) = (when / w, 1e-3 / w);
        let mut s = [0.0; 5].map(|_| State { time_s: 0.0, position: 0.0, velocity: 0.0 });
        for (i, s) in s.iter_mut().enumerate() {
            *s = motion.clone().state_at(t + (i as f64 - 2.0) * h).unwrap();
        }
        let near = motion.clone().events(t + 2.0 * h).any(|e| e.time_s > t - 2.0 * h);
        // A sampled drive has a kink at each sample, which is not an event.
        prop_assume!(!near && d.0 != 3);
        let slope = |f: fn(&State) -> f64| (f(&s[0]) - f(&s[4]) + 8.0 * (f(&s[3]) - f(&s[1]))) / (12.0 * h);
        let size = s[2].position.abs() + s[2].velocity.abs() / w + 1.0;
        prop_assert!((slope(|s| s.position) - s[2].velocity).abs() < 1e-8 * size * w);
        if s[2].velocity != 0.0 {
            let pull = drive.displacement(t) - s[2].position;
            let a = w * w * (pull - o.friction_displacement() * s[2].velocity.signum())
                - 2.0 * o.decay_rate_per_s() * s[2].velocity;
            prop_assert!((slope(|s| s.velocity) - a).abs() < 1e-8 * size * w * w);
        }
        prop_assert!(motion.state_at(t).is_ok());
    }

    #[test]
    fn energy_never_grows_without_a_drive(o in oscillator(), x in -3.0..3.0f64, v in -3.0..3.0f64) {
        let mut motion = Motion::new(&o, Drive::none(), 0.0, x, v * o.omega_0()).unwrap();
        let mut before = energy(&o, &motion.state());
        for i in 1..200 {
            let s = motion.state_at(f64::from(i) * 0.3 / o.omega_0()).unwrap();
            let now = energy(&o, &s);
            prop_assert!(now <= before * (1.0 + 1e-14) + 1e-15, "{now} {before}");
            before = now;
        }
    }

    #[test]
    fn scaling_displacement_and_time_scales_the_motion(
        o in oscillator(), w in tuning(), x in -3.0..3.0f64, a in 0.1..10.0f64, b in 0.1..10.0f64,
    ) {
        let scaled = Oscillator::builder()
            .omega_0(o.omega_0() * b)
            .decay_rate_per_s(o.decay_rate_per_s() * b)
            .friction_displacement(o.friction_displacement() * a)
            .static_displacement(o.static_displacement() * a)
            .build()
            .unwrap();
        let omega = w * o.omega_0();
        let mut one = Motion::new(&o, Drive::harmonic(1.0, omega).unwrap(), 0.0, x, 0.0).unwrap();
        let mut two = Motion::new(&scaled, Drive::harmonic(a, omega * b).unwrap(), 0.0, x * a, 0.0).unwrap();
        for i in 0..20 {
            let t = f64::from(i) / o.omega_0();
            let (p, q) = (one.state_at(t).unwrap(), two.state_at(t / b).unwrap());
            prop_assert!((q.position / a - p.position).abs() < 1e-9, "{p:?} {q:?}");
        }
    }

    #[test]
    fn a_mirrored_start_and_drive_mirror_the_motion(
        o in oscillator(), d in any_drive(), x in -3.0..3.0f64, v in -3.0..3.0f64,
    ) {
        let w = o.omega_0();
        let omega = d.1[0] * w;
        let tone = |phase| Drive::harmonics(0.0, &[Harmonic { amplitude: 1.0, omega, phase }]).unwrap();
        let mut one = Motion::new(&o, tone(0.4), 0.0, x, v * w).unwrap();
        let mut two = Motion::new(&o, tone(0.4 + std::f64::consts::PI), 0.0, -x, -v * w).unwrap();
        for i in 0..40 {
            let t = f64::from(i) / w;
            let (p, q) = (one.state_at(t).unwrap(), two.state_at(t).unwrap());
            prop_assert!((p.position + q.position).abs() < 1e-9, "{p:?} {q:?}");
        }
    }

    #[test]
    fn the_undamped_motion_runs_back_the_way_it_came(x in -3.0..3.0f64, v in -3.0..3.0f64, t in 0.1..300.0f64) {
        let o = Oscillator::kinematic(1.0, 0.0, 0.0).unwrap();
        // A drive that is even about t, so that it is invariant under time reversal.
        let tone = Harmonic { amplitude: 1.0, omega: 0.37, phase: -0.37 * t };
        let drive = Drive::harmonics(0.2, &[tone]).unwrap();
        let there = Motion::new(&o, drive.clone(), 0.0, x, v).unwrap().state_at(t).unwrap();
        let back = Motion::new(&o, drive, t, there.position, -there.velocity).unwrap().state_at(2.0 * t).unwrap();
        prop_assert!((back.position - x).abs() < 1e-12, "{back:?}");
        prop_assert!((back.velocity + v).abs() < 1e-12, "{back:?}");
    }

    #[test]
    fn energy_is_balanced_over_driven_motions(o in oscillator(), w in tuning(), x in -2.0..2.0f64) {
        // Work of the base = change of energy + viscous + sliding loss, by fine quadrature.
        let omega = w * o.omega_0();
        let drive = Drive::harmonic(1.0, omega).unwrap();
        let mut motion = Motion::new(&o, drive.clone(), 0.0, x, 0.0).unwrap();
        let n = 4000;
        let h = 20.0 / o.omega_0() / f64::from(n);
        let start = energy(&o, &motion.state());
        let (mut work, mut last) = (0.0, motion.state());
        for i in 1..=n {
            let s = motion.state_at(f64::from(i) * h).unwrap();
            let mid_v = (s.position - last.position) / h;
            let u = drive.displacement((f64::from(i) - 0.5) * h);
            let loss = 2.0 * o.decay_rate_per_s() / o.omega_0().powi(2) * mid_v * mid_v
                + o.friction_displacement() * mid_v.abs();
            work += (u * mid_v - loss) * h;
            last = s;
        }
        let end = energy(&o, &last);
        prop_assert!((end - start - work).abs() < 2e-3 * (1.0 + end), "{} {work}", end - start);
    }
}

#[test]
fn asymmetric_friction_shifts_the_middle_as_a_constant_force_would() {
    // F+ = a + b, F- = a - b is friction a with a constant force -b.
    let o = Oscillator::kinematic(1.0, 0.01, 0.1).unwrap();
    let skew = Friction::asymmetric([0.14, 0.06], [0.14, 0.06]).unwrap();
    let tone = [Harmonic { amplitude: 1.0, omega: 0.9, phase: 0.0 }];
    let mut a =
        Motion::with_friction(&o, skew, Drive::harmonics(0.0, &tone).unwrap(), 0.0, 1.0, 0.0).unwrap();
    let mut b = Motion::new(&o, Drive::harmonics(-0.04, &tone).unwrap(), 0.0, 1.0, 0.0).unwrap();
    for i in 0..500 {
        let t = f64::from(i) * 0.3;
        let (p, q) = (a.state_at(t).unwrap(), b.state_at(t).unwrap());
        assert!((p.position - q.position).abs() < 1e-12);
    }
    assert!(Friction::asymmetric([0.1, 0.2], [0.1, 0.1]).is_err());
    assert!(Friction::asymmetric([-0.1, 0.2], [0.1, 0.2]).is_err());
}

#[test]
fn a_slip_of_a_millionth_of_a_period_is_not_missed() {
    // The excess of the drive's crest over static friction is made smaller and smaller.
    let o = Oscillator::kinematic(1.0, 0.05, 0.5).unwrap();
    let mut before = f64::INFINITY;
    for e in 2..13 {
        let excess = 10f64.powi(-e);
        // Held at x = 0; drive just beyond x_F at its crest.
        let drive =
            Drive::harmonics(0.0, &[Harmonic { amplitude: 0.5 * (1.0 + excess), omega: 0.2, phase: -1.0 }])
                .unwrap();
        let mut motion = Motion::new(&o, drive, 0.0, 0.0, 0.0).unwrap();
        let events: Vec<_> = motion.events(10.0).collect();
        assert_eq!(events.len(), 2, "{excess} {events:?}");
        assert_eq!((events[0].kind, events[1].kind), (EventKind::Release, EventKind::Stop));
        let slip = events[1].time_s - events[0].time_s;
        assert!((0.0..=before).contains(&slip), "{slip}");
        // From U - x_F = a cos: velocity ~ U' u²/2 + U'' u³/6, zero at 3 sqrt(2 excess)/omega.
        let expected = 3.0 * (2.0 * excess).sqrt() / 0.2;
        assert!((slip / expected - 1.0).abs() < 0.3 * expected + 1e-2, "{slip} {expected}");
        before = slip;
    }
}

#[test]
fn bad_input_is_refused_by_name() {
    let o = Oscillator::kinematic(1.0, 0.05, 0.5).unwrap();
    assert!(Motion::new(&o, Drive::none(), f64::NAN, 0.0, 0.0).is_err());
    assert!(Motion::new(&o, Drive::none(), 0.0, f64::INFINITY, 0.0).is_err());
    assert!(Drive::harmonic(1.0, 0.0).is_err());
    assert!(Drive::harmonic(f64::NAN, 1.0).is_err());
    assert!(Drive::chirp(1.0, 1.0, 2.0, 5.0, 5.0).is_err());
    assert!(Drive::sampled(vec![0.0, 1.0, 1.0], vec![0.0; 3]).is_err());
    assert!(Drive::sampled(vec![], vec![]).is_err());
    assert!(Drive::none().until(3.0).unwrap().until(2.0).is_err());
    // 2 rad/s is 0.318 Hz: a sampling rate of half a hertz cannot resolve it.
    let aliased = Drive::harmonic(1.0, 2.0).unwrap().check_sampling(0.5).unwrap_err().to_string();
    assert!(aliased.contains("drive frequency_hz = 0.318"), "{aliased}");
    assert!(aliased.contains("rate_hz"), "{aliased}");
    assert!(Drive::harmonic(1.0, 2.0).unwrap().check_sampling(1.0).is_ok());
    assert!(Drive::none().check_sampling(0.0).is_err());
    let mut m = Motion::new(&o, Drive::none(), 0.0, 3.0, 0.0).unwrap();
    m.state_at(5.0).unwrap();
    assert!(m.state_at(0.0).is_err());
}

#[test]
fn the_ends_of_the_range_neither_hang_nor_give_what_is_no_number() {
    for omega_0 in [1e-30, 1e-3, 1.0, 1e30] {
        for amplitude in [1e-150, 1.0, 1e100] {
            for x_f in [0.0, 0.3 * amplitude, amplitude, 1e-300] {
                for start in [0.0, 1e-320, amplitude, -1e100] {
                    for tuning in [1e-6, 1e-3, 1.0, 50.0] {
                        let omega: f64 = omega_0 * tuning;
                        let Ok(o) = Oscillator::kinematic(omega_0, 0.01 * omega_0, x_f) else { continue };
                        let Ok(drive) = Drive::harmonic(amplitude, omega) else { continue };
                        let mut motion = Motion::new(&o, drive, 0.0, start, 0.0).unwrap();
                        for e in motion.events(10.0 / omega_0).take(2000) {
                            assert!(e.position.is_finite(), "{e:?}");
                            assert!(e.time_s.is_finite(), "{e:?}");
                        }
                        let s = motion.state_at(11.0 / omega_0).unwrap();
                        assert!(s.position.is_finite(), "{s:?}");
                        assert!(s.velocity.is_finite(), "{s:?}");
                    }
                }
            }
        }
    }
}
