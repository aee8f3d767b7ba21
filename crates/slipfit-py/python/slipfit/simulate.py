"""Exact motion of an oscillator with viscous and sliding friction.

Noise is white, from NumPy's PCG64 with a seed; the command uses another generator.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _input
from ._arguments import public
from ._answers import Table
from ._errors import ReadError
from .typing import Scalar

__all__ = ["decay", "driven", "sweep"]

#: Maximum number of cycles at a frequency; each is computed from event to event.
_MOST_CYCLES = 1e9

#: Units for translation and for rotation.
_SLIDING = {"viscous_coefficient": "N s/m", "coulomb_force": "N", "static_force": "N"}
_TURNING = {
    "mass": "kg m²", "stiffness": "N m/rad", "viscous_coefficient": "N m s/rad",
    "coulomb_force": "N m", "static_force": "N m",
}  # fmt: skip

_OSCILLATOR = """frequency_hz, mass, stiffness : float or quantity, optional
        Undamped frequency [Hz]; or two of it, mass [kg] and stiffness [N/m]. Of an angle the mass is a
        moment of inertia [kg m²], the stiffness in N m/rad, and so on.
    q_factor, viscous_coefficient : float or quantity, optional
        Viscous loss as a quality factor or as a coefficient [N s/m].
    friction_displacement, coulomb_force : float or quantity, optional
        Sliding friction as x_F = F/k, unit of the displacement, or as a force [N], which is turned into
        that unit.
    static_displacement, static_force : float or quantity, optional
        Static friction; that of sliding if not given."""


_NOISE = """noise_rms : float or quantity
        Standard deviation of white noise on every sample, unit of the displacement.
    seed : int
        Of the noise: the same seed, the same numbers."""


def _noisy(signal: NDArray[np.float64], noise_rms: Scalar, seed: int, unit: str) -> NDArray[np.float64]:
    rms = _input.number("noise_rms", noise_rms, unit)
    _check_noise(rms, noise_rms, seed)
    return signal + rms * np.random.default_rng(seed).standard_normal(len(signal)) if rms else signal


def _check_noise(rms: float, given: Scalar, seed: int) -> None:
    if not 0 <= rms < float("inf"):
        raise _input.refuse("noise_rms", f"noise_rms={given!r}: zero or above is needed")
    if seed < 0:
        raise _input.refuse("seed", f"seed={seed!r}: a whole number, zero or above, is needed")


def _record(
    time_s: NDArray[np.float64], signal: NDArray[np.float64], unit: str, moves_by: str, still: str
) -> _core.Record:
    """The samples as a record; a record at rest is refused."""
    if (signal == signal[0]).all() and len(signal) > 1:
        raise _input.refuse(moves_by, still)
    try:
        return _core.record_of_arrays(time_s, signal, None, None, unit, "displacement")
    except ReadError as error:
        if error.code not in ("too_few_rows", "broken"):
            raise
        raise _input.refuse("duration_s", f"{len(signal)} samples in duration_s at rate_hz: more are needed") from None


def _oscillator(unit: str, **given: Scalar | None) -> dict[str, Any]:
    """The oscillator and the unit of its displacements; for a rotation the mass is a moment of inertia, and so on."""
    turns = _core.unit_factor(unit, "rad") is not None
    units = {"friction_displacement": unit, "static_displacement": unit, **(_TURNING if turns else _SLIDING)}
    numbers = {
        name: None if value is None else _input.number(name, value, units.get(name))
        for name, value in given.items()
    }
    return {**numbers, "displacement_unit": unit}


@public
def decay(
    *,
    amplitude: Scalar,
    duration_s: Scalar,
    rate_hz: Scalar,
    unit: str = "m",
    frequency_hz: Scalar | None = None,
    mass: Scalar | None = None,
    stiffness: Scalar | None = None,
    q_factor: Scalar | None = None,
    viscous_coefficient: Scalar | None = None,
    friction_displacement: Scalar | None = None,
    coulomb_force: Scalar | None = None,
    static_displacement: Scalar | None = None,
    static_force: Scalar | None = None,
    noise_rms: Scalar = 0.0,
    seed: int = 0,
) -> _core.Record:
    """A free decay, released from rest.

    Parameters
    ----------
    amplitude : float or quantity
        Displacement at the release.
    duration_s, rate_hz : float or quantity
        Length of the record [s] and samples per second.
    unit : str
        Unit of the displacement; if a force is given, it must be a length or an angle.
    {oscillator}
    {noise}

    Returns
    -------
    Record
        Exact to 1e-14 of the amplitude, apart from noise.

    Raises
    ------
    OptionError
        For a value out of range, or an oscillator that is not determined.

    Examples
    --------
    >>> import slipfit
    >>> swing = slipfit.simulate.decay(frequency_hz=1, friction_displacement=0.5,
    ...     amplitude=9.8, duration_s=10, rate_hz=2)
    >>> swing.signal[:3].round(6).tolist()  # sliding alone takes 2 x_F each half cycle
    [9.8, -8.8, 7.8]
    """
    oscillator = _oscillator(
        unit, frequency_hz=frequency_hz, mass=mass, stiffness=stiffness, q_factor=q_factor,
        viscous_coefficient=viscous_coefficient, friction_displacement=friction_displacement,
        coulomb_force=coulomb_force, static_displacement=static_displacement, static_force=static_force,
    )  # fmt: skip
    time_s, signal = _core.decay(
        oscillator, _input.number("amplitude", amplitude, unit),
        _input.number("duration_s", duration_s), _input.number("rate_hz", rate_hz),
    )  # fmt: skip
    still = f"amplitude={amplitude}: the mass stays where it is released, and a record at rest tells nothing"
    return _record(time_s, _noisy(signal, noise_rms, seed, unit), unit, "amplitude", still)


@public
def driven(
    *,
    drive_amplitude: Scalar,
    duration_s: Scalar,
    rate_hz: Scalar,
    drive_frequency_hz: Scalar | None = None,
    start: Literal["rest", "steady"] = "rest",
    drive_off_s: Scalar | None = None,
    unit: str = "m",
    frequency_hz: Scalar | None = None,
    mass: Scalar | None = None,
    stiffness: Scalar | None = None,
    q_factor: Scalar | None = None,
    viscous_coefficient: Scalar | None = None,
    friction_displacement: Scalar | None = None,
    coulomb_force: Scalar | None = None,
    static_displacement: Scalar | None = None,
    static_force: Scalar | None = None,
    noise_rms: Scalar = 0.0,
    seed: int = 0,
) -> _core.Record:
    """The motion under a harmonic drive of the base, including stops.

    Parameters
    ----------
    drive_amplitude : float or quantity
        x_0, in the unit of the displacement; for a force P it is P/k in that unit.
    duration_s, rate_hz : float or quantity
        Length of the record [s] and samples per second.
    drive_frequency_hz : float or quantity, optional
        Frequency of the drive [Hz]; that of the oscillator if not given.
    start : str
        ``rest``, or ``steady`` for settled motion.
    drive_off_s : float or quantity, optional
        Time at which the drive is switched off [s].
    unit : str
        Unit of the displacement; if a force is given, it must be a length or an angle.
    {oscillator}
    {noise}

    Returns
    -------
    Record
        Samples of the exact motion.

    Raises
    ------
    OptionError
        For a value out of range, or an oscillator that is not determined.

    Examples
    --------
    >>> import slipfit
    >>> motion = slipfit.simulate.driven(frequency_hz=1, q_factor=20, friction_displacement=0.1,
    ...     drive_amplitude=1, duration_s=60, rate_hz=50)
    >>> bool(abs(motion.signal).max() < 20)  # friction keeps it below Q x_0
    True
    """
    off = _input.optional("drive_off_s", drive_off_s)
    if off is not None and not off > 0:
        raise _input.refuse("drive_off_s", f"drive_off_s={drive_off_s}: above zero, or the drive is never on")
    if start not in ("rest", "steady"):
        raise _input.refuse("start", f"start={start!r}: one of rest, steady")
    oscillator = _oscillator(
        unit, frequency_hz=frequency_hz, mass=mass, stiffness=stiffness, q_factor=q_factor,
        viscous_coefficient=viscous_coefficient, friction_displacement=friction_displacement,
        coulomb_force=coulomb_force, static_displacement=static_displacement, static_force=static_force,
    )  # fmt: skip
    time_s, signal = _core.driven(
        oscillator, _input.number("drive_amplitude", drive_amplitude, unit),
        _input.optional("drive_frequency_hz", drive_frequency_hz), _input.number("duration_s", duration_s),
        _input.number("rate_hz", rate_hz), start == "steady", off,
    )  # fmt: skip
    still = f"drive_amplitude={drive_amplitude}: the mass stays at rest, and a record at rest tells nothing"
    return _record(time_s, _noisy(signal, noise_rms, seed, unit), unit, "drive_amplitude", still)


@public
def sweep(
    frequencies_hz: ArrayLike,
    *,
    drive_amplitude: Scalar,
    wait_s: Scalar | None = None,
    unit: str = "m",
    frequency_hz: Scalar | None = None,
    mass: Scalar | None = None,
    stiffness: Scalar | None = None,
    q_factor: Scalar | None = None,
    viscous_coefficient: Scalar | None = None,
    friction_displacement: Scalar | None = None,
    coulomb_force: Scalar | None = None,
    static_displacement: Scalar | None = None,
    static_force: Scalar | None = None,
    noise_rms: Scalar = 0.0,
    seed: int = 0,
) -> Table:
    """Amplitude and phase of the fundamental against the drive frequency.

    Parameters
    ----------
    frequencies_hz : array_like, shape (n,)
        Frequencies of the drive [Hz], or in the unit that they or their name state.
    drive_amplitude : float or quantity
        x_0, in the unit of the displacement; for a force P it is P/k in that unit.
    wait_s : float or quantity, optional
        Time spent at each frequency in turn [s]; the motion is steady at the first, and the fundamental is that
        of the drive cycle after this time. If not given, the motion is settled at each frequency.
    unit : str
        Unit of the displacement; if a force is given, it must be a length or an angle.
    {oscillator}
    noise_rms : float or quantity
        Standard deviation of white noise on each of the two outputs of a lock-in, unit of the displacement.
    seed : int
        Seed of the noise: the same seed gives the same numbers.

    Returns
    -------
    Table
        Columns frequency_hz, amplitude, phase_rad, accepted by :func:`slipfit.resonance`. A mass at
        rest has no phase, which is NaN.

    Raises
    ------
    OptionError
        For a value out of range, or an oscillator that is not determined.

    Examples
    --------
    >>> import numpy as np, slipfit
    >>> curve = slipfit.simulate.sweep([0.9, 1.0, 1.1], frequency_hz=1, q_factor=50,
    ...     drive_amplitude=1)
    >>> curve["amplitude"].round(3).tolist()
    [5.24, 50.0, 4.736]
    >>> curve = slipfit.simulate.sweep(np.linspace(0.9, 1.1, 81), frequency_hz=1, q_factor=50,
    ...     friction_displacement=0.3, drive_amplitude=1, noise_rms=0.02, unit="mm")
    >>> slipfit.resonance(curve, drive_amplitude=1).sliding.detected
    True
    """
    oscillator = _oscillator(
        unit, frequency_hz=frequency_hz, mass=mass, stiffness=stiffness, q_factor=q_factor,
        viscous_coefficient=viscous_coefficient, friction_displacement=friction_displacement,
        coulomb_force=coulomb_force, static_displacement=static_displacement, static_force=static_force,
    )  # fmt: skip
    frequencies = _input.hertz("frequencies_hz", frequencies_hz)
    if not ((frequencies > 0) & np.isfinite(frequencies)).all():
        raise _input.refuse("frequencies_hz", "frequencies_hz: each must be above zero and finite")
    wait = _input.optional("wait_s", wait_s)
    if wait is not None and len(frequencies) and wait * frequencies.max() > _MOST_CYCLES:
        raise _input.refuse("wait_s", f"wait_s={wait_s}: at most {_MOST_CYCLES:.0e} cycles of the drive")
    found = _core.sweep(
        oscillator, _input.number("drive_amplitude", drive_amplitude, unit),
        frequencies.tolist(), wait,
    )  # fmt: skip
    hz, amplitude, phase = found
    amplitude, phase = _noisy_outputs(amplitude, phase, noise_rms, seed, unit)
    columns = {"frequency_hz": hz, "amplitude": amplitude, "phase_rad": phase}
    return Table(columns, {"frequency_hz": "Hz", "amplitude": unit, "phase_rad": "rad"})


def _noisy_outputs(
    amplitude: NDArray[np.float64], phase: NDArray[np.float64], noise_rms: Scalar, seed: int, unit: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Amplitudes and phases [rad] with noise on both outputs of a lock-in; at rest there is only noise."""
    rms = _input.number("noise_rms", noise_rms, unit)
    _check_noise(rms, noise_rms, seed)
    if not rms:
        return amplitude, phase
    noise = rms * np.random.default_rng(seed).standard_normal((2, len(amplitude)))
    outputs = amplitude * np.exp(1j * np.nan_to_num(phase)) + noise[0] + 1j * noise[1]
    return np.abs(outputs), np.angle(outputs)


def _described(*functions: Any) -> None:
    for function in functions:
        if function.__doc__ is not None:  # python -OO removes docstrings
            function.__doc__ = function.__doc__.replace("{oscillator}", _OSCILLATOR).replace("{noise}", _NOISE)


_described(decay, driven, sweep)
