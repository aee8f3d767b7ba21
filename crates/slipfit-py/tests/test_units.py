"""Single values with a unit are taken in it, as arrays are; those of another quantity are refused."""

import numpy as np
import pytest
import slipfit

pint = pytest.importorskip("pint")
UNITS = pint.UnitRegistry()
Q = UNITS.Quantity
SWEEP = slipfit.simulate.sweep(
    np.linspace(0.9, 1.1, 81), frequency_hz=1, q_factor=50, friction_displacement=0.3, drive_amplitude=1
)


def of_astropy(value, unit):
    return value * pytest.importorskip("astropy.units").Unit(unit)


def of_unyt(value, unit):
    return pytest.importorskip("unyt").unyt_quantity(value, unit)


def of_xarray(value, unit):
    return pytest.importorskip("xarray").DataArray(value, attrs={"units": unit})


def of_slipfit(value, unit):
    return slipfit.Quantity(value, 0.0, (value, value), value, unit)


MAKES = [Q, of_astropy, of_unyt, of_xarray, of_slipfit]


@pytest.mark.parametrize("make", MAKES)
def test_values_are_taken_in_their_unit(swing, make):
    signal = swing[1]
    plain = slipfit.ringdown(signal=signal, rate_hz=50, unit="rad")
    assert slipfit.ringdown(signal=signal, rate_hz=make(0.05, "kHz"), unit="rad") == plain
    kept = slipfit.ringdown(signal=signal, rate_hz=50, unit="rad", start_s=2, min_amplitude=0.01, band_hz=(0.5, 2))
    options = {"start_s": make(2000.0, "ms"), "min_amplitude": make(10.0, "mrad")}
    band = (make(500.0, "mHz"), make(2.0, "Hz"))
    found = slipfit.ringdown(signal=signal, rate_hz=50, unit="rad", band_hz=band, **options)
    assert found.parameters.q_factor.value == pytest.approx(kept.parameters.q_factor.value, rel=1e-9)
    forced = slipfit.ringdown(signal=signal, rate_hz=50, unit="mm", stiffness=5000.0).parameters.coulomb_force
    for stiffness in (make(5.0, "N/mm"), make(5000.0, "kg/s**2"), make(5e-3, "N/um")):
        again = slipfit.ringdown(signal=signal, rate_hz=50, unit="mm", stiffness=stiffness).parameters.coulomb_force
        assert again.value == pytest.approx(forced.value, rel=1e-9)
    turned = slipfit.ringdown(signal=signal, rate_hz=50, unit="rad", inertia=2.0).parameters.coulomb_force
    again = slipfit.ringdown(signal=signal, rate_hz=50, unit="rad", inertia=make(2e7, "g*cm**2"))
    assert again.parameters.coulomb_force.value == pytest.approx(turned.value, rel=1e-9)
    if make is not of_slipfit:
        found = slipfit.ringdown(
            signal=signal, rate_hz=50, unit="mm", stiffness=(make(5.0, "N/mm"), make(100.0, "N/m"))
        )
        assert found.parameters.coulomb_force.std_error > 10 * forced.std_error
    response = slipfit.resonance(SWEEP["frequency_hz"], SWEEP["amplitude"], unit="mm", drive_amplitude=make(1e-3, "m"))
    assert response.parameters.friction_displacement.value == pytest.approx(0.3, rel=1e-6)


@pytest.mark.parametrize("make", [Q, of_astropy, of_unyt])
def test_intervals_of_batches_are_taken_in_their_unit(make):
    traces = np.exp(-0.01 * np.arange(200))[np.newaxis]
    for dt in (make(10.0, "ms"), make(1e-2, "s")):
        assert slipfit.fit_batch(traces, amplitude="a", dt=dt)["decay_rate_per_s"][0] == pytest.approx(1)
        assert slipfit.fit_map(traces[np.newaxis], dt)["decay_rate_per_s"].item() == pytest.approx(1)
    some = slipfit.fit_batch(traces, amplitude="a", dt=0.01, unit="mm", min_amplitude=make(500.0, "um"))
    assert some["samples"][0] == 70
    with pytest.raises(slipfit.OptionError, match="min_amplitude is in '.m', what it belongs to in no unit"):
        slipfit.fit_batch(traces, amplitude="a", dt=0.01, min_amplitude=make(500.0, "um"))


def test_an_error_beside_a_value_has_the_unit_of_the_value(swing):
    forces = []
    for stiffness in (
        (5000.0, 100.0), slipfit.Quantity(5, 0.1, (4.8, 5.2), 5, "N/mm"), Q(np.array([5, 0.1]), "N/mm"),
    ):  # fmt: skip
        found = slipfit.ringdown(*swing, unit="mm", stiffness=stiffness)
        forces.append(found.parameters.coulomb_force)
    for force in forces[1:]:
        assert force.value == pytest.approx(forces[0].value, rel=1e-9)
        assert force.std_error == pytest.approx(forces[0].std_error, rel=1e-9)


def test_values_of_another_quantity_are_refused(swing, answer):
    time, signal = swing
    q = answer.parameters.q_factor
    for options, words in (
        ({"stiffness": q}, "stiffness is a pure number where a value in N/m is needed"),
        ({"stiffness": answer.parameters.friction_displacement}, "stiffness is in 'rad' where a value in N/m"),
        ({"stiffness": Q(5, "kg")}, "stiffness is in 'kg' where a value in N/m"),
        ({"mass": Q(5, "N/m")}, "mass is in 'N/m' where a value in kg"),
        ({"torsion_stiffness": Q(5, "N/m")}, "torsion_stiffness is in 'N/m' where a value in N m/rad"),
        ({"start_s": q}, "start_s is a pure number where a value in s"),
        ({"start_s": Q(5, "mm")}, "start_s is in 'mm' where a value in s"),
        ({"band_hz": (Q(5, "s"), Q(6, "s"))}, "band_hz is in 's' where a value in Hz"),
        ({"min_amplitude": Q(5, "mm")}, "min_amplitude is in 'mm', what it belongs to in 'rad'"),
    ):
        with pytest.raises(slipfit.OptionError, match=words) as raised:
            slipfit.ringdown(time, signal, unit="rad", **options)
        assert raised.value.option == next(iter(options))
    with pytest.raises(slipfit.OptionError, match="rate_hz is in 'mm' where a value in Hz"):
        slipfit.ringdown(signal=signal, rate_hz=Q(50, "mm"))
    with pytest.raises(slipfit.OptionError, match="drive_amplitude is in 's', what it belongs to in 'mm'"):
        slipfit.resonance(SWEEP["frequency_hz"], SWEEP["amplitude"], unit="mm", drive_amplitude=Q(1, "s"))
    with pytest.raises(slipfit.OptionError, match="in no unit: give unit"):
        slipfit.resonance(SWEEP["frequency_hz"], SWEEP["amplitude"], drive_amplitude=Q(1, "mm"))
    with pytest.raises(slipfit.OptionError, match="dt is in 'mm' where a value in s"):
        slipfit.fit_batch(signal[np.newaxis], signal="x", method="analyse", dt=Q(1, "mm"))
    with pytest.raises(slipfit.OptionError, match="q_factor is in 'N' where a pure number"):
        slipfit.levels([1, 2, 3, 4], [1, 2, 3, 4], q_factor=Q(1, "N"))


def test_levels_series_and_simulations_take_units():
    levels = {"drive": [1, 2, 3, 4], "amplitude": [0.1, 2.1, 4.1, 6.2], "unit": "mm", "drive_unit": "V"}
    plain = slipfit.levels(**levels, drive_gain=0.005, frequency_hz=1000)
    found = slipfit.levels(**levels, drive_gain=Q(5, "um/V"), frequency_hz=Q(1, "kHz"))
    for name, quantity in plain.parameters.items():
        assert found.parameters[name].value == pytest.approx(quantity.value, rel=1e-9), name
    of = {"q_factor": 80, "unit": "mm", "rate_hz": 50}
    plain = slipfit.simulate.decay(
        frequency_hz=1.2, friction_displacement=0.002, amplitude=0.4, duration_s=30, noise_rms=5e-4, **of
    )
    record = slipfit.simulate.decay(
        frequency_hz=Q(1200, "mHz"), friction_displacement=Q(2, "um"), amplitude=Q(0.4, "mm"),
        duration_s=Q(0.5, "min"), noise_rms=Q(0.5, "um"), **of,
    )  # fmt: skip
    np.testing.assert_allclose(record.signal, plain.signal, rtol=1e-9, atol=1e-12)
    turned = {"mass": Q(1, "kg*m**2"), "stiffness": Q(3, "N*m/rad"), "duration_s": 9, "rate_hz": 9, "unit": "rad"}
    assert slipfit.simulate.decay(**turned, amplitude=Q(180, "deg")).signal[0] == pytest.approx(np.pi)
    measured = [
        slipfit.Measurement(record, value=Q(5, "nN"), options={"min_amplitude": Q(10, "um")}),
        slipfit.Measurement(record, condition="more", value=(Q(6, "uN"), Q(1, "nN"))),
    ]
    assert [row.value for row in slipfit.series(measured, condition_unit="uN").table] == pytest.approx([0.005, 6])
    assert [row.value for row in slipfit.series(measured).table] == pytest.approx([5, 6000])
    with pytest.raises(slipfit.OptionError, match="a value is in 'nN' and condition_unit='mm'"):
        slipfit.series(measured, condition_unit="mm")
    with pytest.raises(slipfit.OptionError, match="min_amplitude is in 's'"):
        slipfit.Measurement(record, options={"min_amplitude": Q(10, "s")})


def test_starts_of_fits_are_taken_in_their_unit():
    time = 0.01 * np.arange(200)
    fit = slipfit.fit_envelope(
        Q(time, "s"), Q(1.4 * np.exp(-0.8 * time) - 0.3, "mm"),
        initial_amplitude=Q(1000, "um"), offset_amplitude=0, decay_rate_per_s=Q(1e-3, "1/ms"),
    )  # fmt: skip
    assert fit.best.offset_amplitude == pytest.approx(0.3)
    with pytest.raises(slipfit.OptionError, match="what it belongs to in 'mm'"):
        slipfit.fit_envelope(
            time, Q(np.exp(-time), "mm"), initial_amplitude=Q(1, "s"), offset_amplitude=0, decay_rate_per_s=1
        )


def test_products_of_units_are_told_apart():
    from slipfit._core import unit_factor

    for unit, wanted, factor in (
        ("N/mm", "N/m", 1e3), ("kg / s2", "N/m", 1), ("kg s⁻²", "N/m", 1), ("N·m/rad", "N m/rad", 1),
        ("N*m/deg", "N m/rad", 180 / np.pi), ("m2 kg", "kg m²", 1), ("g*m^2", "kg m²", 1e-3),
        ("kg m2 / (rad s2)", "N m/rad", 1), ("N/(mm)", "N/m", 1e3), ("mm/s", "m/s", 1e-3), ("um/V", "mm/V", 1e-3),
        ("cm/m", "1", 1e-2), ("N/kg", "N/m", None), ("N/", "N/m", None), ("furlong", "m", None), ("10 N/m", "N/m", None),
        ("mm", "rad", None),
    ):  # fmt: skip
        assert unit_factor(unit, wanted) == (None if factor is None else pytest.approx(factor)), unit
