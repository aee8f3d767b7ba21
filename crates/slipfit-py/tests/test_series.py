"""Series of arrays, records and answers, each with its condition."""

import numpy as np
import pytest
import slipfit

SWING = {"frequency_hz": 1.2, "q_factor": 80, "amplitude": 0.4, "duration_s": 40, "rate_hz": 50, "noise_rms": 5e-4}
FRICTION = {5: 1e-3, 10: 2e-3, 15: 3e-3}


@pytest.fixture(scope="module")
def records():
    """Records at three loads."""
    return {load: slipfit.simulate.decay(**SWING, friction_displacement=x, unit="rad") for load, x in FRICTION.items()}


@pytest.fixture(scope="module")
def expected(records):
    measured = [slipfit.Measurement(record, f"{load} N", value=load) for load, record in records.items()]
    return slipfit.series(measured, condition="load", condition_unit="N")


def rows(series):
    return [(row.condition, row.value, row.ringdown) for row in series.table]


def test_arrays_are_measurements(records, expected):
    pandas, xarray = pytest.importorskip("pandas"), pytest.importorskip("xarray")
    polars = pytest.importorskip("polars")
    load = {"condition": "load", "condition_unit": "N"}
    pairs = {at: (one.time_s, one.signal) for at, one in records.items()}
    forms = {
        "pairs": pairs,
        "records": records,
        "Series": {at: pandas.Series(x, index=t) for at, (t, x) in pairs.items()},
        "DataArray": {at: xarray.DataArray(x, dims="t", coords={"t": t}, attrs={"units": "rad"}) for at, (t, x) in pairs.items()},
        "pandas": {at: pandas.DataFrame({"time (s)": t, "angle (rad)": x}) for at, (t, x) in pairs.items()},
        "turned": {at: pandas.DataFrame({"angle (rad)": x, "time (s)": t}) for at, (t, x) in pairs.items()},
        "polars": {at: polars.DataFrame({"t (ms)": 1e3 * t, "angle (rad)": x}) for at, (t, x) in pairs.items()},
    }
    for form, measurements in forms.items():
        found = slipfit.series(measurements, **load, unit="rad")
        for one, other in zip(rows(found), rows(expected), strict=True):
            assert one[:2] == other[:2], form
            assert float(one[2].friction) == pytest.approx(float(other[2].friction), rel=1e-9), form
    listed = [slipfit.Measurement(pair, value=at, options={"unit": "rad"}) for at, pair in pairs.items()]
    assert rows(slipfit.series(listed, **load)) == rows(expected)
    assert [one.name for one in slipfit.series(pairs).measurements] == ["arrays", "arrays (2)", "arrays (3)"]


def test_labels_and_values_of_conditions_are_keys(records):
    first, second, third = records.values()
    found = slipfit.series({"dry": first, (7.0, 0.5): second, 9: slipfit.Measurement(third, name="third")})
    assert [(row.condition, row.value) for row in found.table] == [("dry", None), ("7", 7.0), ("9", 9.0)]
    assert found.table[1].value_std_error == 0.5
    assert found.measurements[2].name == "third"
    with pytest.raises(slipfit.OptionError, match="it has a condition, and is given under another") as raised:
        slipfit.series({"wet": slipfit.Measurement(first, "dry")})
    assert raised.value.option == "measurements"


def test_measurements_without_a_label_are_told_by_their_values(records):
    """They were averaged as one condition."""
    first, second, _ = records.values()
    found = slipfit.series([slipfit.Measurement(first, value=5), slipfit.Measurement(second, value=10)], condition_unit="N")
    assert [(row.condition, row.value) for row in found.table] == [("5 N", 5.0), ("10 N", 10.0)]
    assert slipfit.series([first]).table[0].condition == "(none)"
    with pytest.raises(slipfit.OptionError, match="condition 'a' has the values 5 and 10: one label is one condition") as raised:
        slipfit.series([slipfit.Measurement(first, "a", value=5), slipfit.Measurement(second, "a", value=10)])
    assert raised.value.option == "measurements"
    again = slipfit.series([slipfit.Measurement(first, "a", value=5), slipfit.Measurement(second, "a", value=5)])
    assert len(again.table) == 1


def test_answers_are_measurements(records, expected, sweep):
    answers = {load: slipfit.ringdown(record) for load, record in records.items()}
    found = slipfit.series(answers, condition="load", condition_unit="N")
    assert rows(found) == rows(expected)
    # Their options go with them, their forces do not.
    late = slipfit.ringdown(records[5], start_s=2, end_s=30, torsion_stiffness=0.02)
    given = slipfit.Measurement(records[5], options={"start_s": 2, "end_s": 30})
    assert rows(slipfit.series([late])) == rows(slipfit.series([given]))
    curve = slipfit.resonance(*sweep, drive_amplitude=1.0, unit="mm")
    drive = np.arange(0.1, 1.3, 0.1)
    levels = slipfit.levels(drive, np.maximum(40 * (drive - 0.35), 0) + 0.02 * (np.arange(12) * 7 % 5), unit="mm", drive_unit="mm")
    both = slipfit.series([curve, levels])
    assert [one.kind for one in both.measurements] == ["sweep", "levels"]
    for wrong, words in (
        (lambda: slipfit.Measurement(curve, options={"model": "viscous"}), "options is given beside an answer"),
        (lambda: slipfit.Measurement(both), "each is needed by itself"),
        (lambda: slipfit.Measurement(curve, analysis="levels"), "analysis='levels' beside data for slipfit.resonance"),
    ):
        with pytest.raises(slipfit.OptionError, match=words):
            wrong()


def test_a_pickled_answer_holds_no_measurement(answer):
    import pickle

    with pytest.raises(slipfit.OptionError, match="from a pickle") as raised:
        slipfit.Measurement(pickle.loads(pickle.dumps(answer)))
    assert raised.value.option == "data"


def test_curves_and_levels_are_told_by_their_analysis(sweep):
    hz, response = sweep
    options = {"unit": "mm", "drive_amplitude": 1.0}
    curve = slipfit.Measurement((hz, response), analysis="resonance", options=options)
    assert isinstance(curve.data, slipfit.Curve) and curve.data.unit == "mm" and curve.options == {"drive_amplitude": 1.0}
    alone = slipfit.resonance(hz, response, **options).parameters.friction_displacement
    found = slipfit.series([curve]).measurements[0].parameters.friction_displacement
    assert float(found) == alone.value
    phases = slipfit.Measurement(
        (hz, np.abs(response)), analysis="resonance", options={**options, "phase_rad": np.angle(response)}
    )
    assert phases.data.has_phase
    drive = np.arange(0.1, 1.3, 0.1)
    levels = slipfit.Measurement((drive, 40 * drive), analysis="levels", options={"unit": "nm", "drive_unit": "V"})
    assert isinstance(levels.data, slipfit.Levels) and levels.data.drive_unit == "V"
    simulated = slipfit.simulate.sweep(hz, frequency_hz=1, q_factor=50, friction_displacement=0.3, drive_amplitude=1)
    assert slipfit.Measurement(simulated).analysis == "resonance"
    for analysis in ("ringdown", None):
        with pytest.raises(slipfit.OptionError, match="^data: signal is complex") as raised:
            slipfit.Measurement((hz, response), analysis=analysis)
        assert raised.value.option == "data"


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ("swing.csv", "as slipfit.read, read_curve and read_levels give them"),
        (b"t,x\n1,2\n", "as slipfit.read, read_curve and read_levels give them"),
        (3, "are needed"),
        (None, "are needed"),
        (np.zeros(9), "are needed"),
        (([1, 2, 3],), "are needed"),
        ((np.arange(9.0)[::-1], np.arange(9)), "^data: .*time goes backwards"),
        (([1, 2, 3], [1, 2]), "^data: .*2 values where"),
        ((np.zeros((2, 2)), np.zeros((2, 2))), "^data: .*one dimension"),
    ],
)
def test_what_is_no_measurement_is_refused(data, words):
    with pytest.raises(slipfit.OptionError, match=words) as raised:
        slipfit.Measurement(data)
    assert raised.value.option == "data"
    if not isinstance(data, (str, bytes)):
        with pytest.raises(slipfit.OptionError, match="^measurement 1: ") as raised:
            slipfit.series([data])
        assert raised.value.option == "measurements"


def test_what_is_no_list_of_measurements_is_refused(swing):
    pandas = pytest.importorskip("pandas")
    time, signal = swing
    frame = pandas.DataFrame({"t": time, "x": signal})
    for wrong in ("swing.csv", b"bytes", ["swing.csv"], frame, frame["x"], 3, None):
        with pytest.raises(slipfit.OptionTypeError, match="several Measurements are needed"):
            slipfit.series(wrong)
    with pytest.raises(slipfit.OptionError, match="^measurement 1: .*are needed"):
        slipfit.series((time, signal))
    with pytest.raises(slipfit.OptionError, match="options: .*unit"):
        slipfit.Measurement((time, signal), options={"unit": 3})
    with pytest.raises(slipfit.OptionError, match="unexpected keyword argument 'drive_unit'"):
        slipfit.Measurement((time, signal), options={"drive_unit": "V"})
