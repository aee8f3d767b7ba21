"""Separates sliding (Coulomb, dry) friction from viscous damping in any oscillator.

>>> import slipfit
>>> swing = slipfit.simulate.decay(frequency_hz=1.2, q_factor=80, friction_displacement=0.002,
...     amplitude=0.4, duration_s=40, rate_hz=50, unit="rad")
>>> answer = slipfit.ringdown(swing, model="viscous+sliding")
>>> round(answer.parameters.friction_displacement.value, 6)
0.002

The analyses are :func:`ringdown`, :func:`resonance`, :func:`levels` and
:func:`series`; each takes arrays, files or what :func:`read` gives, and returns
an answer with parameters, intervals, evidence and warnings. The numbers are
those that the command ``slipfit`` prints.
"""

import importlib
from typing import TYPE_CHECKING, Any

from . import simulate, typing
from ._analyses import (
    Measurement,
    levels,
    read,
    read_curve,
    read_levels,
    resonance,
    ringdown,
    series,
)
from ._answers import (
    Answer,
    LevelsAnswer,
    Parameters,
    Quantity,
    ResonanceAnswer,
    RingdownAnswer,
    Section,
    SeriesAnswer,
    Table,
    Warning,
)
from ._batch import ArrowStream, ArrowTable, fit_batch, fit_stream
from ._core import Curve, Levels, Record, __version__
from ._errors import FolderError, Hint, NoAnswerError, OptionError, OptionTypeError, ReadError, SlipfitError
from ._fits import (
    CurveFit,
    Decay,
    DecayFit,
    Envelope,
    EnvelopeFit,
    fit_envelope,
    fit_resonance,
    fit_waveform,
)
from ._map import fit_map
from ._plot import plot_map

if TYPE_CHECKING:
    from . import engines

__all__ = [
    "Answer",
    "ArrowStream",
    "ArrowTable",
    "Curve",
    "CurveFit",
    "Decay",
    "DecayFit",
    "Envelope",
    "EnvelopeFit",
    "FolderError",
    "Hint",
    "Levels",
    "LevelsAnswer",
    "Measurement",
    "NoAnswerError",
    "OptionError",
    "OptionTypeError",
    "Parameters",
    "Quantity",
    "ReadError",
    "Record",
    "ResonanceAnswer",
    "RingdownAnswer",
    "Section",
    "SeriesAnswer",
    "SlipfitError",
    "Table",
    "Warning",
    "__version__",
    "engines",
    "fit_batch",
    "fit_envelope",
    "fit_map",
    "fit_resonance",
    "fit_stream",
    "fit_waveform",
    "levels",
    "plot_map",
    "read",
    "read_curve",
    "read_levels",
    "resonance",
    "ringdown",
    "series",
    "simulate",
    "typing",
]


def __getattr__(name: str) -> Any:
    # The engines and their packages are imported only on request.
    if name == "engines":
        return importlib.import_module(".engines", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), "engines"})
