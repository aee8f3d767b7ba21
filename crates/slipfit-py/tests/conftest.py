"""What the tests share."""

import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest
import slipfit

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def root():
    """The workspace's folder."""
    return ROOT


@pytest.fixture(scope="session")
def command():
    """The program `slipfit`, as SLIPFIT_COMMAND names it or as cargo built it."""
    named = os.environ.get("SLIPFIT_COMMAND")
    places = [Path(named)] if named else [ROOT / "target" / p / "slipfit" for p in ("release", "debug")]
    for place in places:
        if place.is_file():
            return str(place)
    pytest.skip("the command is not built; SLIPFIT_COMMAND names it")


def real_files(folder, suffix=""):
    """Measured files, with a visible skip where there are none."""
    data = Path(os.environ.get("SLIPFIT_REAL_DATA", ROOT.parent / "shared" / "data"))
    data = data if data.is_absolute() else ROOT / data
    found = sorted((data / folder).glob(f"*{suffix}"))
    if not found:
        skip = pytest.mark.skip(reason=f"no real data at {data}; set SLIPFIT_REAL_DATA")
        return [pytest.param(None, marks=skip, id=folder)]
    return [pytest.param(path, id=path.name) for path in found]


def ends_at_a_signal(work):
    """Whether work that is repeated for ever ends soon after the signal that Ctrl-C sends."""
    if not hasattr(signal, "setitimer"):
        pytest.skip("no timer of this system sends signals")
    old = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        begun = time.perf_counter()
        with pytest.raises(KeyboardInterrupt):
            while True:
                work()
        return time.perf_counter() - begun < 5
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, old)


@pytest.fixture(scope="session")
def swing():
    """Times and samples of a noisy pendulum with sliding friction, 2 mrad."""
    clean = slipfit.simulate.decay(
        frequency_hz=1.2, q_factor=80, friction_displacement=0.002,
        amplitude=0.4, duration_s=40, rate_hz=50, unit="rad",
    )
    noise = 5e-4 * np.random.default_rng(1).standard_normal(len(clean))
    return clean.time_s, clean.signal + noise


@pytest.fixture(scope="session")
def answer(swing):
    return slipfit.ringdown(*swing, unit="rad")


@pytest.fixture(scope="session")
def sweep():
    """Frequencies and complex responses of a driven oscillator with friction."""
    curve = slipfit.simulate.sweep(
        np.linspace(0.9, 1.1, 81), frequency_hz=1.0, q_factor=50,
        friction_displacement=0.3, drive_amplitude=1.0,
    )
    noise = np.random.default_rng(2).standard_normal((2, 81)) * 0.05
    response = curve["amplitude"] * np.exp(1j * curve["phase_rad"]) + noise[0] + 1j * noise[1]
    return curve["frequency_hz"], response
