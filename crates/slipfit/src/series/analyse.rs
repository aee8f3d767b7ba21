//! The analysis of a series: each measurement alone, compared, and together.

use super::answer::{Answer, ConditionRow, Consistency, Estimate};
use super::criteria::Criteria;
use super::joint::{joint, references};
use super::law::{LoadPoint, friction_against_load};
use super::single::analyse_one;
use super::solved::SolvedMeasurement;
use super::{Condition, Measurement, Options};
use crate::answer::Warning;
use crate::answer::calibration::Calibration;
use crate::inference::evidence::{chi_square_tail, student_factor};
use crate::{Error, Quantity};
use nalgebra::{Matrix2, Vector2};
use std::f64::consts::TAU;

/// Analyses each measurement alone, compares the ways at each condition as Table 1 of
/// Vitorino, Vieira and Rodrigues does, and fits everything jointly.
///
/// For the table every ring-down and curve is described by viscous damping and sliding
/// friction, limits lifted, so that estimates of no friction scatter about zero. Two ways
/// are compared by the difference of `(delta, x_F)` with both covariances:
///
/// ```text
/// chi² = d' (C_1 + C_2)⁻¹ d     with two degrees of freedom
/// ```
///
/// The joint fit is the generalised least squares of all answers with the parameters solved
/// to be shared ([`Options::shared`]); damping and friction of one condition always are. Where
/// what is put together does not agree ([`Criteria::disagree`]), its errors are widened by the root of
/// chi square over its degrees of freedom (R. T. Birge, Phys. Rev. 40, 207, 1932). The mean of one condition is widened by
/// it wherever it exceeds one, and by Student's factor for so few: a few measurements seldom show by a p value that they
/// scatter more than their errors say.
///
/// Limits: answers enter by value and covariance, not by their samples; an answer close to a
/// limit enters by its unbounded estimate. A common calibration takes no part in the
/// comparison, since both ways share it; values in newtons, and what follows from them, have its error beside their own.
///
/// # Errors
/// [`Error::TooFewSamples`] without measurements; [`Error::Parameter`] for a scale not above
/// zero; [`Error::NoFit`] where not one measurement could be analysed. One that fails beside
/// others that do not is in [`Answer::singles`] with its error.
pub fn analyse(measurements: &[Measurement], options: &Options) -> Result<Answer, Error> {
    analyse_with(measurements, options, &Criteria::default())
}

/// [`analyse`] with thresholds of your own.
///
/// # Errors
/// As [`analyse`].
pub fn analyse_with(
    measurements: &[Measurement],
    options: &Options,
    criteria: &Criteria,
) -> Result<Answer, Error> {
    if measurements.is_empty() {
        return Err(Error::TooFewSamples { found: 0, needed: 1 });
    }
    for m in measurements {
        crate::model::oscillator::above_zero("scale", m.scale)?;
    }
    options.calibration.map_or(Ok(()), Calibration::check)?;
    let mut warnings = Vec::new();
    let mut singles = Vec::with_capacity(measurements.len());
    let mut solved = Vec::new();
    for (i, m) in measurements.iter().enumerate() {
        let (alone, compared) = analyse_one(&m.data);
        match (&alone, compared) {
            (Err(_), _) => warnings.push(Warning::Failed { name: m.name.clone() }),
            (Ok(_), Some(answer)) => match SolvedMeasurement::new(i, m.scale, &answer) {
                Ok(s) => solved.push(s),
                Err(why) => warnings.push(Warning::NotUsed { name: m.name.clone(), why }),
            },
            (Ok(_), None) => warnings.push(Warning::NotUsed {
                name: m.name.clone(),
                why: "viscous damping and sliding friction could not both be fitted to it",
            }),
        }
        singles.push((m.name.clone(), alone));
    }
    if singles.iter().all(|(_, s)| s.is_err()) {
        return Err(Error::NoFit { reason: "no measurement of the series could be analysed" });
    }
    let mut labels: Vec<&Condition> = Vec::new();
    for m in measurements {
        if !labels.iter().any(|c| c.label == m.condition.label) {
            labels.push(&m.condition);
        }
    }
    let (table, exact): (Vec<ConditionRow>, Vec<Option<Estimate>>) = labels
        .iter()
        .map(|condition| {
            let here = |ring_down: Option<bool>| -> Vec<&SolvedMeasurement> {
                solved
                    .iter()
                    .filter(|s| measurements[s.measurement].condition.label == condition.label)
                    .filter(|s| ring_down.is_none_or(|r| r == s.ring_down))
                    .collect()
            };
            row(condition, &here(Some(true)), &here(Some(false)), &here(None), options)
        })
        .unzip();
    for r in &table {
        if let Some(p_value) = r.p_value.filter(|p| *p < criteria.disagree) {
            warnings.push(Warning::Disagree { condition: r.condition.clone(), p_value });
        }
    }
    let compared: Vec<f64> = labels
        .iter()
        .filter_map(|c| {
            let of = |ring_down: bool| {
                let list: Vec<&SolvedMeasurement> = solved
                    .iter()
                    .filter(|s| {
                        s.ring_down == ring_down && measurements[s.measurement].condition.label == c.label
                    })
                    .collect();
                together(&list).map(|b| widened(b, &list))
            };
            difference(of(true)?, of(false)?)
        })
        .collect();
    let agreement_p_value =
        (!compared.is_empty()).then(|| chi_square_tail(compared.iter().sum(), 2.0 * compared.len() as f64));
    let references = references(&solved, measurements);
    let joint = joint(&solved, &references, measurements, &labels, options, criteria);
    if let Some(j) = &joint
        && j.p_value < criteria.disagree
    {
        warnings.push(Warning::NotShared { p_value: j.p_value });
    }
    for r in &table {
        let below = r.value.filter(|v| v[0] < 0.0 && !options.condition_unit.is_empty());
        if let Some([load, _]) = below.filter(|_| may_be_load(&options.condition_unit)) {
            warnings.push(Warning::NegativeLoad { condition: r.condition.clone(), load });
        }
    }
    let laws = laws(&table, &exact, options);
    let agrees = agreement_p_value.map(|p| !(p < criteria.disagree));
    Ok(Answer { singles, table, agreement_p_value, agrees, joint, laws, warnings })
}

type Both = (Vector2<f64>, Matrix2<f64>);

/// Mean of several by their covariances; `None` where double precision does not hold them.
fn together(list: &[&SolvedMeasurement]) -> Option<Both> {
    let mut weight = Matrix2::zeros();
    let mut sum = Vector2::zeros();
    for s in list {
        let inverse = s.covariance.try_inverse()?;
        weight += inverse;
        sum += inverse * s.value;
    }
    let covariance = weight.try_inverse()?;
    let mean = covariance * sum;
    let held =
        mean.iter().all(|v| v.is_finite()) && covariance.diagonal().iter().all(|v| v.is_normal() && *v > 0.0);
    held.then_some((mean, covariance))
}

/// Where the parts scatter more than their errors say their mean is less sure by the Birge ratio, the root of chi
/// square over its degrees of freedom, and by Student's factor.
fn widened((mean, covariance): Both, list: &[&SolvedMeasurement]) -> Both {
    let off = |s: &&SolvedMeasurement| {
        Some(((s.value - mean).transpose() * s.covariance.try_inverse()? * (s.value - mean))[0])
    };
    let chi_square: f64 = list.iter().filter_map(off).sum();
    let freedom = 2.0 * list.len().saturating_sub(1) as f64;
    let scattered = chi_square > freedom && freedom > 0.0;
    let factor = if scattered { chi_square / freedom * student_factor(freedom).powi(2) } else { 1.0 };
    (mean, covariance * factor)
}

/// Chi square of the difference, two degrees of freedom.
fn difference(a: Both, b: Both) -> Option<f64> {
    let d = a.0 - b.0;
    let inverse = (a.1 + b.1).try_inverse()?;
    Some((d.transpose() * inverse * d)[(0, 0)])
}

fn row(
    condition: &Condition,
    ring_downs: &[&SolvedMeasurement],
    resonances: &[&SolvedMeasurement],
    all: &[&SolvedMeasurement],
    options: &Options,
) -> (ConditionRow, Option<Estimate>) {
    // Ways of several measurements that scatter are less sure, and so is what their difference says.
    let of = |list: &[&SolvedMeasurement]| together(list).map(|b| widened(b, list));
    let (r, s) = (of(ring_downs), of(resonances));
    let hz = all.iter().find_map(|s| s.frequency).map(|f| f[0]);
    let pair = |k: usize| {
        let (a, b) = (r?, s?);
        let z = (a.0[k] - b.0[k]) / (a.1[(k, k)] + b.1[(k, k)]).sqrt();
        Some(Consistency { z, p_value: chi_square_tail(z * z, 1.0) })
    };
    let joint = of(all);
    let row = ConditionRow {
        condition: condition.label.clone(),
        value: condition.value,
        ring_down: r.map(|b| cell(b, hz, options, options.calibration)),
        resonance: s.map(|b| cell(b, hz, options, options.calibration)),
        friction: pair(1),
        damping: pair(0),
        p_value: r.zip(s).and_then(|(a, b)| difference(a, b)).map(|c| chi_square_tail(c, 2.0)),
        joint: joint.map(|b| cell(b, hz, options, options.calibration)),
    };
    (row, joint.map(|b| cell(b, hz, options, options.calibration.map(Calibration::exact))))
}

/// As a person reads it: within the limits, in newtons where a calibration is given, whose error counts.
fn cell(
    (value, covariance): Both,
    hz: Option<f64>,
    options: &Options,
    calibration: Option<Calibration>,
) -> Estimate {
    let limited = |k: usize, unit: &str| {
        let std = covariance[(k, k)].sqrt();
        let [low, high] = crate::inference::interval::bounded_interval(value[k] / std);
        Quantity {
            value: value[k].max(0.0),
            std_error: std,
            interval_95: [low * std, high * std],
            unbounded_value: value[k],
            unit: unit.to_owned(),
        }
    };
    let (delta, x_f) = (limited(0, "1/s"), limited(1, &options.unit));
    let correlation = covariance[(0, 1)] / (covariance[(0, 0)] * covariance[(1, 1)]).sqrt();
    match (calibration, hz) {
        (Some(calibration), Some(hz)) => {
            let of = |calibration| {
                let [(_, damping), (_, friction)] =
                    crate::answer::calibration::physical(calibration, TAU * hz, &options.unit, &delta, &x_f);
                Estimate { friction, damping, correlation }
            };
            let (own, all) = (of(calibration.exact()), of(calibration));
            // The error of the constant moves both alike.
            let common = own.friction.value * own.damping.value * calibration.relative_error().powi(2);
            let covariance = correlation * own.friction.std_error * own.damping.std_error + common;
            let size = all.friction.std_error * all.damping.std_error;
            Estimate { correlation: if size > 0.0 { covariance / size } else { correlation }, ..all }
        }
        _ => Estimate { friction: x_f, damping: delta, correlation },
    }
}

/// Friction against the conditions that are numbers, where they may be loads.
///
/// All points share the calibration, whose error says nothing of how they lie: it counts in what comes out. `exact` are the
/// estimates without it.
fn laws(table: &[ConditionRow], exact: &[Option<Estimate>], options: &Options) -> Vec<super::LawFit> {
    let named = !options.condition_unit.is_empty();
    let negative = table.iter().any(|r| r.value.is_some_and(|v| v[0] < 0.0));
    if !may_be_load(&options.condition_unit) || (negative && !named) {
        return Vec::new();
    }
    let cells: Vec<([f64; 2], &Estimate)> = table
        .iter()
        .zip(exact)
        .filter_map(|(r, exact)| Some((r.value.filter(|v| v[0] >= 0.0)?, exact.as_ref()?)))
        .collect();
    let points: Vec<LoadPoint> = cells
        .iter()
        .map(|([load, load_std_error], c)| LoadPoint {
            load: *load,
            load_std_error: *load_std_error,
            friction: c.friction.unbounded_value,
            friction_std_error: c.friction.std_error,
        })
        .collect();
    let unit = cells.first().map_or("", |(_, c)| c.friction.unit.as_str());
    let mut laws = friction_against_load(&points, [&options.condition_unit, unit]).unwrap_or_default();
    let relative = options.calibration.map_or(0.0, Calibration::relative_error);
    for law in &mut laws {
        law.times_uncertain(relative);
    }
    laws
}

/// Whether a unit is one of force or of a mass that weighs; without a unit anything may be.
fn may_be_load(unit: &str) -> bool {
    const LOADS: [&str; 9] = ["N", "g", "dyn", "gf", "pond", "lb", "lbf", "oz", "kgf"];
    const PREFIXES: [&str; 11] = ["p", "n", "µ", "μ", "u", "m", "c", "d", "k", "M", "G"];
    let plain = |unit: &str| LOADS.contains(&unit);
    unit.is_empty() || plain(unit) || PREFIXES.iter().any(|p| unit.strip_prefix(p).is_some_and(plain))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::decay::FreeDecay;
    use crate::motion::steady::{Phasor, scan};
    use crate::noise::jitter;
    use crate::series::Data;
    use crate::{Oscillator, Record, resonance, ringdown};

    fn both(label: &str, load: f64, x_f: f64, seed: u64) -> Vec<Measurement> {
        let o = Oscillator::builder()
            .frequency_hz(2.0)
            .q_factor(80.0)
            .friction_displacement(x_f)
            .build()
            .unwrap();
        let decay = FreeDecay::from_rest(&o, 10.0).unwrap();
        let time: Vec<f64> = (0..3000).map(|i| 0.02 * i as f64).collect();
        let signal =
            time.iter().enumerate().map(|(i, t)| decay.displacement(*t) + 0.02 * jitter(i, seed)).collect();
        let (mut hz, mut z) = (Vec::new(), Vec::new());
        for i in 0..61 {
            let r = scan::reading(&o, 0.3, 1.9 + 0.2 * i as f64 / 60.0).unwrap();
            hz.push(r.frequency_hz);
            z.push(r.fundamental + Phasor::new(0.05 * jitter(i, seed + 7), 0.05 * jitter(i, seed + 8)));
        }
        let drive = resonance::DriveAmplitude { value: 0.3, std_error: 0.0 };
        let options = resonance::Options { drive_amplitude: Some(drive), ..resonance::Options::default() };
        let condition = Condition { label: label.to_owned(), value: Some([load, 0.0]) };
        vec![
            Measurement {
                name: format!("{label} ring-down"),
                condition: condition.clone(),
                data: Data::RingDown {
                    record: Box::new(Record::new(time, signal).unwrap().with_unit("mm")),
                    options: Box::new(ringdown::Options::default()),
                },
                scale: 1.0,
            },
            Measurement {
                name: format!("{label} sweep"),
                condition,
                data: Data::Sweep {
                    curve: Box::new(resonance::Curve::complex(hz, z).unit("mm").build().unwrap()),
                    options: Box::new(options),
                },
                scale: 1.0,
            },
        ]
    }

    #[test]
    fn two_ways_agree_and_friction_follows_the_load() {
        let mut all = Vec::new();
        for (i, load) in [1.0, 2.0, 4.0].into_iter().enumerate() {
            all.extend(both(&format!("{load} N"), load, 0.02 * load, 10 * i as u64));
        }
        let mut options = Options { unit: "mm".into(), condition_unit: "N".into(), ..Options::default() };
        options.shared.natural_frequency = true;
        options.shared.decay_rate = true;
        let a = analyse(&all, &options).unwrap();
        assert_eq!(a.table.len(), 3);
        for (row, load) in a.table.iter().zip([1.0, 2.0, 4.0]) {
            let joint = row.joint.as_ref().unwrap();
            let z = (joint.friction.unbounded_value - 0.02 * load) / joint.friction.std_error;
            assert!(z.abs() < 3.5, "{row:?}");
            assert!(row.p_value.unwrap() > 1e-3, "{row:?}");
        }
        let j = a.joint.unwrap();
        assert!(j.p_value > 1e-3, "{j:?}");
        assert!((j.natural_frequency_hz.as_ref().unwrap().value - 2.0).abs() < 1e-3, "{j:?}");
        let mu = a.laws.iter().find(|l| l.law == super::super::LoadLaw::Proportional).unwrap();
        assert!((mu.coefficient.value - 0.02).abs() < 0.002, "{:?}", mu.coefficient);
    }

    /// At the limit of friction, values with the limits lifted go with errors with the limits lifted.
    #[test]
    fn without_friction_the_joint_damping_is_held() {
        let delta = std::f64::consts::TAU / 80.0;
        let held = (0..60u64).filter(|&seed| {
            let row = analyse(&both("a", 1.0, 0.0, 100 * seed), &Options::default()).unwrap().table.remove(0);
            let [low, high] = row.joint.unwrap().damping.interval_95;
            (low..=high).contains(&delta)
        });
        // Of 60 at 95 % fewer than 51 are one run in 200.
        let held = held.count();
        assert!(held >= 51, "{held} of 60");
    }

    /// A stiffness known to 5 % leaves no force, and no coefficient of friction, that is known better.
    #[test]
    fn forces_count_the_error_of_the_stiffness() {
        let mut all = Vec::new();
        for (i, load) in [1.0, 2.0, 4.0].into_iter().enumerate() {
            all.extend(both(&format!("{load} N"), load, 0.02 * load, 10 * i as u64));
        }
        let with = |std_error: f64| {
            let calibration = Some(Calibration::Stiffness { value: 100.0, std_error });
            let options =
                Options { unit: "m".into(), condition_unit: "N".into(), calibration, ..Options::default() };
            analyse(&all, &options).unwrap()
        };
        let (exact, unsure) = (with(0.0), with(5.0));
        type Way = fn(&ConditionRow) -> Option<Estimate>;
        let (ring_down, resonance, joint): (Way, Way, Way) =
            (|r| r.ring_down.clone(), |r| r.resonance.clone(), |r| r.joint.clone());
        for (exact, unsure) in exact.table.iter().zip(&unsure.table) {
            for way in [ring_down, resonance, joint] {
                let (exact, unsure) = (way(exact).unwrap(), way(unsure).unwrap());
                for (exact, unsure) in [(exact.friction, unsure.friction), (exact.damping, unsure.damping)] {
                    let expected = exact.std_error.hypot(0.05 * exact.value);
                    assert!((unsure.std_error / expected - 1.0).abs() < 1e-9, "{exact:?} {unsure:?}");
                    assert!(unsure.interval_95[1] - unsure.value >= 1.9 * expected, "{unsure:?}");
                }
            }
            // Both ways share the stiffness: whether they agree does not hang on it.
            assert_eq!(exact.p_value, unsure.p_value);
        }
        for (exact, unsure) in exact.laws.iter().zip(&unsure.laws) {
            assert_eq!((exact.law, exact.chi_square), (unsure.law, unsure.chi_square));
            let expected = exact.coefficient.std_error.hypot(0.05 * exact.coefficient.value);
            assert!((unsure.coefficient.std_error / expected - 1.0).abs() < 1e-9, "{unsure:?}");
        }
    }

    /// Two measurements whose friction scatters by three times its error beside damping that correlates with it as in
    /// a ring-down: intervals of their mean held friction in 79 %.
    #[test]
    fn the_mean_of_a_few_that_scatter_is_held() {
        const RUNS: u64 = 2000;
        let mut held = 0;
        for seed in 0..RUNS {
            let normal = |i: u64| jitter(seed as usize, i);
            let list = [0_u64, 1].map(|i| SolvedMeasurement {
                measurement: i as usize,
                ring_down: true,
                value: {
                    let damping = normal(10 * i + 1);
                    let noise = -0.9 * damping + 0.19_f64.sqrt() * normal(10 * i + 2);
                    Vector2::new(damping, noise + 3.0 * normal(10 * i + 3))
                },
                covariance: Matrix2::new(1.0, -0.9, -0.9, 1.0),
                frequency: None,
                drive: None,
            });
            let all: Vec<&SolvedMeasurement> = list.iter().collect();
            let (mean, covariance) = widened(together(&all).unwrap(), &all);
            held += u64::from(mean[1].abs() <= 1.96 * covariance[(1, 1)].sqrt());
        }
        assert!(held > RUNS * 88 / 100, "{held} of {RUNS}");
    }

    /// Two ring-downs that exclude each other leave no sure ring-down for a resonance to disagree with.
    #[test]
    fn ring_downs_that_scatter_are_less_sure() {
        let mut all = both("a", 1.0, 0.05, 3);
        let sweep = all.remove(1);
        all.extend(both("a", 1.0, 0.04, 7).into_iter().take(1));
        all.push(sweep);
        let row = analyse(&all, &Options::default()).unwrap().table.remove(0);
        let [low, high] = row.ring_down.unwrap().friction.interval_95;
        assert!(low < 0.04 && high > 0.05, "{low} to {high}");
        assert!(row.p_value.unwrap() > 0.01, "{:?}", row.p_value);
    }

    #[test]
    fn a_load_below_zero_is_named() {
        let mut all = Vec::new();
        for (i, load) in [-1.0, 2.0, 4.0].into_iter().enumerate() {
            all.extend(both(&format!("{load} N"), load, 0.05, 10 * i as u64));
        }
        let named = |unit: &str| {
            let options = Options { condition_unit: unit.into(), ..Options::default() };
            let a = analyse(&all, &options).unwrap();
            (a.warnings.iter().any(|w| w.code() == "negative_load"), a.laws.is_empty())
        };
        assert_eq!(named("N"), (true, false));
        // A temperature, or a number of anything.
        assert_eq!(named("\u{b0}C"), (false, true));
        assert_eq!(named(""), (false, true));
    }

    #[test]
    fn a_current_is_no_load() {
        for unit in ["", "N", "mN", "µN", "kg", "g"] {
            assert!(may_be_load(unit), "{unit}");
        }
        for unit in ["mA", "A", "mbar", "Pa", "V", "°C", "m"] {
            assert!(!may_be_load(unit), "{unit}");
        }
    }

    #[test]
    fn what_disagrees_is_said_and_what_fails_does_not_stop_the_rest() {
        let mut all = both("a", 1.0, 0.05, 3);
        all[1] = both("a", 1.0, 0.01, 5).remove(1);
        let mut broken = all[0].clone();
        broken.name = "silence".into();
        broken.condition.label = "b".into();
        let time: Vec<f64> = (0..100).map(f64::from).collect();
        broken.data = Data::RingDown {
            record: Box::new(Record::new(time, (0..100).map(|i| jitter(i, 1)).collect()).unwrap()),
            options: Box::new(ringdown::Options::default()),
        };
        all.push(broken);
        let a = analyse(&all, &Options::default()).unwrap();
        let codes: Vec<_> = a.warnings.iter().map(Warning::code).collect();
        assert!(codes.contains(&"failed"), "{codes:?}");
        assert!(codes.contains(&"disagree"), "{codes:?}");
        // Friction of 0.05 and 0.01: what is between them must not look sure.
        let [ring_down, sweep, joint] = [&a.table[0].ring_down, &a.table[0].resonance, &a.table[0].joint]
            .map(|cell| &cell.as_ref().unwrap().friction);
        let sure = ring_down.std_error.min(sweep.std_error);
        assert!(joint.std_error > 5.0 * sure, "{ring_down:?} {sweep:?} {joint:?}");
        assert!(a.singles[2].1.is_err());
        assert!(a.singles[0].1.is_ok());
        assert!(analyse(&[], &Options::default()).is_err());
    }
}
