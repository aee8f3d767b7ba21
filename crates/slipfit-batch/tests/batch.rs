//! Every row of a table gets its row of answer.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test, as it should")]

use arrow_array::builder::{FixedSizeListBuilder, LargeListBuilder, ListBuilder, PrimitiveBuilder};
use arrow_array::cast::AsArray;
use arrow_array::types::{
    ArrowPrimitiveType, Float32Type, Float64Type, Int16Type, Int32Type, Int64Type, TimestampNanosecondType,
    UInt8Type, UInt64Type,
};
use arrow_array::{
    Array, ArrayRef, DictionaryArray, Float64Array, Int16Array, Int32Array, ListArray, ListViewArray,
    RecordBatch, RunArray, StringArray,
};
use arrow_buffer::{OffsetBuffer, ScalarBuffer};
use arrow_schema::{DataType, Field, Schema};
use proptest::prelude::*;
use slipfit::SignalKind;
use slipfit::ringdown::LowPass;
use slipfit_batch::{Clock, Error, Method, Number, Options, Signal, fit_batch, fit_batch_until, schema};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

const DT: f64 = 0.01;

/// Sliding and viscous loss together, in closed form.
fn decay(sliding: f64, delta: f64, n: usize) -> Vec<f64> {
    let at = |t: f64| 1.0 * (-delta * t).exp() + sliding * (-delta * t).exp_m1() / delta;
    (0..n).map(|i| at(i as f64 * DT)).collect()
}

fn lists<T: ArrowPrimitiveType>(rows: &[Option<Vec<f64>>], native: impl Fn(f64) -> T::Native) -> ArrayRef {
    let mut builder = ListBuilder::new(PrimitiveBuilder::<T>::new());
    for row in rows {
        if let Some(row) = row {
            row.iter().for_each(|v| builder.values().append_value(native(*v)));
        }
        builder.append(row.is_some());
    }
    Arc::new(builder.finish())
}

fn batch(column: ArrayRef) -> RecordBatch {
    RecordBatch::try_from_iter([("amplitude", column)]).unwrap()
}

fn options() -> Options {
    Options::fit(Signal::Amplitude("amplitude".into()), Number::Same(DT))
}

fn number(answer: &RecordBatch, name: &str, row: usize) -> Option<f64> {
    let column = answer[name].as_primitive::<Float64Type>();
    column.is_valid(row).then(|| column.value(row))
}

fn text<'a>(answer: &'a RecordBatch, name: &str, row: usize) -> &'a str {
    answer[name].as_string::<i32>().value(row)
}

#[test]
fn every_kind_of_list_gives_one_answer() {
    let trace = decay(0.2, 0.7, 300);
    let rows = [Some(trace.clone()), Some(trace.clone()), Some(trace.clone())];
    let mut large = LargeListBuilder::new(PrimitiveBuilder::<Float64Type>::new());
    let mut fixed = FixedSizeListBuilder::new(PrimitiveBuilder::<Float64Type>::new(), 300);
    for row in rows.iter().flatten() {
        large.values().append_slice(row);
        large.append(true);
        fixed.values().append_slice(row);
        fixed.append(true);
    }
    let columns: [ArrayRef; 3] =
        [lists::<Float64Type>(&rows, |v| v), Arc::new(large.finish()), Arc::new(fixed.finish())];
    for column in columns {
        let whole = fit_batch(&batch(Arc::clone(&column)), &options()).unwrap();
        assert_eq!(whole.num_rows(), 3);
        assert!((number(&whole, "sliding_rate", 2).unwrap() - 0.2).abs() < 1e-9);
        assert!((number(&whole, "decay_rate_per_s", 0).unwrap() - 0.7).abs() < 1e-9);
        assert_eq!((text(&whole, "status", 1), text(&whole, "reason", 1)), ("done", ""));
        // A slice of a column begins at an offset in its memory.
        let part = fit_batch(&batch(column.slice(1, 2)), &options()).unwrap();
        assert_eq!(part, whole.slice(1, 2));
    }
}

#[test]
fn encoded_columns_are_decoded() {
    let traces = [decay(0.2, 0.7, 300), decay(0.1, 0.5, 300)];
    let interval = [Some(0.01), Some(0.01), None, Some(0.02)];
    let plain = lists::<Float64Type>(
        &[Some(traces[0].clone()), Some(traces[0].clone()), None, Some(traces[1].clone())],
        |v| v,
    );
    let held = lists::<Float64Type>(&traces.clone().map(Some), |v| v);
    let dictionary =
        DictionaryArray::new(Int32Array::from(vec![Some(0), Some(0), None, Some(1)]), Arc::clone(&held));
    let with_null = lists::<Float64Type>(&[Some(traces[0].clone()), None, Some(traces[1].clone())], |v| v);
    let runs = RunArray::try_new(&Int32Array::from(vec![2, 3, 4]), &with_null).unwrap();
    let values = held.as_list::<i32>().values();
    let field = Arc::new(Field::new_list_field(DataType::Float64, true));
    let views = ListViewArray::new(
        field,
        ScalarBuffer::from(vec![0, 0, 0, 300]),
        ScalarBuffer::from(vec![300; 4]),
        Arc::clone(values),
        Some(vec![true, true, false, true].into()),
    );
    // The numbers within the lists are encoded.
    let numbers = plain.as_list::<i32>().values().as_primitive::<Float64Type>().clone();
    let keys: Vec<i32> = (0..numbers.len() as i32).collect();
    let within = DictionaryArray::new(Int32Array::from(keys), Arc::new(numbers));
    let field = Arc::new(Field::new_list_field(within.data_type().clone(), true));
    let lengths = OffsetBuffer::from_lengths([300, 300, 0, 300]);
    let nulls = Some(vec![true, true, false, true].into());
    let within = ListArray::new(field, lengths, Arc::new(within), nulls);
    let columns: [ArrayRef; 4] = [Arc::new(dictionary), Arc::new(runs), Arc::new(views), Arc::new(within)];

    let steps = Float64Array::from(vec![0.01, 0.02]);
    let coded = DictionaryArray::new(
        Int16Array::from(vec![Some(0), Some(0), None, Some(1)]),
        Arc::new(steps) as ArrayRef,
    );
    let in_runs = RunArray::try_new(
        &Int16Array::from(vec![2, 3, 4]),
        &Float64Array::from(vec![Some(0.01), None, Some(0.02)]),
    );
    let intervals: [ArrayRef; 3] =
        [Arc::new(Float64Array::from(interval.to_vec())), Arc::new(coded), Arc::new(in_runs.unwrap())];

    let options = Options::fit(Signal::Amplitude("amplitude".into()), Number::Column("dt".into()));
    let answered = |traces: &ArrayRef, dt: &ArrayRef| {
        let batch =
            RecordBatch::try_from_iter([("amplitude", Arc::clone(traces)), ("dt", Arc::clone(dt))]).unwrap();
        let whole = fit_batch(&batch, &options).unwrap();
        assert_eq!(fit_batch(&batch.slice(1, 3), &options).unwrap(), whole.slice(1, 3));
        whole
    };
    let expected = answered(&plain, &intervals[0]);
    assert_eq!(text(&expected, "reason", 2), "dt is null");
    for traces in columns.iter().chain([&plain]) {
        for dt in &intervals {
            assert_eq!(answered(traces, dt), expected, "{} {}", traces.data_type(), dt.data_type());
        }
    }
    // Without its interval a null of the encoding is a trace that is null.
    for traces in &columns {
        let answer = fit_batch(&batch(Arc::clone(traces)), &self::options()).unwrap();
        assert_eq!(text(&answer, "reason", 2), "the trace is null");
    }
    let words: ArrayRef = Arc::new(["a", "b"].into_iter().collect::<DictionaryArray<Int32Type>>());
    let table = RecordBatch::try_from_iter([("amplitude", plain.slice(0, 2)), ("dt", words)]).unwrap();
    let told = fit_batch(&table, &options).unwrap_err().to_string();
    assert!(told.contains("`dt` is Dictionary(Int32, Utf8)"), "{told}");
    // A dictionary without values, whose rows are all null.
    let empty = DictionaryArray::new(Int32Array::from(vec![None; 2]), held.slice(0, 0));
    let answer = fit_batch(&batch(Arc::new(empty)), &self::options()).unwrap();
    assert_eq!(text(&answer, "reason", 1), "the trace is null");
}

#[test]
fn numbers_of_every_type_are_taken() {
    let trace: Vec<f64> = decay(0.02, 0.7, 300).iter().map(|v| (200.0 * v).round()).collect();
    let rows = [Some(trace)];
    let columns = [
        lists::<Float64Type>(&rows, |v| v),
        lists::<Float32Type>(&rows, |v| v as f32),
        lists::<Int16Type>(&rows, |v| v as i16),
        lists::<Int32Type>(&rows, |v| v as i32),
        lists::<UInt8Type>(&rows, |v| v as u8),
        lists::<UInt64Type>(&rows, |v| v as u64),
    ];
    let answers: Vec<_> = columns.map(|c| fit_batch(&batch(c), &options()).unwrap()).into();
    assert!(answers.iter().all(|answer| *answer == answers[0]));
    let rate = number(&answers[0], "sliding_rate", 0).unwrap();
    assert!((rate - 4.0).abs() < 0.5, "{rate}");
}

#[test]
fn a_row_that_fails_is_a_row_with_its_reason() {
    let good = decay(0.2, 0.7, 300);
    let mut holes = good.clone();
    holes[10..20].fill(f64::NAN);
    let rows = [
        Some(good),
        None,
        Some(vec![]),
        Some(vec![1.0]),
        Some(vec![f64::NAN; 50]),
        Some(holes),
        Some(vec![1.0; 50]),
        Some(vec![f64::INFINITY; 9]),
    ];
    let answer = fit_batch(&batch(lists::<Float64Type>(&rows, |v| v)), &options()).unwrap();
    let status: Vec<&str> = (0..rows.len()).map(|i| text(&answer, "status", i)).collect();
    assert_eq!(status, ["done", "failed", "failed", "failed", "failed", "done", "failed", "failed"]);
    let reasons: Vec<&str> = (0..rows.len()).map(|i| text(&answer, "reason", i)).collect();
    assert_eq!(reasons[1], "the trace is null");
    assert_eq!(reasons[2], "0 usable samples; at least 4 are needed");
    assert_eq!(reasons[3], "1 usable sample; at least 4 are needed");
    assert_eq!(reasons[4], reasons[2]);
    assert!(reasons[6].starts_with("no loss model could be fitted"), "{}", reasons[6]);
    assert_eq!(number(&answer, "sliding_rate", 1), None);
    assert!(answer["sliding_detected"].is_null(1));
    let left_out = answer["samples_left_out"].as_primitive::<Int64Type>();
    assert_eq!((left_out.value(0), left_out.value(5)), (0, 10));
    assert!((number(&answer, "sliding_rate", 5).unwrap() - 0.2).abs() < 1e-9);
}

/// Rows are fitted in blocks: rows that are done, warned, failed or of another length are answered as each is
/// alone.
#[test]
fn the_answer_to_a_row_does_not_depend_on_its_neighbours() {
    let noise = |i: usize| 1e-3 * (7.7 * (i * i % 1009) as f64).sin();
    let row = |i: usize| -> Option<Vec<f64>> {
        // A growing amplitude, a short trace, a gap, nothing at all, a constant; many decay times.
        let (delta, samples) = match i % 11 {
            3 => (-0.4, 300),
            5 => (0.7, 200),
            8 => (2.0, 300),
            10 => (6.0, 300),
            other => (0.1 + 0.05 * other as f64, 300),
        };
        let trace = decay(0.1, delta, samples);
        let mut trace: Vec<f64> = trace.iter().enumerate().map(|(k, a)| a + noise(k + 31 * i)).collect();
        match i % 29 {
            7 => trace[100..110].fill(f64::NAN),
            13 => return None,
            17 => trace.fill(0.5),
            _ => {}
        }
        Some(trace)
    };
    let rows: Vec<_> = (0..2100).map(row).collect();
    let mut options = options();
    options.frequency_hz = Some(Number::Same(20.0));
    let column = lists::<Float64Type>(&rows, |v| v);
    let whole = fit_batch(&batch(Arc::clone(&column)), &options).unwrap();
    let mut told = std::collections::BTreeMap::new();
    for (i, row) in rows.iter().enumerate() {
        let (status, reason) = (text(&whole, "status", i), text(&whole, "reason", i));
        *told.entry((status, reason)).or_insert(0) += 1;
        // Alone in its table, a short trace sets the common length, so that the joint fit takes it.
        if i % 11 != 5 {
            assert_eq!(fit_batch(&batch(column.slice(i, 1)), &options).unwrap(), whole.slice(i, 1), "{i}");
        }
        let samples = whole["samples"].as_primitive::<Int64Type>().value(i) as usize;
        let left_out = whole["samples_left_out"].as_primitive::<Int64Type>().value(i) as usize;
        if status != "failed" {
            assert_eq!(samples + left_out, row.as_ref().unwrap().len(), "{i}");
            assert_eq!(left_out, if i % 29 == 7 { 10 } else { 0 }, "{i}");
        }
    }
    let reasons: Vec<_> = told.keys().copied().collect();
    assert_eq!(
        reasons,
        [
            ("done", ""),
            (
                "failed",
                "no loss model could be fitted: the trace does not distinguish a decay rate from a sliding rate"
            ),
            ("failed", "the trace is null"),
            ("warned", "negative_damping"),
        ]
    );
    assert_eq!(told[&("failed", "the trace is null")], (0..2100).filter(|i| i % 29 == 13).count());
}

#[test]
fn null_samples_are_left_out() {
    let mut builder = ListBuilder::new(PrimitiveBuilder::<Float64Type>::new());
    for (i, v) in decay(0.2, 0.7, 300).into_iter().enumerate() {
        builder.values().append_option((i % 7 != 3).then_some(v));
    }
    builder.append(true);
    let answer = fit_batch(&batch(Arc::new(builder.finish())), &options()).unwrap();
    assert!((number(&answer, "decay_rate_per_s", 0).unwrap() - 0.7).abs() < 1e-9);
    assert_eq!(answer["samples"].as_primitive::<Int64Type>().value(0), 257);
}

#[test]
fn numbers_of_a_row_stand_in_columns() {
    let rows: Vec<_> = vec![Some(decay(0.2, 0.7, 300)); 4];
    let dt = Float64Array::from(vec![Some(DT), Some(2.0 * DT), None, Some(-1.0)]);
    let hz = Float64Array::from(vec![10.0, 20.0, 30.0, 40.0]);
    let names = StringArray::from(vec!["a", "b", "c", "d"]);
    let table = RecordBatch::try_from_iter([
        ("amplitude", lists::<Float64Type>(&rows, |v| v)),
        ("dt", Arc::new(dt) as ArrayRef),
        ("hz", Arc::new(hz) as ArrayRef),
        ("name", Arc::new(names) as ArrayRef),
    ])
    .unwrap();
    let mut options = Options::fit(Signal::Amplitude("amplitude".into()), Number::Column("dt".into()));
    options.frequency_hz = Some(Number::Column("hz".into()));
    options.keep = vec!["name".into()];
    let answer = fit_batch(&table, &options).unwrap();
    assert_eq!(*answer.schema(), schema(&table.schema(), &options).unwrap());
    assert_eq!(text(&answer, "name", 3), "d");
    let rates: Vec<_> = (0..2).map(|i| number(&answer, "sliding_rate", i).unwrap()).collect();
    assert!((rates[0] / rates[1] - 2.0).abs() < 1e-6, "{rates:?}");
    // a0 = 2 omega x_F/pi to second order in delta/omega.
    let x_f = number(&answer, "friction_displacement", 0).unwrap();
    assert!((x_f - 0.2 / (4.0 * 10.0)).abs() < 1e-6, "{x_f}");
    assert_eq!(text(&answer, "reason", 2), "dt is null");
    assert_eq!(text(&answer, "reason", 3), "dt = -1 must be a positive number");
}

#[test]
fn times_stand_in_lists() {
    let trace = decay(0.2, 0.7, 300);
    let times: Vec<f64> = (0..300).map(|i| 5.0 + DT * f64::from(i)).collect();
    let table = RecordBatch::try_from_iter([
        ("amplitude", lists::<Float64Type>(&[Some(trace.clone()), Some(trace.clone()), Some(trace)], |v| v)),
        ("t", lists::<Float64Type>(&[Some(times.clone()), Some(times[1..].to_vec()), None], |v| v)),
    ])
    .unwrap();
    let options = Options::new(Signal::Amplitude("amplitude".into()), Clock::Times("t".into()), Method::Fit);
    let answer = fit_batch(&table, &options).unwrap();
    assert!((number(&answer, "sliding_rate", 0).unwrap() - 0.2).abs() < 1e-8);
    assert_eq!(text(&answer, "reason", 1), "299 times for 300 samples");
    assert_eq!(text(&answer, "reason", 2), "the times are null");
}

#[test]
fn a_trace_is_followed_down_to_the_least_amplitude() {
    // At rest from 0.7 s on: the samples after that belong to no decay.
    let mut trace = decay(0.9, 1.0, 300);
    let stop = trace.iter().position(|a| *a < 0.01).unwrap();
    trace[stop..].fill(0.0);
    let table = batch(lists::<Float64Type>(&[Some(trace)], |v| v));
    let rate = |options: &Options| number(&fit_batch(&table, options).unwrap(), "sliding_rate", 0).unwrap();
    let mut options = options();
    assert!((rate(&options) - 0.9).abs() > 0.05, "the rest spoils the fit");
    options.min_amplitude = Some(Number::Same(0.02));
    assert!((rate(&options) - 0.9).abs() < 1e-6);
}

/// A sum of twelve uniform numbers, nearly normal.
fn normal(i: usize) -> f64 {
    let uniform = |j: usize| {
        let mut z = ((12 * i + j) as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..12).map(uniform).sum::<f64>() - 6.0
}

/// Without a warning, rest after the stop turned friction into damping, and a noise floor hid friction.
#[test]
fn what_is_no_such_decay_is_warned_of() {
    const N: usize = 400;
    let of = |made: &dyn Fn(usize, f64) -> f64, law: &[f64]| Some((0..N).map(|i| made(i, law[i])).collect());
    let (sliding, slow) = (decay(1.5, 0.5, N), decay(0.0, 0.5, N));
    let rows: Vec<Option<Vec<f64>>> = vec![
        of(&|i, a| a.max(0.0) + 0.02 * normal(i), &sliding),
        of(&|i, a| (a.max(0.0) + 0.02 * normal(i)).hypot(0.02 * normal(i + N)), &sliding),
        of(&|i, a| (a + 0.1 * normal(i)).hypot(0.1 * normal(i + N)), &slow),
        of(&|i, a| a + 0.1 * normal(i), &slow),
        of(&|i, a| (a + 0.02 * normal(i)).hypot(0.02 * normal(i + N)), &slow),
    ];
    let table = batch(lists::<Float64Type>(&rows, |v| v));
    let times: Vec<Option<Vec<f64>>> =
        rows.iter().map(|_| Some((0..N).map(|i| i as f64 * DT).collect())).collect();
    let stamped = RecordBatch::try_from_iter([
        ("amplitude", Arc::clone(table.column(0))),
        ("t", lists::<Float64Type>(&times, |v| v)),
    ]);
    let by_times = Options::new(Signal::Amplitude("amplitude".into()), Clock::Times("t".into()), Method::Fit);
    for answer in [fit_batch(&table, &options()).unwrap(), fit_batch(&stamped.unwrap(), &by_times).unwrap()] {
        let reason = |row| text(&answer, "reason", row);
        assert!(reason(0).contains("misfit"), "{}", reason(0));
        assert!(reason(1).contains("misfit"), "{}", reason(1));
        assert_eq!((reason(2), reason(3), reason(4)), ("noise_floor", "", ""));
    }
}

#[test]
fn lock_in_outputs_and_oscillations_are_analysed() {
    let oscillator = slipfit::Oscillator::kinematic(50.0, 0.3, 0.002).unwrap();
    let motion = slipfit::motion::decay::FreeDecay::from_rest(&oscillator, 1.0).unwrap();
    let noise = |i: usize| 1e-3 * (7.7 * (i * i) as f64).sin();
    let times = || (0..3000).map(|i| 0.002 * i as f64);
    let swing: Vec<f64> = times().enumerate().map(|(i, t)| motion.displacement(t) + noise(i)).collect();
    let table = batch(lists::<Float64Type>(&[Some(swing.clone()), Some(vec![1.0; 3000])], |v| v));
    let mut options = Options::new(
        Signal::Oscillation("amplitude".into(), SignalKind::Displacement),
        Clock::Interval(Number::Same(0.002)),
        Method::Analyse,
    );
    options.unit = "rad".into();
    let answer = fit_batch(&table, &options).unwrap();
    // A row gives the same as the analysis of its record.
    let record = slipfit::Record::uniform(500.0, swing).unwrap().with_unit("rad");
    let alone = slipfit::ringdown::analyse(&record, &Default::default()).unwrap();
    let x_f = alone.parameter(slipfit::Parameter::FRICTION_DISPLACEMENT).unwrap();
    assert_eq!(number(&answer, "friction_displacement", 0), Some(x_f.value));
    assert_eq!(number(&answer, "friction_displacement_low", 0), Some(x_f.interval_95[0]));
    assert_eq!(text(&answer, "model", 0), alone.model.name());
    assert!(text(&answer, "reason", 1).contains("constant"), "{}", text(&answer, "reason", 1));

    let amplitude: Vec<f64> = decay(0.05, 0.3, 400);
    let [x, y] = [0.6, 0.8].map(|part| amplitude.iter().map(|a| a * part).collect::<Vec<f64>>());
    let table = RecordBatch::try_from_iter([
        ("x", lists::<Float64Type>(&[Some(x.clone()), Some(x)], |v| v)),
        ("y", lists::<Float64Type>(&[Some(y.clone()), Some(y[1..].to_vec())], |v| v)),
    ])
    .unwrap();
    let both = Options::fit(Signal::LockIn("x".into(), "y".into()), Number::Same(DT));
    let answer = fit_batch(&table, &both).unwrap();
    assert!((number(&answer, "sliding_rate", 0).unwrap() - 0.05).abs() < 1e-8);
    assert_eq!(text(&answer, "reason", 1), "399 values of Y for 400 of X");
    let mut both = both;
    both.method = Method::Analyse;
    let answer = fit_batch(&table, &both).unwrap();
    assert!((number(&answer, "sliding_rate", 0).unwrap() - 0.05).abs() < 1e-3);
}

#[test]
fn a_table_that_cannot_be_meant_is_refused() {
    let table = batch(lists::<Float64Type>(&[Some(decay(0.2, 0.7, 300))], |v| v));
    let refused = |change: fn(&mut Options)| {
        let mut options = options();
        change(&mut options);
        fit_batch(&table, &options).unwrap_err().to_string()
    };
    let said = refused(|o| o.signal = Signal::Amplitude("a".into()));
    assert_eq!(said, "there is no column `a`; there are `amplitude`");
    let said = refused(|o| o.clock = Clock::Interval(Number::Column("amplitude".into())));
    assert!(said.contains("must be a column of numbers"), "{said}");
    let said = refused(|o| o.clock = Clock::Interval(Number::Same(0.0)));
    assert_eq!(said, "dt: 0 must be a positive number");
    let said = refused(|o| o.frequency_hz = Some(Number::Same(f64::NAN)));
    assert_eq!(said, "frequency_hz: NaN must be a positive number");
    let said = refused(|o| o.keep = vec!["b".into()]);
    assert!(said.contains("no column `b`"), "{said}");
    let said = refused(|o| o.signal = Signal::Oscillation("amplitude".into(), SignalKind::Displacement));
    assert!(said.starts_with("method: an oscillation needs"), "{said}");
    let said = refused(|o| {
        o.method = Method::Analyse;
        o.signal = Signal::Oscillation("amplitude".into(), SignalKind::Displacement);
        o.ringdown.lockin = Some(LowPass { time_constant_s: 1.0, order: 2 });
    });
    assert!(
        said.starts_with("time_constant_s: ") && said.ends_with("the signal `amplitude` is an oscillation"),
        "{said}"
    );
    let said = refused(|o| o.ringdown.band_hz = Some([1.0, 2.0]));
    assert!(said.starts_with("band_hz: only for an oscillation"), "{said}");
    let said = refused(|o| o.clock = Clock::Times("amplitude".into()));
    assert_eq!(said, "time: `amplitude` is the column of the traces");
    let texts = batch(Arc::new(StringArray::from(vec!["a"])));
    assert!(matches!(fit_batch(&texts, &options()), Err(Error::ColumnType { .. })));
    let own = RecordBatch::try_from_iter([
        ("amplitude", Arc::clone(table.column(0))),
        ("status", Arc::new(StringArray::from(vec!["x"])) as ArrayRef),
    ])
    .unwrap();
    let mut keep = options();
    keep.keep = vec!["status".into()];
    assert!(matches!(fit_batch(&own, &keep), Err(Error::Option { option: "keep", .. })));
}

#[test]
fn a_batch_ends_when_it_is_told_to() {
    let table = batch(lists::<Float64Type>(&vec![Some(decay(0.2, 0.7, 300)); 500], |v| v));
    let told = AtomicBool::new(true);
    assert!(matches!(fit_batch_until(&table, &options(), &told), Err(Error::Cancelled)));
}

#[test]
fn no_rows_are_no_rows() {
    let empty = batch(lists::<Float64Type>(&[], |v| v));
    let answer = fit_batch(&empty, &options()).unwrap();
    assert_eq!(answer.num_rows(), 0);
    assert_eq!(*answer.schema(), schema(&empty.schema(), &options()).unwrap());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever the numbers are: one row of answer for each, in order, and no panic.
    #[test]
    fn order_and_count_are_kept(
        rows in prop::collection::vec(
            prop::option::of(prop::collection::vec(prop::num::f64::ANY, 0..40)), 0..20
        ),
        dt in prop::sample::select(vec![1e-300, 1e-3, 1.0, 1e300]),
        analyse in any::<bool>(),
    ) {
        let table = batch(lists::<Float64Type>(&rows, |v| v));
        let method = if analyse { Method::Analyse } else { Method::Fit };
        let clock = Clock::Interval(Number::Same(dt));
        let options = Options::new(Signal::Amplitude("amplitude".into()), clock, method);
        let answer = fit_batch(&table, &options).unwrap();
        prop_assert_eq!(answer.num_rows(), rows.len());
        for (i, row) in rows.iter().enumerate() {
            let failed = text(&answer, "status", i) == "failed";
            prop_assert!(failed || row.as_ref().is_some_and(|r| r.len() >= 4));
            prop_assert_eq!(failed, number(&answer, "decay_rate_per_s", i).is_none());
            prop_assert!(!failed || !text(&answer, "reason", i).is_empty());
        }
    }
}

#[test]
fn columns_are_found_once_and_options_meant_for_others_are_refused() {
    let trace: Vec<f64> = (0..60).map(|i| (-0.02 * f64::from(i)).exp()).collect();
    let lists = || -> ArrayRef {
        Arc::new(ListArray::from_iter_primitive::<Float64Type, _, _>([Some(trace.iter().copied().map(Some))]))
    };
    let fields: Vec<Field> =
        ["a", "a", "i"].iter().map(|name| Field::new(*name, lists().data_type().clone(), true)).collect();
    let table = RecordBatch::try_new(Arc::new(Schema::new(fields)), vec![lists(), lists(), lists()]).unwrap();
    let of = |name: &str| Options::fit(Signal::Amplitude(name.into()), Number::Same(0.01));
    assert!(matches!(fit_batch(&table, &of("a")), Err(Error::AmbiguousColumn { name }) if name == "a"));
    let mut twice = of("i");
    twice.keep = vec!["i".into(), "i".into()];
    assert_eq!(fit_batch(&table, &twice).unwrap_err().to_string(), "keep: `i` is named twice");
    let signal = Signal::Oscillation("i".into(), SignalKind::Displacement);
    let mut oscillation = Options::new(signal, Clock::Interval(Number::Same(0.01)), Method::Analyse);
    oscillation.frequency_hz = Some(Number::Same(5.0));
    let said = fit_batch(&table, &oscillation).unwrap_err().to_string();
    assert!(said.starts_with("frequency_hz: only for amplitudes"), "{said}");
}

#[test]
fn dates_count_from_the_first_of_their_row() {
    // From one end of the calendar to the other: the differences exceed 64-bit integers.
    let ends = |i: i64| i64::MIN + 4 * i * (i64::MAX / 800);
    let nanoseconds = (0..200).map(|i| Some(ends(i)));
    let late = (0..200).map(|i| (i > 0).then_some(1_800_000_000_000_000_000 + 10_000_000 * i));
    let dates = ListArray::from_iter_primitive::<TimestampNanosecondType, _, _>([
        Some(nanoseconds.collect::<Vec<_>>()),
        Some(late.collect()),
    ]);
    let traces = [Some(decay(0.2, 0.7, 200)), Some(decay(0.2, 0.7, 200))];
    let table = RecordBatch::try_from_iter([
        ("a", lists::<Float64Type>(&traces, |v| v)),
        ("t", Arc::new(dates) as ArrayRef),
    ])
    .unwrap();
    let options = Options::new(Signal::Amplitude("a".into()), Clock::Times("t".into()), Method::Fit);
    let answer = fit_batch(&table, &options).unwrap();
    let scale = DT / (4.0 * (i64::MAX / 800) as f64 * 1e-9);
    assert!((number(&answer, "sliding_rate", 0).unwrap() / scale - 0.2).abs() < 1e-6);
    // The sample without a date is left out, and the row begins with the next one.
    assert!((number(&answer, "sliding_rate", 1).unwrap() - 0.2).abs() < 1e-9);
    assert!((number(&answer, "initial_amplitude", 1).unwrap() - decay(0.2, 0.7, 2)[1]).abs() < 1e-9);
}

#[test]
fn times_that_go_backwards_fail_their_row() {
    let times: Vec<f64> = (0..60).map(|i| 0.01 * f64::from(i)).collect();
    let trace = || Some(times.iter().map(|t| Some((-2.0 * t).exp() + 1e-3 * (900.0 * t).sin())));
    let back: Vec<f64> = times.iter().rev().copied().collect();
    let stamps = [&times, &back].map(|list| Some(list.iter().copied().map(Some)));
    let table = RecordBatch::try_from_iter([
        ("a", Arc::new(ListArray::from_iter_primitive::<Float64Type, _, _>([trace(), trace()])) as ArrayRef),
        ("t", Arc::new(ListArray::from_iter_primitive::<Float64Type, _, _>(stamps)) as ArrayRef),
    ])
    .unwrap();
    let options = Options::new(Signal::Amplitude("a".into()), Clock::Times("t".into()), Method::Fit);
    let answer = fit_batch(&table, &options).unwrap();
    let reason = answer["reason"].as_string::<i32>();
    assert_eq!(reason.value(0), "");
    assert!(reason.value(1).starts_with("time goes backwards at sample 1"), "{}", reason.value(1));
}

/// Each column of the answer has its unit; for velocities, the friction displacement has that of a length.
#[test]
fn columns_name_their_units() {
    let table = batch(lists::<Float64Type>(&[Some(decay(0.2, 0.7, 300))], |v| v));
    let units = |change: fn(&mut Options)| {
        let mut options = options();
        change(&mut options);
        let schema = schema(&table.schema(), &options).unwrap();
        move |name: &str| schema.field_with_name(name).unwrap().metadata().get("unit").cloned()
    };
    let unit = units(|o| o.unit = "nm".into());
    assert_eq!(unit("decay_rate_low_per_s").as_deref(), Some("1/s"));
    assert_eq!(unit("sliding_rate_std_error").as_deref(), Some("nm/s"));
    assert_eq!(unit("friction_displacement").as_deref(), Some("nm"));
    assert_eq!(unit("residual_rms").as_deref(), Some("nm"));
    assert_eq!([unit("status"), unit("samples"), unit("correlation")], [None, None, None]);
    let unit = units(|_| {});
    assert_eq!([unit("sliding_rate").as_deref(), unit("initial_amplitude").as_deref()], [Some("1/s"), None]);
    let unit = units(|o| {
        o.method = Method::Analyse;
        o.signal = Signal::Oscillation("amplitude".into(), SignalKind::Velocity);
        o.frequency_hz = None;
        o.unit = "mm/s".into();
    });
    assert_eq!(unit("friction_displacement_high").as_deref(), Some("mm"));
    assert_eq!(
        [unit("initial_amplitude").as_deref(), unit("frequency_hz").as_deref()],
        [Some("mm/s"), Some("Hz")]
    );
}

#[test]
fn a_row_without_a_frequency_or_a_least_amplitude_has_its_losses() {
    let trace = decay(0.2, 0.7, 200);
    let table = RecordBatch::try_from_iter([
        ("amplitude", lists::<Float64Type>(&vec![Some(trace); 3], |v| v)),
        ("f", Arc::new(Float64Array::from(vec![Some(5.0), None, Some(f64::NAN)])) as ArrayRef),
    ])
    .unwrap();
    for least in [false, true] {
        let mut asked = options();
        asked.frequency_hz = Some(Number::Column("f".into()));
        asked.min_amplitude = least.then(|| Number::Column("f".into()));
        let found = fit_batch(&table, &asked).unwrap();
        for row in [1, 2] {
            assert!((number(&found, "sliding_rate", row).unwrap() - 0.2).abs() < 1e-9);
            assert_eq!(number(&found, "friction_displacement", row), None);
            let codes = if least { "no_frequency no_min_amplitude" } else { "no_frequency" };
            assert_eq!((text(&found, "status", row), text(&found, "reason", row)), ("warned", codes));
        }
    }
}

#[test]
fn levels_are_amplitudes_and_columns_in_other_units_have_factors() {
    let trace = decay(0.2, 0.7, 300);
    let level = |v: &f64| 20.0 * v.log10();
    let levels: Vec<f64> = trace.iter().take(150).map(level).collect();
    let holed: Vec<f64> =
        levels.iter().enumerate().map(|(i, v)| if i == 7 { f64::NEG_INFINITY } else { *v }).collect();
    let mut asked = options();
    asked.levels = true;
    let column = lists::<Float64Type>(&[Some(levels), Some(holed)], |v| v);
    let whole = fit_batch(&batch(column), &asked).unwrap();
    for row in 0..2 {
        assert!((number(&whole, "sliding_rate", row).unwrap() - 0.2).abs() < 1e-9);
        assert!((number(&whole, "initial_amplitude", row).unwrap() - 1.0).abs() < 1e-9);
    }
    assert_eq!(whole["samples_left_out"].as_primitive::<Int64Type>().values(), &[0, 1]);
    asked.signal = Signal::LockIn("amplitude".into(), "y".into());
    assert!(matches!(
        fit_batch(&batch(lists::<Float64Type>(&[], |v| v)), &asked),
        Err(Error::Option { option: "unit", .. })
    ));

    let times: Vec<f64> = (0..300).map(|i| 1e3 * DT * f64::from(i)).collect();
    let table = RecordBatch::try_from_iter([
        ("amplitude", lists::<Float64Type>(&[Some(trace)], |v| v)),
        ("t", lists::<Float64Type>(&[Some(times)], |v| v)),
        ("dt", Arc::new(Float64Array::from(vec![1e3 * DT])) as ArrayRef),
        ("least", Arc::new(Float64Array::from(vec![500.0])) as ArrayRef),
    ])
    .unwrap();
    for clock in [Clock::Interval(Number::Column("dt".into())), Clock::Times("t".into())] {
        let mut asked = options();
        asked.clock = clock;
        asked.min_amplitude = Some(Number::Column("least".into()));
        asked.factors =
            [("t", 1e-3), ("dt", 1e-3), ("least", 1e-3)].map(|(name, v)| (name.to_owned(), v)).into();
        let found = fit_batch(&table, &asked).unwrap();
        assert!((number(&found, "decay_rate_per_s", 0).unwrap() - 0.7).abs() < 1e-9);
        assert!((number(&found, "sliding_rate", 0).unwrap() - 0.2).abs() < 1e-9);
        assert_eq!(found["samples_left_out"].as_primitive::<Int64Type>().value(0), 229);
    }
}
