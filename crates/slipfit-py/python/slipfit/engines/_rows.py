"""Rows of answer for files."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, get_args

from .. import _arguments, _core, _input
from .._analyses import _ringdown_choices, read, ringdown
from .._answers import Quantity, RingdownAnswer
from .._errors import SlipfitError
from ..typing import Kind

if TYPE_CHECKING:
    import pyarrow as pa

#: Names of the answer's parameters, and prefix and suffix of their columns, as in :func:`slipfit.fit_batch`.
_PARAMETERS = {
    "frequency_hz": ("frequency", "_hz"),
    "decay_rate_per_s": ("decay_rate", "_per_s"),
    "q_factor": ("q_factor", ""),
    "sliding_rate": ("sliding_rate", ""),
    "friction_displacement": ("friction_displacement", ""),
    "initial_amplitude": ("initial_amplitude", ""),
}
_PARTS = ("", "_std_error", "_low", "_high")


def schema() -> pa.Schema:
    """Columns of :func:`of_files`: the file, its status, parameters in the file's units (displacements in
    ``friction_unit``), evidence."""
    import pyarrow as pa

    numbers = [(stem + part + end, pa.float64()) for stem, end in _PARAMETERS.values() for part in _PARTS]
    return pa.schema(
        [("file", pa.string()), ("status", pa.string()), ("reason", pa.string()), ("model", pa.string())]
        + [("unit", pa.string()), ("friction_unit", pa.string()), *numbers]
        + [("sliding_detected", pa.bool_()), ("sliding_p_value", pa.float64()), ("residual_rms", pa.float64())]
        + [("start_s", pa.float64()), ("end_s", pa.float64())]
    )


def _answered(answer: RingdownAnswer) -> dict[str, Any]:
    data = answer.to_dict()
    codes = [warning.code for warning in answer.warnings]
    friction = answer.parameters.get("friction_displacement")
    row: dict[str, Any] = {
        "status": "warned" if codes else "done",
        "reason": " ".join(codes),
        "model": data["model"],
        "unit": data["input"]["unit"],
        "friction_unit": friction.unit if friction is not None else None,
        "sliding_detected": answer.sliding.detected,
        "sliding_p_value": answer.sliding.p_value,
        "residual_rms": data["diagnostics"]["residual_rms"],
        "start_s": answer.segment.start_s,
        "end_s": answer.segment.end_s,
    }
    for name, quantity in answer.parameters.items():
        if name in _PARAMETERS:
            values = (quantity.value, quantity.std_error, *quantity.interval_95)
            stem, end = _PARAMETERS[name]
            row.update({stem + part + end: value for part, value in zip(_PARTS, values)})
    return row


#: Options that say how a file is read.
_READING = ("rate_hz", "unit", "kind")
_CONSTANTS = ("stiffness", "mass", "torsion_stiffness", "inertia")


def checked(options: Mapping[str, Any]) -> dict[str, Any]:
    """The options as plain numbers; options invalid for :func:`slipfit.ringdown` are refused before any file is read.

    A `min_amplitude` with a unit keeps it: each file has its own.
    """
    _arguments.check(ringdown, options)
    for name in ("time", "signal", "quadrature"):
        if options.get(name) is not None:
            raise _input.refuse(name, f"{name} is given beside files, which hold it already")
    rate, kind = _input.optional("rate_hz", options.get("rate_hz")), options.get("kind")
    if rate is not None and not 0 < rate < math.inf:
        raise _input.refuse("rate_hz", f"rate_hz={rate}: a positive number of samples per second is needed")
    if kind is not None and kind not in get_args(Kind):
        raise _input.refuse("kind", f"kind={_arguments.shown(kind)}: one of {', '.join(get_args(Kind))}")
    least = _least(options.get("min_amplitude"), options.get("unit"))
    elsewhere = (*_READING, *_CONSTANTS, "time", "signal", "quadrature", "min_amplitude")
    choices = {name: value for name, value in options.items() if name not in elsewhere}
    constants = _input.constants({name: options.get(name) for name in _CONSTANTS})
    numbers = _ringdown_choices(**choices, min_amplitude=None if least is None else float(least))
    _core.check_ringdown(numbers, constants)
    plain = {**numbers, **constants, "rate_hz": rate, "min_amplitude": least}
    return {name: plain.get(name, value) for name, value in options.items()}


def _least(value: Any, unit: str | None) -> float | Quantity | None:
    """The minimum amplitude: a number in the unit of each file, or with its own unit."""
    own = _input.unit_of_one(value)
    if value is None or not own:
        return _input.optional("min_amplitude", value)
    if unit:
        return _input.number("min_amplitude", value, unit)
    number = _input.number("min_amplitude", value, own)
    return Quantity(number, 0.0, (number, number), number, own)


def of_file(name: str, contents: bytes | None, **options: Any) -> dict[str, Any]:
    """The row of one file; if it cannot be read or analysed, the row contains the reason."""
    try:
        if contents is None:
            raise ValueError("the file could not be fetched")
        reading = {option: options.pop(option) for option in _READING if option in options}
        row = _answered(ringdown(read(contents, name, **reading), **options))
    except (SlipfitError, ValueError, OSError) as error:
        row = {"status": "failed", "reason": str(error)}
    return {"file": name, **row}


def of_files(names: Iterable[str], contents: Iterable[bytes | None], **options: Any) -> pa.Table:
    """One row per file, in order."""
    import pyarrow as pa

    rows = [of_file(name, data, **options) for name, data in zip(names, contents)]
    return pa.Table.from_pylist(rows, schema=schema())
