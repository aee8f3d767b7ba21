"""Whatever is given to a public function, its errors are those of slipfit and speak of its arguments."""

import importlib
import inspect
import io

import numpy as np
import pytest
import slipfit
from hypothesis import given, settings
from hypothesis import strategies as st

pa = pytest.importorskip("pyarrow")

TIME = 0.02 * np.arange(400)
SWING = slipfit.simulate.decay(
    frequency_hz=1.2, q_factor=30, friction_displacement=0.01, amplitude=0.4, duration_s=8, rate_hz=50, unit="rad"
)
ROWS = b"t (s),x (mm)\n" + b"".join(b"%.2f,%.4f\n" % (0.1 * i, 5 * 0.98**i * (-1) ** i) for i in range(60))
CURVE = b"f (Hz),R (mm)\n" + b"".join(b"%d,%.4f\n" % (f, 1 / (1 + 0.1 * (f - 20) ** 2)) for f in range(40))
LEVELS = b"drive (V),A (mm)\n1,0.1\n2,0.9\n3,2.1\n4,3\n5,4.1\n"
HZ, RESPONSE = slipfit.read_curve(CURVE).frequency_hz, slipfit.read_curve(CURVE).amplitude
TRACE = np.exp(-TIME) - 0.1 * (1 - np.exp(-TIME))
OSCILLATOR = {"frequency_hz": 1.0, "q_factor": 20.0}

#: A call of each public function that is answered.
CALLS = {
    "read": {"source": ROWS},
    "read_curve": {"source": CURVE},
    "read_levels": {"source": LEVELS},
    "ringdown": {"time": SWING.time_s, "signal": SWING.signal},
    "resonance": {"frequency": HZ, "response": RESPONSE},
    "levels": {"drive": [1, 2, 3, 4, 5], "amplitude": [0.1, 0.9, 2.1, 3, 4.1]},
    "series": {"measurements": [slipfit.Measurement(SWING)]},
    "Measurement": {"data": SWING},
    "fit_batch": {"table": pa.table({"a": [TRACE]}), "amplitude": "a", "dt": 0.02},
    "fit_stream": {"table": pa.table({"a": [TRACE]}), "amplitude": "a", "dt": 0.02},
    "fit_envelope": {
        "time": TIME, "amplitude": TRACE, "initial_amplitude": 1, "offset_amplitude": 0, "decay_rate_per_s": 1,
    },
    "fit_waveform": {"time": SWING.time_s, "signal": SWING.signal, "initial_amplitude": 0.4, "frequency_hz": 1.2},
    "fit_resonance": {"frequency": HZ, "response": RESPONSE},
    "fit_map": {"stack": TRACE.reshape(1, 1, -1), "dt": 0.02},
    "plot_map": {"found": slipfit.fit_map(TRACE.reshape(1, 1, -1), 0.02)},
    "simulate.decay": {**OSCILLATOR, "amplitude": 1, "duration_s": 9, "rate_hz": 9},
    "simulate.driven": {**OSCILLATOR, "drive_amplitude": 1, "duration_s": 9, "rate_hz": 9},
    "simulate.sweep": {**OSCILLATOR, "drive_amplitude": 1, "frequencies_hz": [0.9, 1.0]},
    "simulate.levels": {**OSCILLATOR, "drive_amplitudes": [0.9, 1.0]},
}  # fmt: skip

WRONG = [
    object(), None, True, 3, -3, 10**400, 2.5, -2.5, float("nan"), float("inf"), 1e300, "", "word", "\ud800", "\0", b"bytes",
    [], [1, 2], [1, "a"], (1.0, 2.0), (2.0, 1.0), (1, 2, 3), ["a"], {}, {"a": 1}, {1}, np.zeros((2, 2)), np.array(3), 1j, len,
]  # fmt: skip


def public(name):
    found = slipfit
    for part in name.split("."):
        found = getattr(found, part)
    return found


PARAMETERS = [(name, option) for name in CALLS for option in inspect.signature(public(name)).parameters]


def failed(name, arguments):
    """The error of a call, once it is known to be one that speaks of its arguments."""
    function = public(name)
    try:
        function(**arguments)
    except OSError:
        return None
    except slipfit.SlipfitError as error:
        options = inspect.signature(function).parameters
        option = getattr(error, "option", None)
        assert option is None or option in options, (option, str(error))
        assert option is None or hasattr(error, "value") or option not in arguments, str(error)
        for hint in error.hints:
            assert hint.option is None or hint.option in options, hint
        assert error.code not in ("", "internal"), str(error)
        return error
    return None


def test_every_public_function_is_walked():
    functions = {n for n in slipfit.__all__ if inspect.isfunction(getattr(slipfit, n))}
    functions |= {f"simulate.{n}" for n in slipfit.simulate.__all__}
    assert functions == set(CALLS) - {"Measurement"}
    for name, arguments in CALLS.items():
        assert failed(name, arguments) is None, name


@pytest.mark.parametrize(("name", "option"), PARAMETERS)
def test_an_argument_of_another_type_is_refused_by_name(name, option, monkeypatch, tmp_path):
    # Where folders may be made.
    monkeypatch.chdir(tmp_path)
    thing = object()
    error = failed(name, {**CALLS[name], option: thing})
    assert isinstance(error, slipfit.OptionTypeError)
    assert isinstance(error, TypeError)
    assert error.option == option
    assert error.value is thing
    for value in WRONG:
        if option != "progress" or value is not len:
            failed(name, {**CALLS[name], option: value})


#: What a call may take long for, what runs code of its own, what may be a file.
LONG = ("duration_s", "rate_hz", "wait_s", "progress", "resume", "source", "time")


@settings(max_examples=200, deadline=None)
@given(
    st.sampled_from([one for one in PARAMETERS if one[1] not in LONG]),
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9) | st.binary(max_size=9)
    | st.lists(st.integers() | st.floats() | st.text(max_size=3), max_size=4)
    | st.dictionaries(st.text(max_size=3), st.integers(), max_size=2) | st.builds(object),
)  # fmt: skip
def test_no_value_does_more_than_raise(parameter, value):
    name, option = parameter
    error = failed(name, {**CALLS[name], option: value})
    if isinstance(error, slipfit.OptionTypeError):
        assert error.option == option
        assert error.value is value


STILL = b"t (s),x (m)\n" + b"".join(b"%.1f,1\n" % (0.1 * i) for i in range(60))
BACK = b"t (s),x (m)\n" + b"".join(b"%.1f,%d\n" % (6 - 0.1 * i, i % 3) for i in range(60))
ONE_FREQUENCY = b"f (Hz),R (mm)\n" + b"".join(b"5,%d\n" % (1 + i % 2) for i in range(40))
FLAT = b"f (Hz),R (mm)\n" + b"".join(b"%d,%d\n" % (i, 1 + i % 2) for i in range(40))
SHIFTS = b"f (Hz),R (mm)\n" + b"".join(b"%d,%d\n" % (i - 5, i) for i in range(40))
NOISE = np.random.default_rng(1).standard_normal(400)
FEW = pa.table({"a": [[1.0]]})


@pytest.mark.parametrize(
    ("name", "arguments", "option"),
    [
        ("read", {"source": STILL}, None),
        ("read", {"source": BACK}, None),
        ("read", {"source": ROWS, "time": "z"}, "time"),
        ("read", {"source": ROWS, "time_unit": "z"}, "time_unit"),
        ("read", {"source": ROWS, "rate_hz": 0}, "rate_hz"),
        ("read", {"source": ROWS, "part": 3}, "part"),
        ("read", {"source": ROWS, "most_samples": -1}, "most_samples"),
        ("read", {"source": ROWS, "format": "z"}, "format"),
        ("read", {"source": ROWS, "unit": "\ud800"}, "unit"),
        ("read_curve", {"source": SHIFTS}, None),
        ("read_curve", {"source": CURVE, "frequency_unit": "z"}, "frequency_unit"),
        ("read_curve", {"source": []}, "source"),
        ("read_levels", {"source": STILL}, None),
        ("ringdown", {"time": STILL}, None),
        ("ringdown", {"time": BACK}, None),
        ("ringdown", {"time": TIME, "signal": NOISE}, None),
        ("ringdown", {"time": TIME, "signal": NOISE[1:]}, "signal"),
        ("ringdown", {"time": TIME[::-1], "signal": NOISE}, "time"),
        ("ringdown", {"signal": NOISE, "rate_hz": -5}, "rate_hz"),
        ("ringdown", {"time": SWING, "start_s": 20}, "start_s"),
        ("ringdown", {"time": SWING, "start_s": 7.9}, None),
        ("ringdown", {"time": SWING, "band_hz": (300, 400)}, "band_hz"),
        ("ringdown", {"time": SWING, "lockin_time_constant_s": -1, "lockin_order": 2}, "lockin_time_constant_s"),
        ("ringdown", {"time": SWING, "lockin_time_constant_s": 1, "lockin_order": 20}, "lockin_order"),
        ("ringdown", {"time": SWING, "lockin_time_constant_s": 1}, "lockin_order"),
        ("ringdown", {"time": SWING, "stiffness": 2}, "stiffness"),
        ("ringdown", {"time": SWING, "torsion_stiffness": -2}, "torsion_stiffness"),
        ("ringdown", {"time": SWING, "inertia": (2, -1)}, "inertia"),
        ("ringdown", {"time": SWING, "min_amplitude": 9}, "min_amplitude"),
        ("resonance", {"frequency": FLAT}, None),
        ("resonance", {"frequency": ONE_FREQUENCY}, None),
        ("resonance", {"frequency": SHIFTS}, None),
        ("resonance", {"frequency": HZ, "response": np.ones(len(HZ))}, None),
        ("resonance", {"frequency": HZ, "response": RESPONSE[1:]}, "response"),
        ("resonance", {"frequency": HZ, "response": -RESPONSE}, "response"),
        ("resonance", {"frequency": HZ[:4], "response": RESPONSE[:4]}, None),
        ("resonance", {"frequency": HZ, "response": RESPONSE, "std_error": -RESPONSE}, "std_error"),
        ("resonance", {"frequency": HZ, "response": RESPONSE, "drive": -RESPONSE}, "drive"),
        ("resonance", {"frequency": HZ, "response": RESPONSE, "drive_amplitude": (1, -1)}, "drive_amplitude"),
        ("resonance", {"frequency": HZ, "response": RESPONSE, "method": "paper"}, "drive_amplitude"),
        ("resonance", {"frequency": HZ, "response": RESPONSE, "mass": -1}, "mass"),
        ("levels", {"drive": STILL}, None),
        ("levels", {"drive": [1, 2, 3, 4], "amplitude": [4, 3, 2, 1]}, None),
        ("levels", {"drive": [1, 2, 3, -4], "amplitude": [1, 2, 3, 4]}, "drive"),
        ("levels", {"drive": [1, 2, 3, 4], "amplitude": [1, 2, 3, 4], "q_factor": 9, "drive_gain": 3}, "q_factor"),
        ("series", {"measurements": [slipfit.Measurement(SWING)], "mass": 1, "inertia": 1}, "inertia"),
        ("series", {"measurements": [slipfit.Measurement(SWING)], "unit": "m"}, "measurements"),
        ("series", {"measurements": [slipfit.Measurement(SWING, options={"model": "glue"})]}, "measurements"),
        ("series", {"measurements": [slipfit.Measurement(slipfit.read(ROWS), options={"start_s": 5.8})]}, None),
        ("series", {"measurements": [3]}, "measurements"),
        ("Measurement", {"data": SWING, "options": {"lockin_order": 2.0}}, "options"),
        ("Measurement", {"data": SWING, "options": {"colour": 2.0}}, "options"),
        ("Measurement", {"data": SWING, "scale": -5}, "scale"),
        ("Measurement", {"data": SWING, "value": float("nan")}, "value"),
        ("Measurement", {"data": SWING, "value": (1, -1)}, "value"),
        ("Measurement", {"data": SWING, "value": (1, float("inf"))}, "value"),
        ("fit_envelope", {**CALLS["fit_envelope"], "time": TIME * np.nan}, "time"),
        ("fit_envelope", {**CALLS["fit_envelope"], "amplitude": TRACE[1:]}, "amplitude"),
        ("fit_envelope", {**CALLS["fit_envelope"], "time": TIME[:3], "amplitude": TRACE[:3]}, None),
        ("fit_waveform", {**CALLS["fit_waveform"], "frequency_hz": -1}, "frequency_hz"),
        ("fit_waveform", {**CALLS["fit_waveform"], "signal": 0 * SWING.signal}, None),
        ("fit_resonance", {"frequency": HZ[:3], "response": RESPONSE[:3]}, None),
        ("fit_resonance", {"frequency": HZ, "response": RESPONSE, "drive_amplitude": -1}, "drive_amplitude"),
        ("fit_batch", {"table": FEW, "amplitude": "b", "dt": 1}, "amplitude"),
        ("fit_batch", {"table": FEW, "amplitude": "a", "dt": "c"}, "dt"),
        ("fit_batch", {"table": FEW, "amplitude": "a", "dt": 1, "keep": ["b"]}, "keep"),
        ("fit_batch", {"table": FEW, "amplitude": "a", "dt": 1, "method": "analyse", "lockin_order": 2}, "lockin_order"),
        ("fit_stream", {"table": FEW, "amplitude": "a", "dt": 1, "keep": "b"}, "keep"),
        ("fit_map", {"stack": np.zeros((2, 2, 9)), "dt": -1}, "dt"),
        ("fit_map", {"stack": np.zeros((2, 2, 9)), "dt": 1, "kind": "speed"}, "kind"),
        ("fit_map", {"stack": np.zeros((2, 2, 9), complex), "dt": 1}, "stack"),
        ("simulate.decay", {**CALLS["simulate.decay"], "amplitude": float("inf")}, "amplitude"),
        ("simulate.decay", {**CALLS["simulate.decay"], "duration_s": 1e-3}, "duration_s"),
        ("simulate.decay", {**CALLS["simulate.decay"], "frequency_hz": 1e50}, "frequency_hz"),
        ("simulate.decay", {**CALLS["simulate.decay"], "coulomb_force": 1}, "stiffness"),
        ("simulate.driven", {**CALLS["simulate.driven"], "drive_amplitude": 1e-200}, "drive_amplitude"),
        ("simulate.driven", {**CALLS["simulate.driven"], "drive_frequency_hz": 1e60}, "drive_frequency_hz"),
        ("simulate.driven", {**CALLS["simulate.driven"], "drive_frequency_hz": 30}, "drive_frequency_hz"),
        ("simulate.driven", {**CALLS["simulate.driven"], "frequency_hz": 30}, "frequency_hz"),
        ("simulate.driven", {**CALLS["simulate.driven"], "drive_off_s": -1}, "drive_off_s"),
        ("simulate.sweep", {**CALLS["simulate.sweep"], "drive_amplitude": -1}, "drive_amplitude"),
        ("simulate.sweep", {**CALLS["simulate.sweep"], "frequencies_hz": [-1.0]}, "frequencies_hz"),
        ("simulate.sweep", {**CALLS["simulate.sweep"], "frequencies_hz": [1e60]}, "frequencies_hz"),
        # A cycle of so slow a drive has as many stops as natural periods.
        ("simulate.sweep", {**CALLS["simulate.sweep"], "friction_displacement": 0.1, "frequencies_hz": [1e-9]}, "frequencies_hz"),
    ],
)
def test_errors_and_their_hints_name_arguments_of_the_call(name, arguments, option):
    error = failed(name, arguments)
    assert error is not None
    assert getattr(error, "option", None) == option, str(error)
    assert "--" not in str(error)
    assert "RATE" not in str(error)


def test_hints_about_files_name_what_reads_them():
    with pytest.raises(slipfit.ReadError, match=r"hint: slipfit.read\(…, signal=…\) names another column"):
        slipfit.ringdown(STILL)
    with pytest.raises(slipfit.NoAnswerError) as raised:
        slipfit.resonance(slipfit.read_curve(FLAT))
    assert "slipfit.read_curve(…, amplitude=…)" in str(raised.value)
    with pytest.raises(slipfit.OptionError) as raised:
        slipfit.ringdown(TIME, np.ones(400))
    assert raised.value.hints == ()


def test_what_another_analysis_takes_is_sent_there():
    curve, held = slipfit.read_curve(CURVE), slipfit.read_levels(LEVELS)
    for call, given, analysis in (
        (slipfit.ringdown, curve, "resonance"),
        (slipfit.ringdown, held, "levels"),
        (slipfit.resonance, SWING, "ringdown"),
        (slipfit.levels, SWING, "ringdown"),
        (slipfit.levels, curve, "resonance"),
    ):
        with pytest.raises(slipfit.OptionTypeError, match=f"slipfit.{analysis} takes it"):
            call(given)
    with pytest.raises(slipfit.OptionTypeError, match="columns is needed: frequency_hz, amplitude, phase_rad"):
        slipfit.ringdown(slipfit.simulate.sweep([1.0], frequency_hz=1, q_factor=9, drive_amplitude=1))
    with pytest.raises(slipfit.OptionError, match=r"band_hz=\(1.5, 1\): a rising pair"):
        slipfit.ringdown(SWING, band_hz=(1.5, 1))


def test_a_motion_at_rest_names_what_would_move_it():
    for name, option, more in (
        ("simulate.decay", "amplitude", {"friction_displacement": 2}),
        ("simulate.decay", "amplitude", {"amplitude": 0}),
        ("simulate.driven", "drive_amplitude", {"friction_displacement": 2}),
        ("simulate.driven", "drive_amplitude", {"friction_displacement": 2, "start": "steady"}),
    ):
        error = failed(name, {**CALLS[name], **more})
        assert type(error) is slipfit.OptionError
        assert error.option == option
        assert "at rest" in str(error)


@pytest.mark.parametrize(
    ("call", "option", "value"),
    [
        ("arrow.ringdown_files", "pattern", 5),
        ("arrow.ringdown_files", "threads", 2.5),
        ("daft.fit", "frame", 5),
        ("daft.ringdown_files", "pattern", 5),
        ("dask.fit", "frame", 5),
        ("duckdb.fit", "relation", 5),
        ("polars.fit", "frame", 5),
        ("spark.fit", "frame", 5),
        ("spark.ringdown_files", "pattern", 5),
    ],
)
def test_engines_refuse_what_they_cannot_take(call, option, value):
    engine, _, name = call.partition(".")
    function = getattr(importlib.import_module(f"slipfit.engines.{engine}"), name)
    others = {"pattern": "none"} if option == "threads" else {"spark": SPARK} if call == "spark.ringdown_files" else {}
    with pytest.raises(slipfit.OptionTypeError, match=option) as raised:
        function(**others, **{option: value})
    assert (raised.value.option, raised.value.value) == (option, value)


FRAMES = {
    "daft": lambda table: pytest.importorskip("daft").from_arrow(table),
    "dask": lambda table: pytest.importorskip("dask.dataframe").from_pandas(table.to_pandas(), npartitions=1),
    "duckdb": lambda table: pytest.importorskip("duckdb").connect().from_arrow(table),
    "polars": lambda table: pytest.importorskip("polars").from_arrow(table).lazy(),
}


@pytest.mark.parametrize("engine", FRAMES)
@pytest.mark.parametrize(
    ("options", "option"),
    [
        ({}, "amplitude"),
        ({"amplitude": "nothing", "dt": 1}, "amplitude"),
        ({"amplitude": "trace", "dt": "nothing"}, "dt"),
        ({"amplitude": "trace", "dt": 1, "keep": ["nothing"]}, "keep"),
        ({"amplitude": "trace", "dt": 0}, "dt"),
    ],
)
def test_engines_refuse_their_options_at_the_call(engine, options, option):
    frame = FRAMES[engine](pa.table({"id": [1, 2], "trace": [TRACE, TRACE]}))
    fit = importlib.import_module(f"slipfit.engines.{engine}").fit
    with pytest.raises(slipfit.OptionError) as raised:
        fit(frame, **options)
    assert raised.value.option == option
    if "nothing" in str(options):
        assert "no column `nothing`; there are `id`, `trace`" in str(raised.value)


def test_counts_of_engines_are_above_zero(tmp_path):
    from slipfit.engines import arrow, duckdb

    (tmp_path / "swing.csv").write_bytes(ROWS)
    with pytest.raises(slipfit.OptionError, match="threads=0"):
        arrow.ringdown_files(f"{tmp_path}/*.csv", threads=0)
    with pytest.raises(TypeError, match="unexpected keyword argument 'losses'"):
        arrow.ringdown_files(f"{tmp_path}/*.csv", losses="viscous")
    relation = FRAMES["duckdb"](pa.table({"trace": [TRACE]}))
    for rows in (0, -1):
        with pytest.raises(slipfit.OptionError, match="rows="):
            duckdb.fit(relation, rows=rows, amplitude="trace", dt=1)


class SparkSession:
    """Stands for Spark's, which the tests do without."""


SPARK = SparkSession()


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("rate", "rate_hz"), ("fs", "rate_hz"), ("dt", "rate_hz=1/dt"), ("units", "unit"), ("band", "band_hz"),
        ("quadratur", "quadrature"), ("colour", None),
    ],
)  # fmt: skip
def test_a_near_keyword_names_the_one_that_is_meant(name, meant):
    words = f"unexpected keyword argument '{name}'" + (f"; did you mean {meant}\\?" if meant else "$")
    with pytest.raises(TypeError, match=words):
        slipfit.ringdown(TIME, SWING.signal, **{name: 2})


def test_what_is_no_file_says_what_is():
    for call in (slipfit.read, slipfit.ringdown, slipfit.read_curve, slipfit.resonance, slipfit.levels):
        with pytest.raises(slipfit.OptionError, match="text of 61 lines, no path: give its bytes") as raised:
            call(ROWS.decode())
        assert len(str(raised.value)) < 120
    for call in (slipfit.read, slipfit.ringdown, slipfit.read_levels):
        with pytest.raises(slipfit.OptionTypeError, match=r"give its bytes, \w+.getvalue\(\)"):
            call(io.BytesIO(ROWS))
    with pytest.raises(slipfit.OptionError, match="signal=z.real, quadrature=z.imag"):
        slipfit.ringdown(TIME, NOISE * 1j)
    with pytest.raises(slipfit.OptionError, match="signal is missing; if this is the signal, give rate_hz"):
        slipfit.ringdown(NOISE)
    with pytest.raises(slipfit.OptionError, match="amplitude='a' and signal='a': one of them is needed"):
        slipfit.fit_batch(FEW, amplitude="a", signal="a", dt=1)


def test_times_in_disorder_name_what_helps_here():
    disorder = np.random.default_rng(2).permutation(TIME)
    with pytest.raises(slipfit.OptionError) as raised:
        slipfit.ringdown(disorder, NOISE)
    assert str(raised.value).endswith("hint: rate_hz replaces these times")
    # As the hint says.
    assert failed("ringdown", {"signal": SWING.signal, "rate_hz": 50.0}) is None
    with pytest.raises(slipfit.ReadError, match="hint: time names another column; rate_hz replaces these times"):
        slipfit.read(BACK)


def test_amplitudes_that_nobody_called_so_name_the_kind():
    amplitudes = np.exp(-0.5 * TIME)
    with pytest.raises(slipfit.NoAnswerError, match='hint: kind="envelope" takes them as amplitudes') as raised:
        slipfit.ringdown(TIME, amplitudes)
    (hint, *_) = raised.value.hints
    answer = slipfit.ringdown(TIME, amplitudes, **{hint.option: hint.value})
    assert answer.parameters.decay_rate_per_s.value == pytest.approx(0.5, 1e-3)
    text = b"t (s),x (m)\n" + b"".join(b"%.2f,%.9f\n" % row for row in zip(TIME, amplitudes))
    # A record has the kind that it was read with.
    with pytest.raises(slipfit.NoAnswerError, match=r'hint: slipfit.read\(…, kind="envelope"\) takes them as amplitudes'):
        slipfit.ringdown(slipfit.read(text))
    with pytest.raises(slipfit.NoAnswerError, match='hint: kind="envelope" takes them'):
        slipfit.ringdown(text)
