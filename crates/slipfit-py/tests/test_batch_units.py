"""Batches and maps take traces, times and numbers in the unit that is told, stated or in a name, as `ringdown` does."""

import numpy as np
import pytest
import slipfit
from hypothesis import given, settings
from hypothesis import strategies as st

pa = pytest.importorskip("pyarrow")

DT = 0.01
TIME = DT * np.arange(300)
#: Amplitudes under viscous and sliding loss, in nm.
AMPLITUDE = np.exp(-0.5 * TIME) - 0.1 * (1 - np.exp(-0.5 * TIME)) / 0.5
NOISE = 1e-3 * np.random.default_rng(3).standard_normal(len(TIME))
PLAIN = {"amplitude": "a", "dt": DT}
#: Levels of a decay without friction, 1.2 per second.
LEVELS = 60 - 20 * np.log10(np.e) * 1.2 * TIME + 0.01 * np.random.default_rng(4).standard_normal(len(TIME))


def same(found, wanted):
    """Equal but for what a factor rounds."""
    for name in wanted:
        if wanted[name].dtype.kind == "f":
            np.testing.assert_allclose(found[name], wanted[name], rtol=1e-6, atol=1e-12, err_msg=name)
        else:
            assert list(found[name]) == list(wanted[name]), name


@pytest.mark.parametrize(("unit", "linear"), [("dB", ""), ("dBm", "√mW"), ("dBV", "V")])
@pytest.mark.parametrize("method", ["fit", "analyse"])
def test_levels_are_amplitudes(unit, linear, method):
    """As `ringdown` reads them, 20 dB a decade: fitted as amplitudes they were decays with friction."""
    xr = pytest.importorskip("xarray")
    options = {"method": method, **PLAIN}
    wanted = slipfit.fit_batch([10 ** (LEVELS / 20)], unit=linear, **options)
    assert wanted["decay_rate_per_s"][0] == pytest.approx(1.2, rel=1e-2) and not wanted["sliding_detected"][0]
    labelled = xr.DataArray(LEVELS[np.newaxis], dims=("row", "time"), attrs={"units": unit})
    table = pa.table({"a": [LEVELS.astype(np.float32).tolist()]})
    for found in (
        slipfit.fit_batch([LEVELS], unit=unit, **options),
        slipfit.fit_batch(labelled, **options),
        slipfit.fit_batch({f"a ({unit})": [LEVELS]}, **{**options, "amplitude": f"a ({unit})"}),
        next(slipfit.fit_stream(pa.table({"a": [LEVELS]}), unit=unit, **options)),
    ):
        same(found, wanted)
        assert found.units == wanted.units and found.units.get("initial_amplitude", "") == linear
    single = slipfit.fit_batch(table, unit=unit, **options)
    assert single["decay_rate_per_s"] == pytest.approx(wanted["decay_rate_per_s"], rel=1e-4)
    image = slipfit.fit_map(LEVELS[np.newaxis, np.newaxis], DT, unit=unit, method=method)
    np.testing.assert_allclose(image["decay_rate_per_s"].item(), wanted["decay_rate_per_s"][0], rtol=1e-9)
    assert image["initial_amplitude"].attrs["units"] == linear
    if method == "analyse":
        alone = slipfit.ringdown(TIME, LEVELS, unit=unit)
        assert alone.parameters.decay_rate_per_s.value == pytest.approx(wanted["decay_rate_per_s"][0], rel=1e-9)
        assert alone.parameters.initial_amplitude.unit == linear


@settings(max_examples=25, deadline=None)
@given(rate=st.floats(0.2, 3), level=st.floats(-120, 120), rows=st.integers(1, 3))
def test_a_decay_in_levels_has_its_rate(rate, level, rows):
    levels = level - 20 * np.log10(np.e) * rate * TIME
    found = slipfit.fit_batch([levels] * rows, unit="dB", **PLAIN)
    assert found["decay_rate_per_s"] == pytest.approx([rate] * rows, rel=1e-6)
    assert found["initial_amplitude"] == pytest.approx([10 ** (level / 20)] * rows, rel=1e-6)


def test_levels_that_are_missing_are_left_out_and_signs_have_none():
    holed = LEVELS.copy()
    holed[[7, 8, 9]] = [np.nan, -np.inf, np.inf]
    found = slipfit.fit_batch([holed], unit="dB", **PLAIN)
    assert found["samples_left_out"].tolist() == [3] and found["status"][0] == "done"
    # A least amplitude is one of the amplitudes, as of `ringdown`.
    cut = slipfit.fit_batch([LEVELS], unit="dBV", min_amplitude=100.0, **PLAIN)
    assert cut["samples"][0] == np.argmax(LEVELS < 40)
    for traces in ({"signal": "a", "method": "analyse"}, {"x": "a", "y": "b"}):
        with pytest.raises(slipfit.OptionError, match="levels of amplitudes: give them as amplitude=") as raised:
            slipfit.fit_batch({"a": [LEVELS], "b": [LEVELS]}, dt=DT, unit="dB", **traces)
        assert raised.value.option == next(iter(traces))


@pytest.mark.parametrize(
    ("unit", "kind", "displacement"),
    [("m/s", "velocity", "m"), ("m/s^2", "acceleration", "m"), ("rad/s", "velocity", "rad"), ("mm", "displacement", "mm")],
)
def test_the_unit_of_an_oscillation_tells_what_it_is(unit, kind, displacement):
    """As to `ringdown`: a velocity taken for a displacement has a friction that is too large by omega."""
    swing = slipfit.simulate.decay(frequency_hz=3, q_factor=60, friction_displacement=0.01, amplitude=1, duration_s=12, rate_hz=100)
    signal = swing.signal
    for _ in range({"displacement": 0, "velocity": 1, "acceleration": 2}[kind]):
        signal = np.gradient(signal, 0.01)
    signal = signal + 1e-3 * np.ptp(signal) * np.random.default_rng(1).standard_normal(len(signal))
    alone = slipfit.ringdown(signal=signal, rate_hz=100, unit=unit).parameters.friction_displacement
    assert alone.unit == displacement
    options = {"signal": "v", "dt": 0.01, "method": "analyse"}
    wanted = slipfit.fit_batch([signal], kind=kind, unit=unit, **options)
    named = {**options, "signal": f"v ({unit})"}
    for found in (
        slipfit.fit_batch([signal], unit=unit, **options),
        slipfit.fit_batch({f"v ({unit})": [signal]}, **named),
        next(slipfit.fit_stream(pa.table({"v": [signal]}), unit=unit, **options)),
    ):
        same(found, wanted)
        assert found.units["friction_displacement"] == displacement
        assert found["friction_displacement"][0] == pytest.approx(alone.value, rel=1e-6)
    # What is told goes before what the unit suggests.
    told = slipfit.fit_batch([signal], kind="displacement", unit=unit, **options)
    assert told.units["friction_displacement"] == unit


def stated(**columns):
    """A table whose columns state their units as those of answers do."""
    fields = [pa.field(name, values.type, metadata={"unit": unit}) for name, (values, unit) in columns.items()]
    return pa.table([values for values, _ in columns.values()], schema=pa.schema(fields))


def test_names_and_metadata_of_columns_tell_their_units():
    """As the header of a file does: an interval of 10 ms was one of 10 s."""
    plain = {"a": [AMPLITUDE + NOISE], "dt": [DT], "f": [5.0], "m": [0.2], "t": [TIME.tolist()]}
    options = {"amplitude": "a", "frequency_hz": "f", "min_amplitude": "m", "unit": "nm"}
    wanted = slipfit.fit_batch(plain, dt="dt", **options)
    by_name = {"a (nm)": plain["a"], "dt (ms)": [1e3 * DT], "f/kHz": [5e-3], "m (um)": [2e-4], "t [ms]": [(1e3 * TIME).tolist()]}
    named = {"amplitude": "a (nm)", "frequency_hz": "f/kHz", "min_amplitude": "m (um)"}
    trace = pa.array([(AMPLITUDE + NOISE).tolist()])
    by_metadata = stated(
        a=(trace, "nm"), dt=(pa.array([1e3 * DT]), "ms"), f=(pa.array([5e-3]), "kHz"), m=(pa.array([2e-4]), "um"),
        t=(pa.array([(1e3 * TIME).tolist()]), "ms"),
    )  # fmt: skip
    polars = pytest.importorskip("polars")
    for table, columns, clocks in (
        (by_name, named, ({"dt": "dt (ms)"}, {"time": "t [ms]"})),
        (polars.DataFrame(by_name), named, ({"dt": "dt (ms)"}, {"time": "t [ms]"})),
        (pa.table(by_name).to_pandas(), named, ({"dt": "dt (ms)"}, {"time": "t [ms]"})),
        (by_metadata, {**options, "unit": ""}, ({"dt": "dt"}, {"time": "t"})),
    ):
        for clock in clocks:
            found = slipfit.fit_batch(table, **columns, **clock)
            same(found, wanted)
            assert found.units == wanted.units
        streamed = pa.table(table) if isinstance(table, dict) else table
        same(next(slipfit.fit_stream(streamed, **columns, **clocks[0])), wanted)
    # For the traces what is told goes before a name, as of `ringdown`; types have a unit of their own.
    told = slipfit.fit_batch(by_name, amplitude="a (nm)", dt="dt (ms)", unit="um")
    assert told.units["initial_amplitude"] == "um"
    import datetime

    lasting = pa.table({"a": trace, "dt (ms)": pa.array([datetime.timedelta(seconds=DT)])})
    same(slipfit.fit_batch(lasting, amplitude="a", dt="dt (ms)"), slipfit.fit_batch(plain, amplitude="a", dt=DT))
    # A word in brackets is no unit.
    same(slipfit.fit_batch({"a": plain["a"], "dt (local)": [DT]}, amplitude="a", dt="dt (local)"), slipfit.fit_batch(plain, amplitude="a", dt=DT))


def test_both_outputs_of_a_lock_in_are_in_one_unit():
    x, y = AMPLITUDE * 0.6 + NOISE, AMPLITUDE * 0.8
    wanted = slipfit.fit_batch({"x": [x], "y": [y]}, x="x", y="y", dt=DT, unit="nm")
    for method in ("fit", "analyse"):
        wanted = slipfit.fit_batch({"x": [x], "y": [y]}, x="x", y="y", dt=DT, unit="nm", method=method)
        found = slipfit.fit_batch({"x (nm)": [x], "y (um)": [1e-3 * y]}, x="x (nm)", y="y (um)", dt=DT, method=method)
        same(found, wanted)
        assert found.units == wanted.units
    with pytest.raises(slipfit.OptionError, match="y is in 'V', what it belongs to in 'nm'") as raised:
        slipfit.fit_batch({"x (nm)": [x], "y (V)": [y]}, x="x (nm)", y="y (V)", dt=DT)
    assert raised.value.option == "y"


@pytest.mark.parametrize(
    ("columns", "options", "option", "words"),
    [
        ({"dt (mV)": [DT]}, {"dt": "dt (mV)"}, "dt", "dt is in 'mV' by its name 'dt (mV)': s, ms"),
        ({"t (Hz)": [TIME]}, {"time": "t (Hz)"}, "time", "time is in 'Hz' by its name"),
        ({"f (mm)": [5.0]}, {"dt": DT, "frequency_hz": "f (mm)"}, "frequency_hz", "frequency_hz is in 'mm'"),
        ({"m (um)": [5.0]}, {"dt": DT, "min_amplitude": "m (um)"}, "min_amplitude", "in no unit: give unit"),
        ({"m (V)": [5.0]}, {"dt": DT, "min_amplitude": "m (V)", "unit": "nm"}, "min_amplitude", "what it belongs to in 'nm'"),
    ],
)
def test_units_of_another_quantity_are_refused(columns, options, option, words):
    import re

    for fit, make in ((slipfit.fit_batch, dict), (slipfit.fit_stream, pa.table)):
        with pytest.raises(slipfit.OptionError, match=re.escape(words)) as raised:
            fit(make({"a": [AMPLITUDE.tolist()], **columns}), amplitude="a", **options)
        assert raised.value.option == option
    with pytest.raises(slipfit.OptionError, match="unit='um' beside amplitude in 'nm'") as raised:
        slipfit.fit_batch(stated(a=(pa.array([AMPLITUDE.tolist()]), "nm")), **PLAIN, unit="um")
    assert raised.value.option == "unit"


def test_units_of_arrays_are_kept_wherever_they_are_given(tmp_path):
    pint, xr = pytest.importorskip("pint"), pytest.importorskip("xarray")
    pandas, h5py = pytest.importorskip("pandas"), pytest.importorskip("h5py")
    ureg = pint.UnitRegistry()
    of = {"frequency_hz": 1, "q_factor": 50, "drive_amplitude": 1}
    wanted = slipfit.simulate.sweep([0.9, 1.0], **of)
    kilohertz = [9e-4, 1e-3]
    for frequencies in (
        kilohertz * ureg.kHz, xr.DataArray(kilohertz, dims="f", attrs={"units": "kHz"}), pandas.Series(kilohertz, name="f (kHz)"),
    ):  # fmt: skip
        found = slipfit.simulate.sweep(frequencies, **of)
        for name in ("frequency_hz", "amplitude", "phase_rad"):
            np.testing.assert_allclose(found[name], wanted[name], rtol=1e-9)
    with pytest.raises(slipfit.OptionError, match="frequencies_hz is in 'm'") as raised:
        slipfit.simulate.sweep([1] * ureg.m, **of)
    assert raised.value.option == "frequencies_hz"
    # The name of an array of xarray tells its unit too.
    labelled = xr.DataArray(AMPLITUDE[np.newaxis], dims=("row", "time"), name="a (nm)")
    assert slipfit.fit_batch(labelled, **PLAIN).units["sliding_rate"] == "nm/s"
    assert slipfit.fit_map(labelled.expand_dims("y"), DT)["sliding_rate"].attrs["units"] == "nm/s"
    # Traces of a list are in the unit of the first.
    rows = [AMPLITUDE * ureg.mm, AMPLITUDE * 1e-3 * ureg.m, None]
    plain = slipfit.fit_batch([AMPLITUDE, AMPLITUDE, None], unit="mm", **PLAIN)
    for table in (rows, {"a": rows}):
        found = slipfit.fit_batch(table, **PLAIN)
        same(found, plain)
        assert found.units == plain.units
    columns = {"a": np.array([AMPLITUDE]) * ureg.nm, "dt": [1e3 * DT] * ureg.ms, "f": xr.DataArray([5e-3], dims="row", attrs={"units": "kHz"})}
    found = slipfit.fit_batch(columns, amplitude="a", dt="dt", frequency_hz="f")
    same(found, slipfit.fit_batch([AMPLITUDE], frequency_hz=5.0, unit="nm", **PLAIN))
    assert found.units["friction_displacement"] == "nm"
    for wrong, words in (
        ([AMPLITUDE * ureg.mm, AMPLITUDE], "without a unit: each needs one"),
        ([AMPLITUDE * ureg.mm, AMPLITUDE * ureg.V], "table is in 'V', what it belongs to in 'mm'"),
    ):
        with pytest.raises(slipfit.OptionError, match=words) as raised:
            slipfit.fit_batch(wrong, **PLAIN)
        assert raised.value.option == "table"
    # A data set has the unit that its file has.
    with h5py.File(tmp_path / "stack.h5", "w") as file:
        file["a"] = AMPLITUDE[np.newaxis, np.newaxis]
        for key, unit in (("units", "nm"), ("unit", np.bytes_("nm")), ("units", np.array(["nm"], dtype="S2"))):
            file["a"].attrs.clear() if hasattr(file["a"].attrs, "clear") else None
            file["a"].attrs[key] = unit
            found = slipfit.fit_map(file["a"], DT)
            assert found["sliding_rate"].attrs["units"] == "nm/s", key
    by_path = slipfit.fit_map(tmp_path / "stack.h5", DT)
    xr.testing.assert_identical(found, by_path)
    zarr = pytest.importorskip("zarr")
    stored = zarr.create_array(store={}, data=AMPLITUDE[np.newaxis, np.newaxis])
    stored.attrs["units"] = "nm"
    assert slipfit.fit_map(stored, DT)["sliding_rate"].attrs["units"] == "nm/s"


@pytest.mark.parametrize("method", ["fit", "analyse"])
@pytest.mark.parametrize("missing", [None, float("nan")])
def test_a_row_without_a_frequency_or_a_least_amplitude_has_its_losses(method, missing):
    """Neither is needed for them; the whole row had failed."""
    traces = [AMPLITUDE + NOISE] * 4
    table = {"a": traces, "f": pa.array([5.0, missing, 5.0, -1.0]), "m": pa.array([0.2, 0.2, missing, 0.2])}
    options = {"method": method, **PLAIN}
    whole = slipfit.fit_batch(traces[:1], frequency_hz=5.0, min_amplitude=0.2, **options)
    found = slipfit.fit_batch(table, frequency_hz="f", min_amplitude="m", **options)
    for name in ("decay_rate_per_s", "sliding_rate", "initial_amplitude", "samples"):
        assert found[name][1] == pytest.approx(whole[name][0], rel=1e-6)
        assert found[name][2] == pytest.approx(slipfit.fit_batch(traces[:1], frequency_hz=5.0, **options)[name][0], rel=1e-6)
    assert np.isnan(found["friction_displacement"]).tolist() == [False, True, False, True]
    assert found["status"].tolist()[1:] == ["warned", "warned", "failed"]
    assert "no_frequency" in found["reason"][1].split() and "no_min_amplitude" not in found["reason"][1]
    assert "no_min_amplitude" in found["reason"][2].split() and "no_frequency" not in found["reason"][2]
    assert "no_" not in found["reason"][0] and "frequency_hz = -1" in found["reason"][3]
    # The same of rows that are fitted side by side.
    beside = slipfit.fit_batch(table, frequency_hz="f", **options)
    assert "no_frequency" in beside["reason"][1].split() and beside["decay_rate_per_s"][1] == pytest.approx(beside["decay_rate_per_s"][0], rel=1e-6)
    assert np.isnan(beside["friction_displacement"]).tolist() == [False, True, False, True]
