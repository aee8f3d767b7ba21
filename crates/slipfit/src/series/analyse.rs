//! The analysis of a series: each measurement alone, comparison, and joint fit.

use super::answer::{Answer, ConditionRow, Consistency, Estimate};
use super::comparison::{Difference, Pair};
use super::criteria::Criteria;
use super::drag::{AveragedMeasurements, Candidates};
use super::joint::{joint, references};
use super::law::{LoadPoint, Replication, laws_of};
use super::scatter::{Mean, Repeats, Scatter};
use super::single::analyse_one;
use super::solved::SolvedMeasurement;
use super::{Condition, Measurement, Options};
use crate::answer::calibration::Calibration;
use crate::answer::{Parameter, Warning};
use crate::{Error, Quantity};
use std::f64::consts::TAU;

/// Analyses each measurement alone, compares the two methods at each condition as in Table 1 of Vitorino, Vieira and
/// Rodrigues, and fits all measurements jointly.
///
/// For the table every ring-down and curve is described by viscous damping and sliding friction without the limits at
/// zero, so that estimates without friction scatter about zero. The two methods are compared by the difference `d` of
/// `(delta, x_F)` with both covariances:
///
/// ```text
/// chi² = d' (C_1 + C_2)⁻¹ d     with two degrees of freedom
/// ```
///
/// Drag is one rate common to all measurements, estimated from them together as far as they agree on it. Values and
/// covariances are averages over the models without and with drag; p values are those of each model, averaged with
/// the same weights. The uncertainty of the drag rate is an error shared by all measurements. A model named in the
/// options of a measurement is used as it is.
///
/// Repeats by one method at one condition may scatter more than their errors: the excess scatter is estimated from
/// all of them together, as in a random-effects meta-analysis (REML), and is included in every covariance above. In
/// the mean of one condition the difference between the two methods is included as well. Intervals use Student's
/// factor for the number of repeats.
///
/// The joint fit is a generalised least-squares fit to all answers with the parameters declared as shared
/// ([`Options::shared`]); damping and friction of one condition always are. If chi square exceeds its degrees of
/// freedom, the errors are scaled by the root of their ratio (R. T. Birge, Phys. Rev. 40, 207, 1932).
///
/// Limits: answers enter by value and covariance, not by their samples; an answer close to a limit enters by its
/// unbounded estimate. A common calibration does not affect the comparison, since both methods share it; values in
/// newtons, and quantities derived from them, include its error in addition to their own.
///
/// # Errors
/// [`Error::TooFewSamples`] without measurements; [`Error::Parameter`] for a scale not above zero; [`Error::NoFit`]
/// if no measurement could be analysed. If only some fail, their errors are in [`Answer::singles`].
pub fn analyse(measurements: &[Measurement], options: &Options) -> Result<Answer, Error> {
    analyse_with(measurements, options, &Criteria::default())
}

/// [`analyse`] with custom thresholds.
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
    let mut candidates = Vec::new();
    for (i, m) in measurements.iter().enumerate() {
        let (alone, compared) = analyse_one(&m.data);
        match (&alone, compared) {
            (Err(_), _) => warnings.push(Warning::Failed { name: m.name.clone() }),
            (Ok(_), Some(found)) => match Candidates::new(i, m.scale, &found) {
                Ok(s) => candidates.push(s),
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
    let AveragedMeasurements { averaged: solved, models } = AveragedMeasurements::new(candidates, criteria);
    let mut labels: Vec<&Condition> = Vec::new();
    for m in measurements {
        if !labels.iter().any(|c| c.label == m.condition.label) {
            labels.push(&m.condition);
        }
    }
    let grouping = Grouping { measurements, labels: &labels };
    // The scatter is estimated from repeats by one method; the difference between the methods is treated separately,
    // but is included in their mean.
    let [ring_downs, resonances, all] =
        [Some(true), Some(false), None].map(|ring_down| grouping.repeats(&solved, ring_down));
    let of_repeats = Scatter::of(ring_downs.iter().chain(&resonances));
    let of_all = Scatter::of(&all);
    let pairs = |(weight, solved): &(f64, Vec<SolvedMeasurement>)| {
        let [ring_downs, resonances] =
            [true, false].map(|ring_down| grouping.repeats(solved, Some(ring_down)));
        let scatter = Scatter::of(ring_downs.iter().chain(&resonances));
        let pair = |(r, s): (&Repeats<'_>, &Repeats<'_>)| {
            Some(Pair { ring_down: r.mean(&scatter)?, resonance: s.mean(&scatter)? })
        };
        (*weight, ring_downs.iter().zip(&resonances).map(pair).collect())
    };
    let compared: Vec<(f64, Vec<Option<Pair>>)> = models.iter().map(pairs).collect();
    let rows = ring_downs.iter().zip(&resonances).zip(&all).enumerate().map(|(i, ((r, s), all))| Row {
        ring_down: r.mean(&of_repeats),
        resonance: s.mean(&of_repeats),
        pairs: compared.iter().map(|(weight, pairs)| (*weight, pairs[i])).collect(),
        joint: all.mean(&of_all),
        hz: all.list.first().map_or(f64::NAN, |s| s.frequency[0]),
        measurements: all.list.len(),
    });
    let rows: Vec<Row> = rows.collect();
    let table: Vec<ConditionRow> = labels.iter().zip(&rows).map(|(c, row)| row.shown(c, options)).collect();
    for r in &table {
        if let Some(p_value) = r.p_value.filter(|p| *p < criteria.disagree) {
            warnings.push(Warning::Disagree { condition: r.condition.clone(), p_value });
        }
    }
    let agreement = compared.iter().map(|(weight, pairs)| {
        let differences = pairs.iter().flatten().filter_map(Pair::difference);
        Some(weight * differences.reduce(Difference::and)?.p_value())
    });
    let agreement_p_value: Option<f64> = agreement.sum();
    let scattered = ring_downs.iter().chain(&resonances).flat_map(|r| {
        let more = of_repeats.covariance(r.level);
        r.list.iter().map(move |s| s.with_scatter(&more))
    });
    let scattered: Vec<SolvedMeasurement> = scattered.collect();
    let references = references(&scattered, measurements);
    let joint = joint(&scattered, &references, measurements, &labels, options, of_repeats.spread());
    if let Some(j) = &joint
        && j.p_value < criteria.disagree
    {
        let shared = [
            (j.natural_frequency_hz.is_some(), Parameter::NaturalFrequency),
            (j.drive_amplitude.is_some(), Parameter::DriveAmplitude),
            (j.decay_rate_per_s.is_some(), Parameter::DECAY_RATE),
        ];
        let shared = shared.into_iter().filter_map(|(is, parameter)| is.then_some(parameter)).collect();
        warnings.push(Warning::NotShared { p_value: j.p_value, shared });
    }
    for r in &table {
        let below = r.value.filter(|v| v[0] < 0.0 && !options.condition_unit.is_empty());
        if let Some([load, _]) = below.filter(|_| may_be_load(&options.condition_unit)) {
            warnings.push(Warning::NegativeLoad { condition: r.condition.clone(), load });
        }
    }
    let laws = laws(&labels, &rows, &of_all, options, criteria);
    let agrees = agreement_p_value.map(|p| !(p < criteria.disagree));
    Ok(Answer {
        singles,
        table,
        agreement_p_value,
        agrees,
        scatter: of_all.relative(&all, criteria),
        joint,
        laws,
        warnings,
    })
}

/// Assignment of the measurements to conditions.
struct Grouping<'a> {
    measurements: &'a [Measurement],
    labels: &'a [&'a Condition],
}

impl Grouping<'_> {
    /// The measurements of each condition, by one method or both.
    fn repeats<'a>(&self, solved: &'a [SolvedMeasurement], ring_down: Option<bool>) -> Vec<Repeats<'a>> {
        let here = |condition: &&Condition| {
            let list = solved
                .iter()
                .filter(|s| self.measurements[s.measurement].condition.label == condition.label)
                .filter(|s| ring_down.is_none_or(|r| r == s.ring_down));
            Repeats::new(list.collect())
        };
        self.labels.iter().map(here).collect()
    }
}

/// Results at one condition.
struct Row {
    ring_down: Option<Mean>,
    resonance: Option<Mean>,
    /// Both methods for each model, with the weight of the model.
    pairs: Vec<(f64, Option<Pair>)>,
    joint: Option<Mean>,
    /// Frequency, Hz, if there are measurements.
    hz: f64,
    measurements: usize,
}

impl Row {
    /// A statistic of both methods, averaged over the models.
    fn averaged(&self, figure: impl Fn(&Pair) -> Option<f64>) -> Option<f64> {
        self.pairs.iter().map(|(weight, pair)| Some(weight * figure(pair.as_ref()?)?)).sum()
    }

    fn shown(&self, condition: &Condition, options: &Options) -> ConditionRow {
        let pair = |k: usize| {
            Some(Consistency {
                z: self.averaged(|pair| Some(pair.consistency(k).z))?,
                p_value: self.averaged(|pair| Some(pair.consistency(k).p_value))?,
            })
        };
        let cell = |mean: Option<Mean>| mean.map(|m| cell(&m, self.hz, options, options.calibration));
        ConditionRow {
            condition: condition.label.clone(),
            value: condition.value,
            ring_down: cell(self.ring_down),
            resonance: cell(self.resonance),
            friction: pair(1),
            damping: pair(0),
            p_value: self.averaged(|pair| Some(pair.difference()?.p_value())),
            joint: cell(self.joint),
        }
    }
}

/// The estimate as reported: within the limits, and in newtons if a calibration is given, whose error is included.
fn cell(mean: &Mean, hz: f64, options: &Options, calibration: Option<Calibration>) -> Estimate {
    let limited = |k: usize, unit: &str| {
        let (value, [std_error, wide]) = (mean.value[k], mean.errors(k));
        let [low, high] = crate::inference::interval::bounded_interval(value / wide);
        Quantity {
            value: value.max(0.0),
            std_error,
            interval_95: [low * wide, high * wide],
            unbounded_value: value,
            unit: unit.to_owned(),
        }
    };
    let (delta, x_f) = (limited(0, "1/s"), limited(1, &options.unit));
    let covariance = &mean.covariance;
    let correlation = covariance[(0, 1)] / (covariance[(0, 0)] * covariance[(1, 1)]).sqrt();
    let Some(calibration) = calibration else {
        return Estimate { friction: x_f, damping: delta, correlation };
    };
    let of = |calibration| {
        let [(_, damping), (_, friction)] =
            crate::answer::calibration::physical(calibration, TAU * hz, &options.unit, &delta, &x_f);
        Estimate { friction, damping, correlation }
    };
    let (own, all) = (of(calibration.exact()), of(calibration));
    // The error of the constant affects both equally.
    let common = own.friction.value * own.damping.value * calibration.relative_error().powi(2);
    let covariance = correlation * own.friction.std_error * own.damping.std_error + common;
    let size = all.friction.std_error * all.damping.std_error;
    Estimate { correlation: if size > 0.0 { covariance / size } else { correlation }, ..all }
}

/// Laws of friction against the numeric conditions, if these may be loads.
///
/// All points share the calibration, so its error does not affect the choice of the law: it is included in the
/// results.
fn laws(
    labels: &[&Condition],
    rows: &[Row],
    scatter: &Scatter,
    options: &Options,
    criteria: &Criteria,
) -> Vec<super::LawFit> {
    let named = !options.condition_unit.is_empty();
    let negative = labels.iter().any(|c| c.value.is_some_and(|v| v[0] < 0.0));
    if !may_be_load(&options.condition_unit) || (negative && !named) {
        return Vec::new();
    }
    let exact = options.calibration.map(Calibration::exact);
    let (mut points, mut shared, mut unit) = (Vec::new(), Vec::new(), String::new());
    let (mut freedom, mut measurements) = (f64::INFINITY, 0.0);
    for (condition, row) in labels.iter().zip(rows) {
        let (Some([load, load_std_error]), Some(mean)) = (condition.value.filter(|v| v[0] >= 0.0), row.joint)
        else {
            continue;
        };
        let friction = cell(&mean, row.hz, options, exact).friction;
        let unit_size = friction.std_error / mean.errors(1)[0];
        points.push(LoadPoint {
            load,
            load_std_error,
            friction: friction.unbounded_value,
            friction_std_error: mean.own_error(1) * unit_size,
        });
        shared.push(mean.shared[1] * unit_size);
        freedom = freedom.min(mean.freedom[1]);
        measurements += row.measurements as f64;
        unit = friction.unit;
    }
    // A single load cannot distinguish the laws.
    if points.iter().all(|p: &LoadPoint| p.load == points[0].load) {
        return Vec::new();
    }
    let known = Replication {
        measurements,
        freedom,
        repeats: scatter.freedom,
        chi_square: scatter.chi_square,
        shared,
    };
    let mut laws = laws_of(&points, [&options.condition_unit, &unit], &known, criteria);
    let relative = options.calibration.map_or(0.0, Calibration::relative_error);
    for law in &mut laws {
        law.add_relative_error(relative);
    }
    laws
}

/// Whether a unit is one of force or of a mass used as a weight; without a unit any quantity is possible.
fn may_be_load(unit: &str) -> bool {
    const LOADS: [&str; 9] = ["N", "g", "dyn", "gf", "pond", "lb", "lbf", "oz", "kgf"];
    const PREFIXES: [&str; 11] = ["p", "n", "µ", "μ", "u", "m", "c", "d", "k", "M", "G"];
    let plain = |unit: &str| LOADS.contains(&unit);
    unit.is_empty() || plain(unit) || PREFIXES.iter().any(|p| unit.strip_prefix(p).is_some_and(plain))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::loss::LossModel;
    use crate::motion::decay::FreeDecay;
    use crate::motion::steady::{Phasor, scan};
    use crate::noise::jitter;
    use crate::series::Data;
    use crate::{Oscillator, Record, resonance, ringdown};
    use nalgebra::{Matrix2, Vector2};

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

    /// At the limit of friction, values without limits must be combined with errors without limits.
    #[test]
    fn without_friction_the_joint_damping_is_held() {
        let delta = std::f64::consts::TAU / 80.0;
        let held = (0..60u64).filter(|&seed| {
            let row = analyse(&both("a", 1.0, 0.0, 100 * seed), &Options::default()).unwrap().table.remove(0);
            let [low, high] = row.joint.unwrap().damping.interval_95;
            (low..=high).contains(&delta)
        });
        // Of 60 at 95 %, fewer than 51 occur in one run in 200.
        let held = held.count();
        assert!(held >= 51, "{held} of 60");
    }

    /// With a stiffness known to 5 %, no force and no coefficient of friction can be known better.
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
            // Both methods share the stiffness: their agreement does not depend on it.
            assert_eq!(exact.p_value, unsure.p_value);
        }
        for (exact, unsure) in exact.laws.iter().zip(&unsure.laws) {
            assert_eq!((exact.law, exact.chi_square), (unsure.law, unsure.chi_square));
            let expected = exact.coefficient.std_error.hypot(0.05 * exact.coefficient.value);
            assert!((unsure.coefficient.std_error / expected - 1.0).abs() < 1e-9, "{unsure:?}");
        }
    }

    /// Drag that a ring-down may or may not have counts according to its probability; drag named in its options is
    /// part of its answer.
    #[test]
    fn a_ring_down_of_a_series_counts_drag_as_far_as_it_is_probable() {
        let Data::RingDown { record, .. } = both("a", 1.0, 0.05, 3).remove(0).data else { unreachable!() };
        let error = |model: Option<LossModel>| {
            let options = ringdown::Options { model, ..ringdown::Options::default() };
            let mut series = both("a", 1.0, 0.05, 3);
            series.truncate(1);
            series[0].data = Data::RingDown { record: record.clone(), options: Box::new(options) };
            let row = analyse(&series, &Options::default()).unwrap().table.remove(0);
            row.ring_down.unwrap().friction.std_error
        };
        let alone = |model: LossModel| {
            let options = ringdown::Options { model: Some(model), ..ringdown::Options::default() };
            let answer = ringdown::analyse(&record, &options).unwrap();
            answer.parameter(Parameter::FRICTION_DISPLACEMENT).unwrap().std_error
        };
        let [two, three] = [LossModel::VISCOUS_SLIDING, LossModel::VISCOUS_SLIDING_DRAG];
        assert!(alone(three) > 1.5 * alone(two));
        assert!(error(None) > alone(two) && error(None) < alone(three), "{} {}", error(None), alone(two));
        assert!((error(Some(two)) / alone(two) - 1.0).abs() < 0.05, "{} {}", error(Some(two)), alone(two));
        assert!(
            (error(Some(three)) / alone(three) - 1.0).abs() < 0.05,
            "{} {}",
            error(Some(three)),
            alone(three)
        );
    }

    /// Two measurements whose friction scatters by three times its error, with damping correlated with it as in a
    /// ring-down: earlier, intervals of their mean covered friction in 79 %.
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
                shared: Vector2::zeros(),
                frequency: [1.0, 0.0],
                drive: None,
            });
            let all = Repeats::new(list.iter().collect());
            let mean = all.mean(&Scatter::of([&all])).unwrap();
            held += u64::from(mean.value[1].abs() <= 1.96 * mean.errors(1)[1]);
        }
        assert!(held > RUNS * 88 / 100, "{held} of {RUNS}");
    }

    /// Two ring-downs that exclude each other give no precise value with which a resonance could disagree.
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
        // A temperature, or a number of unknown kind.
        assert_eq!(named("\u{b0}C"), (false, true));
        assert_eq!(named(""), (false, true));
    }

    #[test]
    fn one_load_has_no_law() {
        let mut all = both("a", 2.0, 0.05, 3);
        all.extend(both("b", 2.0, 0.02, 5));
        assert!(analyse(&all, &Options::default()).unwrap().laws.is_empty());
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
        // Friction of 0.05 and 0.01: the value between them must have a large error.
        let [ring_down, sweep, joint] = [&a.table[0].ring_down, &a.table[0].resonance, &a.table[0].joint]
            .map(|cell| &cell.as_ref().unwrap().friction);
        let sure = ring_down.std_error.min(sweep.std_error);
        assert!(joint.std_error > 5.0 * sure, "{ring_down:?} {sweep:?} {joint:?}");
        assert!(a.singles[2].1.is_err());
        assert!(a.singles[0].1.is_ok());
        assert!(analyse(&[], &Options::default()).is_err());
    }
}
