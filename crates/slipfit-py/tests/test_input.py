"""Everything that is an array is taken; what cannot be meant is refused by name."""

import errno
import io
import pickle
import re
import subprocess
import sys
import threading

import numpy as np
import pytest
import slipfit
from conftest import ends_at_a_signal
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp


def test_any_stride_and_type_gives_one_answer(swing, answer):
    time, signal = swing
    table = np.column_stack([time, np.zeros_like(time), signal])
    same = [
        (table[:, 0], table[:, 2]),
        (np.asfortranarray(table)[:, 0], table.T[2]),
        (time[::-1][::-1], signal[::-1][::-1]),
        (time.astype(">f8"), signal.astype(">f8")),
        (list(time), tuple(signal)),
    ]
    for t, x in same:
        assert slipfit.ringdown(t, x, unit="rad") == answer
    single = slipfit.ringdown(time, signal.astype(np.float32), unit="rad")
    x_f = answer.parameters.friction_displacement
    assert abs(single.parameters.friction_displacement.value - x_f.value) < x_f.std_error
    counts = slipfit.ringdown(time, np.round(signal * 2**20).astype(np.int32))
    assert abs(counts.parameters.q_factor.value / answer.parameters.q_factor.value - 1) < 1e-3


def test_a_rate_stands_in_for_times(swing, answer):
    found = slipfit.ringdown(None, swing[1], rate_hz=50, unit="rad")
    x_f = answer.parameters.friction_displacement
    assert abs(found.parameters.friction_displacement.value - x_f.value) < 1e-3 * x_f.std_error
    assert found.to_dict()["input"]["time"]["source"] == "rate"


def test_missing_samples_are_counted(swing):
    time, signal = swing
    holes = signal.copy()
    holes[100:110] = np.nan
    found = slipfit.ringdown(time, holes, unit="rad")
    assert found.to_dict()["input"]["rows_skipped"] == 10
    masked = np.ma.masked_array(signal, mask=np.isnan(holes))
    assert slipfit.ringdown(time, masked, unit="rad") == found


def test_labelled_arrays_bring_times_and_units(swing, answer):
    pandas = pytest.importorskip("pandas")
    time, signal = swing
    assert slipfit.ringdown(pandas.Series(signal, index=time), unit="rad") == answer
    dated = pandas.Series(signal, index=pandas.Timestamp("2026-03-29", tz="UTC") + pandas.to_timedelta(time, "s"))
    x_f = answer.parameters.friction_displacement
    found = slipfit.ringdown(dated, unit="rad").parameters.friction_displacement
    assert abs(found.value - x_f.value) < 1e-2 * x_f.std_error
    assert slipfit.ringdown(time, pandas.Series(signal), unit="rad") == answer
    frame = pandas.DataFrame({"t": time, "x": signal})
    assert slipfit.ringdown(frame["t"], frame["x"], unit="rad") == answer
    with pytest.raises(slipfit.OptionError, match="no times"):
        slipfit.ringdown(frame["x"])
    with pytest.raises(slipfit.OptionError, match="DataFrame"):
        slipfit.ringdown(frame)


def test_xarray_brings_its_unit(swing, answer):
    xarray = pytest.importorskip("xarray")
    time, signal = swing
    array = xarray.DataArray(signal, coords={"time": time}, dims="time", attrs={"units": "rad"})
    assert slipfit.ringdown(array) == answer
    assert slipfit.ringdown(array, unit="rad") == answer
    with pytest.raises(slipfit.OptionError, match="unit='mm' beside signal in 'rad': give numbers without"):
        slipfit.ringdown(array, unit="mm")
    with pytest.raises(slipfit.OptionError, match="one is needed"):
        slipfit.ringdown(xarray.DataArray(np.zeros((3, 4))))
    # Without a coordinate a dimension counts samples, which are no seconds.
    bare = xarray.DataArray(signal, dims="time", attrs={"units": "rad"})
    with pytest.raises(slipfit.OptionError, match="no times: give time or rate_hz"):
        slipfit.ringdown(bare)
    assert slipfit.ringdown(bare, rate_hz=50) == slipfit.ringdown(signal=signal, rate_hz=50, unit="rad")
    with pytest.raises(slipfit.OptionError, match="response"):
        slipfit.resonance(bare)


def test_polars_series_are_taken(swing, answer):
    polars = pytest.importorskip("polars")
    time, signal = swing
    assert slipfit.ringdown(polars.Series(time), polars.Series(signal), unit="rad") == answer


def test_files_and_bytes_are_read(swing, tmp_path, answer):
    text = "time (s),angle (rad)\n" + "".join(f"{t!r},{x!r}\n" for t, x in zip(*map(np.ndarray.tolist, swing)))
    path = tmp_path / "swing.csv"
    path.write_text(text)
    record = slipfit.read(path)
    assert (record.unit, record.kind, len(record)) == ("rad", "displacement", len(swing[0]))
    assert repr(record).startswith("<Record of ")
    np.testing.assert_array_equal(record.signal, swing[1])
    from_file, from_bytes = slipfit.ringdown(path), slipfit.ringdown(slipfit.read(text.encode(), "swing.csv"))
    assert from_file.parameters == from_bytes.parameters == answer.parameters
    assert slipfit.read(memoryview(text.encode()), signal=2).sha256 == record.sha256


@pytest.mark.parametrize(
    ("arguments", "options", "error", "words"),
    [
        ((), {}, slipfit.OptionError, "no times"),
        (([0, 1],), {}, slipfit.OptionError, "no times"),
        (([0, 1, 2], [1, 2]), {}, slipfit.OptionError, "2 values where time_s has 3"),
        ((np.zeros((3, 3)), np.zeros(3)), {}, slipfit.OptionError, "one dimension"),
        ((np.arange(9), np.arange(9) * 1j), {}, slipfit.OptionError, "complex"),
        ((np.arange(9), np.array(["a"] * 9)), {}, slipfit.OptionError, "numbers"),
        ((np.arange(9), np.array([object()] * 9)), {}, slipfit.OptionError, "numbers"),
        ((np.arange(9), np.arange(9)), {"kind": "speed"}, slipfit.OptionError, "one of displacement"),
        ((np.arange(9), np.arange(9)), {"model": "glue"}, slipfit.OptionError, "glue"),
        ((np.arange(9), np.arange(9)), {"band_hz": 3}, slipfit.OptionError, "two frequencies"),
        ((np.arange(9), np.arange(9)), {"band_hz": (3, 2)}, slipfit.OptionError, "rising"),
        ((np.arange(9), np.arange(9)), {"start_s": "x"}, slipfit.OptionError, "number"),
        ((np.arange(9), np.arange(9)), {"lockin_order": 2}, slipfit.OptionError, "give both"),
        ((np.arange(9), np.arange(9)), {"stiffness": 1, "mass": 2}, slipfit.OptionError, "both given"),
        ((np.arange(9), np.arange(9)), {"stiffness": 1, "unit": "rad"}, slipfit.OptionError, "angle"),
        ((np.arange(9), np.arange(9)), {"rate_hz": 0}, slipfit.SlipfitError, "rate"),
        ((np.arange(9.0)[::-1], np.arange(9)), {}, slipfit.SlipfitError, "backwards"),
        ((np.zeros(9), np.arange(9)), {}, slipfit.SlipfitError, "stands still"),
        ((np.arange(9), np.ones(9)), {}, slipfit.SlipfitError, "constant"),
        ((np.arange(2), np.arange(2)), {}, slipfit.SlipfitError, "needed"),
        (([], []), {}, slipfit.SlipfitError, "no rows"),
        ((b"no table\n",), {}, slipfit.ReadError, "no table"),
        ((slipfit.simulate.decay(frequency_hz=1, amplitude=1, duration_s=9, rate_hz=9), [1]), {}, slipfit.OptionError, "beside"),
    ],
)  # fmt: skip
def test_what_cannot_be_meant_is_refused(arguments, options, error, words):
    with pytest.raises(error, match=words) as raised:
        slipfit.ringdown(*arguments, **options)
    assert isinstance(raised.value, ValueError)
    assert raised.value.code
    assert "--" not in str(raised.value)


def test_errors_carry_their_values(tmp_path):
    path = tmp_path / "back.csv"
    rows = [0.1 * i for i in range(20)]
    path.write_text("t (s),x (m)\n" + "".join(f"{t:.1f},{i % 3}\n" for i, t in enumerate(rows[::-1])))
    with pytest.raises(slipfit.ReadError) as raised:
        slipfit.read(path)
    assert raised.value.file == str(path)
    assert raised.value.row == 3
    assert raised.value.column.startswith("column 1")
    assert {hint.option for hint in raised.value.hints} == {"time", "rate_hz"}
    with pytest.raises(AttributeError):
        raised.value.nothing
    with pytest.raises(slipfit.OptionError) as raised:
        slipfit.ringdown(np.arange(9), np.arange(9), min_amplitude=-1)
    assert (raised.value.option, raised.value.value) == ("min_amplitude", -1)
    with pytest.raises(FileNotFoundError) as raised:
        slipfit.ringdown(tmp_path / "none.csv")
    assert raised.value.filename == str(tmp_path / "none.csv")


def test_curves_and_levels_are_refused_by_name(sweep):
    with pytest.raises(slipfit.OptionError, match="has it"):
        slipfit.resonance(*sweep, phase_rad=np.zeros(81))
    with pytest.raises(slipfit.OptionError, match="exact, leading, paper"):
        slipfit.resonance(*sweep, method="guess")
    with pytest.raises(slipfit.OptionError, match="response"):
        slipfit.resonance(sweep[0])
    with pytest.raises(slipfit.OptionError, match="in `mm`"):
        other = slipfit.read_curve(b"f (Hz),R (mm)\n1,2\n2,3\n3,1\n4,1\n", "free.csv")
        slipfit.resonance(*sweep, unit="rad", reference=other)
    with pytest.raises(slipfit.OptionError, match="amplitudes"):
        slipfit.levels([1, 2, 3])
    with pytest.raises(slipfit.SlipfitError):
        slipfit.levels([1, 2, 3, 4], [4, 3, 2, 1])
    with pytest.raises(slipfit.OptionError, match="at least one"):
        slipfit.series([])
    with pytest.raises(slipfit.OptionError, match="cannot be shared"):
        record = slipfit.simulate.decay(frequency_hz=1, q_factor=20, amplitude=1, duration_s=9, rate_hz=50)
        slipfit.series([slipfit.Measurement(record)], shared=["mood"])
    with pytest.raises(slipfit.OptionError, match="reference is the curve without friction"):
        slipfit.Measurement(record, reference=other)
    with pytest.raises(slipfit.OptionError, match="its number is"):
        slipfit.series([slipfit.Measurement(record, condition=9e-9)])
    with pytest.raises(slipfit.OptionError, match="unexpected keyword"):
        slipfit.series([slipfit.Measurement(record, options={"colour": "viscous"})])


def test_simulations_say_what_they_need():
    for arguments in (
        {},
        {"frequency_hz": 0},
        {"frequency_hz": 1, "q_factor": -1},
        {"frequency_hz": 1, "duration_s": -1},
        {"frequency_hz": 1, "rate_hz": 1e12},
    ):
        with pytest.raises(slipfit.OptionError):
            slipfit.simulate.decay(**{"amplitude": 1, "duration_s": 9, "rate_hz": 9} | arguments)


def test_noise_has_its_size_and_its_seed():
    swing = {"frequency_hz": 1, "q_factor": 50, "amplitude": 1, "duration_s": 100, "rate_hz": 100}
    clean = slipfit.simulate.decay(**swing).signal
    noisy = slipfit.simulate.decay(**swing, noise_rms=0.02, seed=3).signal
    # Five standard errors of 10 001 draws.
    assert abs(np.std(noisy - clean) / 0.02 - 1) < 0.036
    np.testing.assert_array_equal(noisy, slipfit.simulate.decay(**swing, noise_rms=0.02, seed=3).signal)
    assert not np.array_equal(noisy, slipfit.simulate.decay(**swing, noise_rms=0.02, seed=4).signal)
    for wrong in ({"noise_rms": -1}, {"noise_rms": float("nan")}, {"noise_rms": 1, "seed": -1}, {"noise_rms": 1, "seed": 0.5}):
        with pytest.raises(slipfit.OptionError):
            slipfit.simulate.decay(**swing, **wrong)


def test_threads_give_the_same_answer(swing, answer):
    found = []
    threads = [
        threading.Thread(target=lambda: found.append(slipfit.ringdown(*swing, unit="rad"))) for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [answer] * 4


def test_ctrl_c_ends_a_long_analysis():
    t = np.arange(3_000_000) * 1e-3
    x = np.exp(-1e-3 * t) * np.cos(50 * t) + 1e-3 * np.random.default_rng(5).standard_normal(len(t))
    assert ends_at_a_signal(lambda: slipfit.ringdown(t, x))


@settings(max_examples=150, deadline=None)
@given(
    hnp.arrays(
        st.sampled_from([np.float64, np.float32, np.int16, np.uint8, np.bool_, np.complex128]),
        hnp.array_shapes(min_dims=0, max_dims=2, min_side=0, max_side=60),
    ),
    st.sampled_from([None, 1.0, 0.0, -3.0, float("nan"), 1e300]),
    st.booleans(),
)
def test_no_array_does_more_than_raise(values, rate, with_times):
    time = np.arange(len(values) if values.ndim else 1) * 0.1 if with_times else None
    try:
        slipfit.ringdown(time, values, rate_hz=rate)
    except slipfit.SlipfitError as error:
        assert error.code != "internal", error


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=400))
def test_no_bytes_do_more_than_raise(data):
    for read in (slipfit.read, slipfit.read_curve, slipfit.read_levels):
        try:
            read(data, "bytes")
        except slipfit.SlipfitError as error:
            assert error.code != "internal", error


def test_doctests_hold():
    import doctest

    from slipfit import _analyses, _answers, _batch, _errors, _fits, _input, _map, _plot, simulate, typing

    tried = 0
    for module in (slipfit, _analyses, _answers, _batch, _errors, _fits, _input, _map, _plot, simulate, typing):
        found = doctest.testmod(module, report=True)
        assert found.failed == 0, module.__name__
        tried += found.attempted
    assert tried > 40


def test_npy_of_pickled_objects_is_refused():
    held = io.BytesIO()
    np.save(held, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    with pytest.raises(slipfit.ReadError):
        slipfit.read(held.getvalue(), "objects.npy")


def test_what_is_masked_is_left_out_wherever_it_stands(swing):
    time, signal = swing
    mask = np.arange(len(time)) % 7 == 3
    missing = np.where(mask, np.nan, signal)
    found = slipfit.ringdown(time, missing, unit="rad")
    assert slipfit.ringdown(np.ma.array(np.where(mask, 0, time), mask=mask), missing, unit="rad").parameters == (
        slipfit.ringdown(np.where(mask, np.nan, time), missing, unit="rad").parameters
    )
    assert slipfit.ringdown(time, np.ma.array(np.where(mask, 50, signal), mask=mask), unit="rad") == found
    with pytest.raises(slipfit.OptionError, match="complex"):
        slipfit.ringdown(time, np.ma.array(signal + 1j, mask=mask))
    frequency = np.linspace(0.9, 1.1, 81)
    sweep = slipfit.simulate.sweep(
        frequency, frequency_hz=1, q_factor=50, friction_displacement=0.3, drive_amplitude=1
    )
    response = sweep["amplitude"] * np.exp(1j * sweep["phase_rad"])
    hidden = np.arange(81) % 7 == 3
    garbage = np.ma.array(np.where(hidden, 50 + 50j, response), mask=hidden)
    assert slipfit.fit_resonance(frequency, garbage, drive_amplitude=1).friction_displacement[0] == pytest.approx(0.3)


def test_times_are_taken_in_the_unit_that_they_name(swing):
    xarray = pytest.importorskip("xarray")
    time, signal = swing
    hz = slipfit.ringdown(time, signal, unit="rad").parameters.frequency_hz.value

    def labelled(scale, unit):
        return xarray.DataArray(signal, dims="t", coords={"t": ("t", time * scale, {"units": unit})})

    for scale, unit in [(1.0, "s"), (1e3, "ms"), (1e6, "us"), (1 / 60, "min")]:
        found = slipfit.ringdown(labelled(scale, unit), unit="rad").parameters.frequency_hz.value
        assert found == pytest.approx(hz, rel=1e-9)
    with pytest.raises(slipfit.OptionError, match="fortnights"):
        slipfit.ringdown(labelled(1.0, "fortnights"))


def test_dates_of_every_make_are_times(swing):
    pandas = pytest.importorskip("pandas")
    time, signal = swing
    hz = slipfit.ringdown(time, signal, unit="rad").parameters.frequency_hz.value
    dates = pandas.Timestamp("2026-03-29", tz="UTC") + pandas.to_timedelta(time, unit="s")
    for given in (pandas.Series(dates), dates, list(dates.to_pydatetime()), list(pandas.to_timedelta(time, unit="s"))):
        found = slipfit.ringdown(given, signal, unit="rad")
        assert found.parameters.frequency_hz.value == pytest.approx(hz, rel=1e-6)
    holes = list(dates.to_pydatetime())
    holes[10], holes[20], holes[30] = None, pandas.NaT, pandas.NA
    found = slipfit.ringdown(holes, signal, unit="rad")
    assert found.to_dict()["input"]["rows_skipped"] == 3


@pytest.mark.parametrize(
    ("option", "given"),
    [
        ("stiffness", {"stiffness": "12"}),
        ("band_hz", {"band_hz": "79"}),
        ("start_s", {"start_s": 10**400}),
        ("rate_hz", {"rate_hz": 500}),
    ],
)
def test_what_would_be_taken_for_something_else_is_refused(swing, option, given):
    with pytest.raises(slipfit.OptionError) as refused:
        slipfit.ringdown(*swing, **given)
    assert refused.value.option == option


def test_a_list_of_lists_of_other_lengths_is_refused(swing):
    with pytest.raises(slipfit.OptionError):
        slipfit.ringdown(swing[0][:2], [[1], [1, 2]])


def test_what_is_missing_in_objects_is_missing(swing):
    pandas = pytest.importorskip("pandas")
    time, signal = swing
    for missing in (None, pandas.NA, float("nan")):
        objects = np.array([missing, *signal[1:]], dtype=object)
        assert slipfit.ringdown(time, objects).to_dict()["input"]["rows_skipped"] == 1
    with pytest.raises(slipfit.OptionError, match="does not hold numbers"):
        slipfit.ringdown(time, np.array([1j, *signal[1:]], dtype=object))


def test_numbers_beyond_doubles_are_left_out_without_a_warning(swing):
    time, signal = swing
    wide = signal.astype(np.longdouble)
    if np.finfo(wide.dtype).max <= np.finfo(float).max:
        pytest.skip("no wider numbers here")
    wide[5] = np.longdouble("1e4000")
    assert slipfit.ringdown(time, wide).to_dict()["input"]["rows_skipped"] == 1


@pytest.mark.parametrize(("rows", "words"), [(0, "signal has no rows"), (1, "signal has one row")])
def test_arrays_without_rows_are_not_called_a_broken_file(rows, words):
    with pytest.raises(slipfit.OptionError, match=words) as raised:
        slipfit.ringdown(np.arange(rows), np.arange(rows))
    assert (raised.value.code, raised.value.found) == ("too_few_rows", rows)
    with pytest.raises(slipfit.OptionError, match="amplitude has"):
        slipfit.levels(np.arange(rows), np.arange(rows))


def test_what_is_wrong_with_arrays_is_told_of_arguments(swing, sweep):
    time, signal = swing
    cases = [
        (lambda: slipfit.ringdown(time[::-1], signal), "time", r"^time: time goes backwards .*, at index 1\n"),
        (lambda: slipfit.ringdown(time * 0, signal), None, "^time stands still"),
        (lambda: slipfit.ringdown(time, signal * 0), "signal", "^signal is constant"),
        (lambda: slipfit.ringdown(time, signal * np.nan), "signal", r"^signal has no usable rows.* in signal \(index 0 and others\)$"),
        (lambda: slipfit.ringdown(signal=signal, rate_hz=0), "rate_hz", "^rate_hz"),
        (lambda: slipfit.resonance(-sweep[0], sweep[1]), "frequency", "^frequency: .*below zero, at index 0"),
        (lambda: slipfit.resonance(sweep[0] * 0 + 3, sweep[1]), "frequency", "^frequency"),
        (lambda: slipfit.resonance(sweep[0], -abs(sweep[1])), "response", "^response: .*below zero, at index 0"),
        (lambda: slipfit.levels([1, 2, 3, 4], [1, 2, -3, 4]), "amplitude", "^amplitude: .*below zero, at index 2"),
    ]
    for call, option, words in cases:
        with pytest.raises(slipfit.OptionError, match=words) as raised:
            call()
        error = raised.value
        assert getattr(error, "option", None) == option, str(error)
        assert not re.search(r"\b(column|row|arrays)\b", str(error))
        assert not hasattr(error, "file")


def test_numbers_beyond_all_powers_have_no_hint_but_another_unit(swing):
    with pytest.raises(slipfit.NoAnswerError, match="choose another unit") as raised:
        slipfit.ringdown(swing[0], swing[1] * 1e200)
    assert raised.value.hints == ()


def test_labelled_curves_and_levels_bring_their_units(sweep):
    xarray = pytest.importorskip("xarray")
    pandas = pytest.importorskip("pandas")
    frequency, response = sweep
    plain = slipfit.resonance(frequency, response, drive_amplitude=1, unit="mm")
    for scale, unit in ((1.0, "Hz"), (1e-3, "kHz"), (2 * np.pi, "rad/s"), (1.0, None)):
        attrs = {} if unit is None else {"units": unit}
        hz = xarray.DataArray(scale * frequency, dims="f", attrs=attrs)
        values = xarray.DataArray(response, dims="f", attrs={"units": "mm"})
        for arguments in ((hz, values), (values.assign_coords(f=hz),), (hz, response)):
            found = slipfit.resonance(*arguments, drive_amplitude=1)
            x_f, other = (one.parameters.friction_displacement for one in (found, plain))
            assert x_f.value == pytest.approx(other.value, rel=1e-6)
            assert found.parameters.natural_frequency_hz.value == pytest.approx(1, abs=1e-3)
            assert x_f.unit == ("" if arguments[-1] is response else "mm")
    with pytest.raises(slipfit.OptionError, match="frequency is in 'THz': mHz") as raised:
        slipfit.resonance(xarray.DataArray(frequency, dims="f", attrs={"units": "THz"}), response)
    assert raised.value.option == "frequency"
    with pytest.raises(slipfit.OptionError, match="frequency is a DataFrame") as raised:
        slipfit.resonance(pandas.DataFrame({"f": frequency}))
    assert raised.value.option == "frequency"
    whole = pandas.Series(np.abs(response), index=np.arange(10, 91))
    assert slipfit.resonance(whole, drive_amplitude=1).parameters.natural_frequency_hz.value > 10
    drive = np.arange(0.1, 1.3, 0.1)
    amplitude = np.maximum(40 * (drive - 0.35), 0) + 0.02 * (np.arange(12) * 7 % 5)
    labelled = (xarray.DataArray(one, dims="d", attrs={"units": unit}) for one, unit in ((drive, "V"), (amplitude, "mm")))
    data = slipfit.levels(*labelled).to_dict()["input"]
    assert (data["drive_unit"], data["unit"]) == ("V", "mm")
    real, turned = (slipfit.levels(drive, one).parameters for one in (amplitude, amplitude * np.exp(2j)))
    assert turned.threshold.value == pytest.approx(real.threshold.value)


def test_a_folder_says_what_takes_its_files(tmp_path):
    (tmp_path / "one.csv").write_text("t (s),x (mm)\n")
    for call in (slipfit.read, slipfit.ringdown, lambda path: slipfit.ringdown(str(path))):
        with pytest.raises(slipfit.FolderError, match="this is a folder") as raised:
            call(tmp_path)
        error = raised.value
        assert isinstance(error, slipfit.ReadError) and isinstance(error, IsADirectoryError)
        assert (error.errno, error.filename, error.file) == (errno.EISDIR, str(tmp_path), str(tmp_path))
        assert error.code == "folder"
        assert f"slipfit.engines.arrow.ringdown_files({str(tmp_path / '*')!r})" in str(error)
        again = pickle.loads(pickle.dumps(error))
        assert (str(again), again.filename, again.hints) == (str(error), error.filename, error.hints)
    with pytest.raises(slipfit.FolderError, match="one of its files"):
        slipfit.levels(tmp_path)
    # Of driven records a folder is what is wanted.
    with pytest.raises(slipfit.ReadError, match="driven record"):
        slipfit.resonance(tmp_path)


def test_arrays_with_units_are_taken_in_them(swing, answer):
    pint = pytest.importorskip("pint")
    unit = pint.UnitRegistry()
    time, signal = swing

    class Astropy(np.ndarray):
        """An array as those of astropy are: NumPy sees its numbers alone."""

    def astropy(numbers, unit):
        held = np.asarray(numbers).view(Astropy)
        held.unit, held.value = unit, np.asarray(numbers)
        return held

    for times, samples in (
        (unit.Quantity(time * 1e3, "ms"), unit.Quantity(signal, "rad")),
        (astropy(time * 1e3, "ms"), astropy(signal, "rad")),
    ):
        found = slipfit.ringdown(times, samples)
        assert found.parameters.friction_displacement.unit == "rad"
        assert found.parameters.frequency_hz.value == pytest.approx(answer.parameters.frequency_hz.value, rel=1e-9)
        with pytest.raises(slipfit.OptionError, match="unit='mrad' beside signal in 'rad': convert signal") as raised:
            slipfit.ringdown(times, samples, unit="mrad")
        assert raised.value.option == "unit"
    with pytest.raises(slipfit.OptionError, match="time is in 'mm'"):
        slipfit.ringdown(unit.Quantity(time, "mm"), signal)
    # Both outputs of a lock-in in one unit.
    noise = 1e-3 * np.random.default_rng(3).standard_normal((2, len(time)))
    x, y = np.outer([0.6, 0.8], np.exp(-0.1 * time)) + noise
    apart = slipfit.ringdown(time, unit.Quantity(x, "mm"), quadrature=unit.Quantity(y * 1e3, "um"))
    alone = slipfit.ringdown(time, x, quadrature=y, unit="mm").parameters.initial_amplitude
    assert apart.parameters.initial_amplitude.value == pytest.approx(alone.value, rel=1e-9)
    assert apart.parameters.initial_amplitude.unit == "mm"
    with pytest.raises(slipfit.OptionError, match="quadrature is in 's'"):
        slipfit.ringdown(time, unit.Quantity(x, "mm"), quadrature=unit.Quantity(y, "s"))


def test_curves_with_units_are_taken_in_them(sweep):
    pint = pytest.importorskip("pint")
    unit = pint.UnitRegistry()
    hz, response = sweep
    amplitude, phase = np.abs(response), np.unwrap(np.angle(response))
    plain = slipfit.resonance(hz, amplitude, phase_rad=phase, std_error=amplitude * 0 + 0.05, unit="mm")
    found = slipfit.resonance(
        unit.Quantity(hz * 1e3, "mHz"), unit.Quantity(amplitude, "mm"),
        phase_rad=unit.Quantity(np.degrees(phase), "deg"), std_error=unit.Quantity(amplitude * 0 + 50, "um"),
    )  # fmt: skip
    for name, quantity in plain.parameters.items():
        assert found.parameters[name].value == pytest.approx(quantity.value, rel=1e-6), name
        assert found.parameters[name].unit == quantity.unit


def test_texts_as_times_are_told_from_numbers(swing):
    time, signal = swing
    dates = [f"2026-01-01T00:{int(t) // 60:02}:{t % 60:09.6f}" for t in time]
    for texts in (dates, np.array(dates), np.array(dates, object)):
        with pytest.raises(slipfit.OptionError, match=r"such as '2026-01-01T00:00:00.*pandas.to_datetime\(time\)"):
            slipfit.ringdown(texts, signal)


def test_an_index_tells_its_unit_and_stands_beside_no_rate(swing, answer):
    pandas = pytest.importorskip("pandas")
    time, signal = swing
    for scale, name in ((1e3, "time (ms)"), (1, "t [s]"), (1, "time")):
        series = pandas.Series(signal, index=pandas.Index(time * scale, name=name))
        found = slipfit.ringdown(series, unit="rad").parameters.frequency_hz.value
        assert found == pytest.approx(answer.parameters.frequency_hz.value, rel=1e-9)
        with pytest.raises(slipfit.OptionError, match="rate_hz is given beside the index"):
            slipfit.ringdown(series, rate_hz=50)
    with pytest.raises(slipfit.OptionError, match="time is in 'mm'"):
        slipfit.ringdown(pandas.Series(signal, index=pandas.Index(time, name="time (mm)")))
    assert slipfit.ringdown(pandas.Series(signal), rate_hz=50) == slipfit.ringdown(signal=signal, rate_hz=50)


@pytest.mark.parametrize("kind", ["envelope", "lock-in"])
def test_a_curve_is_a_motion(sweep, kind):
    for call in (lambda: slipfit.resonance(*sweep, kind=kind), lambda: slipfit.read_curve(b"f,R\n1,2\n", kind=kind)):
        with pytest.raises(slipfit.OptionError, match="displacement, velocity, acceleration for a") as raised:
            call()
        assert raised.value.option == "kind"


def test_an_oscillation_has_no_output_filter(swing):
    with pytest.raises(slipfit.OptionError, match="this record oscillates") as raised:
        slipfit.ringdown(*swing, lockin_time_constant_s=0.1, lockin_order=2)
    assert raised.value.option == "lockin_time_constant_s"
    amplitudes = np.exp(-0.1 * swing[0]) + 1e-3 * np.random.default_rng(1).standard_normal(len(swing[0]))
    slipfit.ringdown(swing[0], amplitudes, kind="envelope", lockin_time_constant_s=0.1, lockin_order=2)


def test_engines_are_there_without_an_import():
    code = "import slipfit; assert 'engines' in dir(slipfit); slipfit.engines.arrow.ringdown_files"
    subprocess.run([sys.executable, "-c", code], check=True)
    with pytest.raises(AttributeError, match="no attribute 'engine'"):
        slipfit.engine


def test_a_name_tells_the_unit_as_a_header_does(swing, answer):
    pandas, polars = pytest.importorskip("pandas"), pytest.importorskip("polars")
    time, signal = swing
    hz = answer.parameters.frequency_hz.value
    for make in (pandas.Series, polars.Series):
        for scale, name in ((1e3, "time (ms)"), (1e3, "t/ms"), (1e6, "time [us]"), (1 / 60, "t (min)"), (1 / 86400, "days (days)")):
            column = make(time * scale, name=name) if make is pandas.Series else make(name, time * scale)
            found = slipfit.ringdown(column, signal).parameters.frequency_hz.value
            assert found == pytest.approx(hz, rel=1e-9), name
    # What is no unit is a word.
    for name in ("time (local)", "time [UTC]", "t (1)", "run (3)", "time (lab clock)", "time", 5, ("t", "ms")):
        column = pandas.Series(time, name=name)
        assert slipfit.ringdown(column, signal, unit="rad") == answer, name
        indexed = pandas.Series(signal, index=pandas.Index(time, name=name))
        assert slipfit.ringdown(indexed, unit="rad") == answer, name
    for name in ("time (mV)", "t (mm)", "f (kHz)"):
        with pytest.raises(slipfit.OptionError, match=f"time is in '.*' by its name '{re.escape(name)}': s, ms") as raised:
            slipfit.ringdown(pandas.Series(time, name=name), signal)
        assert raised.value.option == "time"
        assert slipfit.ringdown(pandas.Series(time, name=name).to_numpy(), signal, unit="rad") == answer
    dates = pandas.Series(pandas.to_datetime(time, unit="s"), name="time (mV)")
    assert slipfit.ringdown(dates, signal).parameters.frequency_hz.value == pytest.approx(hz, rel=1e-6)


def test_names_of_samples_phases_and_errors_tell_their_units(swing, sweep):
    pandas = pytest.importorskip("pandas")
    time, signal = swing
    named = slipfit.ringdown(time, pandas.Series(signal, name="angle (mrad)"))
    assert named == slipfit.ringdown(time, signal, unit="mrad")
    assert slipfit.ringdown(time, pandas.Series(signal, name="angle (V)"), unit="rad").parameters == (
        slipfit.ringdown(time, signal, unit="rad").parameters
    )
    assert slipfit.ringdown(time, pandas.Series(signal, name="shifted_ms")).to_dict()["input"]["unit"] == ""
    frequency, response = sweep
    columns = {"f (mHz)": 1e3 * frequency, "R (mm)": np.abs(response), "phase (deg)": np.degrees(np.angle(response)), "e (um)": np.full(81, 50.0)}
    frame = pandas.DataFrame(columns)
    plain = slipfit.resonance(
        frequency, np.abs(response), phase_rad=np.angle(response), std_error=np.full(81, 0.05), unit="mm", drive_amplitude=1
    )
    found = slipfit.resonance(
        frame["f (mHz)"], frame["R (mm)"], phase_rad=frame["phase (deg)"], std_error=frame["e (um)"], drive_amplitude=1
    )
    for name, quantity in plain.parameters.items():
        assert found.parameters[name].value == pytest.approx(quantity.value, rel=1e-6), name
        assert found.parameters[name].unit == quantity.unit
    with pytest.raises(slipfit.OptionError, match="phase_rad is in 'mm' by its name"):
        slipfit.resonance(frequency, np.abs(response), phase_rad=frame["R (mm)"])
    levels = slipfit.levels(pandas.Series([1.0, 2, 3, 4], name="drive (V)"), pandas.Series([0.1, 2.1, 4.1, 6.2], name="R (nm)"))
    assert levels.parameters.threshold.unit == "V"


def test_a_reversed_record_is_told_from_an_unsorted_one(swing, answer):
    time, signal = swing
    with pytest.raises(slipfit.OptionError, match="as in every step: .* reverse its rows, at index 1") as raised:
        slipfit.ringdown(time[::-1], signal[::-1])
    assert (raised.value.option, raised.value.code) == ("time", "time_backwards")
    for seed in range(8):
        mixed = np.random.default_rng(seed).permutation(len(time))
        with pytest.raises(slipfit.OptionError, match=r"as in \d+ of 2000 steps: .* sort them by time, at index"):
            slipfit.ringdown(time[mixed], signal[mixed])
        order = np.argsort(time[mixed])
        assert slipfit.ringdown(time[mixed][order], signal[mixed][order], unit="rad") == answer


def test_rows_of_pandas_stand_beside_the_same_rows(swing, sweep):
    """A quadrature with other rows was taken by its place."""
    pandas = pytest.importorskip("pandas")
    time, signal = swing
    x, y = pandas.Series(signal, index=time), pandas.Series(np.roll(signal, 10), index=time)
    wanted = slipfit.ringdown(time, signal, quadrature=y.to_numpy())
    assert slipfit.ringdown(x, quadrature=y) == slipfit.ringdown(x, quadrature=y.to_numpy()) == wanted
    for other in (y[::-1], y.sample(frac=1, random_state=1), y.reset_index(drop=True)):
        with pytest.raises(slipfit.OptionError, match=r"quadrature.reindex\(signal.index\) has its rows") as raised:
            slipfit.ringdown(x, quadrature=other)
        assert raised.value.option == "quadrature"
    assert slipfit.ringdown(x, quadrature=y[::-1].reindex(x.index)) == wanted
    frequency, response = sweep
    curve = pandas.Series(np.abs(response), index=frequency)
    for option in ("phase_rad", "std_error", "drive"):
        beside = pandas.Series(np.ones(len(frequency)), index=frequency)
        with pytest.raises(slipfit.OptionError, match="has another index than response") as raised:
            slipfit.resonance(curve, **{option: beside[::-1]})
        assert raised.value.option == option


def test_a_view_of_numbers_is_an_array(swing, answer):
    """It was taken for the bytes of a file."""
    time, signal = swing
    assert slipfit.ringdown(memoryview(time), memoryview(signal), unit="rad") == answer
    for code in "fd":
        view = memoryview(signal.astype(code))
        found = slipfit.ringdown(signal=view, rate_hz=50, unit="rad")
        assert found.parameters.frequency_hz.value == pytest.approx(answer.parameters.frequency_hz.value, rel=1e-6)
    with pytest.raises(slipfit.OptionError, match="signal is missing; if this is the signal, give rate_hz"):
        slipfit.ringdown(memoryview(signal))
    rows = b"".join(b"%.6f,%.9f\n" % row for row in zip(time, signal))
    assert len(slipfit.read(memoryview(rows))) == len(time)
    assert slipfit.ringdown(memoryview(rows)).sliding.detected


@pytest.mark.parametrize("several", [np.ones(81), np.ones(3), np.ones((2, 2)), [1.0, 2.0, 3.0]])
def test_several_numbers_are_no_value_with_its_error(swing, sweep, several):
    """They raised what Python says of values to unpack."""
    for call, arguments, option in (
        (slipfit.resonance, (sweep[0], np.abs(sweep[1])), "drive_amplitude"),
        (slipfit.ringdown, swing, "stiffness"),
    ):
        with pytest.raises(slipfit.OptionTypeError, match="a number, or a number and its standard error") as raised:
            call(*arguments, **{option: several})
        assert raised.value.option == option and raised.value.value is several


def test_messages_name_what_was_given(swing, tmp_path):
    xr = pytest.importorskip("xarray")
    time, signal = swing
    held = xr.DataArray(signal, dims="time", coords={"time": time}, attrs={"units": "mm"})
    with pytest.raises(slipfit.OptionError, match="unit='um' beside signal in 'mm'"):
        slipfit.ringdown(held, unit="um")
    with pytest.raises(slipfit.OptionError, match="kind='lock-in' without quadrature: signal=… and quadrature=…") as raised:
        slipfit.ringdown(time, signal, kind="lock-in")
    assert raised.value.option == "quadrature"
    with pytest.raises(slipfit.OptionError, match="kind='velocity' beside quadrature") as raised:
        slipfit.ringdown(time, signal, quadrature=signal, kind="velocity")
    assert raised.value.option == "kind"
    path = tmp_path / "swing.csv"
    path.write_bytes(b"t (s),x (m)\n" + b"".join(b"%.6f,%.9f\n" % row for row in zip(time[::-1], signal[::-1])))
    with path.open("rb") as file:
        with pytest.raises(slipfit.OptionTypeError, match=r"give its bytes, time.read\(\)") as raised:
            slipfit.ringdown(file)
        assert raised.value.option == "time"
        for call, option in ((slipfit.resonance, "frequency"), (slipfit.levels, "drive")):
            with pytest.raises(slipfit.OptionTypeError, match=rf"give its bytes, {option}.read\(\)") as raised:
                call(file)
            assert raised.value.option == option
    with pytest.raises(slipfit.ReadError, match=r"slipfit.read\(…, time=…\) names another column"):
        slipfit.ringdown(path)


def test_amplitudes_without_a_bend_have_no_decay_rate():
    """The rate of the start came back as if it were measured, to seven digits."""
    time = 0.1 * np.arange(50)
    for amplitude in (np.full(50, 2.0), np.zeros(50), np.full(50, -3e7)):
        for rate in (0.01, 1.0, 7.5):
            with pytest.raises(slipfit.NoAnswerError, match="decay rate") as raised:
                slipfit.fit_envelope(time, amplitude, initial_amplitude=1, offset_amplitude=0, decay_rate_per_s=rate)
            assert raised.value.code == "no_fit"


def test_arguments_are_refused_before_the_analysis(swing, sweep, monkeypatch):
    def analysed(*_):
        raise AssertionError("the analysis runs")

    for name in ("ringdown_answer", "resonance_answer", "levels_answer", "series_answer"):
        monkeypatch.setattr(slipfit._core, name, analysed)
    record = slipfit.read(np_bytes_of(swing), "swing.npy", time=1, signal=2, unit="rad")
    wrong = [
        {"lockin_time_constant_s": 0.1, "lockin_order": 2}, {"lockin_order": 2}, {"model": "glue"}, {"law": "any"},
        {"start_s": 3, "end_s": 2}, {"min_amplitude": -1}, {"stiffness": 1, "mass": 1}, {"stiffness": -1},
        {"band_hz": (3, 2)}, {"frequency_hz": -1},
    ]  # fmt: skip
    for options in wrong:
        with pytest.raises(slipfit.OptionError):
            slipfit.ringdown(*swing, unit="rad", **options)
        with pytest.raises(slipfit.OptionError):
            slipfit.ringdown(record, **options)
    with pytest.raises(slipfit.OptionError, match="options: lockin_time_constant_s=0.1: only for amplitudes"):
        slipfit.Measurement(record, options=wrong[0])


def np_bytes_of(columns):
    held = io.BytesIO()
    np.save(held, np.column_stack(columns))
    return held.getvalue()


def test_what_is_no_column_says_which_there_are(swing):
    pandas, polars = pytest.importorskip("pandas"), pytest.importorskip("polars")
    columns = {"t (s)": swing[0], "x (rad)": swing[1]}
    for table in (pandas.DataFrame(columns), polars.DataFrame(columns)):
        with pytest.raises(slipfit.OptionError, match=r"of 2 columns: one is needed as time, .*; there is 't \(s\)', 'x \(rad\)'"):
            slipfit.ringdown(table)
    with pytest.raises(slipfit.OptionError, match=r"of 1 column: the column itself is needed; there is 'x \(rad\)'"):
        slipfit.ringdown(pandas.DataFrame(columns).set_index("t (s)"))
    with pytest.raises(slipfit.OptionError, match="ndarray of 2 columns: one"):
        slipfit.ringdown(np.column_stack(swing))
    with pytest.raises(slipfit.OptionTypeError, match=r"slipfit.Measurement\(slipfit.read"):
        slipfit.series(["swing.csv"])
    with pytest.raises(slipfit.OptionTypeError, match="as slipfit.read, read_curve and read_levels give them"):
        slipfit.Measurement("swing.csv")
