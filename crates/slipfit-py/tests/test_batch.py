"""Batches: one row of answer for each trace, from any table with Arrow's C interface."""

import copy
import datetime
import inspect
import pickle

import numpy as np
import pytest
import slipfit
from conftest import ends_at_a_signal
from hypothesis import given, settings
from hypothesis import strategies as st

pa = pytest.importorskip("pyarrow")

DT = 0.01
TIME = DT * np.arange(300)


def decays(count, noise=0.0):
    """Rates of sliding and viscous loss, and the amplitudes they leave."""
    random = np.random.default_rng(7)
    sliding, delta = random.uniform(0, 0.2, (count, 1)), random.uniform(0.2, 1.0, (count, 1))
    fall = np.exp(-delta * TIME)
    traces = fall - sliding * (1 - fall) / delta + noise * random.standard_normal((count, len(TIME)))
    return sliding[:, 0], delta[:, 0], traces


def lists(traces, kind=None):
    kind = kind or pa.list_(pa.float64())
    return pa.table({"id": range(len(traces)), "amplitude": pa.array(list(traces), type=kind)})


@pytest.mark.parametrize(
    "kind",
    [
        pa.list_(pa.float64()),
        pa.list_(pa.float32()),
        pa.large_list(pa.float64()),
        pa.list_(pa.float64(), len(TIME)),
        pa.large_list(pa.float32()),
    ],
    ids=str,
)
def test_lists_of_every_kind(kind):
    sliding, delta, traces = decays(20)
    answers = slipfit.fit_batch(lists(traces, kind), amplitude="amplitude", dt=DT, keep=["id"])
    single = "float" in str(kind) and "double" not in str(kind)
    np.testing.assert_allclose(answers["sliding_rate"], sliding, atol=1e-4 if single else 1e-8)
    np.testing.assert_allclose(answers["decay_rate_per_s"], delta, atol=1e-3 if single else 1e-8)
    assert answers.to_pyarrow()["id"].to_pylist() == list(range(20))
    assert answers.column_names[:3] == ["id", "status", "reason"]


def test_one_row_is_the_fit_of_its_envelope():
    _, _, traces = decays(5, noise=0.01)
    answers = slipfit.fit_batch(traces, amplitude="a", dt=DT, frequency_hz=50)
    for row, trace in enumerate(traces):
        fit = slipfit.fit_envelope(TIME, trace, initial_amplitude=1, offset_amplitude=0.1, decay_rate_per_s=0.5)
        error = fit.std_error.decay_rate_per_s
        assert abs(fit.best.decay_rate_per_s - answers["decay_rate_per_s"][row]) < 0.02 * error
        assert answers["decay_rate_std_error_per_s"][row] == pytest.approx(error, rel=1e-2)


def test_intervals_hold_the_truth():
    sliding, delta, traces = decays(4000, noise=0.02)
    answers = slipfit.fit_batch(traces, amplitude="a", dt=DT)
    for truth, name, unit in ((sliding, "sliding_rate", ""), (delta, "decay_rate", "_per_s")):
        inside = (answers[f"{name}_low{unit}"] <= truth) & (truth <= answers[f"{name}_high{unit}"])
        # 95 % of 4000 scatters by 0.35 %; four times that.
        assert abs(inside.mean() - 0.95) < 0.014, name


def test_any_producer_gives_the_same(tmp_path):
    _, _, traces = decays(50, noise=0.01)
    table = lists(traces)
    expected = slipfit.fit_batch(table, amplitude="amplitude", dt=DT).to_pyarrow()
    producers = [table.combine_chunks().to_batches()[0], table.to_reader(max_chunksize=7)]
    polars = pytest.importorskip("polars")
    producers.append(polars.from_arrow(table))
    pandas = pytest.importorskip("pandas")
    producers.append(pandas.DataFrame({"amplitude": list(traces)}))
    duckdb = pytest.importorskip("duckdb")
    producers.append(duckdb.from_arrow(table).order("id").project("amplitude"))
    for producer in producers:
        found = slipfit.fit_batch(producer, amplitude="amplitude", dt=DT).to_pyarrow()
        assert found.combine_chunks() == expected, type(producer)
    whole = slipfit.fit_batch(table, amplitude="amplitude", dt=DT)
    assert polars.DataFrame(whole).equals(whole.to_polars())
    assert whole.to_pandas().shape == (50, 24)


def test_slices_and_chunks_are_read_where_they_begin():
    sliding, _, traces = decays(40)
    for kind in (None, pa.list_(pa.float64(), len(TIME))):
        table = lists(traces, kind)
        chunked = pa.concat_tables([table.slice(0, 11), table.slice(11, 20), table.slice(31)]).slice(5, 30)
        answers = slipfit.fit_batch(chunked, amplitude="amplitude", dt=DT)
        np.testing.assert_allclose(answers["sliding_rate"], sliding[5:35], atol=1e-8)
        one = table.slice(3, 30).combine_chunks().to_batches()[0]
        answers = slipfit.fit_batch(one.slice(2, 9), amplitude="amplitude", dt=DT)
        np.testing.assert_allclose(answers["sliding_rate"], sliding[5:14], atol=1e-8)


def test_bad_rows_are_rows():
    _, _, traces = decays(1)
    good = traces[0].tolist()
    rows = [good, None, [], [1.0], [None] * 9, [float("nan")] * 9, [*good[:50], None, *good[51:]], [1.0] * 30]
    answers = slipfit.fit_batch(
        pa.table({"amplitude": pa.array(rows, pa.list_(pa.float64()))}), amplitude="amplitude", dt=DT
    )
    assert list(answers["status"]) == ["done", *["failed"] * 5, "done", "failed"]
    assert answers["reason"][1] == "the trace is null"
    assert np.isnan(answers["sliding_rate"][1])
    assert answers["samples_left_out"][6] == 1


def test_the_whole_analysis_of_a_row_is_that_of_its_record():
    record = slipfit.simulate.decay(
        frequency_hz=8, q_factor=90, friction_displacement=0.002, amplitude=1, duration_s=6, rate_hz=400
    )
    noisy = record.signal + 1e-3 * np.random.default_rng(8).standard_normal(len(record))
    table = pa.table({"x": [noisy.tolist(), [0.0] * 100]})
    answers = slipfit.fit_batch(table, signal="x", dt=1 / 400, method="analyse", unit="rad")
    alone = slipfit.ringdown(None, noisy, rate_hz=400, unit="rad")
    x_f = alone.parameters.friction_displacement
    assert answers["friction_displacement"][0] == x_f.value
    assert (answers["friction_displacement_low"][0], answers["friction_displacement_high"][0]) == x_f.interval_95
    assert answers["model"][0] == alone.model
    assert answers["reason"][0].split() == [w.code for w in alone.warnings]
    assert "constant" in answers["reason"][1]


def test_a_stream_is_read_batch_by_batch():
    sliding, _, traces = decays(30)
    table = lists(traces)
    taken = []

    def batches():
        for batch in table.to_batches(max_chunksize=10):
            taken.append(batch.num_rows)
            yield batch

    def source():
        return pa.RecordBatchReader.from_batches(table.schema, batches())

    found = []
    for answers in slipfit.fit_stream(source(), amplitude="amplitude", dt=DT):
        found.extend(answers["sliding_rate"])
        assert len(found) == sum(taken), "one batch at a time"
    np.testing.assert_allclose(found, sliding, atol=1e-8)
    stream = slipfit.fit_stream(source(), amplitude="amplitude", dt=DT)
    whole = pa.RecordBatchReader.from_stream(stream).read_all()
    assert whole.num_rows == 30 and whole.column_names == stream.column_names
    with pytest.raises(slipfit.OptionError, match="has been read"):
        pa.RecordBatchReader.from_stream(stream)


def test_a_source_that_fails_says_so():
    schema = pa.schema({"amplitude": pa.list_(pa.float64())})

    def batches():
        yield pa.record_batch([pa.array([[1.0] * 9], schema.field(0).type)], schema=schema)
        raise RuntimeError("the disk is gone")

    source = pa.RecordBatchReader.from_batches(schema, batches())
    with pytest.raises(slipfit.SlipfitError, match="the disk is gone"):
        slipfit.fit_batch(source, amplitude="amplitude", dt=DT)


@pytest.mark.parametrize(
    ("table", "options", "words"),
    [
        (np.zeros(9), {"amplitude": "a", "dt": 1}, "rows, samples"),
        (np.zeros((3, 9), dtype=complex), {"amplitude": "a", "dt": 1}, "rows, samples"),
        ({1, 2}, {"amplitude": "a", "dt": 1}, "does not export"),
        ([1, 2], {"amplitude": "a", "dt": 1}, "a list of traces"),
        (pa.array([[1.0]]), {"amplitude": "a", "dt": 1}, "ListArray and has no columns with names"),
        (pa.chunked_array([[[1.0]]]), {"amplitude": "a", "dt": 1}, "ChunkedArray and has no columns with names"),
        (pa.table({str(i): [1] for i in range(99)}), {"amplitude": "a", "dt": 1}, "`19`, others, 99 in all"),
        (pa.table([[[1.0]]] * 2, ["a", "a"]), {"amplitude": "a", "dt": 1}, "several columns `a`"),
        (pa.table({"a": [[1.0]], "i": [1]}), {"amplitude": "a", "dt": 1, "keep": ["i", "i"]}, "named twice"),
        (pa.table({"a": [[1.0]]}), {"amplitude": "a", "dt": 1, "kind": "velocity"}, "what signal="),
        (
            pa.table({"a": [[1.0]]}),
            {"signal": "a", "dt": 1, "method": "analyse", "frequency_hz": 5},
            "frequency of its own",
        ),
        (pa.table({"b": [[1.0]]}), {"amplitude": "a", "dt": 1}, "no column `a`; there are `b`"),
        (pa.table({"a": [1.0]}), {"amplitude": "a", "dt": 1}, "must be a list"),
        (pa.table({"a": [["x"]]}), {"amplitude": "a", "dt": 1}, "must be a list"),
        (pa.table({"a": [[1.0]]}), {"amplitude": "a"}, "dt="),
        (pa.table({"a": [[1.0]]}), {"dt": 1}, "amplitude="),
        (pa.table({"a": [[1.0]]}), {"amplitude": "a", "signal": "a", "dt": 1}, "amplitude="),
        (pa.table({"a": [[1.0]]}), {"amplitude": "a", "dt": 0}, "positive"),
        (pa.table({"a": [[1.0]]}), {"amplitude": "a", "dt": 1, "frequency_hz": 0}, "positive"),
        (pa.table({"a": [[1.0]]}), {"amplitude": "a", "dt": 1, "method": "guess"}, "fit, analyse"),
        (pa.table({"a": [[1.0]]}), {"signal": "a", "dt": 1}, "needs the method analyse"),
        (pa.table({"a": [[1.0]]}), {"amplitude": "a", "dt": 1, "model": "viscous"}, "option of method"),
        (pa.table({"a": [[1.0]]}), {"amplitude": "a", "dt": 1, "keep": ["b"]}, "no column `b`"),
    ],
)
def test_what_cannot_be_meant_is_refused(table, options, words):
    with pytest.raises(slipfit.OptionError, match=words):
        slipfit.fit_batch(table, **options)


def test_tables_of_answers_are_copied_and_pickled():
    rows = pa.array([[1 - 0.002 * k * i for i in range(90)] for k in (1, 2)] + [None], pa.list_(pa.float64()))
    names = pa.array(["one", "two", "three"]).dictionary_encode()
    table = pa.table({"amplitude": rows, "name": names})
    answers = slipfit.fit_batch(table, amplitude="amplitude", dt=DT, keep="name")
    (streamed,) = slipfit.fit_stream(table, amplitude="amplitude", dt=DT, keep="name")
    empty = slipfit.fit_batch(table[:0], amplitude="amplitude", dt=DT, keep="name")
    for held in (answers, streamed, empty):
        for same in (pickle.loads(pickle.dumps(held)), copy.copy(held), copy.deepcopy(held)):
            assert same.to_pyarrow().equals(held.to_pyarrow())
            assert same == held
            assert same.column_names == held.column_names


def test_a_misspelt_option_of_a_stream_is_named():
    with pytest.raises(TypeError, match=r"fit_stream\(\) got an unexpected keyword argument 'amplitud'"):
        slipfit.fit_stream(pa.table({"a": [[1.0]]}), amplitud="a", dt=1)
    options = inspect.signature(slipfit.fit_batch).parameters
    assert inspect.signature(slipfit.fit_stream).parameters == options


def test_ctrl_c_ends_a_batch():
    trace = np.cos(0.05 * np.arange(60_000)) * np.exp(-1e-4 * np.arange(60_000))
    table = pa.table({"x": pa.FixedSizeListArray.from_arrays(pa.array(np.tile(trace, 300)), len(trace))})
    assert ends_at_a_signal(lambda: slipfit.fit_batch(table, signal="x", dt=1e-3, method="analyse"))


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.none() | st.lists(st.none() | st.floats(width=32), max_size=30), max_size=12),
    st.sampled_from([pa.list_(pa.float64()), pa.large_list(pa.float32())]),
    st.sampled_from(["fit", "analyse"]),
)
def test_order_and_count_are_kept(rows, kind, method):
    table = pa.table({"amplitude": pa.array(rows, kind)})
    answers = slipfit.fit_batch(table, amplitude="amplitude", dt=DT, method=method)
    assert len(answers) == len(rows)
    for row, status in zip(rows, answers["status"] if rows else []):
        assert status == "failed" or sum(v is not None for v in row) >= 4


NAMES = st.sampled_from([None, "trace", "x", "nothing", "word", "id"])


@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.none() | st.lists(st.none() | st.floats(width=32), max_size=40), max_size=4),
    st.fixed_dictionaries(
        {},
        optional={
            "amplitude": NAMES, "x": NAMES, "y": NAMES, "signal": NAMES, "time": NAMES,
            "dt": NAMES | st.floats(), "frequency_hz": NAMES | st.floats(), "min_amplitude": NAMES | st.floats(),
            "method": st.sampled_from(["fit", "analyse", "guess"]),
            "keep": st.lists(st.sampled_from(["id", "word", "nothing", "status"]), max_size=2),
            "unit": st.sampled_from(["", "nm", "\0", "m" * 300]),
        },
    ),
)  # fmt: skip
def test_no_table_or_option_does_more_than_raise(rows, options):
    """A schema without the columns, lists of different length, frequencies of zero: an exception or a row's status."""
    count = len(rows)
    table = pa.table(
        {
            "trace": pa.array(rows, pa.list_(pa.float32())),
            "x": pa.array([row and row[:7] for row in rows], pa.large_list(pa.float64())),
            "word": pa.array(["a"] * count, pa.string()),
            "id": pa.array(range(count), pa.int64()),
        }
    )
    try:
        answers = slipfit.fit_batch(table, **options)
    except slipfit.SlipfitError as error:
        assert error.code != "internal", error
        return
    assert len(answers) == count
    assert set(answers["status"]) <= {"done", "warned", "failed"}
    assert all(reason for status, reason in zip(answers["status"], answers["reason"]) if status == "failed")


def test_arrays_of_every_make_are_tables():
    t = 0.01 * np.arange(120)
    trace = np.exp(-0.5 * t) - 0.1 * (1 - np.exp(-0.5 * t)) / 0.5
    mask = np.zeros((1, 120), bool)
    mask[0, 7] = True
    masked = np.ma.array(np.where(mask, 50.0, trace), mask=mask)
    tables = [np.array([trace]), np.array([trace]).astype(">f8"), np.array([trace]).astype(np.longdouble), masked]
    for table in tables:
        found = slipfit.fit_batch(table, amplitude="a", dt=0.01)
        assert found["sliding_rate"][0] == pytest.approx(0.1, rel=1e-6)
    assert found["samples_left_out"][0] == 1
    assert slipfit.fit_batch(np.zeros((2, 0)), amplitude="a", dt=0.01)["status"].tolist() == ["failed", "failed"]
    assert "sliding_rate" in found
    assert list(found) == found.column_names


def test_tables_of_answers_are_equal_by_their_rows():
    _, _, traces = decays(9)
    table = lists(traces)
    whole = slipfit.fit_batch(table, amplitude="amplitude", dt=DT, keep="id")
    cut = pa.concat_tables([table.slice(0, 2), table.slice(2, 0), table.slice(2, 5), table.slice(7)])
    assert slipfit.fit_batch(cut, amplitude="amplitude", dt=DT, keep="id") == whole
    assert slipfit.fit_batch(table[:8], amplitude="amplitude", dt=DT, keep="id") != whole
    assert slipfit.fit_batch(table, amplitude="amplitude", dt=DT) != whole
    assert slipfit.fit_batch(table, amplitude="amplitude", dt=2 * DT, keep="id") != whole
    assert whole != 3
    with pytest.raises(TypeError, match="unhashable"):
        hash(whole)


KEPT = {
    "count": pa.array([1, None, 3], pa.int64()),
    "short": pa.array([1, 2, 3], pa.int16()),
    "single": pa.array([1.5, None, 3], pa.float32()),
    "half": pa.array(np.array([1, 2, 3], np.float16)),
    "flag": pa.array([True, None, False]),
    "text": pa.array(["x", None, "z"]),
    "large": pa.array(["x", "y", "z"], pa.large_string()),
    "view": pa.array(["x", "y", "z"], pa.string_view()),
    "word": pa.array(["x", None, "x"]).dictionary_encode(),
    "date": pa.array([1, 2, 3], pa.timestamp("s")),
}


def test_kept_columns_have_their_values():
    table = pa.table({"amplitude": [np.exp(-TIME)] * 3, **KEPT})
    answers = slipfit.fit_batch(table, amplitude="amplitude", dt=DT, keep=list(KEPT))
    np.testing.assert_array_equal(answers["count"], [1.0, np.nan, 3.0])
    assert answers["short"].dtype == np.int16 and answers["short"].tolist() == [1, 2, 3]
    assert answers["single"].dtype == np.float32
    np.testing.assert_array_equal(answers["single"], np.array([1.5, np.nan, 3], np.float32))
    assert answers["half"].tolist() == [1, 2, 3]
    assert answers["flag"].tolist() == [True, False, False]
    for name in ("text", "large", "view", "word"):
        assert answers[name].tolist() == table[name].to_pylist()
    with pytest.raises(slipfit.OptionError, match=r"to_pyarrow\(\) has it"):
        answers["date"]
    assert answers.to_pyarrow()["date"].to_pylist() == table["date"].to_pylist()
    none = slipfit.fit_batch(table[:0], amplitude="amplitude", dt=DT, keep=["text", "word"])
    assert none["text"].dtype.kind == none["word"].dtype.kind == none["status"].dtype.kind == "U"


@pytest.mark.parametrize("key", [0, -1, None, 1.5, slice(0, 2), ["status"], ("status", "reason"), b"status"])
def test_a_column_is_taken_by_its_name(key):
    answers = slipfit.fit_batch(np.exp(-TIME)[None], amplitude="a", dt=DT)
    with pytest.raises(slipfit.OptionTypeError, match="name of a column is needed, one of status, reason") as raised:
        answers[key]
    assert raised.value.value == key
    with pytest.raises(KeyError, match="no column 'nothing'; there are status, reason"):
        answers["nothing"]
    assert key not in answers


def test_times_of_a_row_go_forwards():
    t, trace = list(TIME), decays(1, noise=0.001)[2][0]
    rows = {"a": [trace] * 3, "t": [t, t[::-1], [*t[:9], t[7], *t[10:]]]}
    answers = slipfit.fit_batch(pa.table(rows), amplitude="a", time="t")
    assert answers["status"].tolist() == ["done", "failed", "failed"]
    assert all("time goes backwards" in reason for reason in answers["reason"][1:])
    with pytest.raises(slipfit.OptionError, match="time goes backwards") as raised:
        slipfit.fit_envelope(t[::-1], np.exp(-TIME), initial_amplitude=1, offset_amplitude=0, decay_rate_per_s=1)
    assert (raised.value.index, raised.value.code) == (1, "time_backwards")
    gaps = pa.table({"a": [np.exp(-TIME)], "d": pa.array([None])})
    assert slipfit.fit_batch(gaps, amplitude="a", dt="d")["reason"].tolist() == ["dt is null"]


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
@pytest.mark.parametrize("zone", [None, "Europe/Lisbon"])
def test_times_may_be_dates_or_durations(unit, zone):
    """Dates of today in nanoseconds have more digits than doubles: each row counts from its first."""
    step = {"s": 1000, "ms": 1000, "us": 10_000, "ns": 10_000_000}[unit]
    per_second = {"s": 1, "ms": 1000, "us": 1_000_000, "ns": 1_000_000_000}[unit]
    counts = step * np.arange(len(TIME))
    dates = [1_770_000_000 * per_second + late + counts for late in (0, 7, 123_456_789)]
    traces = list(decays(3, noise=0.001)[2])
    plain = pa.table({"a": traces, "t": [counts / per_second] * 3})
    expected = slipfit.fit_batch(plain, amplitude="a", time="t")
    assert expected["status"].tolist() == ["done"] * 3
    for kind, stamps in ((pa.timestamp(unit, zone), dates), (pa.duration(unit), [counts] * 3)):
        for column in (pa.list_(kind), pa.large_list(kind), pa.list_(kind, len(TIME))):
            times = pa.array([row.tolist() for row in stamps], column)
            found = slipfit.fit_batch(pa.table({"a": traces, "t": times}), amplitude="a", time="t")
            assert found == expected, column
            part = slipfit.fit_batch(pa.table({"a": traces, "t": times}).slice(1), amplitude="a", time="t")
            assert (part["decay_rate_per_s"] == expected["decay_rate_per_s"][1:]).all()
    with pytest.raises(slipfit.OptionError, match="fixed-size list of numbers$"):
        slipfit.fit_batch(pa.table({"a": times}), amplitude="a", dt=DT)


def test_dates_that_are_missing_are_left_out():
    start = np.datetime64("2026-11-27T07:00:00", "us")
    stamps = (start + np.arange(len(TIME)) * np.timedelta64(10, "ms")).astype(object).tolist()
    gaps = [None if i % 50 == 0 else one for i, one in enumerate(stamps)]
    traces = list(decays(2)[2])
    # The first date known, of the second sample, is where the row begins.
    answers = slipfit.fit_batch(pa.table({"a": traces, "t": [gaps, None]}), amplitude="a", time="t")
    assert answers["samples_left_out"].tolist() == [6, 0]
    assert answers["reason"].tolist() == ["", "the times are null"]
    assert abs(answers["initial_amplitude"][0] - traces[0][1]) < 1e-6


def test_decimals_are_numbers():
    """DuckDB makes them of numbers that are typed, 0.01."""
    traces = list(decays(2, noise=0.001)[2])
    expected = slipfit.fit_batch(pa.table({"a": traces}), amplitude="a", dt=DT)
    for kind in (pa.decimal32(5, 2), pa.decimal64(12, 4), pa.decimal128(30, 9), pa.decimal256(60, 12)):
        step = pa.array([DT] * 2, pa.float64()).cast(kind)
        assert slipfit.fit_batch(pa.table({"a": traces, "dt": step}), amplitude="a", dt="dt") == expected
    times = pa.array([TIME.round(2)] * 2).cast(pa.list_(pa.decimal128(10, 2)))
    found = slipfit.fit_batch(pa.table({"a": traces, "t": times}), amplitude="a", time="t")
    np.testing.assert_allclose(found["decay_rate_per_s"], expected["decay_rate_per_s"], rtol=1e-9)
    # Below zero, where a number of 256 bits is the complement of one.
    falling = pa.array([(1 - np.arange(300) / 200).tolist()])
    expected = slipfit.fit_batch(pa.table({"a": falling}), amplitude="a", dt=DT)
    for kind in (pa.decimal32(9, 3), pa.decimal128(30, 3), pa.decimal256(60, 3)):
        found = slipfit.fit_batch(pa.table({"a": falling.cast(pa.list_(kind))}), amplitude="a", dt=DT)
        np.testing.assert_allclose(found["sliding_rate"], expected["sliding_rate"], rtol=1e-9)
        np.testing.assert_allclose(found["sliding_rate"], 0.5, rtol=1e-6)


def test_an_interval_may_be_a_duration():
    traces = list(decays(2, noise=0.001)[2])
    expected = slipfit.fit_batch(pa.table({"a": traces}), amplitude="a", dt=DT)
    for unit, step in (("ms", 10), ("us", 10_000), ("ns", 10_000_000)):
        steps = pa.table({"a": traces, "dt": pa.array([step] * 2, pa.duration(unit))})
        assert slipfit.fit_batch(steps, amplitude="a", dt="dt") == expected
        with pytest.raises(slipfit.OptionError, match="a column of numbers$"):
            slipfit.fit_batch(steps, amplitude="a", dt=DT, min_amplitude="dt")


def test_answers_are_columns_and_no_array_of_their_names():
    """NumPy and pandas would go through a table and find the names."""
    pd = pytest.importorskip("pandas")
    answers = slipfit.fit_batch(decays(3)[2], amplitude="a", dt=DT)
    for made in (np.asarray, np.array, pd.DataFrame):
        with pytest.raises(slipfit.OptionTypeError, match="to_pandas"):
            made(answers)
    frame = answers.to_pandas()
    assert list(frame) == list(dict(answers)) == answers.keys()
    pd.testing.assert_frame_equal(pa.table(answers).to_pandas(), frame)
    pd.testing.assert_frame_equal(pd.DataFrame(dict(answers)), frame, check_dtype=False)


def test_an_array_of_xarray_is_one_of_numpy():
    xr = pytest.importorskip("xarray")
    traces = decays(3)[2]
    expected = slipfit.fit_batch(traces, amplitude="a", dt=DT)
    assert slipfit.fit_batch(xr.DataArray(traces, dims=("row", "t")), amplitude="a", dt=DT) == expected


def test_options_out_of_range_are_refused_at_once():
    """Not by every row for itself."""
    for options, words in (
        ({"start_s": 5, "end_s": 3}, "end_s = 3 is outside times after start_s"),
        ({"start_s": np.nan}, "start_s = NaN is outside finite times"),
        ({"lockin_order": 9, "lockin_time_constant_s": 1}, "lockin_order = 9 is outside 1 to 8"),
        ({"band_hz": (-3, 1)}, "not a rising pair"),
    ):
        with pytest.raises(slipfit.OptionError, match=words):
            slipfit.fit_batch(np.ones((2, 9)), signal="a", dt=1, method="analyse", **options)


def test_rows_are_the_answers_of_their_records_to_the_last_bit():
    """Two hundred oscillations of many frequencies, losses and noises, with and without gaps."""
    random = np.random.default_rng(0)
    names = {
        "frequency_hz": ("frequency", "_hz"), "decay_rate_per_s": ("decay_rate", "_per_s"),
        "friction_displacement": ("friction_displacement", ""), "initial_amplitude": ("initial_amplitude", ""),
        "sliding_rate": ("sliding_rate", ""),
    }  # fmt: skip
    rows = []
    for seed in range(200):
        record = slipfit.simulate.decay(
            frequency_hz=random.uniform(2, 12), q_factor=random.uniform(15, 400),
            friction_displacement=random.choice([0, 1e-3, 5e-3]), amplitude=random.uniform(0.1, 2),
            duration_s=random.uniform(4, 9), rate_hz=100, noise_rms=10 ** random.uniform(-4, -2), seed=seed,
        )  # fmt: skip
        signal = record.signal
        if seed % 5 == 0:
            signal[random.integers(0, len(signal), 3)] = np.nan
        rows.append(signal)
    answers = slipfit.fit_batch(pa.table({"x": rows}), signal="x", dt=0.01, method="analyse", unit="m")
    done = 0
    for row, signal in enumerate(rows):
        held = {name: answers[name][row] for name in answers}
        try:
            alone = slipfit.ringdown(signal=signal, rate_hz=100, unit="m")
        except slipfit.SlipfitError:
            assert held["status"] == "failed"
            continue
        done += 1
        assert held["reason"].split() == [warning.code for warning in alone.warnings]
        assert (held["model"], held["sliding_p_value"]) == (alone.model, alone.sliding.p_value)
        assert (held["start_s"], held["end_s"]) == (alone.segment.start_s, alone.segment.end_s)
        for name, quantity in alone.parameters.items():
            if name in names:
                stem, end = names[name]
                values = (quantity.value, quantity.std_error, *quantity.interval_95)
                parts = [held[stem + part + end] for part in ("", "_std_error", "_low", "_high")]
                np.testing.assert_array_equal(parts, values, err_msg=f"{name} of row {row}")
    assert done > 150


def test_columns_of_nothing_but_nulls_are_rows():
    """As pandas makes them of a part of a table in which every trace is missing, or which has no rows."""
    for options in ({"amplitude": "a"}, {"signal": "a", "method": "analyse"}, {"x": "a", "y": "b"}):
        for rows in (0, 1, 300):
            answers = slipfit.fit_batch(pa.table({"a": pa.nulls(rows), "b": pa.nulls(rows)}), dt=DT, **options)
            assert answers["status"].tolist() == ["failed"] * rows
            assert set(answers["reason"].tolist()) <= {"the trace is null"}
    times = pa.table({"a": [[1.0, 0.5]], "t": pa.nulls(1)})
    assert slipfit.fit_batch(times, amplitude="a", time="t")["reason"].tolist() == ["the times are null"]
    assert list(slipfit.fit_stream(pa.table({"a": pa.nulls(2)}), amplitude="a", dt=DT))[0]["status"].size == 2


def test_tables_that_cannot_be_exported_say_so():
    pandas = pytest.importorskip("pandas")
    mixed = pandas.DataFrame({"amplitude": [[1.0, 0.5], 3, "x"]})
    for call in (slipfit.fit_batch, slipfit.fit_stream):
        with pytest.raises(slipfit.OptionError, match="the table cannot be taken: .*amplitude") as raised:
            call(mixed, amplitude="amplitude", dt=DT)
        assert raised.value.option == "table"
        assert raised.value.__cause__ is not None


def test_one_interval_may_be_a_duration():
    pandas = pytest.importorskip("pandas")
    _, _, traces = decays(3)
    whole = slipfit.fit_batch(traces, amplitude="amplitude", dt=0.01)
    stamps = pandas.date_range("2026-01-01", periods=3, freq="10ms")
    for dt in (datetime.timedelta(milliseconds=10), np.timedelta64(10, "ms"), stamps[1] - stamps[0]):
        assert slipfit.fit_batch(traces, amplitude="amplitude", dt=dt) == whole
    for dt in (np.timedelta64("NaT"), np.timedelta64(1, "Y"), pandas.NaT, -datetime.timedelta(1), [0.01], np.ones(3)):
        with pytest.raises(slipfit.OptionError) as raised:
            slipfit.fit_batch(traces, amplitude="amplitude", dt=dt)
        assert raised.value.option == "dt"
    with pytest.raises(slipfit.OptionTypeError, match="the name of a column of lists of times is needed"):
        slipfit.fit_batch(traces, amplitude="amplitude", time=TIME)


def test_labelled_rows_bring_their_time_and_unit():
    xr = pytest.importorskip("xarray")
    _, _, traces = decays(4)
    whole = slipfit.fit_batch(traces, amplitude="amplitude", dt=DT)
    sampled = DT * np.arange(traces.shape[1])
    dates = np.datetime64("2026-01-01", "ns") + (sampled * 1e9).round().astype("timedelta64[ns]")
    for name, coordinate in (("time", sampled), ("T", sampled), ("sampled", dates)):
        rows = xr.DataArray(traces, dims=("row", name), coords={name: coordinate})
        for held in (rows, rows.transpose()):
            answers = slipfit.fit_batch(held, amplitude="amplitude")
            np.testing.assert_allclose(answers["sliding_rate"], whole["sliding_rate"], rtol=1e-6)
            assert slipfit.fit_batch(held, amplitude="amplitude", dt=DT)["sliding_rate"] == pytest.approx(whole["sliding_rate"], rel=1e-6)
            # Another interval was taken in place of the coordinate's.
            with pytest.raises(slipfit.OptionError, match="dt is given as 0.02 s beside the coordinate") as raised:
                slipfit.fit_batch(held, amplitude="amplitude", dt=2 * DT)
            assert raised.value.option == "dt"
    # Columns of these names are no unit and no numbers of one.
    named = pa.table({"value": lists(traces)["amplitude"], "unit": ["nm"] * 4}).to_pandas()
    assert slipfit.fit_batch(named, amplitude="value", dt=DT)["sliding_rate"].tolist() == whole["sliding_rate"].tolist()
    plain = xr.DataArray(traces, dims=("row", "sample"))
    assert slipfit.fit_batch(plain, amplitude="amplitude", dt=DT) == whole
    with pytest.raises(slipfit.OptionError, match="'time' is not even: give a table"):
        uneven = xr.DataArray(traces, dims=("row", "time"), coords={"time": sampled**2})
        slipfit.fit_batch(uneven, amplitude="amplitude")


TRACES = pa.table({"a": [[1.0]], "b": [[1.0]], "c": [[1.0]], "t": [[1.0]]})


@pytest.mark.parametrize(
    ("options", "option", "words"),
    [
        ({"amplitude": "a", "y": "b"}, "y", ("y='b'", "amplitude='a'")),
        ({"signal": "a", "y": "b", "method": "analyse"}, "y", ("y='b'", "signal='a'")),
        ({"x": "a"}, "y", ("x='a'", "without y")),
        ({"y": "a"}, "y", ("y='a'", "without x")),
        ({"x": "a", "y": "a"}, "y", ("x='a'", "y='a'", "two columns")),
        ({"amplitude": "a", "x": "b", "y": "c"}, "x", ("amplitude='a'", "x='b'")),
        ({"x": "a", "y": "b", "signal": "c"}, "signal", ("x='a'", "signal='c'")),
        ({"amplitude": "a", "kind": "velocity"}, "kind", ("kind='velocity'", "amplitude='a'")),
        ({"x": "a", "y": "b", "kind": "velocity"}, "kind", ("kind='velocity'", "x='a'")),
        ({"signal": "a", "kind": "speed"}, "kind", ("kind='speed'", "one of displacement")),
        ({"signal": "a"}, "method", ("method='fit'", "signal='a'")),
        ({"signal": "a", "frequency_hz": 3, "method": "analyse"}, "frequency_hz", ("frequency_hz=3", "signal='a'")),
        ({"amplitude": "a", "band_hz": (1, 2), "method": "analyse"}, "band_hz", ("band_hz=(1, 2)", "amplitude='a'")),
        ({"x": "a", "y": "b", "band_hz": (1, 2), "method": "analyse"}, "band_hz", ("band_hz=(1, 2)", "x='a'")),
        ({"amplitude": "a", "time": "t"}, "time", ("dt=0.01", "time='t'")),
        ({"amplitude": "a", "time": "a", "dt": None}, "time", ("time='a'", "amplitude='a'")),
        ({"x": "a", "y": "b", "time": "b", "dt": None}, "time", ("time='b'", "y='b'")),
        ({"amplitude": "a", "lockin_order": 2, "method": "analyse"}, "lockin_order", ("lockin_order", "give both")),
        (
            {"signal": "a", "lockin_time_constant_s": 1, "lockin_order": 2, "method": "analyse"},
            "lockin_time_constant_s", ("lockin_time_constant_s", "signal `a`"),
        ),
        ({"amplitude": "a", "lockin_order": 2}, "lockin_order", ("lockin_order", "method='analyse'")),
    ],
)  # fmt: skip
def test_options_that_contradict_each_other_are_both_named(options, option, words):
    for fit in (slipfit.fit_batch, slipfit.fit_stream):
        with pytest.raises(slipfit.OptionError) as raised:
            fit(TRACES, **{"dt": DT, **options})
        assert raised.value.option == option, str(raised.value)
        assert all(word in str(raised.value) for word in words), str(raised.value)


def test_columns_carry_their_units(tmp_path):
    import pyarrow.parquet as pq

    traces = np.exp(-TIME)[np.newaxis]
    answers = slipfit.fit_batch(traces, amplitude="a", dt=DT, unit="nm", frequency_hz=5)
    units = answers.units
    assert units["decay_rate_std_error_per_s"] == "1/s" and units["sliding_rate_low"] == "nm/s"
    assert units["friction_displacement"] == units["initial_amplitude_high"] == units["residual_rms"] == "nm"
    assert not {"status", "samples", "correlation", "sliding_p_value"} & units.keys()
    assert list(units) == [name for name in answers if name in units]
    field = answers.to_pyarrow().schema.field("sliding_rate")
    assert field.metadata == {b"unit": b"nm/s"}
    pq.write_table(answers.to_pyarrow(), tmp_path / "answers.parquet")
    assert pq.read_schema(tmp_path / "answers.parquet").field("sliding_rate").metadata[b"unit"] == b"nm/s"
    assert answers.to_pandas().attrs["units"] == units
    assert slipfit.fit_batch(traces, amplitude="a", dt=DT).units.get("friction_displacement") is None
    whole = slipfit.fit_batch(traces, signal="a", kind="velocity", dt=DT, unit="mm/s", method="analyse").units
    assert whole["friction_displacement_std_error"] == "mm" and whole["initial_amplitude"] == "mm/s"
    assert whole["frequency_low_hz"] == "Hz" and whole["start_s"] == "s"
    again = pickle.loads(pickle.dumps(answers))
    assert again.units == units and again == answers
    kept = pa.table({"a": [traces[0]], "f": [5.0]}, pa.schema([pa.field("a", pa.list_(pa.float64())), pa.field("f", pa.float64(), metadata={"unit": "kHz"})]))
    assert slipfit.fit_batch(kept, amplitude="a", dt=DT, keep=["f"]).units["f"] == "kHz"


def test_a_notebook_shows_a_table():
    traces = np.exp(-TIME) * np.ones((30, 1))
    traces[29] = np.nan
    name = pa.array(["<b>"] * 30)
    table = pa.table({"a": list(traces), "name": name, "day": pa.array([0] * 30, pa.date32())})
    answers = slipfit.fit_batch(table, amplitude="a", dt=DT, unit="nm", keep=["name", "day", "a"])
    html = answers._repr_html_()
    assert html.count("<tr>") == 2 + 5 + 1 + 5 and "30 rows × 27 columns" in html
    assert "<th>nm/s</th>" in html and "&lt;b&gt;" in html and "<b>" not in html and "…" in html
    assert "<th>0</th>" in html and "<th>29</th>" in html and "0 usable samples" in html
    few = slipfit.fit_batch(traces[:3], amplitude="a", dt=DT)._repr_html_()
    assert few.count("<tr>") == 2 + 3 and "⋮" not in few
    assert slipfit.fit_batch(traces[:0], amplitude="a", dt=DT)._repr_html_().count("<tr>") == 2
    # Rows of several batches.
    (streamed,) = slipfit.fit_stream(table, amplitude="a", dt=DT)
    assert "30 rows" in streamed._repr_html_()
    parts = pa.table({"a": pa.chunked_array([list(traces[:7]), list(traces[7:])])})
    assert slipfit.fit_batch(parts, amplitude="a", dt=DT)._repr_html_() == slipfit.fit_batch(pa.table({"a": list(traces)}), amplitude="a", dt=DT)._repr_html_()


def test_lists_and_dictionaries_of_traces_are_tables():
    time = 0.01 * np.arange(300)
    traces = [np.exp(-rate * time[:length]) for rate, length in ((1.0, 300), (2.0, 200))]
    options = {"amplitude": "trace", "dt": 0.01}
    wanted = slipfit.fit_batch(pa.table({"trace": [trace.tolist() for trace in traces]}), **options)
    for given in (traces, tuple(traces), [traces[0].tolist(), traces[1]], [trace.astype(">f8") for trace in traces]):
        assert slipfit.fit_batch(given, **options) == wanted
    assert slipfit.fit_batch({"trace": traces}, **options) == wanted
    chunked = pa.chunked_array([[trace.tolist() for trace in traces]])
    assert slipfit.fit_batch({"trace": chunked}, **options) == wanted
    with_gap = slipfit.fit_batch([traces[0], None], **options)
    assert list(with_gap["status"]) == [wanted["status"][0], "failed"]
    even = np.array([traces[0], np.exp(-3 * time)])
    table = {"trace": even, "f0": np.array([5.0, 6.0]), "pixel": ["a", "b"]}
    answers = slipfit.fit_batch(table, frequency_hz="f0", keep=["pixel"], **options)
    assert list(answers["pixel"]) == ["a", "b"]
    one = slipfit.fit_batch(even[1:], frequency_hz=6.0, **options)
    assert answers["friction_displacement"][1] == one["friction_displacement"][0]
    masked = np.ma.masked_greater(np.where(np.arange(300) == 7, 9.0, even), 8)
    for given in (masked, list(masked)):
        assert list(slipfit.fit_batch({"trace": given}, **options)["samples_left_out"]) == [1, 1]
    for wrong, words in (
        (traces[0].tolist(), "a list of traces needs an array or a list of numbers for each"),
        ([even], "a list of traces"),
        ([[[1.0], [1.0, 2.0]]], "a list of traces"),
        ({"trace": even, "f0": [1.0]}, "columns of one length"),
        ({"trace": even[np.newaxis]}, "of the shape (1, 2, 300)"),
        ({"trace": "swing"}, "columns of one length"),
    ):
        with pytest.raises(slipfit.OptionTypeError) as raised:
            slipfit.fit_batch(wrong, **options)
        assert raised.value.option == "table" and words in str(raised.value), str(raised.value)
    with pytest.raises(slipfit.OptionError, match="trace"):
        slipfit.fit_batch({"other": traces}, **options)


def test_a_table_of_answers_is_gone_through_as_a_dictionary():
    answers = slipfit.fit_batch(np.exp(-TIME) * np.ones((3, 1)), amplitude="a", dt=DT)
    names, columns = zip(*answers.items())
    assert list(names) == answers.keys()
    for column, other in zip(columns, answers.values()):
        np.testing.assert_array_equal(column, other)
    assert answers.get("samples").tolist() == [len(TIME)] * 3
    assert answers.get("none") is None and answers.get("none", 5) == 5


def test_a_table_of_answers_has_the_shape_of_a_frame():
    answers = slipfit.fit_batch(np.ones((3, 50)), amplitude="a", dt=0.1)
    frame = answers.to_pandas()
    assert answers.shape == frame.shape and answers.columns == list(frame.columns) == answers.column_names
