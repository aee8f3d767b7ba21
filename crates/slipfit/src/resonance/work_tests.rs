//! Counted work of difficult curves: curves of few points or of 401 points end within the allowed work.

use super::analyse::analyse_within;
use super::criteria::Criteria;
use super::work::Work;
use super::{Curve, Options};
use crate::motion::steady::Phasor;
use crate::noise::jitter;

/// Ratio of the work of the default analysis to that allowed for the search and the intervals; a pass that has started
/// is finished.
fn work_over_allowed(curve: &Curve) -> f64 {
    let criteria = Criteria::default();
    let allowed = criteria.search.work(curve.len());
    let work = Work::limited(allowed);
    let _ = analyse_within(curve, curve, &Options::default(), &criteria, &work);
    work.spent() as f64 / allowed as f64
}

/// The search, the loss models and the intervals, each with a sixteenth more in closed form after its end; in addition
/// the points that are reported, a hundredth each.
const MOST: f64 = 1.0625 * (1.0 + 0.15 + 0.17) + 0.3;

fn amplitudes(frequency_hz: Vec<f64>, amplitude: Vec<f64>) -> Curve {
    Curve::builder(frequency_hz, amplitude).build().unwrap()
}

#[test]
fn seven_to_twelve_points_end() {
    for n in 7..=12 {
        let index: Vec<f64> = (1..=n).map(f64::from).collect();
        let mut last = index.clone();
        last[index.len() - 1] = 1000.0;
        let mut far = index.clone();
        far[index.len() - 1] = 1e9;
        let mut slow = index.clone();
        slow[0] = 1e-9;
        let noise: Vec<f64> = (0..n).map(|i| jitter(i as usize, 3).abs()).collect();
        let single: Vec<f64> = (0..n).map(|i| if i == n / 2 { 1e6 } else { 1.0 }).collect();
        for (what, f, a) in [
            ("rising amplitudes and one far off", &last, &index),
            ("rising amplitudes and one much farther off", &far, &index),
            ("a drive far slower than the rest", &slow, &noise),
            ("noise", &index, &noise),
            ("one point of a million", &index, &single),
        ] {
            let share = work_over_allowed(&amplitudes(f.clone(), a.clone()));
            assert!(share < MOST, "{n} points, {what}: {share}");
        }
    }
}

#[test]
fn four_hundred_points_end() {
    let hz: Vec<f64> = (0..401).map(|i| 10.0 + 0.05 * f64::from(i)).collect();
    let noise = |seed: u64| (0..401).map(|i| jitter(i, seed)).collect::<Vec<f64>>();
    let step: Vec<f64> = hz.iter().map(|f| if *f < 20.0 { 1.0 } else { 0.2 }).collect();
    let swing: Vec<f64> = (0..401).map(|i| (0.3 * f64::from(i)).cos().abs()).collect();
    let mut curves = vec![
        ("noise", amplitudes(hz.clone(), noise(1).iter().map(|v| v.abs() + 1e-3).collect())),
        ("a step", amplitudes(hz.clone(), step)),
        ("a swing", amplitudes(hz.clone(), swing)),
    ];
    let z = noise(2).into_iter().zip(noise(3)).map(|(a, b)| Phasor::new(a, b)).collect();
    curves.push(("noise with phases", Curve::complex(hz, z).build().unwrap()));
    for (what, curve) in curves {
        let share = work_over_allowed(&curve);
        assert!(share < MOST, "{what}: {share}");
    }
}

/// The delay is so long that the phases increase through the resonance: as measured they fit no resonance.
#[test]
fn a_plain_curve_without_end_leaves_work_for_a_delay() {
    use super::analyse::analyse;
    use crate::motion::steady::scan;
    let q = 5000.0;
    let o = crate::Oscillator::builder().frequency_hz(1.0).q_factor(q).build().unwrap();
    let place: Vec<f64> = (0..401).map(|i| -9.0 + 0.045 * f64::from(i)).collect();
    let hz: Vec<f64> = place.iter().map(|nu| 1.0 + nu / (2.0 * q)).collect();
    let seen = place.iter().zip(&hz).enumerate().map(|(i, (nu, f))| {
        let noise = Phasor::new(jitter(i, 1), jitter(i, 2)) * (q / 900.0);
        scan::reading(&o, 1.0, *f).unwrap().fundamental * Phasor::from_polar(1.0, 0.56 * nu) + noise
    });
    let seen: Vec<Phasor> = seen.collect();
    let amplitude = seen.iter().map(|z| z.norm()).collect();
    let phase = seen.iter().map(|z| z.arg()).collect();
    let curve = Curve::builder(hz, amplitude).phase_rad(phase).build().unwrap();
    let answer = analyse(&curve, &Options::default()).unwrap();
    let delta = answer.parameter(crate::Parameter::DECAY_RATE).unwrap().value;
    assert!((delta * q / std::f64::consts::PI - 1.0).abs() < 0.02, "{delta}");
}
