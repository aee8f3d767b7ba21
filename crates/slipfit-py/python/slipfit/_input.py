"""Arrays of all kinds as vectors of double precision."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, TypeAlias, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import OptionError

Vector: TypeAlias = NDArray[np.float64]
#: A path, or several of them.
Path: TypeAlias = Union[str, "os.PathLike[str]"]
#: A value, or a value with its standard error.
Uncertain: TypeAlias = Union[float, tuple[float, float]]


def refuse(option: str, message: str) -> OptionError:
    """The exception for an argument that cannot be meant."""
    return OptionError(message, "option", details={"option": option})


def vector(name: str, values: ArrayLike) -> Vector:
    """One-dimensional array of double precision; what is masked or missing is NaN.

    Nothing is copied where the values are such an array already, whatever its stride.
    """
    if isinstance(values, np.ma.MaskedArray):
        values = np.ma.filled(values.astype(np.float64), np.nan)
    array = np.asarray(values)
    if array.ndim != 1:
        raise refuse(name, f"{name} has the shape {array.shape} where one dimension is needed")
    if array.dtype.kind == "c":
        raise refuse(name, f"{name} is complex where real numbers are needed")
    if array.dtype.kind in "mM":
        raise refuse(name, f"{name} holds times where numbers are needed")
    try:
        return np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise refuse(name, f"{name} does not hold numbers ({array.dtype}): {error}") from None


def seconds(name: str, values: ArrayLike) -> Vector:
    """Times in seconds; dates and durations are counted from the first."""
    array = np.asarray(values)
    if array.dtype.kind == "M":
        known = array[~np.isnat(array)]
        array = array - (known[0] if known.size else np.datetime64(0, "s"))
    if array.dtype.kind == "m":
        # From the first, so that no digit of a date in nanoseconds is lost.
        missing = np.isnat(array)
        array = array.astype("timedelta64[ns]").astype(np.int64) / 1e9
        array[missing] = np.nan
    return vector(name, array)


def _index_times(index: Any) -> Vector:
    if getattr(index, "tz", None) is not None:
        index = index.tz_convert(None)
    return seconds("time", index.to_numpy())


def time_and_signal(time: Any, signal: Any) -> tuple[Vector | None, Any, str | None]:
    """Times, signal and the unit that a labelled array brings along.

    A pandas Series has its times in its index, an xarray DataArray in the
    coordinate of its one dimension and its unit in ``attrs["units"]``.
    """
    labelled = time if signal is None else signal
    unit: str | None = None
    times: Vector | None = None
    module = type(labelled).__module__.split(".")[0]
    if module == "xarray":
        if labelled.ndim != 1:
            raise refuse("signal", f"signal has the dimensions {labelled.dims} where one is needed")
        given = labelled.attrs.get("units")
        unit = None if given is None else str(given)
        dimension = labelled.dims[0]
        if dimension in labelled.coords:
            times = seconds("time", labelled.coords[dimension].to_numpy())
        values: Any = labelled.to_numpy()
    elif module == "pandas" and hasattr(labelled, "index"):
        if getattr(labelled, "ndim", 1) != 1:
            raise refuse("signal", "signal is a DataFrame: one of its columns is needed")
        # A plain count of rows says nothing about time.
        if type(labelled.index).__name__ != "RangeIndex":
            times = _index_times(labelled.index)
        values = labelled.to_numpy()
    else:
        values = labelled
    if signal is not None and time is not None:
        times = seconds("time", _index_times(time) if hasattr(time, "to_numpy") and hasattr(time, "tz") else time)
    return times, values, unit


def pair(name: str, value: Uncertain | None) -> float | tuple[float, float] | None:
    """A value with or without its standard error."""
    if value is None or isinstance(value, (int, float, np.integer, np.floating)):
        return None if value is None else float(value)
    try:
        number, error = value
        return float(number), float(error)
    except (TypeError, ValueError):
        raise refuse(name, f"{name}={value!r}: a number, or a number and its standard error") from None


def number(name: str, value: float | None) -> float | None:
    """A number, whatever type of number it is."""
    if value is None:
        return None
    try:
        return float(value)
    except (TypeError, ValueError):
        raise refuse(name, f"{name}={value!r}: a number is needed") from None


def band(value: tuple[float, float] | None) -> tuple[float, float] | None:
    """Lower and upper limit."""
    if value is None:
        return None
    try:
        low, high = value
        return float(low), float(high)
    except (TypeError, ValueError):
        raise refuse("band_hz", f"band_hz={value!r}: two frequencies, the lower one first") from None


def constants(given: Mapping[str, Uncertain | None]) -> dict[str, float | tuple[float, float] | None]:
    """Mechanical constants as the extension takes them."""
    return {name: pair(name, value) for name, value in given.items()}


def path_like(source: object) -> bool:
    """Whether this names a file."""
    return isinstance(source, (str, os.PathLike))
