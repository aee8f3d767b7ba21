"""Simulated motion: forces in the unit of the displacement, noise, and curves that are analysed as they are."""

import pickle

import numpy as np
import pytest
import slipfit

FORK = {"frequency_hz": 32700, "stiffness": 1e4, "viscous_coefficient": 20e-6, "coulomb_force": 15e-9}
NEAR = np.linspace(32670, 32730, 121)


def test_forces_are_turned_into_the_unit_of_the_displacement():
    made = {
        unit: slipfit.simulate.decay(**FORK, amplitude=25e-9 / m, unit=unit, duration_s=0.02, rate_hz=200e3)
        for unit, m in (("m", 1), ("nm", 1e-9), ("mm", 1e-3))
    }
    for unit, m in (("nm", 1e-9), ("mm", 1e-3)):
        np.testing.assert_allclose(made[unit].signal * m, made["m"].signal, atol=1e-20)
    swung = slipfit.simulate.driven(**FORK, drive_amplitude=0.012, unit="nm", duration_s=0.02, rate_hz=200e3)
    wanted = slipfit.simulate.driven(**FORK, drive_amplitude=0.012e-9, duration_s=0.02, rate_hz=200e3)
    np.testing.assert_allclose(swung.signal * 1e-9, wanted.signal, atol=1e-18)
    swept = slipfit.simulate.sweep(NEAR, **FORK, drive_amplitude=0.012, unit="nm")
    wanted = slipfit.simulate.sweep(NEAR, **FORK, drive_amplitude=0.012e-9)
    np.testing.assert_allclose(swept.amplitude * 1e-9, wanted.amplitude, rtol=1e-9)


def test_the_force_given_is_the_force_found():
    noisy = slipfit.simulate.decay(
        **FORK, amplitude=25, unit="nm", duration_s=0.05, rate_hz=200e3, noise_rms=0.3
    )
    found = slipfit.ringdown(noisy, stiffness=1e4).parameters.coulomb_force
    assert abs(found.value - 15e-9) < 4 * found.std_error < 4e-9
    swing = {"frequency_hz": 1, "stiffness": 0.02, "q_factor": 60, "coulomb_force": 1e-4}
    record = slipfit.simulate.decay(**swing, amplitude=20, unit="deg", duration_s=30, rate_hz=50, noise_rms=0.02)
    found = slipfit.ringdown(record, torsion_stiffness=0.02).parameters.coulomb_force
    assert abs(found.value - 1e-4) < 4 * found.std_error < 4e-6
    assert found.unit == "N m"


@pytest.mark.parametrize("unit", ["dB", "furlong", "V"])
def test_a_unit_that_no_force_over_a_stiffness_has_is_for_displacements_alone(unit):
    given = {"frequency_hz": 1, "stiffness": 100, "q_factor": 50, "unit": unit}
    record = {"duration_s": 2, "rate_hz": 20}
    for make in (
        lambda force: slipfit.simulate.decay(**given, **force, **record, amplitude=1),
        lambda force: slipfit.simulate.driven(**given, **force, **record, drive_amplitude=1),
        lambda force: slipfit.simulate.sweep([0.9, 1.0], **given, **force, drive_amplitude=1),
    ):
        with pytest.raises(slipfit.OptionError, match="is neither") as raised:
            make({"coulomb_force": 0.1})
        assert (raised.value.option, raised.value.value) == ("unit", unit)
        make({"friction_displacement": 0.01})


def test_a_simulated_curve_is_analysed_as_it_is():
    given = {"frequency_hz": 1, "q_factor": 50, "friction_displacement": 0.3, "drive_amplitude": 1, "unit": "mm"}
    frequencies = np.linspace(0.9, 1.1, 81)
    curve = slipfit.simulate.sweep(frequencies, **given, noise_rms=0.02, seed=3)
    answer = slipfit.resonance(curve, drive_amplitude=1)
    x_f = answer.parameters.friction_displacement
    assert abs(x_f.value - 0.3) < 4 * x_f.std_error < 0.1
    assert x_f.unit == "mm"
    same = slipfit.resonance(
        curve.frequency_hz, curve.amplitude, phase_rad=curve.phase_rad, unit="mm", drive_amplitude=1
    )
    assert answer == same
    free = slipfit.simulate.sweep(frequencies, **{**given, "friction_displacement": 0}, noise_rms=0.02, seed=4)
    by_reference = slipfit.resonance(curve, reference=free).parameters.friction_displacement
    assert abs(by_reference.value - 0.3) < 4 * by_reference.std_error
    with pytest.raises(slipfit.OptionError, match="unit is given beside a simulated curve"):
        slipfit.resonance(curve, unit="mm")


def test_a_sweep_has_units_and_noise_by_its_seed():
    given = {"frequency_hz": 1, "q_factor": 50, "drive_amplitude": 1, "unit": "mm"}
    frequencies = np.linspace(0.8, 1.2, 4001)
    clean = slipfit.simulate.sweep(frequencies, **given)
    noisy = slipfit.simulate.sweep(frequencies, **given, noise_rms=0.05, seed=7)
    again = slipfit.simulate.sweep(frequencies, **given, noise_rms=0.05, seed=7)
    assert noisy == again
    assert noisy != slipfit.simulate.sweep(frequencies, **given, noise_rms=0.05, seed=8)
    assert noisy.units == {"frequency_hz": "Hz", "amplitude": "mm", "phase_rad": "rad"}
    assert pickle.loads(pickle.dumps(noisy)).units == noisy.units
    apart = noisy.amplitude * np.exp(1j * noisy.phase_rad) - clean.amplitude * np.exp(1j * clean.phase_rad)
    for part in (apart.real, apart.imag):
        assert abs(part.std() / 0.05 - 1) < 0.05
    for option, value in (("noise_rms", -1), ("seed", -1)):
        with pytest.raises(slipfit.OptionError, match=option) as raised:
            slipfit.simulate.sweep(frequencies, **given, **{option: value})
        assert raised.value.option == option


def test_a_mass_at_rest_has_no_phase():
    given = {"frequency_hz": 1, "friction_displacement": 2, "drive_amplitude": 1}
    still = slipfit.simulate.sweep([0.9, 1.0], **given)
    assert still.amplitude.tolist() == [0, 0]
    assert np.isnan(still.phase_rad).all()
    assert np.isfinite(slipfit.simulate.sweep([0.9, 1.0], **given, noise_rms=0.1).phase_rad).all()
