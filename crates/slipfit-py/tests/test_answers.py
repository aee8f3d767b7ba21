"""Answers are objects with everything in them."""

import copy
import inspect
import json
import math
import pickle

import numpy as np
import pytest
import slipfit
from slipfit import _core


SWING = {"frequency_hz": 1.2, "q_factor": 80, "amplitude": 0.4, "duration_s": 40, "rate_hz": 50, "unit": "rad"}


def test_a_known_friction_is_found(answer):
    x_f = answer.parameters.friction_displacement
    assert abs(x_f.value - 0.002) < 4 * x_f.std_error
    assert x_f.interval_95[0] < x_f.value < x_f.interval_95[1]
    assert x_f.unit == "rad"
    assert float(x_f) == x_f.value
    assert answer.sliding.detected
    assert answer.sliding["detected"] is True
    assert answer.model == "viscous+sliding"
    assert answer.preferred_model == "viscous+sliding"
    assert -1 <= answer.correlation("decay_rate_per_s", "friction_displacement") <= 1
    assert answer.correlation("decay_rate_per_s", "slope") is None
    with pytest.raises(KeyError, match="no parameter 'decay_rate'; there are"):
        answer.correlation("decay_rate", "friction_displacement")
    assert answer.second_mode is None and answer.sensor_curve is None


def test_parameters_are_items_and_attributes(answer):
    parameters = answer.parameters
    assert parameters["q_factor"] == parameters.q_factor
    assert list(parameters) == list(answer.to_dict()["parameters"])
    assert "q_factor" in dir(parameters)
    with pytest.raises(AttributeError, match="no parameter 'slope'.*friction_displacement"):
        parameters.slope
    with pytest.raises(KeyError, match="no parameter 'slope'; there are frequency_hz"):
        parameters["slope"]
    with pytest.raises(KeyError, match="no value 'slope'; there are start_s"):
        answer.segment["slope"]
    with pytest.raises(KeyError, match="no column 'slope'; there are time_s"):
        answer.envelope["slope"]
    assert parameters.get("slope") is None and "slope" not in answer.segment


@pytest.mark.parametrize(
    ("value", "std_error", "unit", "spec", "text"),
    [
        (0.0123456, 0.000789, "rad", "", "0.0123456 ± 0.00079 rad"),
        (0.0123456, 0.000789, "rad", ".3g", "0.0123 ± 0.000789 rad"),
        (0.0123456, 0.000789, "rad", "+.4f", "+0.0123 ± 0.0008 rad"),
        (0.0123456, 0.000789, "", ".1e", "1.2e-02 ± 7.9e-04"),
        (1234567.0, 89.0, "", ",.0f", "1,234,567 ± 89"),
        (0.0123456, 0.000789, "rad", "26", "   0.0123456 ± 0.00079 rad"),
        (0.0123456, 0.000789, "rad", "*<24.1u", "0.0123 ± 0.0008 rad*****"),
        (0.0123456, 0.000789, "rad", "^21.1u", " 0.0123 ± 0.0008 rad "),
        # To the digits of the error, which may round up into the next decade.
        (0.0123456, 0.000789, "rad", "u", "0.01235 ± 0.00079 rad"),
        (12.345, 0.0996, "s", ".2u", "12.35 ± 0.10 s"),
        (-12.345, 0.0996, "s", ".1u", "-12.3 ± 0.1 s"),
        (123456.0, 789.0, "", ".2u", "(1.2346 ± 0.0079)e+05"),
        (1.5e-9, 2.2e-11, "m", "+.1u", "(+1.50 ± 0.02)e-09 m"),
        (0.0, 2.2e-10, "m", ".2u", "(0.0 ± 2.2)e-10 m"),
        (1e-320, 1e-322, "m", ".1u", "(10.00 ± 0.10)e-321 m"),
        # Without an error there is nothing to round to.
        (1.5, 0.0, "mm", ".2u", "1.5 ± 0 mm"),
        (math.inf, math.nan, "", ".2u", "inf ± nan"),
    ],
)
def test_a_quantity_is_formatted_as_its_numbers(value, std_error, unit, spec, text):
    assert format(slipfit.Quantity(value, std_error, (0.0, 1.0), value, unit), spec) == text


@pytest.mark.parametrize("spec", ["d", "x", "08.3f", "=20", ".3s", "rad", "%d"])
def test_a_format_of_no_number_is_refused(answer, spec):
    with pytest.raises(ValueError, match="format"):
        format(answer.parameters.q_factor, spec)


def test_typed_names_are_all_parameters():
    assert set(slipfit.Parameters.__annotations__) == set(_core.parameter_names())


def test_infinite_values_stay_infinite():
    """JSON has null for them."""
    record = slipfit.simulate.decay(
        frequency_hz=1, friction_displacement=0.01, amplitude=1, duration_s=30, rate_hz=40
    )
    noise = 1e-3 * np.random.default_rng(3).standard_normal(len(record))
    answer = slipfit.ringdown(record.time_s, record.signal + noise)
    data = answer.to_dict()["parameters"]
    lost = [name for name, q in data.items() if None in (q["value"], q["std_error"], *q["interval_95"])]
    for name in lost:
        q = answer.parameters[name]
        assert any(math.isinf(v) for v in (q.value, q.std_error, *q.interval_95)), name
    assert lost, "a decay without viscous loss has an unbounded quality factor"


def test_columns_are_arrays(answer):
    envelope = answer.envelope
    assert envelope["used"].dtype == bool
    assert envelope.amplitude.dtype == np.float64
    assert len({len(column) for column in envelope.values()}) == 1
    assert np.nanmax(np.abs(envelope.fitted - envelope.amplitude)[envelope.used]) < 5e-3
    assert 0 < envelope.used.sum() < len(envelope.used)
    assert answer.loss.amplitude.shape == answer.loss.fitted.shape
    comparison = answer.comparison
    assert comparison.model[0] == "viscous+sliding"
    assert comparison.delta_bic[0] == 0
    with pytest.raises(AttributeError, match="no column 'nothing'"):
        comparison.nothing


def test_the_fit_follows_the_samples(answer, swing):
    fit = answer.fit
    within = np.isfinite(fit["fitted"])
    assert within.sum() >= answer.segment.samples
    np.testing.assert_array_equal(fit["time_s"], swing[0])
    np.testing.assert_array_equal(fit["signal"], swing[1])
    # White noise of 5e-4; the standard error of its estimate is below 3 % of it.
    assert abs(np.std((fit["signal"] - fit["fitted"])[within]) / 5e-4 - 1) < 0.1
    fit["signal"][:] = 0
    assert answer.fit["signal"].any(), "arrays are the caller's own"


def test_json_is_the_contract(answer, root):
    schema = json.loads((root / "docs/schema/ringdown-1.json").read_text())
    data = answer.to_dict()
    assert data["schema"] == "slipfit/ringdown-1"
    assert set(schema["required"]) <= set(data)


@pytest.mark.parametrize("name", ["ringdown", "resonance", "levels"])
def test_keywords_are_the_options_of_the_core(name, root):
    schema = json.loads((root / f"docs/schema/{name}-1.json").read_text())
    text = json.dumps(schema["properties"]["options"])
    options = schema["$defs"][text.split("#/$defs/")[1].split('"')[0]]["properties"]
    keywords = {
        n for n, p in inspect.signature(getattr(slipfit, name)).parameters.items() if p.kind == p.KEYWORD_ONLY
    }
    assert set(options) - {"calibration"} <= keywords
    assert {"stiffness", "mass", "torsion_stiffness", "inertia"} <= keywords


def test_an_answer_is_printed_and_shown(answer):
    text = str(answer)
    assert text.startswith("Sliding friction carries")
    assert "friction displacement   x_F" in text
    assert "\x1b" not in text
    assert answer.sentence.split()[0] == text.split()[0]
    assert repr(answer) == f"<RingdownAnswer: {answer.sentence}>"
    page = answer._repr_html_()
    assert page.startswith("<div") and "friction displacement" in page
    assert answer.to_svg().startswith("<svg") or answer.to_svg().startswith("<?xml")
    assert "time_s,amplitude" in answer.to_csv()


def test_answers_are_copied_pickled_and_compared(answer, swing):
    again = slipfit.ringdown(*swing, unit="rad")
    other = slipfit.ringdown(*swing, unit="mrad")
    assert answer == again and hash(answer) == hash(again)
    assert answer != other and answer != "an answer"
    for same in (copy.copy(answer), copy.deepcopy(answer), pickle.loads(pickle.dumps(answer))):
        assert same == answer
        assert type(same) is slipfit.RingdownAnswer
        assert same.parameters == answer.parameters
        assert str(same) == str(answer)
        np.testing.assert_array_equal(same.fit["fitted"], answer.fit["fitted"])
        assert same.warnings == answer.warnings
    # And once more from what has no live answer behind it.
    assert pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(answer)))) == answer
    for part in (answer.parameters, answer.sliding, answer.comparison):
        assert str(pickle.loads(pickle.dumps(part))) == str(part)


def test_warnings_have_codes_and_hints_in_python():
    time = np.arange(0, 20, 0.01)
    two = np.exp(-0.1 * time) * np.cos(2 * np.pi * 3 * time) + 0.3 * np.exp(-0.1 * time) * np.cos(
        2 * np.pi * 7.3 * time
    )
    noise = 1e-3 * np.random.default_rng(4).standard_normal(len(time))
    answer = slipfit.ringdown(time, two + noise)
    warning = next(w for w in answer.warnings if w.code == "several_modes")
    (hint,) = [h for h in warning.hints if h.option == "band_hz"]
    assert isinstance(hint.value, tuple) and hint.value[0] < 3 < hint.value[1] < 7.3
    assert hint.text.startswith("band_hz=(")
    assert "--" not in str(warning) and str(warning) in str(answer).replace("\n         ", " ")
    # The value of the hint can be given as it is.
    alone = slipfit.ringdown(time, two + noise, **{hint.option: hint.value})
    assert abs(alone.parameters.frequency_hz.value - 3) < 0.01


def test_parameters_as_a_dataframe(answer):
    pandas = pytest.importorskip("pandas")
    frame = answer.to_dataframe()
    assert isinstance(frame, pandas.DataFrame)
    assert frame.loc["friction_displacement", "value"] == answer.parameters.friction_displacement.value
    assert len(answer.comparison.to_dataframe()) == len(answer.comparison.model)


def test_answers_are_drawn(answer, sweep):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    _, ax = plt.subplots()
    assert answer.plot(ax) == [ax]
    assert ax.get_xlabel() == "time [s]" and ax.get_ylabel() == "amplitude [rad]"
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["measured", "not used", "viscous+sliding"]
    assert len(answer.plot()) == 4
    curve = slipfit.resonance(*sweep, drive_amplitude=1.0, unit="mm")
    assert len(curve.plot()) == 2
    drive = np.arange(0.1, 1.3, 0.1)
    levels = slipfit.levels(drive, np.maximum(40 * (drive - 0.35), 0) + 0.02 * (np.arange(12) * 7 % 5))
    assert len(levels.plot()) == 1
    assert "without friction" in [line.get_label() for line in curve.plot()[0].lines]
    for number in plt.get_fignums():
        plt.figure(number).canvas.draw()
    series = slipfit.series([slipfit.Measurement(slipfit.simulate.decay(**SWING))])
    for drawn in (answer, curve, levels, series):
        for wrong in (5, "ax", [ax], np.array([ax]), plt.figure()):
            with pytest.raises(slipfit.OptionTypeError, match="matplotlib Axes are needed") as raised:
                drawn.plot(wrong)
            assert raised.value.option == "ax" and raised.value.value is wrong
    plt.close("all")


def test_resonance_with_phases(sweep):
    answer = slipfit.resonance(*sweep, drive_amplitude=1.0, unit="mm")
    x_f = answer.parameters.friction_displacement
    assert abs(x_f.value - 0.3) < 4 * x_f.std_error + 1e-3
    assert (answer.method, answer.drive_source) == ("exact", "known")
    assert answer.curve.phase_rad.shape == (81,)
    assert answer.fit["frequency_hz"][0] == pytest.approx(0.9)
    assert answer.instrument.delay_s is None or answer.instrument["delay_s"]
    amplitudes = slipfit.resonance(sweep[0], np.abs(sweep[1]), phase_rad=np.angle(sweep[1]), drive_amplitude=1.0)
    assert amplitudes.parameters.friction_displacement.value == pytest.approx(x_f.value, rel=1e-6)
    assert slipfit.resonance(*sweep, reference=None, method="paper", drive_amplitude=1).method == "paper"


def test_levels_find_the_threshold():
    drive = np.arange(0.1, 1.3, 0.1)
    amplitude = np.maximum(40 * (drive - 0.35), 0) + 0.02 * (np.arange(12) * 7 % 5)
    answer = slipfit.levels(drive, amplitude, unit="mm", drive_unit="mm", frequency_hz=3)
    assert abs(answer.parameters.threshold.value - 0.35) < 0.01
    assert answer.detected and answer.p_value < 0.01
    assert answer.levels.moving.sum() >= 8
    assert answer.breakaway.moving_from == pytest.approx(0.4)
    assert "decay_rate_per_s" in answer.parameters


def test_a_series_compares_ringdown_and_resonance(swing):
    pytest.importorskip("pandas")
    record = slipfit.read(np_bytes(swing), "swing.npy", time=1, signal=2, unit="rad")
    answer = slipfit.series([slipfit.Measurement(record, "10 N", value=10)], condition="load")
    assert answer.table[0].condition == "10 N"
    assert answer.measurements[0].name == "swing.npy"
    frame = answer.to_dataframe()
    assert set(frame["by"]) >= {"ringdown"}
    assert pickle.loads(pickle.dumps(answer)) == answer


def np_bytes(columns):
    """The bytes of an NPY file."""
    import io

    held = io.BytesIO()
    np.save(held, np.column_stack(columns))
    return held.getvalue()


def test_tables_and_bare_fits_are_compared(swing):
    one, other = (slipfit.ringdown(*swing, unit="rad").comparison for _ in range(2))
    assert one == other
    shorter = [column[:1500] for column in swing]
    assert one != slipfit.ringdown(*shorter, unit="rad").comparison
    t = 0.01 * np.arange(120)
    fits = [
        slipfit.fit_envelope(t, np.exp(-t), initial_amplitude=1, offset_amplitude=0, decay_rate_per_s=start)
        for start in (0.9, 0.9)
    ]
    assert fits[0] == fits[1]
    assert hash(fits[0]) == hash(fits[1])


def test_a_table_is_no_array_of_its_names(answer):
    """NumPy and pandas would go through a mapping and find its keys."""
    pd = pytest.importorskip("pandas")
    for made in (np.asarray, np.array, pd.DataFrame):
        with pytest.raises(slipfit.OptionTypeError, match="to_dataframe"):
            made(answer.comparison)
    assert list(answer.comparison.to_dataframe()) == list(answer.comparison) == list(dict(answer.comparison))


def test_sections_are_the_callers_own(swing):
    answer = slipfit.ringdown(*swing, unit="rad", law="free")
    law = answer.free_law
    assert law.curve.amplitude.shape == law.curve.loss_per_cycle.shape
    assert law.limit.interval_95[0] < law.limit.value == answer.to_dict()["free_law"]["limit"]["value"]
    assert len(repr(law)) < 1000
    law.curve.amplitude[:] = -1
    law.limit.interval_95[0] = -1
    assert answer.free_law.curve.amplitude.min() >= 0
    assert answer.free_law.limit.interval_95[0] == answer.to_dict()["free_law"]["limit"]["interval_95"][0]
    for same in (copy.deepcopy(answer.free_law), pickle.loads(pickle.dumps(answer.free_law))):
        assert same == answer.free_law


def test_a_parameter_is_given_on_with_its_error(swing, answer):
    drive = np.arange(0.1, 1.3, 0.1)
    amplitude = np.maximum(40 * (drive - 0.35), 0) + 0.02 * (np.arange(12) * 7 % 5)
    q = answer.parameters.q_factor
    given = slipfit.levels(drive, amplitude, unit="rad", q_factor=q)
    assert given == slipfit.levels(drive, amplitude, unit="rad", q_factor=(q.value, q.std_error))
    assert given != slipfit.levels(drive, amplitude, unit="rad", q_factor=q.value)
    k = slipfit.Quantity(2, 0.1, (1.8, 2.2), 2, "N m/rad")
    wide = slipfit.ringdown(*swing, unit="rad", torsion_stiffness=k).parameters.coulomb_force
    exact = slipfit.ringdown(*swing, unit="rad", torsion_stiffness=k.value).parameters.coulomb_force
    assert wide.std_error > exact.std_error
    measured = slipfit.Measurement(slipfit.simulate.decay(**SWING), value=q)
    assert slipfit.series([measured]).table[0].value == q.value


HOSTILE = "<script>alert(1)</script>"


def test_names_and_units_are_no_markup():
    record = slipfit.simulate.decay(**{**SWING, "unit": HOSTILE})
    sweep = slipfit.simulate.sweep(
        np.linspace(0.9, 1.1, 41), frequency_hz=1, q_factor=50, friction_displacement=0.3, drive_amplitude=1
    )
    drive = np.arange(0.1, 1.3, 0.1)
    answers = [
        slipfit.ringdown(record),
        slipfit.resonance(sweep.frequency_hz, sweep.amplitude, drive_amplitude=1, unit=HOSTILE),
        slipfit.levels(drive, np.maximum(40 * (drive - 0.35), 0), unit=HOSTILE, drive_unit=HOSTILE),
        slipfit.series(
            [slipfit.Measurement(record, HOSTILE, name=HOSTILE)], title=HOSTILE, condition=HOSTILE,
            condition_unit=HOSTILE,
        ),
    ]  # fmt: skip
    for answer in answers:
        for page in (answer._repr_html_(), answer.to_svg()):
            assert "<script" not in page, type(answer).__name__
        assert HOSTILE in answer.to_json()


def test_an_answer_serves_many_threads(swing):
    import threading

    answer = slipfit.ringdown(*swing, unit="rad")
    begun, found = threading.Barrier(8), []

    def look():
        begun.wait()
        found.append((str(answer), answer._repr_html_(), hash(answer), answer.parameters, answer.fit, answer.warnings))

    threads = [threading.Thread(target=look) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 8 and all(one == found[0] for one in found)


@pytest.mark.parametrize("kind", [slipfit.Record, slipfit.Curve, slipfit.Levels, slipfit.ArrowTable, slipfit.RingdownAnswer])
def test_every_attribute_says_what_it_is(kind):
    for name in dir(kind):
        assert name.startswith("_") or inspect.getdoc(getattr(kind, name)), name


def test_parameters_go_on_as_docs_python_says(answer):
    uncertainties = pytest.importorskip("uncertainties")
    decay_rate, x_f = answer.parameters.decay_rate_per_s, answer.parameters.friction_displacement
    assert float(x_f) == x_f.value
    assert np.array([decay_rate, x_f], float).tolist() == [decay_rate.value, x_f.value]
    r = answer.correlation("decay_rate_per_s", "friction_displacement")
    pairs = [(q.value, q.std_error) for q in (decay_rate, x_f)]
    d, x = uncertainties.correlated_values_norm(pairs, [[1, r], [r, 1]])
    ratio = x / d
    # More together makes less of a ratio.
    alone = uncertainties.ufloat(*pairs[1]) / uncertainties.ufloat(*pairs[0])
    assert ratio.n == alone.n and (ratio.s < alone.s) == (r > 0)
    with pytest.raises(TypeError):
        x_f / decay_rate


def test_a_series_has_quantities_as_other_answers_have():
    pandas, plt = pytest.importorskip("pandas"), pytest.importorskip("matplotlib.pyplot")
    swings = [slipfit.simulate.decay(**SWING, friction_displacement=x, noise_rms=5e-4) for x in (1e-3, 2e-3, 3e-3)]
    loads = [(5, 0.1), (10, 0.1), (15, 0.1)]
    measured = [slipfit.Measurement(one, f"{at[0]} N", value=at) for one, at in zip(swings, loads)]
    answer = slipfit.series(measured, condition="load", condition_unit="N")
    friction = answer.table[1].ringdown.friction
    quantity = slipfit.Quantity(
        friction.value, friction.std_error, tuple(friction.interval_95), friction.unbounded_value, "rad"
    )
    for spec in ("", ".3g", ".2u", ">40.1e"):
        assert format(friction, spec) == format(quantity, spec)
    assert str(friction) == str(quantity) and float(friction) == friction["value"] == quantity.value
    assert "±" in f"{answer.laws[0].coefficient:.2u}" and "±" in f"{answer.measurements[0].parameters.q_factor:u}"
    with pytest.raises(ValueError, match="format"):
        format(friction, "d")
    for same in (copy.deepcopy(friction), pickle.loads(pickle.dumps(friction))):
        assert same == friction and f"{same:u}" == f"{friction:u}"
    # A quantity of one answer goes on to another.
    turned = {**SWING, "unit": "mrad", "amplitude": 400}
    given = slipfit.simulate.decay(**turned, friction_displacement=friction)
    assert given == slipfit.simulate.decay(**turned, friction_displacement=friction.value * 1e3)
    frame = answer.to_dataframe()
    assert list(frame)[:5] == ["condition", "condition_value", "condition_std_error", "by", "quantity"]
    chosen = frame[(frame.by == "ringdown") & (frame.quantity == "friction")]
    assert chosen.condition_value.tolist() == [5, 10, 15] and set(chosen.condition_std_error) == {0.1}
    assert isinstance(frame, pandas.DataFrame) and list(slipfit.series([measured[0]]).to_dataframe()) == list(frame)
    left, right = answer.plot()
    assert left.get_xlabel() == "load [N]" and left.get_ylabel() == "friction [rad]" and "1/s" in right.get_ylabel()
    assert left.dataLim.x0 == pytest.approx(4.9) and left.dataLim.x1 == pytest.approx(15.1)
    named = slipfit.series([slipfit.Measurement(swings[0], "dry"), slipfit.Measurement(swings[1], "wet")]).plot()
    assert [label.get_text() for label in named[0].get_xticklabels()] == ["dry", "wet"]
    plt.close("all")


def test_infinite_quantities_of_a_series_are_infinite():
    record = slipfit.simulate.decay(
        frequency_hz=1, friction_displacement=0.01, amplitude=1, duration_s=30, rate_hz=40, noise_rms=1e-3, seed=3
    )
    held = slipfit.series([slipfit.Measurement(record)]).measurements[0].parameters
    alone = slipfit.ringdown(record).parameters
    assert math.isinf(alone.q_factor.interval_95[1])
    for name, quantity in alone.items():
        assert float(held[name]) == quantity.value, name


def test_levels_and_resonance_have_all_of_their_json(sweep):
    drive = np.arange(0.1, 1.3, 0.1)
    levels = slipfit.levels(drive, np.maximum(40 * (drive - 0.35), 0) + 0.02 * (np.arange(12) * 7 % 5))
    assert levels.correlation() == levels.correlation("threshold", "slope") == levels.to_dict()["correlation"]
    assert levels.correlation("slope", "slope") is None
    with pytest.raises(KeyError, match="no parameter 'q'; there are slope"):
        levels.correlation("q", "slope")
    curve = slipfit.resonance(*sweep, drive_amplitude=1.0, unit="mm", method="paper")
    data = curve.to_dict()
    assert dict(curve.force_line).keys() == data["force_line"].keys()
    assert curve.reference is None and curve.mean_drive is None
    assert curve.paper.keys() == data["paper"].keys()
