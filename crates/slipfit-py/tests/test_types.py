"""What annotations say is what is taken."""

import inspect
import re
import subprocess
import sys

import pytest
import slipfit

TYPED = """
import datetime
import numpy as np
import pint
import slipfit
from slipfit.typing import Band, Interval, PerRow, Scalar, Uncertain

def of(quantity: "pint.Quantity[float]", own: slipfit.Quantity) -> None:
    for one in (quantity, own, 3, 3.0, np.float32(3)):
        scalar: Scalar = one
        band: Band = (scalar, scalar)
        uncertain: Uncertain = (scalar, 1.0)
        slipfit.ringdown("a.csv", start_s=one, band_hz=band, stiffness=one, mass=uncertain, min_amplitude=one)
        slipfit.fit_batch(None, amplitude="a", dt=one, min_amplitude=one, frequency_hz="f")
        slipfit.fit_map(None, one, frequency_hz=one)
        slipfit.simulate.decay(amplitude=one, duration_s=one, rate_hz=one, noise_rms=one)
        slipfit.levels([1.0], [1.0], q_factor=one, frequency_hz=one)
    interval: Interval = datetime.timedelta(seconds=1)
    row: PerRow = "column"
    slipfit.fit_batch(None, amplitude="a", dt=interval, frequency_hz=row, start_s=interval)
    slipfit.ringdown("a.csv", start_s=interval, end_s=interval)
"""


def test_annotations_take_quantities(tmp_path):
    pytest.importorskip("mypy"), pytest.importorskip("pint")
    check = [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", f"--cache-dir={tmp_path}"]
    (tmp_path / "typed.py").write_text(TYPED)
    done = subprocess.run([*check, "typed.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (tmp_path / "wrong.py").write_text('import slipfit\n\nslipfit.ringdown("a.csv", start_s="3")\n')
    done = subprocess.run([*check, "wrong.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert 'Argument "start_s"' in done.stdout


CALLS = [getattr(slipfit, name) for name in slipfit.__all__ if inspect.isfunction(getattr(slipfit, name))]
CALLS += [getattr(slipfit.simulate, name) for name in slipfit.simulate.__all__]


@pytest.mark.parametrize("call", CALLS, ids=lambda call: call.__name__)
def test_no_number_is_declared_without_its_unit(call):
    for name, parameter in inspect.signature(call).parameters.items():
        assert not re.search(r"\bfloat\b", str(parameter.annotation)), name
