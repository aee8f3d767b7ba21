"""Simulated motion: forces in the unit of the displacement, noise, and curves that are analysed as they are."""

import pickle
import subprocess

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


LEVELS = {"frequency_hz": 1, "q_factor": 50, "friction_displacement": 0.01}


def test_levels_are_those_of_the_command(command):
    drive = np.linspace(0.002, 0.1, 9)
    for python, words in (
        ({}, []),
        ({"drive_frequency_hz": 0.99}, ["--drive-frequency-hz", "0.99"]),
        ({"wait_s": 20}, ["--wait", "20"]),
    ):
        found = slipfit.simulate.levels(drive, **LEVELS, **python, unit="mm")
        told = [
            command, "simulate", "levels", "--frequency-hz", "1", "--q", "50", "--friction-displacement", "0.01",
            "--start-amplitude", "0.002", "--stop-amplitude", "0.1", "--points", "9", "--unit", "mm", *words,
        ]  # fmt: skip
        lines = subprocess.run(told, capture_output=True, text=True, check=True).stdout.splitlines()
        rows = [line.split(",") for line in lines if line[:1].isdigit()]
        columns = np.array([[float(cell or "nan") for cell in row] for row in rows]).T
        np.testing.assert_allclose(found.drive_amplitude, columns[0], rtol=1e-12)
        np.testing.assert_array_equal(found.amplitude, columns[1])
        np.testing.assert_allclose(found.phase_rad, np.radians(columns[2]), rtol=1e-12)
    assert found.units == {"drive_amplitude": "mm", "amplitude": "mm", "phase_rad": "rad"}


def test_simulated_levels_are_analysed_as_they_are():
    drive = np.linspace(0.002, 0.1, 50)
    curve = slipfit.simulate.levels(drive, **LEVELS, unit="mm", noise_rms=0.002, seed=2)
    assert curve == slipfit.simulate.levels(drive, **LEVELS, unit="mm", noise_rms=0.002, seed=2)
    answer = slipfit.levels(curve)
    threshold, x_f = answer.parameters.threshold, answer.parameters.friction_displacement
    # Nothing moves below x_0 = 4 x_F/pi.
    assert abs(threshold.value - 0.04 / np.pi) < 4 * threshold.std_error + 1e-4 and threshold.unit == "mm"
    assert abs(x_f.value - 0.01) < 4 * x_f.std_error + 1e-4 and x_f.unit == "mm"
    with pytest.raises(slipfit.OptionError, match="unit is given beside simulated levels"):
        slipfit.levels(curve, unit="mm")
    assert slipfit.Measurement(curve).analysis == "levels"
    measured = slipfit.series([slipfit.Measurement(curve, "dry")]).measurements[0].parameters.threshold
    assert float(measured) == threshold.value


def test_levels_are_above_zero():
    pandas = pytest.importorskip("pandas")
    named = slipfit.simulate.levels(pandas.Series([2.0, 50.0], name="drive (um)"), **LEVELS, unit="mm")
    np.testing.assert_allclose(named.drive_amplitude, [0.002, 0.05])
    for wrong in ([0.0, 1.0], [-1.0], [np.nan], [np.inf]):
        with pytest.raises(slipfit.OptionError, match="each must be above zero and finite") as raised:
            slipfit.simulate.levels(wrong, **LEVELS)
        assert raised.value.option == "drive_amplitudes"
    with pytest.raises(slipfit.OptionError, match="at most 1e.09 cycles") as raised:
        slipfit.simulate.levels([1.0], mass=1e-9, stiffness=1e9, wait_s=10)
    assert raised.value.option == "wait_s"
    assert len(slipfit.simulate.levels([], **LEVELS)["amplitude"]) == 0


def test_tones_are_those_of_the_command(command):
    record = {"duration_s": 20, "rate_hz": 50}
    friction = {"frequency_hz": 1, "q_factor": 20, "friction_displacement": 0.3}
    found = slipfit.simulate.driven(**friction, **record, tone=[(0.4, 1), (1.2, 0.4, 90)])
    told = [
        command, "simulate", "driven", "--frequency-hz", "1", "--q", "20", "--friction-displacement", "0.3",
        "--tone", "0.4,1", "--tone", "1.2,0.4,90", "--duration", "20", "--rate-hz", "50",
    ]  # fmt: skip
    lines = subprocess.run(told, capture_output=True, text=True, check=True).stdout.splitlines()
    columns = np.array([[float(cell) for cell in line.split(",")] for line in lines if line[:1].isdigit()]).T
    np.testing.assert_allclose(found.time_s, columns[0], rtol=1e-14)
    # The command writes seven digits.
    np.testing.assert_allclose(found.signal, columns[1], atol=1e-6)
    one = slipfit.simulate.driven(**friction, **record, drive_amplitude=1, drive_frequency_hz=0.4)
    np.testing.assert_array_equal(slipfit.simulate.driven(**friction, **record, tone=[(0.4, 1)]).signal, one.signal)
    steady = {"start": "steady", **record}
    np.testing.assert_array_equal(
        slipfit.simulate.driven(**friction, **steady, tone=[(0.4, 1, 0)]).signal,
        slipfit.simulate.driven(**friction, **steady, drive_amplitude=1, drive_frequency_hz=0.4).signal,
    )
    both = slipfit.simulate.driven(**friction, **record, drive_amplitude=1, drive_frequency_hz=0.4, tone=[(1.2, 0.4, 90)])
    np.testing.assert_array_equal(both.signal, found.signal)


@pytest.mark.parametrize(
    ("options", "option", "words"),
    [
        ({}, "drive_amplitude", "nothing drives it"),
        ({"drive_frequency_hz": 1}, "drive_frequency_hz", "without drive_amplitude"),
        ({"tone": (0.4, 1)}, "tone", "harmonics are needed"),
        ({"tone": [(0.4,)]}, "tone", "harmonics are needed"),
        ({"tone": [(0.4, 1, 2, 3)]}, "tone", "harmonics are needed"),
        ({"tone": ["a1"]}, "tone", "a number is needed"),
        ({"tone": [(-0.4, 1)]}, "tone", "above zero"),
        ({"tone": [(0.4, np.nan)]}, "tone", "finite numbers"),
        ({"tone": [(0.4, 1, 90)], "start": "steady"}, "start", "one harmonic without a phase"),
        ({"tone": [(0.4, 1)], "drive_amplitude": 1, "start": "steady"}, "start", "one harmonic without a phase"),
    ],
)
def test_a_drive_of_tones_is_refused_by_its_name(options, option, words):
    with pytest.raises(slipfit.OptionError, match=words) as raised:
        slipfit.simulate.driven(frequency_hz=1, q_factor=20, duration_s=20, rate_hz=50, **options)
    assert raised.value.option == option
