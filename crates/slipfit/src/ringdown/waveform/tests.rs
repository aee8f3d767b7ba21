use super::*;
use crate::Oscillator;
use crate::inference::least_squares::minimise;
use crate::motion::decay::FreeDecay;
use crate::motion::decay::parameters::DRAG;
use crate::motion::decay::path::SHAPE;
use crate::motion::simulate::Drive;
use crate::motion::simulate::smooth::{self, SmoothMotion};
use crate::noise::jitter;

fn wave<'a>(time: &'a [f64], signal: &'a [f64], backbone: Option<BackboneIntegral>) -> Waveform<'a> {
    let duration = time[time.len() - 1];
    Waveform {
        time,
        signal,
        observable: Observable::Displacement,
        guard: None,
        origin: 0.0,
        duration,
        backbone,
        rest: RestLevel::Exact,
        rounding_rms: 0.0,
        active: (0..OFFSET + 3).collect(),
        gathered: None,
    }
}

fn residuals(wave: &Waveform, p: &[f64]) -> f64 {
    let mut out = Normal::zeros(COUNT);
    assert!(wave.normal(p, &mut out));
    out.rss
}

#[test]
fn is_the_exact_free_decay() {
    for (q, x_f) in [(3.0, 0.02), (50.0, 0.01), (1000.0, 0.0), (1e6, 0.001)] {
        let omega_0 = 7.0;
        let delta = omega_0 / (2.0 * q);
        let oscillator = Oscillator::kinematic(omega_0, delta, x_f).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let time: Vec<f64> = (0..400).map(|i| i as f64 * 0.021).collect();
        let end = decay.stop().map_or(f64::INFINITY, |s| s.time_s);
        let time: Vec<f64> = time.into_iter().filter(|&t| t < end).collect();
        let signal: Vec<f64> = time.iter().map(|&t| decay.displacement(t) + 0.3).collect();
        let mut p = [0.0; COUNT];
        (p[A0], p[X_F], p[DELTA], p[OMEGA], p[OFFSET]) = (1.0, x_f, delta, oscillator.omega_d(), 0.3);
        let rms = (residuals(&wave(&time, &signal, None), &p) / time.len() as f64).sqrt();
        assert!(rms < 1e-13, "Q {q}: {rms:e}");
    }
}

/// Samples in bursts that cover one half cycle in thousands, with the stop between two of them.
#[test]
fn gaps_are_crossed_as_the_exact_decay_does() {
    let (omega_0, delta, x_f) = (7.0, 1e-4, 1e-5);
    let oscillator = Oscillator::kinematic(omega_0, delta, x_f).expect("valid");
    let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
    let stop = decay.stop().expect("friction stops it").time_s;
    let time: Vec<f64> = (0..12)
        .flat_map(|i| (0..40).map(move |k| stop * 0.13 * f64::from(i) + 0.05 * f64::from(k)))
        .collect();
    let signal: Vec<f64> = time.iter().map(|&t| decay.displacement(t) + 0.3).collect();
    let mut p = [0.0; COUNT];
    (p[A0], p[X_F], p[DELTA], p[OMEGA], p[OFFSET]) = (1.0, x_f, delta, oscillator.omega_d(), 0.3);
    // With drag and with a chirp among the parameters, half cycles differ from each other.
    for further in [vec![], vec![DRAG], vec![DRAG, CHIRP]] {
        let active = [A0, X_F, DELTA].into_iter().chain(further).chain([PHASE, OMEGA, OFFSET]).collect();
        let wave = Waveform { active, ..wave(&time, &signal, None) };
        let rms = (residuals(&wave, &p) / time.len() as f64).sqrt();
        assert!(rms < 1e-10, "{:?}: {rms:e}", wave.active);
    }
}

/// Velocities and accelerations of the exact decay, relative to `omega` and its square, up to the stop and at
/// rest.
#[test]
fn is_its_velocity_and_its_acceleration() {
    for (q, x_f) in [(3.0, 0.02), (8.0, 0.05), (50.0, 0.01), (1000.0, 0.0)] {
        let (omega_0, h) = (7.0, 1e-4);
        let delta = omega_0 / (2.0 * q);
        let oscillator = Oscillator::kinematic(omega_0, delta, x_f).expect("valid");
        let omega = oscillator.omega_d();
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let time: Vec<f64> = (0..800).map(|i| f64::from(i) * 0.011).collect();
        let mut p = [0.0; COUNT];
        (p[DELTA], p[OMEGA], p[OFFSET]) = (delta, omega, 0.3);
        let rms = |observable: Observable, signal: &dyn Fn(f64) -> f64, p: &[f64; COUNT]| {
            let signal: Vec<f64> = time.iter().map(|t| signal(*t)).collect();
            let wave = Waveform { observable, ..wave(&time, &signal, None) };
            let residuals = wave.residuals(p);
            // A finite difference across a turning point is not valid.
            let turns = |t: f64| ((t - h) * omega / PI).floor() != ((t + h) * omega / PI).floor();
            let inside = residuals.iter().zip(&time).filter(|(_, t)| !turns(**t));
            (inside.map(|(r, _)| r * r).sum::<f64>() / time.len() as f64).sqrt()
        };
        (p[A0], p[X_F]) = (omega, omega * x_f);
        let velocity = rms(Observable::Velocity, &|t| decay.velocity(t) + 0.3, &p);
        assert!(velocity < 1e-12, "Q {q}: {velocity:e}");
        (p[A0], p[X_F]) = (omega * omega, omega * omega * x_f);
        let slope = |t: f64| (decay.velocity(t + h) - decay.velocity(t - h)) / (2.0 * h);
        let acceleration = rms(Observable::Acceleration, &|t| slope(t) + 0.3, &p);
        assert!(acceleration < 1e-5, "Q {q}: {acceleration:e}");
    }
}

/// Samples next to turning points are excluded and counted; at rest all samples are used.
#[test]
fn samples_beside_a_turn_do_not_count() {
    let oscillator = Oscillator::kinematic(7.0, 0.4, 0.03).expect("valid");
    let stop = FreeDecay::from_rest(&oscillator, 1.0).expect("valid").stop().expect("stops").time_s;
    let time: Vec<f64> = (0..900).map(|i| f64::from(i) * 0.0123).collect();
    let lifted = vec![0.1; time.len()];
    let mut p = [0.0; COUNT];
    (p[A0], p[X_F], p[DELTA], p[OMEGA]) = (1.0, 0.03, 0.4, oscillator.omega_d());
    let all = Waveform { observable: Observable::Acceleration, ..wave(&time, &lifted, None) };
    let guarded = Waveform { guard: Some(Guard { reach: 0.05, stands_for: None }), ..all.clone() };
    let (every, kept) = (all.residuals(&p), guarded.residuals(&p));
    let left_out = kept.iter().filter(|r| **r == 0.0).count();
    assert!(left_out > 5 && left_out == guarded.at_turns(&p), "{left_out}");
    assert_eq!(all.at_turns(&p), 0);
    for ((t, all), kept) in time.iter().zip(every).zip(kept) {
        assert!(kept == all || kept == 0.0 && *t < stop, "{t}: {kept} for {all}");
    }
}

/// For noise alone a continuing motion leaves the same residuals as a mass at rest: turning points without
/// motion explain nothing.
#[test]
fn a_motion_with_more_turns_gains_nothing_by_them() {
    let time: Vec<f64> = (0..20_000).map(|i| f64::from(i) * 0.01).collect();
    let noise: Vec<f64> = (0..time.len()).map(|i| jitter(i, 5)).collect();
    let mut p = [0.0; COUNT];
    (p[A0], p[DELTA], p[OMEGA]) = (1e-6, 0.01, 9.0);
    let guard = Some(Guard { reach: 0.05, stands_for: Some(time.len() as f64) });
    let wave = Waveform { observable: Observable::Acceleration, guard, ..wave(&time, &noise, None) };
    let going_on = residuals(&wave, &p);
    assert!(wave.at_turns(&p) > 500);
    p[X_F] = 2e-6;
    assert_eq!(wave.at_turns(&p), 0);
    let gained = 1.0 - going_on / residuals(&wave, &p);
    assert!(gained.abs() < 0.01, "{gained}");
}

/// Comparison with the integrated motion: with drag a half cycle is accurate to second order in the loss, and
/// the accumulated error falls with its square.
#[test]
fn is_the_motion_with_drag_to_second_order() {
    for (x_f, viscous) in [(0.0, 0.0), (0.0, 1.0), (0.5, 0.3)] {
        let left = [8.0, 30.0, 120.0].map(|q| {
            let omega_0 = 7.0;
            let whole = omega_0 / (2.0 * q);
            let (delta, drag, x_f) = (viscous * whole, whole, x_f * whole * PI / (2.0 * omega_0));
            let oscillator = Oscillator::kinematic(omega_0, delta, x_f).expect("valid");
            let law = smooth::drag(drag * 3.0 * PI / (4.0 * omega_0.powi(3))).expect("valid");
            let drive = Drive::none();
            let mut motion = SmoothMotion::new(&oscillator, law, drive, 0.0, 1.0, 0.0).expect("valid");
            let duration = 1.5 / whole;
            let time: Vec<f64> = (0..600).map(|i| f64::from(i) * duration / 600.0).collect();
            let mut states = |&t: &f64| motion.state_at(t).expect("moves");
            let states: Vec<_> = time.iter().map(&mut states).collect();
            let signal: Vec<f64> = states.iter().map(|state| state.position).collect();
            let free = [A0, PHASE, OMEGA, X_F, DELTA, DRAG];
            let mut p = vec![0.0; COUNT];
            (p[A0], p[X_F], p[DELTA], p[DRAG], p[OMEGA]) = (1.0, x_f, delta, drag, oscillator.omega_d());
            let position = wave(&time, &signal, None);
            let fit = minimise(&position, &p, &free).expect("fits");
            let velocity: Vec<f64> = states.iter().map(|state| state.velocity).collect();
            let mut in_signal = p.clone();
            in_signal[..2].iter_mut().for_each(|length| *length *= p[OMEGA]);
            in_signal[DRAG] /= p[OMEGA];
            let velocity = Waveform { observable: Observable::Velocity, ..wave(&time, &velocity, None) };
            [residuals(&position, &p), fit.rss, residuals(&velocity, &in_signal) / p[OMEGA].powi(2)]
                .map(|rss| (rss / 600.0).sqrt())
        });
        // Four times the quality factor gives a sixteenth of the error.
        for [here, there] in [[left[0], left[1]], [left[1], left[2]]] {
            assert!(there.iter().zip(here).all(|(there, here)| *there < here / 14.0), "{left:?}");
        }
        assert!(left[1][0] < 2e-5 && left[1][1] < 3e-6 && left[1][2] < 4e-5, "{left:?}");
    }
}

/// With the level of the rest free, a shift of all samples at rest has no effect, and the gradient with
/// respect to the offsets is that of the remaining residuals.
#[test]
fn the_samples_at_rest_have_their_own_level() {
    let oscillator = Oscillator::kinematic(7.0, 0.02, 0.01).expect("valid");
    let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
    let stop = decay.stop().expect("stops").time_s;
    let time: Vec<f64> = (0..900).map(|i| f64::from(i) * 1.5 * stop / 900.0).collect();
    let signal: Vec<f64> = time.iter().map(|&t| decay.displacement(t) + 0.003 * (31.0 * t).sin()).collect();
    let lifted = |by: f64| -> Vec<f64> {
        time.iter().zip(&signal).map(|(&t, x)| x + if t > stop { by } else { 0.0 }).collect()
    };
    let (inside, outside) = (lifted(0.004), lifted(0.2));
    let mut p = [0.0; COUNT];
    (p[A0], p[X_F], p[DELTA], p[OMEGA]) = (1.0, 0.01, 0.02, oscillator.omega_d());
    (p[OFFSET], p[OFFSET + 1]) = (0.001, 0.002);
    let free = |signal| Waveform { rest: RestLevel::Bounded, ..wave(&time, signal, None) };
    // Anywhere within `±x_F` the level fits equally well, beyond it does not.
    let rss = residuals(&free(&signal), &p);
    assert!((residuals(&free(&inside), &p) / rss - 1.0).abs() < 1e-9);
    assert!(residuals(&free(&outside), &p) > 2.0 * rss);
    for lifted in [&inside, &outside] {
        let wave = free(lifted);
        let mut out = Normal::zeros(COUNT);
        assert!(wave.normal(&p, &mut out));
        let listed: f64 = wave.residuals(&p).iter().map(|r| r * r).sum();
        assert!((listed / out.rss - 1.0).abs() < 1e-9);
        for k in [OFFSET, OFFSET + 1, OFFSET + 2] {
            let h = 1e-6;
            let (mut up, mut down) = (p, p);
            up[k] += h;
            down[k] -= h;
            let numeric = -(residuals(&wave, &up) - residuals(&wave, &down)) / (4.0 * h);
            let error = (out.jtr[k] - numeric).abs() / (out.jtj[(k, k)] * out.rss).sqrt();
            assert!(error < 1e-6, "parameter {k}: {} against {numeric}", out.jtr[k]);
        }
    }
}

/// A level at the limit `±x_F` moves with it: apart from the motion before the rest, this is the whole
/// derivative of the samples at rest.
#[test]
fn the_level_on_its_limit_follows_the_friction() {
    let time: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.5).collect();
    let signal: Vec<f64> = time.iter().map(|t| 0.3 + 0.1 * (3.0 * t).sin()).collect();
    let mut p = [0.0; COUNT];
    (p[A0], p[X_F], p[DELTA], p[OMEGA], p[PHASE]) = (1.0, 0.02, 0.01, 7.0, 0.4);
    let sums = |rest: RestLevel| {
        let mut out = Normal::zeros(COUNT);
        assert!(Waveform { rest, ..wave(&time, &signal, None) }.normal(&p, &mut out));
        out
    };
    let out = sums(RestLevel::Bounded);
    let at_rest = |p: &[f64; COUNT]| {
        let wave = Waveform { rest: RestLevel::Bounded, ..wave(&time, &signal, None) };
        let residuals = wave.residuals(p);
        residuals[residuals.len() / 2..].iter().map(|r| r * r).sum::<f64>()
    };
    let h = 1e-7;
    let (mut up, mut down) = (p, p);
    up[X_F] += h;
    down[X_F] -= h;
    let numeric = -(at_rest(&up) - at_rest(&down)) / (4.0 * h);
    // The second half of the samples is long at rest.
    let half: f64 = signal[100..].iter().map(|x| x - p[X_F]).sum();
    assert!((numeric / half - 1.0).abs() < 1e-6, "{numeric} against {half}");
    assert!(out.jtj[(X_F, X_F)] >= 100.0, "{}", out.jtj[(X_F, X_F)]);
}

/// Near the reference the gathered sums agree with those of all samples, with and without a stop among them;
/// the neglected terms are of second order over a twelfth of the window.
#[test]
fn sums_that_were_gathered_are_those_of_all_samples() {
    use Observable::{Acceleration, Displacement, Velocity};
    let cases = [(0.004, 1.0, Displacement), (0.02, 1.4, Displacement)];
    // Friction makes an acceleration jump at each turning point, which the gathered sums cannot reproduce for
    // other motions.
    let derivatives = [(0.004, 1.0, Velocity), (0.02, 1.4, Velocity), (1e-5, 1.0, Acceleration)];
    for (x_f, length, observable) in cases.into_iter().chain(derivatives) {
        let oscillator = Oscillator::kinematic(7.0, 0.05, x_f).expect("valid");
        let decay = FreeDecay::from_rest(&oscillator, 1.0).expect("valid");
        let stop = decay.stop().expect("stops").time_s;
        let time: Vec<f64> = (0..3000).map(|i| f64::from(i) * length * stop.min(30.0) / 3000.0).collect();
        let noise = |i: usize| 0.05 * ((i * 7919) % 101) as f64 / 101.0;
        let mut p = [0.0; COUNT];
        (p[A0], p[X_F], p[DELTA], p[OMEGA], p[OFFSET]) = (1.0, x_f, 0.05, oscillator.omega_d(), 0.025);
        p[PHASE] = -observable.phase_lead();
        let nothing = vec![0.0; time.len()];
        let model = Waveform { observable, ..wave(&time, &nothing, None) }.residuals(&p);
        let signal: Vec<f64> = model.iter().enumerate().map(|(i, x)| noise(i) - 0.025 - x).collect();
        let exact = Waveform { observable, ..wave(&time, &signal, None) };
        let gathered = exact.clone().gathered_about(&p);
        assert!(gathered.gathered.is_some());
        let accurate = gathered.accurate();
        let free = [A0, X_F, DELTA, DRAG, PHASE, OMEGA, OFFSET];
        let sums = |problem: &Waveform, p: &[f64]| {
            let mut out = Normal::zeros(COUNT);
            assert!(problem.normal_of(p, &free, &mut out, f64::INFINITY));
            out
        };
        let here = sums(&exact, &p);
        let at_reference = sums(&gathered, &p);
        for (k, i) in free.iter().flat_map(|k| free.iter().map(move |i| (*k, *i))).filter(|(k, i)| i <= k) {
            let scale = (here.jtj[(k, k)] * here.jtj[(i, i)]).sqrt();
            let off = (at_reference.jtj[(k, i)] - here.jtj[(k, i)]).abs() / scale;
            assert!(off < 1e-5, "{observable:?} {k} {i}: {off}");
        }
        let steps = [
            (A0, 3e-3),
            (X_F, 1e-4),
            (DELTA, 5e-4),
            (DRAG, 5e-4),
            (PHASE, 3e-3),
            (OMEGA, 3e-4),
            (OFFSET, 3e-3),
        ];
        for (k, by) in steps {
            let mut q = p;
            q[k] += by;
            let (all, near) = (sums(&exact, &q), sums(&gathered, &q));
            let rise = by * by * here.jtj[(k, k)];
            assert!(
                (near.rss - all.rss).abs() < 2e-3 * rise,
                "{observable:?} {k}: {} for {}, {rise}",
                near.rss,
                all.rss
            );
            for &i in &free {
                let scale = (all.jtj[(i, i)] * rise).sqrt();
                let miss = (near.jtr[i] - all.jtr[i]).abs() / scale;
                assert!(miss < 0.02, "{k} {i}: {miss}");
                assert!((near.jtj[(i, i)] / all.jtj[(i, i)] - 1.0).abs() < 3e-3, "{k} {i}");
            }
            // With `accurate`, no parameter moves by more than a thousandth of its error, or of the deviation
            // of the motion.
            let close = sums(&accurate, &q);
            let off = (all.rss / 3000.0 + rise).sqrt();
            for &i in &free {
                let miss = (close.jtr[i] - all.jtr[i]).abs() / (all.jtj[(i, i)].sqrt() * off);
                assert!(miss < 2e-3, "{observable:?} {k} {i}: {miss}");
            }
        }
        // Motions far from the reference are summed sample by sample.
        let mut far = p;
        far[OMEGA] += 0.2;
        assert_eq!(sums(&gathered, &far).rss, sums(&exact, &far).rss);
    }
}

/// `Jᵀr` is minus half the gradient of `rᵀr`.
#[test]
fn the_gradient_holds_for_every_parameter() {
    let time: Vec<f64> = (0..300).map(|i| i as f64 * 0.05 + 0.003 * (i % 7) as f64).collect();
    let signal: Vec<f64> = time.iter().map(|t| (-0.1 * t).exp() * (5.1 * t + 0.3).cos() + 0.1).collect();
    let backbone = BackboneIntegral::along(|t| 1.1 * (-0.12 * t).exp(), 15.1);
    for observable in [Observable::Displacement, Observable::Velocity, Observable::Acceleration] {
        let wave = Waveform { observable, ..wave(&time, &signal, Some(backbone.clone())) };
        let mut p = [0.0; COUNT];
        p[..SHAPE].fill(0.01);
        p[SHAPE..PHASE].fill(1.5);
        p[..4].copy_from_slice(&[1.1, 0.02, 0.08, 0.03]);
        p[PHASE..].copy_from_slice(&[0.7, 5.0, 0.0, 0.002, 0.05, 0.02, -0.03]);
        let mut out = Normal::zeros(COUNT);
        assert!(wave.normal(&p, &mut out));
        for k in 0..COUNT {
            let h = 1e-6;
            let (mut up, mut down) = (p, p);
            up[k] += h;
            down[k] -= h;
            let numeric = -(residuals(&wave, &up) - residuals(&wave, &down)) / (4.0 * h);
            // The backbone also changes the loss terms, which its derivative neglects; inside a half cycle
            // its shapes are taken as straight lines.
            let tolerance = match k {
                BACKBONE => 0.2,
                CHIRP => 2e-3,
                // The derivative by the shape is curved inside a half cycle.
                k if (SHAPE..PHASE).contains(&k) => 2e-4,
                _ => 2e-5,
            };
            // For a derivative, the change of the phase rate inside a half cycle is neglected as well.
            let tolerance = if observable == Observable::Displacement { tolerance } else { 10.0 * tolerance };
            let error = (out.jtr[k] - numeric).abs() / (out.jtj[(k, k)] * out.rss).sqrt();
            assert!(error < tolerance, "{observable:?} {k}: {} against {numeric}", out.jtr[k]);
        }
    }
}

/// Compares the closed-form motion with the kernel for arbitrary losses, including a rest.
#[test]
fn sums_of_parts_are_the_same_by_both_kernels() {
    let time: Vec<f64> = (0..600).map(|i| 0.011 * f64::from(i)).collect();
    let signal: Vec<f64> = (0..600).map(|i| jitter(i, 17)).collect();
    let mut p = [0.0; COUNT];
    (p[A0], p[X_F], p[DELTA], p[OMEGA], p[PHASE], p[OFFSET]) = (1.0, 0.06, 0.2, 9.0, 0.4, 0.1);
    let free = [A0, DELTA, X_F, PHASE, OMEGA, OFFSET];
    let borders = [0, 37, 37, 300, 590];
    for rest in [RestLevel::Exact, RestLevel::Free] {
        let wave = Waveform { rest, ..wave(&time, &signal, None) };
        let closed = wave.closed_parts(&p, &free, &borders).expect("nothing but these losses");
        let any = wave.window(&free).sums_of_parts(&p, &borders, None).expect("a motion");
        assert_eq!(closed.len(), borders.len() + 1);
        for (part, (a, b)) in closed.iter().zip(&any).enumerate() {
            assert_eq!(a.len(), b.len());
            for (x, y) in a.iter().zip(b) {
                // One of them computes its derivatives by Simpson's rule.
                assert!((x - y).abs() < 1e-6 * (1.0 + y.abs()), "{rest:?}, part {part}: {x} for {y}");
            }
        }
    }
    p[DRAG] = 0.01;
    assert!(wave(&time, &signal, None).closed_parts(&p, &free, &borders).is_none());
}

/// With drag the amplitude law may leave an arbitrarily small last half cycle: derivatives must not be
/// divided by it.
#[test]
fn derivatives_hold_where_the_last_swing_vanishes() {
    const FRICTION: f64 = 0.0117;
    let time: Vec<f64> = (0..612).map(|i| f64::from(i) * 0.01).collect();
    let signal = vec![0.0; time.len()];
    let at = |a_0: f64| {
        let mut p = [0.0; COUNT];
        (p[A0], p[X_F], p[DRAG], p[OMEGA]) = (a_0, FRICTION, 0.46, 31.4);
        p
    };
    let level = |a_0: f64| wave(&time, &signal, None).residuals(&at(a_0))[time.len() - 1].abs();
    let bisected = |[mut low, mut high]: [f64; 2], lies_above: &dyn Fn(f64) -> bool| {
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if lies_above(middle) { &mut high } else { &mut low }) = middle;
        }
        [low, high]
    };
    // The stop position increases until the spring overcomes the friction once more, slightly above x_F.
    let from = (0..100).map(|i| 1.0 + 1e-3 * f64::from(i)).find(|a_0| level(*a_0) < 1e-3).expect("near zero");
    let mut to = from;
    while level(to) < FRICTION {
        to += 2e-6;
    }
    let [low, high] = bisected([to, to + 1e-4], &|a_0| level(a_0) < FRICTION);
    for a_0 in [low, high, high + 1e-12, high + 1e-10, high + 1e-8] {
        let mut out = Normal::zeros(COUNT);
        assert!(wave(&time, &signal, None).normal(&at(a_0), &mut out));
        // Each sample contributes at most one.
        let square = out.jtj[(A0, A0)];
        assert!(square <= time.len() as f64, "{a_0}: {square}");
    }
}
