"""Units of single values: those of options are fixed, or are those of the samples."""

from __future__ import annotations

import re
from typing import Any

#: Units of options by their names, and by the endings of their names; any other option is a pure number.
_OF_OPTIONS = {"dt": "s", "stiffness": "N/m", "mass": "kg", "torsion_stiffness": "N m/rad", "inertia": "kg m²"}
_OF_ENDINGS = {"_hz": "Hz", "_per_s": "1/s", "_s": "s", "_rad": "rad"}


def of_option(name: str) -> str:
    """The unit in which an option is taken; empty for a pure number."""
    endings = (unit for ending, unit in _OF_ENDINGS.items() if name.endswith(ending))
    return _OF_OPTIONS.get(name) or next(endings, "")


def spelled(unit: Any) -> str:
    """The text of a unit of pint, astropy or unyt."""
    try:
        # pint writes unit names in full unless symbols are requested.
        text = format(unit, "~C")
    except (TypeError, ValueError):
        text = str(unit)
    return "" if text == "dimensionless" else re.sub(r"\s*([*/])\s*", r"\1", text)
