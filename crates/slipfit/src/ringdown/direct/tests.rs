use super::envelope::{self, Trace};
use super::samples::{Pass, Stop};
use super::*;
use crate::motion::decay::FreeDecay;
use crate::{Error, Oscillator};
use std::f64::consts::{PI, TAU};

/// SplitMix64, uniform on ±0.5.
pub(in crate::ringdown) fn noise(i: usize) -> f64 {
    let mut z = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

fn decay(q: f64, x_f: f64, times: &[f64]) -> (Decay, Vec<f64>) {
    let omega_0 = 7.0;
    let delta = omega_0 / (2.0 * q);
    let oscillator = Oscillator::kinematic(omega_0, delta, x_f).unwrap();
    let motion = FreeDecay::from_rest(&oscillator, 1.0).unwrap();
    let truth = Decay {
        initial_amplitude: 1.0,
        friction_displacement: x_f,
        decay_rate_per_s: delta,
        phase_rad: 0.0,
        frequency_hz: oscillator.omega_d() / TAU,
        offset: 0.3,
    };
    (truth, times.iter().map(|&t| motion.displacement(t) + 0.3).collect())
}

fn away(truth: &Decay) -> Decay {
    Decay {
        initial_amplitude: 1.05 * truth.initial_amplitude,
        friction_displacement: 0.0,
        decay_rate_per_s: 0.8 * truth.decay_rate_per_s,
        phase_rad: 0.2,
        frequency_hz: 1.004 * truth.frequency_hz,
        offset: 0.0,
    }
}

fn list(d: &Decay) -> [f64; 6] {
    [d.initial_amplitude, d.friction_displacement, d.decay_rate_per_s, d.phase_rad, d.frequency_hz, d.offset]
}

#[test]
fn the_exact_motion_is_recovered_to_rounding() {
    for (q, x_f) in [(3.0, 0.005), (50.0, 0.01), (1000.0, 0.001), (1e6, 0.002)] {
        for uneven in [0.0, 0.01] {
            let times: Vec<f64> = (0..900).map(|i| i as f64 * 0.021 + uneven * noise(i)).collect();
            // Only before the stop: beyond it there is a minimum for every half cycle.
            let end = if q < 10.0 { 3.0 } else { 12.0 };
            let times: Vec<f64> = times.iter().map(|t| t - times[0]).filter(|&t| t < end).collect();
            let (truth, signal) = decay(q, x_f, &times);
            let fit = fit_waveform(&times, &signal, &away(&truth)).unwrap();
            assert!(fit.converged, "Q {q}: {fit:?}");
            for (found, put_in) in list(&fit.best).iter().zip(list(&truth)) {
                assert!((found - put_in).abs() < 1e-9, "Q {q}, {uneven}: {:?} for {truth:?}", fit.best);
            }
        }
    }
}

#[test]
fn a_record_that_runs_into_the_rest_is_fitted_whole() {
    let times: Vec<f64> = (0..1500).map(|i| i as f64 * 0.02).collect();
    let (truth, signal) = decay(100.0, 0.04, &times);
    let start = Decay { friction_displacement: 0.0399, ..truth };
    let fit = fit_waveform(&times, &signal, &start).unwrap();
    assert!((fit.best.friction_displacement - 0.04).abs() < 1e-9, "{fit:?}");
}

/// Records that extend past the stop by a twentieth to three times the duration of the motion, of 2 to 400
/// half cycles, from start values without friction.
#[test]
fn no_converged_answer_lies_above_the_truth_where_the_record_goes_on_past_the_stop() {
    let uniform = |i: usize, low: f64, high: f64| low + (high - low) * (noise(i) + 0.5);
    let (mut stopped, mut above) = (0, Vec::new());
    for i in 0..600 {
        let q = 10f64.powf(uniform(10 * i, 0.8, 2.6));
        let share = uniform(10 * i + 1, 0.05, 0.95);
        let x_f = (share / (1.0 - share) * PI / q / 4.0).min(uniform(10 * i + 2, 0.02, 0.2));
        let scatter = 10f64.powf(uniform(10 * i + 3, -4.0, -1.0));
        let delta = 7.0 / (2.0 * q);
        let motion = FreeDecay::from_rest(&Oscillator::kinematic(7.0, delta, x_f).unwrap(), 1.0).unwrap();
        let end = motion.stop().unwrap().time_s * (1.0 + uniform(10 * i + 4, 0.05, 3.0));
        let count = (end * 14.0).clamp(300.0, 4000.0);
        let times: Vec<f64> = (0..count as usize).map(|k| k as f64 * end / count).collect();
        let (truth, clean) = decay(q, x_f, &times);
        let jitter = |k: usize| scatter * 12f64.sqrt() * noise(100_000 + 5000 * i + k);
        let signal: Vec<f64> = clean.iter().enumerate().map(|(k, x)| x + jitter(k)).collect();
        let start = Decay {
            initial_amplitude: uniform(10 * i + 5, 0.8, 1.2),
            friction_displacement: 0.0,
            decay_rate_per_s: delta * uniform(10 * i + 6, 0.5, 2.0),
            phase_rad: uniform(10 * i + 7, -0.4, 0.4),
            ..truth
        };
        let Ok(fit) = fit_waveform(&times, &signal, &start) else { continue };
        stopped += usize::from(fit.converged);
        let left = fit.residual_rms.powi(2) * times.len() as f64;
        let least: f64 = (0..times.len()).map(|k| jitter(k).powi(2)).sum();
        if fit.converged && left > least * (1.0 + 1e-9) {
            above.push((i, left / least));
        }
    }
    assert!(stopped > 560, "{stopped} of 600 converged");
    assert!(above.is_empty(), "{above:?}");
}

/// `Jᵀr` is minus half the gradient of `rᵀr`, at low and high Q, with and without a rest.
#[test]
fn the_gradient_holds_for_every_parameter() {
    let times: Vec<f64> = (0..800).map(|i| i as f64 * 0.023 + 0.01 * noise(i)).collect();
    let signal: Vec<f64> = times.iter().map(|t| (-0.1 * t).exp() * (5.1 * t + 0.3).cos() + 0.1).collect();
    let sums = |p: &[f64; 6], stop: Stop| {
        crate::numeric::dispatch(Pass {
            time: &times,
            signal: &signal,
            origin: times[0],
            p,
            stop,
            models_rest_position: true,
            borders: &[],
            parts: &mut Vec::new(),
        })
        .unwrap()
    };
    for p in [
        [1.1, 0.01, 0.08, 0.7, 5.0, 0.05],
        [1.1, 0.02, 1.3, -0.4, 5.0, 0.05],
        [1.1, 0.002, -0.003, 4.0, 5.0, 0.05],
        [0.9, 0.05, 0.0, 0.2, 5.3, 0.0],
    ]
    .into_iter()
    .flat_map(|p| [(p, Stop::Never), (p, Stop::Friction), (p, Stop::Turn(9.0))])
    {
        let (p, stop) = p;
        let here = sums(&p, stop);
        for k in 0..6 {
            let h = 1e-6;
            let (mut up, mut down) = (p, p);
            up[k] += h;
            down[k] -= h;
            let numeric = -(sums(&up, stop).rss - sums(&down, stop).rss) / (4.0 * h);
            let error = (here.jtr[k] - numeric).abs() / (here.jtj[k][k] * here.rss).sqrt();
            assert!(error < 1e-7, "parameter {k} of {p:?}: {} against {numeric}", here.jtr[k]);
        }
    }
}

#[test]
fn standard_errors_tell_the_scatter() {
    let times: Vec<f64> = (0..2000).map(|i| i as f64 * 0.02).collect();
    let (truth, clean) = decay(80.0, 0.002, &times);
    let mut squares = [0.0; 6];
    let runs = 120;
    for run in 0..runs {
        let signal: Vec<f64> =
            clean.iter().enumerate().map(|(i, x)| x + 0.05 * noise(i * 131 + run * 1_000_003)).collect();
        let fit = fit_waveform(&times, &signal, &truth).unwrap();
        for (k, square) in squares.iter_mut().enumerate() {
            let z = (list(&fit.best)[k] - list(&truth)[k]) / list(&fit.std_error)[k];
            *square += z * z / runs as f64;
        }
    }
    // The mean of 120 squares has a standard deviation of 0.13; the tolerance is five times that.
    assert!(squares.iter().all(|s| (s - 1.0).abs() < 0.65), "{squares:?}");
}

#[test]
fn envelopes_of_even_and_uneven_clocks_agree_with_the_truth() {
    for n in [4, 63, 64, 200, 512, 1234] {
        for uneven in [0.0, 0.3] {
            let times: Vec<f64> =
                (0..n).map(|i| 5.0 + (i as f64 + uneven * noise(i)) * 2.0 / n as f64).collect();
            let trace: Vec<f64> = times.iter().map(|t| 1.4 * (-0.9 * (t - times[0])).exp() - 0.4).collect();
            let start =
                EnvelopeStart { initial_amplitude: 0.8, offset_amplitude: 0.1, decay_rate_per_s: 0.4 };
            let fit = fit_envelope(&times, &trace, &start).unwrap();
            let found = [fit.best.initial_amplitude, fit.best.offset_amplitude, fit.best.decay_rate_per_s];
            for (found, truth) in found.iter().zip([1.0, 0.4, 0.9]) {
                assert!((found - truth).abs() < 1e-9, "{n}, {uneven}: {fit:?}");
                assert!(fit.converged, "{n}, {uneven}: {fit:?}");
            }
        }
    }
}

/// The two methods of summation agree, on data that no decay fits.
#[test]
fn an_even_clock_only_changes_the_speed() {
    for n in [5, 64, 777, 3000] {
        let time: Vec<f64> = (0..n).map(|i| 2.0 + i as f64 * 0.01).collect();
        let amplitude: Vec<f64> = (0..n).map(|i| (-(i as f64) * 0.004).exp() + 0.02 * noise(i)).collect();
        for rate in [0.3, 2.0, -0.1] {
            let sums = |interval| {
                let data = Trace { time: Some(&time), amplitude: &amplitude, first: 2.0, interval };
                crate::numeric::dispatch(envelope::Pass { data: &data, height: 0.9, level: 0.1, rate })
            };
            let (tabled, plain) = (sums(Some(0.01)), sums(None));
            assert!((tabled.rss / plain.rss - 1.0).abs() < 1e-11, "{n}, {rate}");
            for i in 0..3 {
                let scale = (plain.jtj[i][i] * plain.rss).sqrt();
                assert!((tabled.jtr[i] - plain.jtr[i]).abs() < 1e-11 * scale, "{n}, {rate}, {i}");
                for k in 0..3 {
                    let error = tabled.jtj[i][k] - plain.jtj[i][k];
                    assert!(error.abs() < 1e-11 * plain.jtj[i][k].abs(), "{n}, {rate}, {i}, {k}");
                }
            }
        }
    }
}

#[test]
fn what_cannot_be_fitted_is_refused_by_name() {
    let times: Vec<f64> = (0..50).map(|i| i as f64 * 0.1).collect();
    let (truth, signal) = decay(20.0, 0.01, &times);
    let with = |i: usize, v: f64| {
        let mut s = signal.clone();
        s[i] = v;
        s
    };
    assert!(matches!(fit_waveform(&times, &signal[1..], &truth), Err(Error::Length { .. })));
    assert!(matches!(fit_waveform(&times[..6], &signal[..6], &truth), Err(Error::TooFewSamples { .. })));
    for bad in [f64::NAN, f64::INFINITY] {
        let found = fit_waveform(&times, &with(17, bad), &truth);
        assert!(matches!(found, Err(Error::Parameter { name: "signal", .. })), "{found:?}");
        assert!(matches!(fit_waveform(&with(17, bad), &signal, &truth), Err(Error::Parameter { .. })));
    }
    let mut back = times.clone();
    back[20] = 0.0;
    assert!(matches!(fit_waveform(&back, &signal, &truth), Err(Error::TimeBackwards { index: 20, .. })));
    let still = Decay { frequency_hz: 0.0, ..truth };
    assert!(matches!(
        fit_waveform(&times, &signal, &still),
        Err(Error::Parameter { name: "frequency_hz", .. })
    ));
    assert!(matches!(fit_waveform(&[1.0; 50], &signal, &truth), Err(Error::NoFit { .. })));

    let start = EnvelopeStart { initial_amplitude: 1.0, offset_amplitude: 0.1, decay_rate_per_s: 0.2 };
    assert!(matches!(fit_envelope(&times, &signal[1..], &start), Err(Error::Length { .. })));
    assert!(matches!(fit_envelope(&times[..3], &signal[..3], &start), Err(Error::TooFewSamples { .. })));
    assert!(matches!(
        fit_envelope(&times, &with(3, f64::NAN), &start),
        Err(Error::Parameter { name: "amplitude", .. })
    ));
    assert!(matches!(fit_envelope(&[2.0; 50], &signal, &start), Err(Error::NoFit { .. })));
    // For amplitudes without curvature the start rate used to be returned as if it had been measured.
    for constant in [2.0, 0.0, -3e7, 1e-30] {
        for decay_rate_per_s in [0.01, 0.2, 5.0, -1.0] {
            let found = fit_envelope(
                &times,
                &vec![constant; times.len()],
                &EnvelopeStart { decay_rate_per_s, ..start },
            );
            assert!(matches!(found, Err(Error::NoFit { .. })), "{constant}: {found:?}");
        }
    }
    let nan = EnvelopeStart { decay_rate_per_s: f64::NAN, ..start };
    assert!(fit_envelope(&times, &signal, &nan).is_err());
}

/// Amplitudes under both losses, in closed form.
fn both_losses(initial: f64, sliding: f64, delta: f64, times: &[f64]) -> Vec<f64> {
    let gone = |t: f64| if delta == 0.0 { t } else { -(-delta * t).exp_m1() / delta };
    times.iter().map(|&t| initial * (-delta * t).exp() - sliding * gone(t)).collect()
}

#[test]
fn losses_are_recovered_from_nothing_viscous_to_nothing_sliding() {
    // Over one second, from a straight line across the limit of the series to a steep decay.
    for delta in [0.0, 1e-6, 1e-4, 9.9e-3, 1.01e-2, 0.1, 1.0, 4.0, -0.3] {
        for sliding in [0.0, 0.02, 0.6] {
            for n in [4, 7, 64, 200, 512, 1234] {
                let times: Vec<f64> = (0..n).map(|i| i as f64 / (n - 1) as f64).collect();
                let uneven: Vec<f64> =
                    times.iter().enumerate().map(|(i, t)| t + 0.2 * noise(i) / n as f64).collect();
                if sliding == 0.0 && delta == 0.0 {
                    continue;
                }
                let interval = 1.0 / (n - 1) as f64;
                let even =
                    fit_amplitudes(Sampling::Every(interval), &both_losses(1.0, sliding, delta, &times));
                let own: Vec<f64> = uneven.iter().map(|t| t - uneven[0]).collect();
                let other = fit_amplitudes(Sampling::At(&uneven), &both_losses(1.0, sliding, delta, &own));
                for fit in [even.unwrap(), other.unwrap()] {
                    let found = [fit.initial_amplitude, fit.sliding_rate, fit.decay_rate_per_s];
                    for ([found, _], truth) in found.iter().zip([1.0, sliding, delta]) {
                        assert!((found - truth).abs() < 1e-7, "{n}, {delta}, {sliding}: {fit:?}");
                    }
                    assert!(fit.converged, "{n}, {delta}, {sliding}: {fit:?}");
                }
            }
        }
    }
}

/// With noise both fits find the same minimum, since they fit the same law.
#[test]
fn the_law_is_that_of_the_envelope() {
    let times: Vec<f64> = (0..512).map(|i| i as f64 * 0.01).collect();
    for (sliding, delta) in [(0.1, 0.4), (0.05, 0.2), (0.0, 0.8)] {
        let clean = both_losses(1.0, sliding, delta, &times);
        let trace: Vec<f64> = clean.iter().enumerate().map(|(i, a)| a + 0.02 * noise(i)).collect();
        let start = EnvelopeStart { initial_amplitude: 1.0, offset_amplitude: 0.1, decay_rate_per_s: delta };
        let envelope = fit_envelope(&times, &trace, &start).unwrap();
        let fit = fit_amplitudes(Sampling::Every(0.01), &trace).unwrap();
        let pairs = [
            (fit.initial_amplitude, envelope.best.initial_amplitude, envelope.std_error.initial_amplitude),
            (fit.decay_rate_per_s, envelope.best.decay_rate_per_s, envelope.std_error.decay_rate_per_s),
        ];
        for ([value, error], other, other_error) in pairs {
            // Both stop within a hundredth of a standard error.
            assert!((value - other).abs() < 0.02 * error, "{fit:?} {envelope:?}");
            assert!((error / other_error - 1.0).abs() < 1e-2, "{fit:?} {envelope:?}");
        }
    }
}

#[test]
fn standard_errors_of_amplitudes_tell_the_scatter() {
    let times: Vec<f64> = (0..300).map(|i| i as f64 * 0.01).collect();
    for (sliding, delta) in [(0.25, 0.0), (0.1, 0.3), (0.0, 0.7)] {
        let clean = both_losses(1.0, sliding, delta, &times);
        let runs = 200;
        let mut squares = [0.0; 4];
        for run in 0..runs {
            let trace: Vec<f64> =
                clean.iter().enumerate().map(|(i, a)| a + 0.02 * noise(i * 131 + run * 1_000_003)).collect();
            let fit = fit_amplitudes(Sampling::Every(0.01), &trace).unwrap();
            let x_f = fit.friction_displacement(8.0);
            let omega = TAU * 8.0;
            let truth_x_f = sliding / crate::motion::decay::amplitude::sliding_gain(delta, omega)[0];
            let all = [
                (fit.initial_amplitude, 1.0),
                (fit.sliding_rate, sliding),
                (fit.decay_rate_per_s, delta),
                (x_f, truth_x_f),
            ];
            for (square, ([value, error], truth)) in squares.iter_mut().zip(all) {
                *square += ((value - truth) / error).powi(2) / runs as f64;
            }
        }
        // The mean of 200 squares has a standard deviation of 0.1; the tolerance is five times that.
        assert!(squares.iter().all(|s| (s - 1.0).abs() < 0.5), "{sliding}, {delta}: {squares:?}");
    }
}

#[test]
fn the_p_value_of_sliding_friction_is_that_of_its_tail() {
    let fit = |rate: f64| AmplitudeFit {
        initial_amplitude: [1.0, 0.1],
        sliding_rate: [rate, 1.0],
        decay_rate_per_s: [0.0, 1.0],
        correlation: 0.0,
        residual_rms: 1.0,
        lack_of_fit: [0.0; 2],
        converged: true,
        steps: 1,
    };
    assert_eq!(fit(-2.0).sliding_p_value(500), 1.0);
    // One-sided 5 % and 1 % points of the normal distribution; then of Student's t with 10 degrees of
    // freedom.
    assert!((fit(1.644_85).sliding_p_value(1_000_000) - 0.05).abs() < 1e-5);
    assert!((fit(2.326_35).sliding_p_value(1_000_000) - 0.01).abs() < 1e-5);
    assert!((fit(1.812_46).sliding_p_value(13) - 0.05).abs() < 1e-5);
    let [near, far] = [203, 204].map(|n| fit(3.0).sliding_p_value(n));
    assert!((near / far - 1.0).abs() < 0.15, "{near} {far}");
    assert_eq!(fit(60.0).sliding_p_value(500), 0.0);
}

#[test]
fn the_series_and_the_exponentials_are_one() {
    let n = 333;
    let times: Vec<f64> = (0..n).map(|i| i as f64 * 0.003).collect();
    let trace: Vec<f64> = times.iter().enumerate().map(|(i, t)| 1.0 - 0.4 * t + 0.05 * noise(i)).collect();
    let data = Trace { time: None, amplitude: &trace, first: 0.0, interval: Some(0.003) };
    for rate in [0.02, -0.015] {
        let (initial, slope) = (0.98, 0.37);
        let straight = crate::numeric::dispatch(amplitudes::Straight { data: &data, initial, slope, rate });
        let height = slope / rate;
        let pass = envelope::Pass { data: &data, height, level: initial - height, rate };
        let bent = amplitudes::by_slope(&crate::numeric::dispatch(pass), height, rate);
        assert!((straight.rss / bent.rss - 1.0).abs() < 1e-12);
        for i in 0..3 {
            let scale = (straight.jtj[i][i] * straight.rss).sqrt();
            assert!((straight.jtr[i] - bent.jtr[i]).abs() < 1e-9 * scale, "{i}");
            for k in 0..3 {
                let scale = (straight.jtj[i][i] * straight.jtj[k][k]).sqrt();
                assert!((straight.jtj[i][k] - bent.jtj[i][k]).abs() < 1e-7 * scale, "{i}, {k}");
            }
        }
    }
}

#[test]
fn amplitudes_that_tell_nothing_are_refused() {
    let every = Sampling::Every(0.1);
    assert!(matches!(fit_amplitudes(every, &[1.0; 3]), Err(Error::TooFewSamples { found: 3, needed: 4 })));
    assert!(matches!(fit_amplitudes(every, &[]), Err(Error::TooFewSamples { .. })));
    assert!(matches!(fit_amplitudes(every, &[1.0; 50]), Err(Error::NoFit { .. })));
    assert!(matches!(fit_amplitudes(every, &[0.0; 50]), Err(Error::NoFit { .. })));
    let hole = [1.0, 0.9, f64::NAN, 0.7, 0.6];
    assert!(matches!(fit_amplitudes(every, &hole), Err(Error::Parameter { name: "amplitude", .. })));
    for interval in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = fit_amplitudes(Sampling::Every(interval), &[1.0, 0.9, 0.8, 0.75]);
        assert!(matches!(found, Err(Error::Parameter { name: "interval_s", .. })), "{interval}");
    }
    let times = [0.0, 1.0, 2.0];
    assert!(matches!(fit_amplitudes(Sampling::At(&times), &hole), Err(Error::Length { .. })));
    assert!(matches!(
        fit_amplitudes(Sampling::At(&[2.0; 5]), &[5.0, 4.0, 3.0, 2.0, 1.0]),
        Err(Error::NoFit { .. })
    ));
}

fn fitted_both_ways(trace: &[f64]) -> [AmplitudeFit; 2] {
    let together = EvenTraces::new(trace.len()).fit(&[(trace, 0.01)]).remove(0).unwrap();
    let times: Vec<f64> = (0..trace.len()).map(|i| 0.01 * i as f64).collect();
    [together, fit_amplitudes(Sampling::At(&times), trace).unwrap()]
}

/// A decay `e^(-delta t)` with a sliding rate and noise; it stays at zero after the stop.
fn ending_trace(samples: usize, delta: f64, sliding: f64, sigma: f64, seed: usize) -> Vec<f64> {
    let value = |i: usize| {
        let t = 0.01 * i as f64;
        let gain = if delta > 0.0 { -(-delta * t).exp_m1() / delta } else { t };
        ((1.0 - delta * gain) - sliding * gain).max(0.0) + sigma * noise(i + seed * samples)
    };
    (0..samples).map(value).collect()
}

#[test]
fn noise_alone_seldom_is_a_misfit() {
    for (delta, sliding) in [(0.3, 0.0), (0.3, 0.1), (0.0, 0.2), (1.5, 0.02), (4.0, 0.0)] {
        let p: Vec<[f64; 2]> = (0..400)
            .map(|seed| {
                fitted_both_ways(&ending_trace(200, delta, sliding, 0.02, seed))
                    .map(|fit| fit.misfit_p_value(200))
            })
            .collect();
        for way in 0..2 {
            // 400 trials at 10 %: 40 ± 6; the tolerance is four times that.
            let few = p.iter().filter(|p| p[way] < 0.1).count();
            assert!((16..=64).contains(&few), "{delta}, {sliding}, {way}: {few}");
            assert!(p.iter().all(|p| p[way] > 3e-5), "{delta}, {sliding}, {way}");
        }
    }
}

#[test]
fn a_motion_that_stops_within_the_trace_is_a_misfit() {
    for fit in fitted_both_ways(&ending_trace(200, 0.3, 1.0, 0.02, 7)) {
        assert!(fit.misfit_p_value(200) < 1e-6, "{fit:?}");
    }
}

#[test]
fn few_samples_and_no_noise_say_nothing() {
    let short = fit_amplitudes(Sampling::Every(0.01), &ending_trace(12, 0.3, 1.0, 0.02, 7)).unwrap();
    assert_eq!(short.misfit_p_value(12), 1.0);
    let constant = AmplitudeFit { lack_of_fit: [0.0; 2], ..short };
    assert_eq!(constant.misfit_p_value(500), 1.0);
}
