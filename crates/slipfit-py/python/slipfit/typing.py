"""Types of arguments, for annotations in user code.

Examples
--------
>>> import slipfit
>>> from slipfit.typing import Scalar
>>> def forced(stiffness: Scalar) -> slipfit.RingdownAnswer:
...     return slipfit.ringdown("swing.csv", stiffness=stiffness)
"""

from __future__ import annotations

import datetime
import os
from typing import Literal, SupportsFloat, TypeAlias, Union

import numpy as np

__all__ = ["Band", "Column", "Interval", "Kind", "Motion", "Path", "PerRow", "Scalar", "Uncertain"]

#: A number, or a value with a unit of pint, astropy, unyt, xarray or slipfit, which is converted or refused.
Scalar: TypeAlias = Union[float, SupportsFloat]
#: A value, exact or with its standard error, such as a parameter of another answer.
Uncertain: TypeAlias = Union[Scalar, tuple[Scalar, Scalar]]
#: Lower and upper frequency.
Band: TypeAlias = tuple[Scalar, Scalar]
#: A number of seconds, or a duration.
Interval: TypeAlias = Union[Scalar, datetime.timedelta, np.timedelta64]
#: A number for all rows, or the name of a column of numbers.
PerRow: TypeAlias = Union[Scalar, str]
#: A file.
Path: TypeAlias = Union[str, os.PathLike[str]]
#: A column of a file by name or by number from 1.
Column: TypeAlias = Union[str, int]
#: Kinds of a record.
Kind: TypeAlias = Literal["displacement", "velocity", "acceleration", "envelope", "lock-in"]
#: Kinds of the response of a curve.
Motion: TypeAlias = Literal["displacement", "velocity", "acceleration"]
