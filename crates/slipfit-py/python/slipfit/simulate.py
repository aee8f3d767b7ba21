"""Exact motion of an oscillator with viscous and sliding friction.

Noise is white, from NumPy's PCG64 with a seed; the command uses another generator.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _input
from ._arguments import public, wrong_type
from ._answers import Table
from ._errors import ReadError
from .typing import Scalar

__all__ = ["decay", "driven", "levels", "sweep"]

#: Maximum number of cycles at a frequency; each is computed from event to event.
_MOST_CYCLES = 1e9

#: Units for translation and for rotation.
_SLIDING = {"viscous_coefficient": "N s/m", "coulomb_force": "N", "static_force": "N"}
_TURNING = {
    "mass": "kg m²", "stiffness": "N m/rad", "viscous_coefficient": "N m s/rad",
    "coulomb_force": "N m", "static_force": "N m",
}  # fmt: skip

_TONES = "harmonics are needed, each (frequency [Hz], amplitude) or (frequency [Hz], amplitude, phase [deg])"

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

_OUTPUTS = """noise_rms : float or quantity
        Standard deviation of white noise on each of the two outputs of a lock-in, unit of the displacement.
    seed : int
        Seed of the noise: the same seed gives the same numbers."""


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
    duration_s: Scalar,
    rate_hz: Scalar,
    drive_amplitude: Scalar | None = None,
    drive_frequency_hz: Scalar | None = None,
    tone: Annotated[Sequence[Sequence[Scalar]], _TONES] = (),
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
    """The motion under a drive of the base by one or several harmonics, including stops.

    Parameters
    ----------
    duration_s, rate_hz : float or quantity
        Length of the record [s] and samples per second.
    drive_amplitude : float or quantity, optional
        x_0, in the unit of the displacement; for a force P it is P/k in that unit. Needed unless `tone` drives.
    drive_frequency_hz : float or quantity, optional
        Frequency of that drive [Hz]; that of the oscillator if not given.
    tone : sequence of tuples, optional
        Further harmonics of the base: frequency [Hz], amplitude [unit of the displacement] and phase ahead of a
        cosine [deg], zero if not given.
    start : str
        ``rest``, or ``steady`` for settled motion, under one harmonic without a phase.
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
    >>> beating = slipfit.simulate.driven(frequency_hz=1, q_factor=20, friction_displacement=0.3,
    ...     tone=[(0.4, 1), (1.2, 0.4, 90)], duration_s=100, rate_hz=50)
    """
    harmonics = _tones(tone, unit)
    if drive_amplitude is not None:
        own = _input.optional("drive_frequency_hz", drive_frequency_hz)
        harmonics.insert(0, (_input.number("drive_amplitude", drive_amplitude, unit), own, 0.0))
    elif drive_frequency_hz is not None:
        raise _input.refuse(
            "drive_frequency_hz", "drive_frequency_hz without drive_amplitude: each tone has a frequency of its own"
        )
    elif not harmonics:
        raise _input.refuse("drive_amplitude", "nothing drives it: give drive_amplitude, or tone")
    if start == "steady" and (len(harmonics) > 1 or harmonics[0][2]):
        what = "one harmonic without a phase has a steady motion here; any other settles in a longer duration_s"
        raise _input.refuse("start", f"start={start!r}: {what}")
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
        oscillator, harmonics, _input.number("duration_s", duration_s), _input.number("rate_hz", rate_hz),
        start == "steady", off,
    )  # fmt: skip
    drive = "tone" if drive_amplitude is None else "drive_amplitude"
    given = tone if drive_amplitude is None else drive_amplitude
    still = f"{drive}={given}: the mass stays at rest, and a record at rest tells nothing"
    return _record(time_s, _noisy(signal, noise_rms, seed, unit), unit, drive, still)


def _tones(given: Iterable[Sequence[Scalar]], unit: str) -> list[tuple[float, float | None, float]]:
    """Amplitude, frequency [Hz] and phase [rad] of each harmonic."""
    harmonics: list[tuple[float, float | None, float]] = []
    for one in given:
        if not 2 <= len(one) <= 3:
            raise wrong_type("tone", one, _TONES)
        hz, x = _input.number("tone", one[0], "Hz"), _input.number("tone", one[1], unit)
        degrees = _input.number("tone", one[2], "deg") if len(one) > 2 else 0.0
        if not (hz > 0 and np.isfinite([hz, x, degrees]).all()):
            raise _input.refuse("tone", f"tone={one!r}: a frequency above zero, and finite numbers, are needed")
        # A whole turn is subtracted before the conversion, which rounds.
        harmonics.append((x, hz, float(np.radians(degrees % 360))))
    return harmonics


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
    {outputs}

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
    _check_wait(wait, wait_s, float(frequencies.max(initial=0)))
    x_0 = _input.number("drive_amplitude", drive_amplitude, unit)
    found = _core.readings(oscillator, [(x_0, hz) for hz in frequencies.tolist()], wait)
    amplitude, phase = _noisy_outputs(*found, noise_rms, seed, unit)
    columns = {"frequency_hz": frequencies.copy(), "amplitude": amplitude, "phase_rad": phase}
    return Table(columns, {"frequency_hz": "Hz", "amplitude": unit, "phase_rad": "rad"})


@public
def levels(
    drive_amplitudes: ArrayLike,
    *,
    drive_frequency_hz: Scalar | None = None,
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
    """Amplitude and phase of the fundamental against the amplitude of the drive, at one frequency.

    Parameters
    ----------
    drive_amplitudes : array_like, shape (n,)
        Amplitudes x_0 of the drive, in the unit of the displacement or in the unit that they or their name state.
    drive_frequency_hz : float or quantity, optional
        Frequency of the drive [Hz]; that of the oscillator if not given.
    wait_s : float or quantity, optional
        Time spent at each level in turn [s]; the motion is steady at the first, and the fundamental is that of the
        drive cycle after this time. If not given, the motion is settled at each level.
    unit : str
        Unit of the displacement; if a force is given, it must be a length or an angle.
    {oscillator}
    {outputs}

    Returns
    -------
    Table
        Columns drive_amplitude, amplitude, phase_rad, accepted by :func:`slipfit.levels`. A mass at rest has no
        phase, which is NaN.

    Raises
    ------
    OptionError
        For a value out of range, or an oscillator that is not determined.

    Examples
    --------
    >>> import numpy as np, slipfit
    >>> curve = slipfit.simulate.levels(np.linspace(0.002, 0.1, 50), frequency_hz=1, q_factor=50,
    ...     friction_displacement=0.01, noise_rms=0.002, unit="mm")
    >>> answer = slipfit.levels(curve)
    >>> answer.parameters.threshold.unit, abs(answer.parameters.threshold.value - 0.04 / np.pi) < 1e-3
    ('mm', True)
    """
    oscillator = _oscillator(
        unit, frequency_hz=frequency_hz, mass=mass, stiffness=stiffness, q_factor=q_factor,
        viscous_coefficient=viscous_coefficient, friction_displacement=friction_displacement,
        coulomb_force=coulomb_force, static_displacement=static_displacement, static_force=static_force,
    )  # fmt: skip
    drive = _input.alike("drive_amplitudes", drive_amplitudes, unit)
    if not ((drive > 0) & np.isfinite(drive)).all():
        raise _input.refuse("drive_amplitudes", "drive_amplitudes: each must be above zero and finite")
    hz, wait = _input.optional("drive_frequency_hz", drive_frequency_hz), _input.optional("wait_s", wait_s)
    _check_wait(wait, wait_s, _own_frequency_hz(oscillator) if hz is None else hz)
    found = _core.readings(oscillator, [(x_0, hz) for x_0 in drive.tolist()], wait)
    amplitude, phase = _noisy_outputs(*found, noise_rms, seed, unit)
    columns = {"drive_amplitude": drive.copy(), "amplitude": amplitude, "phase_rad": phase}
    return Table(columns, {"drive_amplitude": unit, "amplitude": unit, "phase_rad": "rad"})


def _check_wait(wait: float | None, given: Scalar | None, drive_hz: float) -> None:
    if wait is not None and wait * drive_hz > _MOST_CYCLES:
        raise _input.refuse("wait_s", f"wait_s={given}: at most {_MOST_CYCLES:.0e} cycles of the drive")


def _own_frequency_hz(oscillator: dict[str, Any]) -> float:
    """Undamped frequency, zero if it is not determined, which is refused later."""
    hz, mass, stiffness = (oscillator[name] for name in ("frequency_hz", "mass", "stiffness"))
    if hz is not None:
        return float(hz)
    return float(np.sqrt(max(stiffness / mass, 0)) / (2 * np.pi)) if mass and stiffness else 0.0


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
            for name, text in (("{oscillator}", _OSCILLATOR), ("{noise}", _NOISE), ("{outputs}", _OUTPUTS)):
                function.__doc__ = function.__doc__.replace(name, text)


_described(decay, driven, levels, sweep)
