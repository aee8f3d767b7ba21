"""Arrays of all kinds as vectors of double precision."""

from __future__ import annotations

import datetime
import operator
import os
from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arguments import shown, wrong_type
from ._errors import OptionError

Vector: TypeAlias = NDArray[np.float64]
#: A path, or several of them.
Path: TypeAlias = Union[str, os.PathLike[str]]
#: A value, or a value with its standard error.
Uncertain: TypeAlias = Union[float, tuple[float, float]]


def refuse(option: str, message: str) -> OptionError:
    """The exception for an argument that cannot be meant."""
    return OptionError(message, "option", details={"option": option})


#: Seconds in the units of time that labelled arrays name.
_SECONDS = {
    "s": 1.0, "sec": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "millisecond": 1e-3, "milliseconds": 1e-3,
    "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "microsecond": 1e-6, "microseconds": 1e-6,
    "ns": 1e-9, "nanosecond": 1e-9, "nanoseconds": 1e-9, "min": 60.0, "minute": 60.0, "minutes": 60.0,
    "h": 3600.0, "hour": 3600.0, "hours": 3600.0,
}  # fmt: skip


def unmasked(values: Any) -> Any:
    """A masked array with NaN in place of what is masked, anything else as it is."""
    if not isinstance(values, np.ma.MaskedArray):
        return values
    if values.dtype.kind in "mM":
        return values.filled(np.datetime64("NaT") if values.dtype.kind == "M" else np.timedelta64("NaT"))
    if values.dtype.kind in "fc":
        return values.filled(np.nan)
    numbers: Any = values.astype(object if values.dtype.kind == "O" else np.float64)
    return numbers.filled(np.nan)


def held(name: str, values: Any) -> NDArray[Any]:
    """Whatever can be an array, as one."""
    if type(values) is np.ndarray:
        return values
    try:
        array = np.asarray(unmasked(values))
    except Exception as error:  # an object's own conversion raises what it likes
        raise wrong_type(name, values, f"an array is needed ({error})") from None
    if not array.ndim and not hasattr(values, "shape"):
        raise wrong_type(name, values, "an array is needed")
    return array


def vector(name: str, values: ArrayLike) -> Vector:
    """One-dimensional array of double precision; what is masked or missing is NaN.

    Nothing is copied where the values are such an array already, whatever its stride.
    """
    array = held(name, values)
    if array.ndim != 1:
        raise refuse(name, f"{name} has the shape {array.shape} where one dimension is needed")
    if array.dtype.kind == "c":
        raise refuse(name, f"{name} is complex where real numbers are needed")
    if array.dtype.kind in "mM":
        raise refuse(name, f"{name} holds times where numbers are needed")
    try:
        return np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise refuse(name, f"{name} does not hold numbers ({array.dtype}): {error}") from None


def seconds(name: str, values: ArrayLike) -> Vector:
    """Times in seconds; dates are counted from the first."""
    if getattr(getattr(values, "dtype", None), "tz", None) is not None:
        # A column of pandas whose dates have a time zone.
        dates: Any = values
        values = dates.dt.tz_convert(None)
    array = held(name, values)
    if array.dtype.kind == "O" and array.ndim == 1:
        array = _moments(array)
    if array.dtype.kind == "M":
        known = array[~np.isnat(array)]
        array = array - (known[0] if known.size else np.datetime64(0, "s"))
    if array.dtype.kind == "m":
        # From the first, so that no digit of a date in nanoseconds is lost.
        missing = np.isnat(array)
        array = array.astype("timedelta64[ns]").astype(np.int64) / 1e9
        array[missing] = np.nan
    return vector(name, array)


def _moments(array: NDArray[np.object_]) -> NDArray[Any]:
    """Dates or durations held as objects of their own; anything else as it is."""
    known = [one for one in array if not _missing(one)]
    if known and all(isinstance(one, datetime.timedelta) for one in known):
        return np.array([np.timedelta64("NaT") if _missing(one) else one for one in array], "timedelta64[ns]")
    if known and all(isinstance(one, datetime.datetime) for one in known):
        return np.array([np.datetime64("NaT") if _missing(one) else _naive(one) for one in array], "datetime64[ns]")
    return array


def _missing(one: Any) -> bool:
    """Whether an object stands for no value: None, NaN and NaT, which differ from themselves, or the NA of pandas."""
    try:
        return one is None or bool(one != one)
    except TypeError:
        return True


def _naive(moment: datetime.datetime) -> datetime.datetime:
    """A date without its time zone, in that of Greenwich."""
    return moment if moment.tzinfo is None else moment.astimezone(datetime.timezone.utc).replace(tzinfo=None)


def coordinate_seconds(coordinate: Any) -> Vector:
    """Times of a coordinate of xarray, in the unit that it names."""
    times = seconds("time", coordinate.to_numpy())
    unit = coordinate.attrs.get("units")
    if unit is None or coordinate.dtype.kind in "mM":
        return times
    if str(unit) not in _SECONDS:
        raise refuse("time", f"the times are in {str(unit)!r}: s, ms, us, ns, min or h are known")
    return times * _SECONDS[str(unit)]


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
        if not hasattr(labelled, "ndim"):
            kind = type(labelled).__name__
            raise wrong_type("signal", labelled, f"one of the variables of the {kind} is needed")
        if labelled.ndim != 1:
            raise refuse("signal", f"signal has the dimensions {labelled.dims} where one is needed")
        given = labelled.attrs.get("units")
        unit = None if given is None else str(given)
        dimension = labelled.dims[0]
        if dimension in labelled.coords:
            times = coordinate_seconds(labelled.coords[dimension])
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


def number(name: str, value: Any) -> float:
    """A number, whatever type of number it is."""
    try:
        return float(value)
    except OverflowError:
        raise refuse(name, f"{name}={shown(value)}: beyond all numbers of double precision") from None
    except (TypeError, ValueError):
        raise wrong_type(name, value, "a number is needed") from None


def optional(name: str, value: float | None) -> float | None:
    """A number or nothing."""
    return None if value is None else number(name, value)


def whole(name: str, value: int | None) -> int | None:
    """A count or nothing."""
    if value is None:
        return None
    count = operator.index(value)
    if not 0 <= count < 1 << 32:
        raise refuse(name, f"{name}={shown(count)}: a whole number from zero to {(1 << 32) - 1} is needed")
    return count


def pair(name: str, value: Uncertain | None) -> float | tuple[float, float] | None:
    """A value with or without its standard error."""
    if isinstance(value, Iterable) and np.ndim(value):
        first, error = value
        return number(name, first), number(name, error)
    return None if value is None else number(name, value)


def band(value: tuple[float, float] | None) -> tuple[float, float] | None:
    """Lower and upper limit."""
    if value is None:
        return None
    low, high = (number("band_hz", one) for one in value)
    if low >= high:
        raise refuse("band_hz", f"band_hz={shown(value)}: a rising pair of frequencies is needed")
    return low, high


def constants(given: Mapping[str, Uncertain | None]) -> dict[str, float | tuple[float, float] | None]:
    """Mechanical constants as the extension takes them."""
    return {name: pair(name, value) for name, value in given.items()}


def path_like(source: object) -> bool:
    """Whether this names a file."""
    return isinstance(source, (str, os.PathLike))
