"""Fits of one model: no search for the decay, no comparison, no intervals."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _input
from ._arguments import public
from ._analyses import _curve
from .typing import Scalar


@dataclass(frozen=True)
class Envelope:
    """Parameters of the envelope ``A(t) = (A_0 + C) exp(-delta t) - C``.

    Attributes
    ----------
    initial_amplitude : float
        A_0, the amplitude at the first time, unit of the signal.
    offset_amplitude : float
        C, unit of the signal: ``x_F coth(pi delta/2 omega_d)`` for sliding friction.
    decay_rate_per_s : float
        delta = gamma/2m [1/s].
    """

    initial_amplitude: float
    offset_amplitude: float
    decay_rate_per_s: float


@dataclass(frozen=True)
class Decay:
    """Parameters of a free decay with viscous and sliding friction.

    Attributes
    ----------
    initial_amplitude : float
        A_0 at the first time, unit of the signal.
    friction_displacement : float
        x_F = F/k, unit of the signal.
    decay_rate_per_s : float
        delta = gamma/2m [1/s].
    phase_rad : float
        Phase at the first time [rad].
    frequency_hz : float
        omega_d/2 pi [Hz].
    offset : float
        Rest position of the spring, unit of the signal.
    """

    initial_amplitude: float
    friction_displacement: float
    decay_rate_per_s: float
    phase_rad: float
    frequency_hz: float
    offset: float


@dataclass(frozen=True)
class EnvelopeFit:
    """Result of :func:`fit_envelope`: best values, standard errors, correlations (3 × 3)."""

    best: Envelope
    std_error: Envelope
    #: Ignored when two fits are compared.
    correlation: NDArray[np.float64] = field(compare=False)
    residual_rms: float
    converged: bool
    steps: int


@dataclass(frozen=True)
class DecayFit:
    """Result of :func:`fit_waveform`: best values, standard errors, correlations (6 × 6)."""

    best: Decay
    std_error: Decay
    correlation: NDArray[np.float64] = field(compare=False)
    residual_rms: float
    converged: bool
    steps: int


@dataclass(frozen=True)
class CurveFit:
    """Result of :func:`fit_resonance`: value and standard error of each parameter.

    Frequencies in Hz, the decay rate in 1/s, lengths in the unit of the response.
    """

    natural_frequency_hz: tuple[float, float]
    decay_rate_per_s: tuple[float, float]
    friction_displacement: tuple[float, float]
    drive_amplitude: tuple[float, float]
    phase_offset_rad: tuple[float, float]
    residual_rms: float
    converged: bool


@public
def fit_envelope(
    time: ArrayLike,
    amplitude: ArrayLike,
    *,
    initial_amplitude: Scalar,
    offset_amplitude: Scalar,
    decay_rate_per_s: Scalar,
) -> EnvelopeFit:
    """Fits ``A(t) = (A_0 + C) exp(-delta t) - C`` to amplitudes by least squares.

    Parameters
    ----------
    time : array_like, shape (n,)
        Times [s]; t counts from the first.
    amplitude : array_like, shape (n,)
        Amplitudes in any unit, finite, n >= 4.
    initial_amplitude, offset_amplitude, decay_rate_per_s : float or quantity
        Start values: A_0, C, delta.

    Returns
    -------
    EnvelopeFit
        Standard errors are those of white noise.

    Raises
    ------
    OptionError
        For arrays of different length, too few samples, or values that are not finite.
    NoAnswerError
        If the data do not determine three parameters.

    Notes
    -----
    Eq. (15) and (16) of Vitorino, Vieira and Rodrigues, Sci. Rep. 7 (2017).

    Examples
    --------
    >>> import numpy as np, slipfit
    >>> t = np.arange(0, 2, 0.01)
    >>> fit = slipfit.fit_envelope(t, 1.4 * np.exp(-0.8 * t) - 0.3,
    ...     initial_amplitude=1, offset_amplitude=0, decay_rate_per_s=1)
    >>> round(fit.best.offset_amplitude, 9)
    0.3
    """
    unit = _input.own_unit(amplitude) or ""
    start = (
        _input.number("initial_amplitude", initial_amplitude, unit),
        _input.number("offset_amplitude", offset_amplitude, unit),
        _input.number("decay_rate_per_s", decay_rate_per_s),
    )
    times = _input.seconds("time", time)
    _input.check_order("time", times)
    found = _core.envelope(times, _input.vector("amplitude", amplitude), start)
    best, error, correlation, rms, converged, steps = found
    return EnvelopeFit(Envelope(*best), Envelope(*error), np.array(correlation), rms, converged, steps)


@public
def fit_waveform(
    time: ArrayLike,
    signal: ArrayLike,
    *,
    initial_amplitude: Scalar,
    frequency_hz: Scalar,
    friction_displacement: Scalar = 0.0,
    decay_rate_per_s: Scalar = 0.0,
    phase_rad: Scalar = 0.0,
    offset: Scalar = 0.0,
) -> DecayFit:
    """Fits the exact free decay under viscous and sliding friction to every sample.

    Parameters
    ----------
    time : array_like, shape (n,)
        Times [s], never decreasing.
    signal : array_like, shape (n,)
        Displacement in any unit, finite, n >= 7.
    initial_amplitude, frequency_hz, friction_displacement, decay_rate_per_s, phase_rad, offset : float or quantity
        Start values. The frequency must be correct to about half a
        cycle over the record, the phase to about a radian.

    Returns
    -------
    DecayFit
        Standard errors are those of white noise. If the record continues after the motion has stopped,
        the result is the lowest minimum over all turning points at which it may have stopped.

    Raises
    ------
    OptionError
        For arrays of different length, too few samples, or values that are not finite.
    NoAnswerError
        If the data do not determine six parameters.

    Examples
    --------
    >>> import slipfit
    >>> swing = slipfit.simulate.decay(frequency_hz=6.4, q_factor=200, friction_displacement=0.002,
    ...     amplitude=1, duration_s=6, rate_hz=500)
    >>> fit = slipfit.fit_waveform(swing.time_s, swing.signal,
    ...     initial_amplitude=0.9, frequency_hz=6.39, decay_rate_per_s=0.2)
    >>> round(fit.best.friction_displacement, 9)
    0.002
    """
    unit = _input.own_unit(signal) or ""
    start = (
        _input.number("initial_amplitude", initial_amplitude, unit),
        _input.number("friction_displacement", friction_displacement, unit),
        _input.number("decay_rate_per_s", decay_rate_per_s),
        _input.number("phase_rad", phase_rad),
        _input.number("frequency_hz", frequency_hz),
        _input.number("offset", offset, unit),
    )
    times = _input.seconds("time", time)
    _input.check_order("time", times)
    found = _core.waveform(times, _input.vector("signal", signal), start)
    best, error, correlation, rms, converged, steps = found
    return DecayFit(Decay(*best), Decay(*error), np.array(correlation), rms, converged, steps)


@public
def fit_resonance(
    frequency: Any,
    response: Any = None,
    *,
    phase_rad: ArrayLike | None = None,
    std_error: ArrayLike | None = None,
    drive_amplitude: Scalar | None = None,
) -> CurveFit:
    """Fits the exact fundamental with viscous damping and sliding friction to a curve.

    Parameters
    ----------
    frequency : array_like, shape (n,), or Curve
        Frequencies [Hz].
    response : array_like, shape (n,)
        Amplitudes or complex responses.
    phase_rad, std_error : array_like, shape (n,), optional
        Phases [rad] and standard errors of real amplitudes.
    drive_amplitude : float or quantity, optional
        Fixes x_0; if not given, x_0 is fitted.

    Returns
    -------
    CurveFit
        Start values come from the curve; standard errors are those of white noise.

    Raises
    ------
    NoAnswerError
        If there is no resonance.
    OptionError
        If an argument is invalid.

    Examples
    --------
    >>> import numpy as np, slipfit
    >>> sweep = slipfit.simulate.sweep(np.linspace(0.9, 1.1, 41), frequency_hz=1, q_factor=40,
    ...     friction_displacement=0.3, drive_amplitude=1)
    >>> response = sweep["amplitude"] * np.exp(1j * sweep["phase_rad"])
    >>> fit = slipfit.fit_resonance(sweep["frequency_hz"], response, drive_amplitude=1)
    >>> round(fit.friction_displacement[0], 6)
    0.3
    """
    curve = _curve(frequency, response, phase_rad=phase_rad, std_error=std_error)
    drive = _input.of_samples("drive_amplitude", drive_amplitude, curve.unit)
    values, rms, converged = _core.resonance_fit(curve, _input.optional("drive_amplitude", drive))
    hz, delta, x_f, x_0, phase = ((value, error) for value, error in values)
    return CurveFit(hz, delta, x_f, x_0, phase, rms, converged)
