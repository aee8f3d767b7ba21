use proptest::prelude::*;

use super::*;

fn ring(n: usize) -> Vec<f64> {
    (0..n).map(|i| (-0.01 * i as f64).exp() * (0.3 * i as f64).cos()).collect()
}

fn round_to_significant(v: f64, digits: i32) -> f64 {
    format!("{v:.*e}", digits as usize - 1).parse().unwrap()
}

#[test]
fn equidistant_decimal_stamps_become_a_uniform_clock() {
    let time: Vec<f64> =
        (0..5000).map(|i| format!("{:.2}", 1.0 + 0.01 * i as f64).parse().unwrap()).collect();
    let record = Record::new(time.clone(), ring(5000)).unwrap();
    assert!(record.clock().is_uniform());
    for (i, t) in time.iter().enumerate() {
        assert!((record.time_s(i) - t).abs() < 1e-11);
    }
    assert_eq!(record.clock_report().step_spread, 0.0);
}

#[test]
fn jitter_of_a_millionth_of_a_step_is_kept() {
    let mut time: Vec<f64> = (0..100).map(|i| 0.01 * i as f64).collect();
    time[50] += 1e-8;
    let record = Record::new(time.clone(), ring(100)).unwrap();
    assert_eq!(record.clock(), &Clock::Stamps(time));
}

#[test]
fn blanks_at_the_ends_of_a_rated_record_leave_it_uniform() {
    let mut signal = ring(20);
    signal[0] = f64::NAN;
    signal[19] = f64::INFINITY;
    let record = Record::uniform(10.0, signal).unwrap();
    assert_eq!(record.clock(), &Clock::Uniform { start_s: 0.1, interval_s: 0.1 });
    assert_eq!((record.clock_report().nonfinite_leading, record.clock_report().nonfinite_trailing), (1, 1));
    assert_eq!(record.len(), 18);
}

#[test]
fn a_blank_inside_a_rated_record_is_a_gap() {
    let mut signal = ring(20);
    signal[7] = f64::NAN;
    let record = Record::uniform(10.0, signal).unwrap();
    assert_eq!(record.len(), 19);
    assert_eq!(record.clock_report().gaps, 1);
    let gap = record.clock_report().longest_gap.unwrap();
    assert!((gap.start_s - 0.6).abs() < 1e-12);
    assert!((gap.length_s - 0.2).abs() < 1e-12);
}

#[test]
fn after_a_reset_the_longest_run_is_kept() {
    let mut time: Vec<f64> = (0..30).map(|i| 0.1 * f64::from(i)).collect();
    time.extend((0..50).map(|i| 0.1 * f64::from(i)));
    let record = Record::new(time, ring(80)).unwrap();
    assert_eq!(record.len(), 50);
    assert_eq!(record.signal()[0], ring(80)[30]);
    let report = record.clock_report();
    assert_eq!((report.resets, report.other_run_rows), (1, 30));
}

#[test]
fn the_run_that_is_asked_for_is_kept_and_one_too_many_is_refused() {
    let mut time: Vec<f64> = (0..30).map(|i| 0.1 * f64::from(i)).collect();
    time.extend((0..50).map(|i| 0.1 * f64::from(i)));
    time[40] = 1e6;
    let run = |n| Record::of_run(n, time.clone(), ring(80), None);
    for (n, first, len) in [(1, 0, 30), (2, 30, 49)] {
        let record = run(n).unwrap();
        assert_eq!((record.len(), record.signal()[0]), (len, ring(80)[first]), "run {n}");
        let report = record.clock_report();
        assert_eq!((report.resets, report.run, report.corrupt_stamps), (1, n, 1), "run {n}");
        assert_eq!(record.len() + report.other_run_rows + report.corrupt_stamps, 80, "run {n}");
    }
    for asked in [0, 3] {
        assert_eq!(run(asked), Err(Error::NoSuchRun { asked, found: 2 }));
    }
    let even: Vec<f64> = (0..30).map(f64::from).collect();
    assert!(Record::of_run(1, even.clone(), ring(30), None).is_ok());
    assert_eq!(Record::of_run(2, even, ring(30), None), Err(Error::NoSuchRun { asked: 2, found: 1 }));
}

#[test]
fn rows_out_of_order_by_a_little_are_sorted_with_their_samples() {
    let mut time: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i) + 1e-4 * f64::from(i % 3)).collect();
    let mut signal = ring(40);
    let wanted = signal.clone();
    time.swap(10, 12);
    signal.swap(10, 12);
    let record = Record::new(time, signal).unwrap();
    assert_eq!(record.signal(), &wanted[..]);
    assert_eq!(record.clock_report().reordered, 2);
    assert_eq!(record.clock_report().resets, 0);
}

#[test]
fn one_corrupt_stamp_costs_one_row() {
    for bad in [0.0, 1e6, -5.0] {
        let mut time: Vec<f64> = (0..400).map(|i| 0.1 * f64::from(i)).collect();
        time[200] = bad;
        let record = Record::new(time, ring(400)).unwrap();
        assert_eq!(record.len(), 399, "{bad}");
        assert_eq!(record.clock_report().corrupt_stamps, 1, "{bad}");
        assert_eq!(record.clock_report().gaps, 1, "{bad}");
    }
}

#[test]
fn a_clock_written_with_three_digits_is_rebuilt() {
    let time: Vec<f64> = (0..5000).map(|i| round_to_significant(f64::from(i) / 29.97, 3)).collect();
    let record = Record::new(time, ring(5000)).unwrap();
    let Clock::Uniform { interval_s, .. } = *record.clock() else { panic!("{:?}", record.clock_report()) };
    assert!((interval_s * 29.97 - 1.0).abs() < 5e-5, "{interval_s}");
    assert_eq!(record.clock_report().rebuilt_quantum_s, Some(1.0));
    assert!(record.clock_report().repeated_stamps > 3000);
}

#[test]
fn a_clock_in_whole_seconds_is_rebuilt_truncated_or_rounded() {
    for offset in [0.0, 0.5] {
        let time: Vec<f64> = (0..4000).map(|i| (f64::from(i) * 0.1001 + offset).floor()).collect();
        let record = Record::new(time, ring(4000)).unwrap();
        let Clock::Uniform { interval_s, .. } = *record.clock() else { panic!("{offset}") };
        assert!((interval_s / 0.1001 - 1.0).abs() < 1e-4);
    }
}

#[test]
fn repeats_of_an_irregular_clock_stay() {
    let time: Vec<f64> =
        (0..1000).map(|i| (f64::from(i) * 0.37).sin() * 0.3 + f64::from(i / 3) * 3.0).collect();
    let mut time: Vec<f64> = time.iter().map(|t| t.floor()).collect();
    time.sort_by(f64::total_cmp);
    let record = Record::new(time.clone(), ring(1000)).unwrap();
    assert_eq!(record.clock(), &Clock::Stamps(time));
    assert!(record.clock_report().repeated_stamps > 100);
    assert!(record.clock_report().rebuilt_quantum_s.is_none());
}

#[test]
fn a_long_rest_of_an_event_driven_encoder_is_a_gap_and_its_turns_are_not() {
    // An encoder that reports every crossing of one of its lines by cos(t).
    let line = |k: f64| (k / 100.0).acos();
    let half: Vec<f64> = (-99..100).rev().map(|k| line(f64::from(k))).collect();
    let mut time: Vec<f64> = (0..20)
        .flat_map(|turn| half.iter().map(move |t| t + f64::from(turn) * std::f64::consts::PI))
        .collect();
    let stop = *time.last().unwrap();
    time.push(stop + 30.0);
    let record = Record::new(time.clone(), ring(time.len())).unwrap();
    let gap = record.clock_report().longest_gap.unwrap();
    assert_eq!((gap.start_s, gap.length_s), (stop, stop + 30.0 - stop));
    assert_eq!(record.clock_report().gaps, 1);
    assert!(record.clock_report().step_spread > 0.5);
}

#[test]
fn what_cannot_be_a_record_is_refused_by_name() {
    let time: Vec<f64> = (0..20).map(f64::from).collect();
    let back: Vec<f64> = time.iter().rev().copied().collect();
    assert_eq!(
        Record::new(back, ring(20)),
        Err(Error::TimeOutOfOrder { index: 1, previous: 19.0, next: 18.0, backward: 19, forward: 0 })
    );
    assert_eq!(Record::new(vec![3.0; 20], ring(20)), Err(Error::TimeStandsStill { time_s: 3.0 }));
    assert_eq!(Record::new(time.clone(), vec![2.0; 20]), Err(Error::ConstantSignal { value: 2.0 }));
    assert_eq!(
        Record::new(time.clone(), vec![f64::NAN; 20]),
        Err(Error::TooFewSamples { found: 0, needed: 8 })
    );
    assert_eq!(Record::new(time, ring(19)), Err(Error::Length { name: "signal", found: 19, expected: 20 }));
    assert!(matches!(Record::uniform(f64::NAN, ring(20)), Err(Error::Parameter { .. })));
    assert!(matches!(Record::uniform(1e-320, ring(20)), Err(Error::Parameter { .. })));
    assert_eq!(Record::new(vec![], vec![]), Err(Error::TooFewSamples { found: 0, needed: 8 }));
}

#[test]
fn a_lock_in_row_goes_where_either_output_is_missing() {
    let mut quadrature = ring(30);
    quadrature[4] = f64::NAN;
    let time = (0..30).map(f64::from).collect();
    let record = Record::lock_in(time, ring(30), quadrature).unwrap();
    assert_eq!(record.kind(), SignalKind::LockIn);
    assert_eq!((record.len(), record.quadrature().unwrap().len()), (29, 29));
}

fn any_time() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -1e3..1e3f64,
        4 => (0..100u32).prop_map(f64::from),
        1 => any::<f64>(),
    ]
}

proptest! {
    #[test]
    fn every_row_is_kept_or_counted_and_time_never_decreases(
        rows in prop::collection::vec((any_time(), any_time()), 0..200),
        sorted in any::<bool>(),
    ) {
        let (mut time, signal): (Vec<f64>, Vec<f64>) = rows.into_iter().unzip();
        if sorted {
            time.sort_by(f64::total_cmp);
        }
        let n = time.len();
        if let Ok(record) = Record::new(time, signal) {
            let report = record.clock_report();
            prop_assert_eq!(
                record.len() + report.nonfinite() + report.corrupt_stamps + report.other_run_rows, n
            );
            let times = record.times_s(0..record.len());
            prop_assert!(times.windows(2).all(|w| w[1] >= w[0]));
            prop_assert!(times.iter().chain(record.signal()).all(|v| v.is_finite()));
            prop_assert!(report.median_step_s > 0.0);
        }
    }

    #[test]
    fn a_uniform_clock_survives_its_own_stamps(rate in 1e-3..1e9f64, n in 8..3000usize) {
        let record = Record::uniform(rate, ring(n)).unwrap();
        let again = Record::new(record.times_s(0..n), ring(n)).unwrap();
        prop_assert!(again.clock().is_uniform());
    }
}

#[test]
fn bursts_under_one_stamp_are_put_on_the_even_clock_they_come_from() {
    for (samples, jitter) in [(4, 0.0), (8, 0.0), (5, 0.2)] {
        let dt = 0.0517;
        let stamp = |i: usize| {
            let burst = i / samples;
            let late = jitter * samples as f64 * dt * (burst as f64 * 1.7).sin().abs();
            (burst * samples + samples - 1) as f64 * dt + late
        };
        let record = Record::new((0..400).map(stamp).collect(), ring(400)).unwrap();
        let report = record.clock_report();
        assert_eq!(report.burst_samples, Some(samples));
        let Clock::Uniform { interval_s, .. } = *record.clock() else { panic!("{report:?}") };
        let off = (interval_s / dt - 1.0).abs();
        assert!(off <= report.rebuilt_rate_error + 1e-12, "{off} {report:?}");
        assert!(report.rebuilt_rate_error < 5e-3, "{report:?}");
    }
}

#[test]
fn bursts_that_are_lost_leave_a_gap() {
    let dt = 0.0517;
    let stamps = (0..400).filter(|i| !(160..200).contains(i)).map(|i| (i / 4 * 4 + 3) as f64 * dt);
    let record = Record::new(stamps.collect(), ring(360)).unwrap();
    let report = record.clock_report();
    assert_eq!((report.burst_samples, report.gaps), (Some(4), 1));
    assert!((record.time_s(200) - 240.0 * dt).abs() < 1e-9, "{}", record.time_s(200));
    assert!((report.longest_gap.unwrap().length_s - 41.0 * dt).abs() < 1e-9);
}

#[test]
fn values_that_are_held_are_no_bursts() {
    let time: Vec<f64> = (0..400).map(|i| (i / 4) as f64 * 0.123_456_789).collect();
    let held: Vec<f64> = ring(100).into_iter().flat_map(|v| [v; 4]).collect();
    assert_eq!(Record::new(time, held).unwrap().clock_report().burst_samples, None);
}

#[test]
fn the_rate_of_a_rebuilt_clock_is_known_as_far_as_its_stamps_say() {
    for dt in [0.1001, 0.0595, 0.03337] {
        let time: Vec<f64> = (0..420).map(|i| (f64::from(i) * dt).floor()).collect();
        let record = Record::new(time, ring(420)).unwrap();
        let Clock::Uniform { interval_s, .. } = *record.clock() else { panic!("{dt}") };
        let error = record.clock_report().rebuilt_rate_error;
        assert!((interval_s / dt - 1.0).abs() <= error, "{dt}: {interval_s} {error}");
        // Less than a third of a second over the whole record, although each stamp is off by up to one second.
        assert!(error * 420.0 * dt < 0.33, "{dt}: {error}");
    }
}

#[test]
fn a_counter_that_begins_again_is_counted_on() {
    for (period_s, start_s, dt) in [
        (4_294.967_296, 4290.0, 0.01),
        (4_294_967.296, 4_294_960.0, 0.02),
        (60.0, 57.0, 0.02),
        (1.0, 0.4, 0.02),
        (65.536, 60.0, 0.02),
        (86400.0, 86390.0, 0.01),
    ] {
        for unit_s in [0.0, 1e-6] {
            let stamp = |i: usize| {
                let t = (start_s + i as f64 * dt) % period_s;
                if unit_s > 0.0 { (t / unit_s).floor() * unit_s } else { t }
            };
            let record = Record::new((0..3000).map(stamp).collect(), ring(3000)).unwrap();
            let report = record.clock_report();
            let wraps = ((start_s + 2999.0 * dt) / period_s) as usize;
            assert_eq!((record.len(), report.wraps, report.resets), (3000, wraps, 0), "{period_s}");
            assert!((report.wrap_period_s.unwrap() - period_s).abs() < 1e-9 * period_s);
            assert!((record.duration_s() - 2999.0 * dt).abs() < 1e-5, "{}", record.duration_s());
        }
    }
    // A 16-bit integer continues at its most negative value.
    let stamp = |i: i32| f64::from((i * 20 + 32768).rem_euclid(65536) - 32768) / 1e3;
    let record = Record::new((0..4000).map(stamp).collect(), ring(4000)).unwrap();
    assert_eq!((record.clock_report().wraps, record.clock_report().resets), (1, 0));
    assert!((record.duration_s() - 79.98).abs() < 1e-9);
}

#[test]
fn runs_of_a_round_length_from_zero_are_no_counter() {
    for (first, n) in [(0, 3000), (1, 3001)] {
        let one = || (first..n).map(|i| f64::from(i) * 0.02);
        let time: Vec<f64> = one().chain(one()).collect();
        let record = Record::new(time, ring(6000)).unwrap();
        assert_eq!((record.len(), record.clock_report().wraps, record.clock_report().resets), (3000, 0, 1));
    }
    // Nor are runs whose clocks start at another time.
    let time: Vec<f64> = (2000..2900).chain(0..600).map(|i| f64::from(i) * 0.02).collect();
    assert_eq!(Record::new(time, ring(1500)).unwrap().clock_report().wraps, 0);
}

#[test]
fn a_run_behind_one_whose_counter_began_again_has_a_clock_of_its_own() {
    let counted = |i: i32| (57.0 + f64::from(i) * 0.02) % 60.0;
    let time: Vec<f64> = (0..1000).map(counted).chain((0..500).map(|i| 30.0 + f64::from(i) * 0.02)).collect();
    let time: Vec<f64> = time.into_iter().chain((0..300).map(|i| 5.0 + f64::from(i) * 0.02)).collect();
    let record = Record::new(time, ring(1800)).unwrap();
    let report = record.clock_report();
    assert_eq!((report.wraps, report.resets, record.len()), (1, 1, 1500));
}

/// In a permutation as many steps go back as forward: whether it is refused must not depend on which are more.
#[test]
fn mixed_rows_are_refused_and_rows_near_their_place_are_put_there() {
    let n = 400;
    for seed in 0..20_u64 {
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by_key(|i| (*i as u64 + 1).wrapping_mul(2 * seed + 0x9e37_79b9_7f4a_7c15) >> 20);
        let times = order.iter().map(|i| 0.1 * *i as f64).collect();
        let signal = order.iter().map(|i| ring(n)[*i]).collect();
        let found = Record::new(times, signal);
        assert!(matches!(found, Err(Error::TimeOutOfOrder { forward: 1.., .. })), "{seed}: {found:?}");
    }
    // Swapped pairs, after a row in its place.
    let swapped: Vec<usize> =
        (0..n).map(|i| if i % 2 == 1 { i + 1 } else { i.saturating_sub(1) }).map(|i| i.min(n - 1)).collect();
    let times = swapped.iter().map(|i| 0.1 * *i as f64).collect();
    let record = Record::new(times, swapped.iter().map(|i| ring(n)[*i]).collect()).unwrap();
    assert_eq!((record.len(), record.clock_report().reordered), (n, n / 2 - 1));
    assert_eq!(record.signal(), ring(n));
}
