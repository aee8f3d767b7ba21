"""Columns that are encoded: dictionaries, as categories are, runs, and views."""

import numpy as np
import pytest
import slipfit

pa = pytest.importorskip("pyarrow")
pc = pytest.importorskip("pyarrow.compute")

FALL = np.exp(-0.01 * np.arange(300))
TRACES = [FALL.tolist(), (0.9 * FALL - 0.1 * (1 - FALL)).tolist()]
STEPS = [0.01, 0.01, 0.02]
PLAIN = pa.array([TRACES[0], TRACES[0], TRACES[1]])


def answered(traces, steps, **options):
    return slipfit.fit_batch(pa.table({"a": traces, "dt": steps}), amplitude="a", dt="dt", **options)


@pytest.fixture(scope="module")
def expected():
    return answered(PLAIN, STEPS)


def test_numbers_of_rows_may_be_encoded(expected):
    pandas, polars = pytest.importorskip("pandas"), pytest.importorskip("polars")
    plain = pa.array(STEPS)
    durations = pa.array([10, 10, 20], pa.duration("ms"))
    for steps in (plain.dictionary_encode(), pc.run_end_encode(plain), durations.dictionary_encode(), pc.run_end_encode(durations)):
        assert answered(PLAIN, steps) == expected, steps.type
    frame = pandas.DataFrame({"a": list(PLAIN.to_pylist()), "dt": pandas.Categorical(STEPS)})
    assert slipfit.fit_batch(frame, amplitude="a", dt="dt") == expected
    hertz = pa.array([50.0, None, 60.0])
    one, other = (
        slipfit.fit_batch(pa.table({"a": PLAIN, "f": column}), amplitude="a", dt=0.01, frequency_hz="f")
        for column in (hertz, hertz.dictionary_encode())
    )
    assert one == other and one["reason"].tolist() == ["", "no_frequency", ""]
    named = pa.table({"a": PLAIN, "dt (ms)": pa.array([10.0, 10.0, 20.0]).dictionary_encode()})
    assert slipfit.fit_batch(named, amplitude="a", dt="dt (ms)") == expected
    words = pandas.DataFrame({"a": list(PLAIN.to_pylist()), "dt": pandas.Categorical(["x", "y", "x"])})
    with pytest.raises(slipfit.OptionError, match=r"`dt` is Dictionary\(Int8, .*Utf8\); it must be a column of numbers") as raised:
        slipfit.fit_batch(words, amplitude="a", dt="dt")
    assert raised.value.option == "dt"
    with pytest.raises(slipfit.OptionError, match=r"`dt` is Dictionary\(UInt32, Utf8View\)"):
        slipfit.fit_batch(polars.from_pandas(words), amplitude="a", dt="dt")


def test_traces_may_be_encoded(expected):
    held = pa.array(TRACES)
    flat = pa.array(np.concatenate([TRACES[0], TRACES[0], TRACES[1]]))
    offsets = [0, 300, 600, 900]
    forms = [
        pa.DictionaryArray.from_arrays(pa.array([0, 0, 1], pa.int8()), held),
        pa.RunEndEncodedArray.from_arrays(pa.array([2, 3], pa.int16()), held),
        pa.ListArray.from_arrays(offsets, flat.dictionary_encode()),
        pa.ListArray.from_arrays(offsets, pc.run_end_encode(flat)),
        pa.array(PLAIN.to_pylist(), pa.list_view(pa.float64())),
        pa.ListViewArray.from_arrays([0, 0, 300], [300, 300, 300], held.flatten()),
        pa.LargeListViewArray.from_arrays([0, 0, 300], [300, 300, 300], held.flatten()),
    ]
    for traces in forms:
        assert answered(traces, STEPS) == expected, traces.type
        chunks = pa.table({"a": pa.chunked_array([traces[:1], traces[1:]]), "dt": STEPS})
        assert slipfit.fit_batch(chunks, amplitude="a", dt="dt") == expected, traces.type
        (streamed,) = slipfit.fit_stream(pa.table({"a": traces, "dt": STEPS}), amplitude="a", dt="dt")
        assert streamed == expected
    single = pa.array(PLAIN.to_pylist(), pa.large_list_view(pa.float32()))
    np.testing.assert_allclose(answered(single, STEPS)["decay_rate_per_s"], expected["decay_rate_per_s"], rtol=1e-4)


def test_times_may_be_encoded(expected):
    times = pa.array([[step * i for i in range(300)] for step in STEPS])
    coded = pa.ListArray.from_arrays([0, 300, 600, 900], times.flatten().dictionary_encode())
    views = pa.array(times.to_pylist(), pa.list_view(pa.float64()))
    wanted = slipfit.fit_batch(pa.table({"a": PLAIN, "t": times}), amplitude="a", time="t")
    for column in (coded, views, pa.DictionaryArray.from_arrays(pa.array([0, 1, 2]), times)):
        assert slipfit.fit_batch(pa.table({"a": PLAIN, "t": column}), amplitude="a", time="t") == wanted, column.type
    dates = pa.array([[10_000 * i for i in range(300)]] * 3, pa.list_(pa.timestamp("us")))
    wanted = slipfit.fit_batch(pa.table({"a": PLAIN, "t (s)": dates}), amplitude="a", time="t (s)")
    in_view = pa.array(dates.to_pylist(), pa.list_view(pa.timestamp("us")))
    assert slipfit.fit_batch(pa.table({"a": PLAIN, "t (ms)": in_view}), amplitude="a", time="t (ms)") == wanted
