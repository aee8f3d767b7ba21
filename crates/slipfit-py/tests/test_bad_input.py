"""Arrays and tables that cannot be meant: an exception that names the argument, or the status of a row."""

import datetime

import numpy as np
import pytest
import slipfit
from hypothesis import given, settings
from hypothesis import strategies as st

pa = pytest.importorskip("pyarrow")

TIME = 0.02 * np.arange(300)
SIGNAL = (1.05 * np.exp(-0.1 * TIME) - 0.05) * np.cos(8 * TIME)
AMPLITUDE = np.exp(-0.1 * TIME)
HZ = np.linspace(0.9, 1.1, 81)
RESPONSE = np.abs(0.02 / (1 - HZ**2 + 1j * HZ / 50))
DRIVE = np.arange(1.0, 13.0)
START = {"initial_amplitude": 1, "decay_rate_per_s": 0.1}

#: Each argument that is an array: how it is given, and numbers for it.
ARRAYS = {
    "time": (lambda v: slipfit.ringdown(v, SIGNAL), TIME),
    "signal": (lambda v: slipfit.ringdown(TIME, v), SIGNAL),
    "quadrature": (lambda v: slipfit.ringdown(TIME, AMPLITUDE, quadrature=v), AMPLITUDE),
    "frequency": (lambda v: slipfit.resonance(v, RESPONSE), HZ),
    "response": (lambda v: slipfit.resonance(HZ, v), RESPONSE),
    "phase_rad": (lambda v: slipfit.resonance(HZ, RESPONSE, phase_rad=v), HZ),
    "std_error": (lambda v: slipfit.resonance(HZ, RESPONSE, std_error=v), RESPONSE),
    "drive": (lambda v: slipfit.resonance(HZ, RESPONSE, drive=v), HZ),
    "levels drive": (lambda v: slipfit.levels(v, 2 * DRIVE), DRIVE),
    "levels amplitude": (lambda v: slipfit.levels(DRIVE, v), 2 * DRIVE),
    "levels std_error": (lambda v: slipfit.levels(DRIVE, 2 * DRIVE, std_error=v), DRIVE),
    "envelope time": (lambda v: slipfit.fit_envelope(v, AMPLITUDE, **START, offset_amplitude=0), TIME),
    "envelope amplitude": (lambda v: slipfit.fit_envelope(TIME, v, **START, offset_amplitude=0), AMPLITUDE),
    "waveform time": (lambda v: slipfit.fit_waveform(v, SIGNAL, **START, frequency_hz=1.27), TIME),
    "waveform signal": (lambda v: slipfit.fit_waveform(TIME, v, **START, frequency_hz=1.27), SIGNAL),
    "frequencies_hz": (lambda v: slipfit.simulate.sweep(v, frequency_hz=1, q_factor=50, drive_amplitude=1), HZ),
    "drive_amplitudes": (lambda v: slipfit.simulate.levels(v, frequency_hz=1, q_factor=50), DRIVE),
}

#: What no array of numbers is, and what is said of it.
NO_NUMBERS = {
    "flags": (lambda v: v > v.mean(), "holds True and False"),
    "flags and gaps": (lambda v: np.array([None, *(v[1:] > 0)], object), "holds True and False"),
    "masked flags": (lambda v: np.ma.array(v > v.mean(), mask=np.arange(len(v)) % 5 == 1), "holds True and False"),
    "flags of Arrow": (lambda v: pa.array(v > v.mean()), "holds True and False"),
    "table": (lambda v: np.column_stack([v, v]), "where one"),
    "scalar": (lambda v: np.array(1.0), "where one|levels need"),
    "words": (lambda v: np.array(["a"] * len(v)), "numbers"),
    "objects": (lambda v: np.array([object()] * len(v)), "does not hold numbers"),
    "lists": (lambda v: [[1.0]] * (len(v) - 1) + [[1.0, 2.0]], "an array is needed|does not hold numbers"),
    "complex objects": (lambda v: np.array([1j, *v[1:]], object), "does not hold numbers"),
    "fields": (lambda v: np.zeros(len(v), [("a", float), ("b", float)]), "does not hold numbers"),
    "set": (lambda v: set(v), "array is needed"),
    "text": (lambda v: 3, "array is needed"),
}


@pytest.mark.parametrize("name", ARRAYS)
@pytest.mark.parametrize("kind", NO_NUMBERS)
def test_an_array_of_no_numbers_is_refused_by_its_name(name, kind):
    """Flags were taken for zero and one, also as times."""
    call, values = ARRAYS[name]
    make, words = NO_NUMBERS[kind]
    with pytest.raises(slipfit.OptionError, match=words) as raised:
        call(make(values))
    assert raised.value.option == name.rpartition(" ")[2]


@pytest.mark.parametrize("name", ["frequency", "response", "phase_rad", "std_error", "drive", *(n for n in ARRAYS if "levels" in n)])
def test_an_array_of_missing_values_is_refused_by_its_name(name):
    call, values = ARRAYS[name]
    for missing in (values * np.nan, [None] * len(values), np.ma.array(values, mask=True), pa.nulls(len(values))):
        with pytest.raises(slipfit.OptionError, match="holds no number: every value is missing") as raised:
            call(missing)
        assert raised.value.option == name.rpartition(" ")[2]


@pytest.mark.parametrize("name", ["envelope time", "waveform time"])
def test_times_that_go_backwards_are_those_of_an_argument(name):
    with pytest.raises(slipfit.OptionError, match="time goes backwards") as raised:
        ARRAYS[name][0](TIME[::-1])
    assert (raised.value.option, raised.value.index) == ("time", 1)


def test_a_flag_is_no_number():
    """It was one second, or one hertz."""
    table = pa.table({"a": [AMPLITUDE.tolist()]})
    for call, option in (
        (lambda v: slipfit.fit_batch(table, amplitude="a", dt=v), "dt"),
        (lambda v: slipfit.fit_batch(table, amplitude="a", dt=0.02, frequency_hz=v), "frequency_hz"),
        (lambda v: slipfit.fit_map(AMPLITUDE.reshape(1, 1, -1), v), "dt"),
        (lambda v: slipfit.ringdown(TIME, SIGNAL, start_s=v), "start_s"),
        (lambda v: slipfit.ringdown(signal=SIGNAL, rate_hz=v), "rate_hz"),
        (lambda v: slipfit.simulate.decay(frequency_hz=v, amplitude=1, duration_s=9, rate_hz=9), "frequency_hz"),
        (lambda v: slipfit.simulate.decay(frequency_hz=1, amplitude=1, duration_s=9, rate_hz=9, seed=v), "seed"),
    ):
        for flag in (True, np.True_):
            with pytest.raises(slipfit.OptionTypeError) as raised:
                call(flag)
            assert raised.value.option == option


def test_columns_of_a_dictionary_are_refused_by_the_table():
    """Comparisons of arrays with names, and keys of data frames, raised errors of NumPy and pandas."""
    pandas = pytest.importorskip("pandas")
    traces = [AMPLITUDE.tolist()] * 2
    wrong = [
        [AMPLITUDE > 0.5] * 2,
        [np.array(["x"] * 9)] * 2,
        [np.zeros(9, "datetime64[s]")] * 2,
        {"a": traces, "dt": pandas.DataFrame({"dt": [0.01, 0.02]})},
        {"a": traces, "dt": {0.01, 0.02}},
        {"a": [set(AMPLITUDE), set(AMPLITUDE)]},
        {"a": traces, "dt": [0.01]},
        {"a": traces, "dt": np.array([0.01, 0.02]) + 0j},
        {"a": 1},
        [np.zeros((2, 2))],
    ]
    for table in wrong:
        with pytest.raises(slipfit.OptionError) as raised:
            slipfit.fit_batch(table, amplitude="a", dt="dt" if isinstance(table, dict) and "dt" in table else 0.02)
        assert raised.value.option in ("table", "amplitude", "dt"), str(raised.value)
    wide = slipfit.fit_batch([AMPLITUDE.astype(np.longdouble)] * 2, amplitude="a", dt=0.02)
    assert wide == slipfit.fit_batch([AMPLITUDE] * 2, amplitude="a", dt=0.02)


def test_numbers_of_an_extension_type_are_not_its_values():
    """Periods of pandas are stored as counts since 1970, which were taken for seconds."""
    pandas = pytest.importorskip("pandas")
    traces = [AMPLITUDE.tolist()] * 2
    periods = pandas.DataFrame({"a": traces, "dt": pandas.period_range("2026", periods=2, freq="s")})
    with pytest.raises(slipfit.OptionError, match="`dt` is of the extension type pandas.period; it must be a column") as raised:
        slipfit.fit_batch(periods, amplitude="a", dt="dt")
    assert raised.value.option == "dt"
    flags = pa.ExtensionArray.from_storage(pa.bool8(), pa.array([1] * 300, pa.int8()))
    field = pa.field("item", flags.type)
    lists = pa.ListArray.from_arrays([0, 300], flags, type=pa.list_(field))
    with pytest.raises(slipfit.OptionError, match="`a` is of the extension type arrow.bool8; it must be a list") as raised:
        slipfit.fit_batch(pa.table({"a": lists}), amplitude="a", dt=0.02)
    assert raised.value.option == "amplitude"
    # A tensor is a list of its numbers.
    tensors = pa.ExtensionArray.from_storage(
        pa.fixed_shape_tensor(pa.float64(), (300,)), pa.FixedSizeListArray.from_arrays(pa.array(np.tile(AMPLITUDE, 2)), 300)
    )
    assert slipfit.fit_batch(pa.table({"a": tensors}), amplitude="a", dt=0.02) == slipfit.fit_batch([AMPLITUDE] * 2, amplitude="a", dt=0.02)


#: Types of a column, by what may stand in it.
TYPES = st.sampled_from(
    [
        pa.null(), pa.bool_(), pa.int8(), pa.uint64(), pa.float16(), pa.float32(), pa.float64(), pa.string(), pa.large_string(),
        pa.string_view(), pa.binary(), pa.date32(), pa.date64(), pa.time32("s"), pa.time64("us"), pa.timestamp("ns"),
        pa.timestamp("s", "UTC"), pa.duration("ms"), pa.month_day_nano_interval(), pa.decimal128(20, 3), pa.decimal256(40, 3),
    ]
)  # fmt: skip
NESTED = TYPES.flatmap(
    lambda kind: st.sampled_from(
        [
            kind, pa.list_(kind), pa.large_list(kind), pa.list_(kind, 6), pa.list_view(kind), pa.large_list_view(kind),
            pa.struct({"a": kind}), pa.map_(pa.string(), kind), pa.list_(pa.list_(kind)),
        ]
    )
)  # fmt: skip

OF_TYPE = {
    pa.bool_(): True, pa.string(): "1", pa.large_string(): "1", pa.string_view(): "1", pa.binary(): b"1",
    pa.date32(): datetime.date(2026, 1, 1), pa.date64(): datetime.date(2026, 1, 1), pa.time32("s"): datetime.time(1),
    pa.time64("us"): datetime.time(1), pa.timestamp("ns"): datetime.datetime(2026, 1, 1),
    pa.timestamp("s", "UTC"): datetime.datetime(2026, 1, 1, tzinfo=datetime.timezone.utc),
    pa.duration("ms"): datetime.timedelta(seconds=1), pa.month_day_nano_interval(): pa.MonthDayNano([1, 2, 3]), pa.null(): None,
}  # fmt: skip


def one_of(kind, count):
    """A value of a type, with lists of so many items."""
    if pa.types.is_map(kind):
        return [("a", one_of(kind.item_type, count))]
    if pa.types.is_struct(kind):
        return {"a": one_of(kind.field("a").type, count)}
    if hasattr(kind, "value_type"):
        return [one_of(kind.value_type, count)] * (6 if pa.types.is_fixed_size_list(kind) else count)
    return OF_TYPE.get(kind, 1)


@settings(max_examples=300, deadline=None)
@given(
    st.fixed_dictionaries({name: NESTED for name in ("trace", "dt", "t", "f")}),
    st.lists(st.none() | st.integers(0, 8), max_size=4),
    st.fixed_dictionaries(
        {"method": st.sampled_from(["fit", "analyse"])},
        optional={"dt": st.sampled_from(["dt", "t", 0.01]), "time": st.just("t"), "frequency_hz": st.just("f"), "min_amplitude": st.just("f")},
    ),
    st.sampled_from(["plain", "chunks", "dictionary", "runs"]),
)
def test_a_column_of_any_type_is_refused_or_answered(kinds, counts, options, form):
    columns = {
        name: pa.array([None if count is None else one_of(kind, count) for count in counts], kind) for name, kind in kinds.items()
    }
    if form in ("dictionary", "runs") and counts:
        of = pa.array(range(len(counts)), pa.int32())
        ends = pa.array(range(1, len(counts) + 1), pa.int32())
        for name, values in columns.items():
            coded = pa.DictionaryArray.from_arrays(of, values) if form == "dictionary" else None
            columns[name] = pa.RunEndEncodedArray.from_arrays(ends, values) if coded is None else coded
    table = pa.table(columns)
    if form == "chunks":
        table = pa.concat_tables([table.slice(0, 1), table.slice(1, 0), table.slice(1)])
    try:
        answers = slipfit.fit_batch(table, amplitude="trace", **options)
    except slipfit.SlipfitError as error:
        assert error.code != "internal", error
        assert error.option in ("amplitude", "dt", "time", "frequency_hz", "min_amplitude", "table"), error
        return
    assert len(answers) == len(counts)
    assert all(reason for status, reason in zip(answers["status"], answers["reason"]) if status == "failed")
