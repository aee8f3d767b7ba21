"""Units of single values: those of options are fixed, or those of the samples."""

from __future__ import annotations

import re
from typing import Any

from . import _core

#: Units of options by their names, and by the endings of their names; any other is a pure number.
_OF_OPTIONS = {"dt": "s", "stiffness": "N/m", "mass": "kg", "torsion_stiffness": "N m/rad", "inertia": "kg m²"}
_OF_ENDINGS = {"_hz": "Hz", "_per_s": "1/s", "_s": "s", "_rad": "rad"}

#: Powers of length, mass, time, voltage and current in what a product may hold.
_POWERS = {
    "s": (0, 0, 1, 0, 0), "m": (1, 0, 0, 0, 0), "kg": (0, 1, 0, 0, 0), "N": (1, 1, -2, 0, 0),
    "rad": (0, 0, 0, 0, 0), "V": (0, 0, 0, 1, 0), "A": (0, 0, 0, 0, 1),
}  # fmt: skip
_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_FACTOR = re.compile(r"([a-zµμ°]+)(?:\*\*|\^)?\(?([-+]?\d+)?\)?", re.IGNORECASE)


def of_option(name: str) -> str:
    """The unit in which an option is taken; empty for a pure number."""
    endings = (unit for ending, unit in _OF_ENDINGS.items() if name.endswith(ending))
    return _OF_OPTIONS.get(name) or next(endings, "")


def spelled(unit: Any) -> str:
    """The text of a unit of pint, astropy or unyt."""
    try:
        # pint spells its units out unless it is asked for symbols.
        text = format(unit, "~C")
    except (TypeError, ValueError):
        text = str(unit)
    return "" if text == "dimensionless" else re.sub(r"\s*([*/])\s*", r"\1", text)


def ratio(unit: str, wanted: str) -> float | None:
    """What turns numbers in a unit into numbers in another of the same quantity; None where none is known."""
    known = _core.unit_factor(unit, wanted)
    if known is not None:
        return known
    given, needed = _product(unit), _product(wanted)
    if given is None or needed is None or given[1] != needed[1]:
        return None
    return given[0] / needed[0]


def _product(unit: str) -> tuple[float, list[int]] | None:
    """Factor to SI and powers of the base units of a product such as `N/mm` or `kg*m**2`."""
    text = unit.translate(_RAISED).replace("**", "^")
    size, powers = 1.0, [0] * 5
    below = held = False
    parts = re.findall(r"[a-zµμ°]+(?:\^?\(?[-+]?\d+\)?)?|[/()*·⋅.\s]|1(?!\d)|.", text, re.IGNORECASE)
    for part in parts:
        if part == "/":
            below = True
        elif part in "()":
            # A quotient's lower part may stand in brackets.
            held = part == "("
            below = below and held
        elif part == "1" or part in "*·⋅." or part.isspace():
            continue
        else:
            found = _FACTOR.fullmatch(part)
            one = None if found is None else _simple(found[1])
            if found is None or one is None:
                return None
            power = int(found[2] or 1) * (-1 if below else 1)
            size *= one[0] ** power
            powers = [total + power * own for total, own in zip(powers, one[1])]
            below = below and held
    return size, powers


def _simple(unit: str) -> tuple[float, tuple[int, ...]] | None:
    for base, powers in _POWERS.items():
        factor = _core.unit_factor(unit, base)
        if factor is not None:
            return factor, powers
    return None
