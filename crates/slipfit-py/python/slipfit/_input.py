"""Converts arrays of all kinds to vectors of double precision."""

from __future__ import annotations

import datetime
import functools
import operator
import os
import re
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _units
from ._arguments import shown, wrong_type
from ._errors import OptionError
from .typing import Band, Scalar, Uncertain

Vector: TypeAlias = NDArray[np.float64]


def refuse(option: str, message: str) -> OptionError:
    """The exception for an invalid argument."""
    return OptionError(message, "option", details={"option": option})


def unmasked(values: Any) -> Any:
    """A masked array with NaN in place of masked values; anything else unchanged."""
    if not isinstance(values, np.ma.MaskedArray):
        return values
    if values.dtype.kind in "mM":
        return values.filled(np.datetime64("NaT") if values.dtype.kind == "M" else np.timedelta64("NaT"))
    if values.dtype.kind in "fc":
        return values.filled(np.nan)
    numbers: Any = values.astype(object if values.dtype.kind in "Ob" else np.float64)
    return numbers.filled(np.nan)


def _measured(values: Any) -> tuple[Any, str] | None:
    """Numbers and unit of an object with both, such as those of pint, astropy and unyt; None otherwise."""
    # A scalar of pint has no shape.
    if type(values) is np.ndarray or not (hasattr(values, "shape") or hasattr(values, "magnitude")):
        return None
    for number, unit in (("magnitude", "units"), ("value", "unit"), ("value", "units")):
        if hasattr(values, number) and hasattr(values, unit):
            held, named = getattr(values, number), getattr(values, unit)
            if hasattr(named, "shape"):
                # These are columns of a frame or of records.
                return None
            return held, _units.spelled(named)
    return None


def numbers(values: Any) -> Any:
    """The numbers of an array with a unit; anything else unchanged."""
    measured = _measured(values)
    return values if measured is None else measured[0]


def held(name: str, values: Any) -> NDArray[Any]:
    """The value as an array, if it can be converted to one."""
    if type(values) is np.ndarray:
        return values
    try:
        array = np.asarray(unmasked(numbers(values)))
    except Exception as error:  # an object's own conversion raises what it likes
        raise wrong_type(name, values, f"an array is needed ({error})") from None
    if not array.ndim and not hasattr(values, "shape"):
        raise wrong_type(name, values, "an array is needed")
    return array


def vector(name: str, values: ArrayLike) -> Vector:
    """One-dimensional array of double precision; masked and missing values are NaN.

    Nothing is copied if the values are such an array already, whatever its stride.
    """
    array = held(name, values)
    if array.ndim != 1:
        raise refuse(name, f"{name} has the shape {array.shape} where one dimension is needed")
    if array.dtype.kind == "c":
        raise refuse(name, f"{name} is complex where real numbers are needed")
    if array.dtype.kind in "mM":
        raise refuse(name, f"{name} holds times where numbers are needed")
    if array.dtype.kind == "b" or array.dtype.kind == "O" and any(isinstance(one, (bool, np.bool_)) for one in array):
        raise refuse(name, f"{name} holds True and False where numbers are needed: {name}.astype(float) makes 1 and 0 of them")
    try:
        return _doubles(array)
    except (TypeError, ValueError, ArithmeticError) as error:
        raise refuse(name, f"{name} does not hold numbers ({array.dtype}): {error}") from None


def _doubles(array: NDArray[Any]) -> Vector:
    # Values beyond the range of doubles become infinite: left out and counted, like any infinite sample.
    with np.errstate(over="ignore"):
        try:
            return np.asarray(array, dtype=np.float64)
        except TypeError:
            if array.dtype.kind != "O":
                raise
            return np.array([np.nan if _missing(one) else one for one in array], dtype=np.float64)


def is_of_xarray(values: Any) -> bool:
    """Whether this is an xarray array or data set."""
    return _package(values) == "xarray"


def own_unit(values: Any) -> str | None:
    """The unit stated by an xarray array or a data set of a file, or attached to the array."""
    if _package(values) in ("h5py", "zarr"):
        # Under the keys that the reader of such files uses.
        stated = [values.attrs[key] for key in ("units", "unit") if key in values.attrs]
        unit = np.asarray(stated[0]).reshape(-1)[:1].tolist() if stated else []
        return (unit[0].decode(errors="replace") if isinstance(unit[0], bytes) else str(unit[0])) or None if unit else None
    if not is_of_xarray(values):
        measured = _measured(values)
        return measured[1] or None if measured is not None else None
    unit = getattr(values, "attrs", {}).get("units")
    return own_unit(getattr(values, "data", None)) if unit is None else str(unit)


def _package(values: Any) -> str:
    """The package of the type of an object."""
    return type(values).__module__.split(".")[0]


def _named_unit(values: Any) -> str | None:
    """The unit in the name of a column of pandas, polars or xarray, parsed like the header of a file."""
    name = getattr(values, "name", None)
    labelled = _package(values) in ("pandas", "polars", "xarray")
    return _core.unit_of_name(name) if labelled and isinstance(name, str) else None


def unit_known(values: Any) -> str | None:
    """The unit of an array, or else the unit in its name."""
    return own_unit(values) or _named_unit(values)


def unit_told(name: str, own: str | None, unit: str | None, option: str = "unit") -> str | None:
    """The unit of samples: the given one, or that of the array if it has one. Both must agree."""
    if unit is None or not own or own == unit:
        return own if unit is None else unit
    factor = _core.unit_factor(own, unit)
    if factor == 1:
        return unit
    told = f"{option}={unit!r} beside {name} in {own!r}"
    if factor is None:
        raise refuse(option, f"{told}: give numbers without a unit, such as numpy.asarray({name})")
    raise refuse(option, f"{told}: convert {name} to {unit!r}, or leave {option} out")


def check_any(columns: Mapping[str, Vector | None], names: Mapping[str, str]) -> None:
    """Refuses a column without a number, under the name of its argument."""
    for column, numbers in columns.items():
        if numbers is not None and numbers.size and not np.isfinite(numbers).any():
            name = names.get(column, column)
            raise refuse(name, f"{name} holds no number: every value is missing or infinite")


def alike(name: str, values: ArrayLike, unit: str | None) -> Vector:
    """Numbers that accompany others in this unit, converted to it if they state a unit."""
    scale = factor_alike(name, unit_known(values), unit)
    return vector(name, values) if scale == 1 else vector(name, values) * scale


def factor_alike(name: str, own: str | None, unit: str | None) -> float:
    """Factor that converts numbers to the unit of those they accompany; 1 if either states no unit."""
    if not own or not unit or own == unit:
        return 1.0
    found = _core.unit_factor(own, unit)
    if found is None:
        raise refuse(name, f"{name} is in {own!r}, what it belongs to in {unit!r}")
    return found


def radians(name: str, values: ArrayLike) -> Vector:
    """Angles in rad; those that state a unit are converted from it."""
    return _in_unit(name, vector(name, values), values, "rad", "rad, mrad, deg and turns")


def _in_unit(name: str, numbers: Vector, given: Any, wanted: str, words: str) -> Vector:
    """The given numbers, converted to the wanted unit if they or their name state another of the same quantity."""
    unit = unit_known(given)
    if not unit:
        return numbers
    named = None if own_unit(given) else given.name
    return numbers * factor_to(name, unit, wanted, words, named, f"{name}.to_numpy() has no name")


def factor_to(name: str, unit: str, wanted: str, words: str, named: str | None, without: str) -> float:
    """Factor from a unit, stated by the numbers or by their name, to the wanted unit."""
    factor = _core.unit_factor(unit, wanted)
    if factor is None:
        by_name = "" if named is None else f" by its name {named!r}"
        advice = "" if named is None else f"; {without}"
        raise refuse(name, f"{name} is in {unit!r}{by_name}: {words} are known{advice}")
    return factor


#: Units of frequencies and of times, for messages.
FREQUENCIES, TIMES = "mHz, Hz, kHz, MHz, GHz and rad/s", "s, ms, us, ns, min, h and days"


def hertz(name: str, values: ArrayLike) -> Vector:
    """Frequencies in Hz; those of xarray are converted from the unit that they state."""
    return _in_unit(name, vector(name, values), values, "Hz", FREQUENCIES)


def seconds(name: str, values: ArrayLike) -> Vector:
    """Times in seconds; dates count from the first one, numbers are converted from their stated unit."""
    given = values
    if getattr(getattr(values, "dtype", None), "tz", None) is not None:
        # A column, an index or an array of pandas whose dates have a time zone.
        dates: Any = values
        values = getattr(dates, "dt", dates).tz_convert(None)
    array = held(name, values)
    if array.dtype.kind == "O" and array.ndim == 1:
        array = _moments(name, array)
    if array.dtype.kind == "M":
        if np.datetime_data(array.dtype)[0] in ("Y", "M"):
            # Months differ in length, so their first days are used.
            array = array.astype("datetime64[D]")
        known = array[~np.isnat(array)]
        array = array - (known[0] if known.size else np.datetime64(0, "s"))
    if array.dtype.kind == "m":
        return _durations(name, array)
    try:
        numbers = vector(name, array)
    except OptionError:
        if array.ndim != 1 or not all(isinstance(one, str) for one in array[:1]):
            raise
        dates = f"pandas.to_datetime({name}) makes dates of texts"
        raise refuse(name, f"{name} holds texts that are no numbers, such as {shown(str(array[0]))}: {dates}") from None
    return _in_unit(name, numbers, given, "s", TIMES)


def interval(name: str, value: Any) -> float | None:
    """A number of seconds, a duration converted to one, or nothing."""
    if isinstance(value, datetime.timedelta):
        return value.total_seconds()
    if isinstance(value, np.timedelta64):
        return float(_durations(name, np.array([value]))[0])
    return optional(name, value)


def time_dimension(array: Any) -> Any:
    """The time dimension of an xarray array: the one of this name, or the only one with a time coordinate."""
    for wanted in _TIME_NAMES:
        found = [name for name in array.dims if _is_named(name, wanted)]
        if found:
            return found[0]
    timed = [name for name in array.dims if time_coordinate(array, name) is not None]
    return timed[0] if len(timed) == 1 else None


def time_coordinate(array: Any, dimension: Any) -> Any:
    """The time coordinate along an xarray dimension, by name, dates or durations, or unit; None if there is none."""
    along = [name for name, one in array.coords.items() if one.dims == (dimension,)]
    along.sort(key=lambda name: name != dimension)

    def of_time(name: Any) -> bool:
        coordinate = array.coords[name]
        unit = own_unit(coordinate)
        return coordinate.dtype.kind in "mM" or bool(unit and coordinate.dtype.kind in "fiu" and _core.unit_factor(unit, "s"))

    for wanted in _TIME_NAMES:
        found = [name for name in along if _is_named(name, wanted)]
        if found:
            return found[0]
    return next((name for name in along if of_time(name)), None)


def _is_named(name: Any, wanted: str) -> bool:
    """Whether this is a name, alone or before its unit."""
    return _NAME.split(str(name).lower(), 1)[0] == wanted


#: Names of times.
_TIME_NAMES = ("time", "t")

#: Separator between a name and its unit.
_NAME = re.compile(r"\s*[(\[{/]")


def even_step(name: object, coordinate: Any, otherwise: str) -> float:
    """Interval of uniform times [s]."""
    times = seconds("time", coordinate)
    steps = np.diff(times)
    # Times of single precision are uniform only to their last digit.
    digit = np.finfo(coordinate.dtype).eps if coordinate.dtype.kind == "f" else 0.0
    step = float(times[-1] - times[0]) / max(1, steps.size) if times.size else 0.0
    if steps.size and step <= 0:
        raise refuse("dt", f"the coordinate {name!r} does not rise: sort by it")
    if not steps.size or not np.abs(steps - step).max() <= 1e-6 * step + 2 * digit * np.abs(times).max():
        raise refuse("dt", f"the coordinate {name!r} is not even: {otherwise}")
    return step


def step_of(coordinate: Any, name: object, dt: Any, otherwise: str) -> float:
    """Interval of uniform times [s]; no other interval is accepted."""
    if dt is None:
        return even_step(name, coordinate, otherwise)
    step = interval("dt", dt)
    assert step is not None
    if step > 0:
        # Any other value is refused when the options are checked.
        check_step("dt", step, name, coordinate)
    return step


def check_step(option: str, step: float, name: object, coordinate: Any) -> None:
    """Refuses an interval [s] that contradicts a coordinate of times."""
    times = seconds("time", coordinate)
    away = np.abs(times - times[:1] - step * np.arange(times.size))
    digit = np.finfo(coordinate.dtype).eps if coordinate.dtype.kind == "f" else 0.0
    # A stamp may be rounded.
    if not (away <= 0.01 * step + 2 * digit * np.abs(times)).all():
        own = f", whose step is {(times[-1] - times[0]) / (times.size - 1):g} s" if times.size > 1 else ""
        given = f"{option} is given as {step:g} s" if option == "dt" else f"{option} is given as {1 / step:g} Hz"
        raise refuse(option, f"{given} beside the coordinate {name!r}{own}: leave {option} out, or drop_vars({name!r}) leaves the coordinate out")


def check_order(name: str, times: Vector) -> None:
    """Refuses decreasing times, which the reader of a file would split into runs or sort."""
    known = np.flatnonzero(np.isfinite(times))
    back = np.flatnonzero(np.diff(times[known]) < 0)
    if back.size:
        index = int(known[back[0] + 1])
        previous, following = float(times[known[back[0]]]), float(times[index])
        raise OptionError(
            f"{name} goes backwards, {previous:g} s then {following:g} s, at index {index}: sort the samples by time, "
            "or give one of several runs",
            "time_backwards", details={"option": name, "index": index, "previous": previous, "next": following},
        )  # fmt: skip


#: Seconds per larger unit of NumPy's durations, and number of smaller units per second.
_LONG = {"W": 604800, "D": 86400, "h": 3600, "m": 60, "s": 1}
_SHORT = {"ms": 1e3, "us": 1e6, "ns": 1e9, "ps": 1e12, "fs": 1e15, "as": 1e18}


def _durations(name: str, array: NDArray[Any]) -> Vector:
    """Durations in seconds, from integer counts of their unit, so that no digit is lost."""
    unit, step = np.datetime_data(array.dtype)
    if unit not in _LONG and unit not in _SHORT:
        words = "no unit" if unit == "generic" else "months or years, which differ in length"
        raise refuse(name, f"{name} holds durations of {words} ({array.dtype})")
    counts = array.astype(np.int64) * float(step)
    times = counts * _LONG[unit] if unit in _LONG else counts / _SHORT[unit]
    times[np.isnat(array)] = np.nan
    return vector(name, times)


def _moments(name: str, array: NDArray[np.object_]) -> NDArray[Any]:
    """Dates or durations stored as Python objects, converted to an array; anything else unchanged."""
    known = [one for one in array if not _missing(one)]
    if known and all(isinstance(one, datetime.timedelta) for one in known):
        return np.array([np.timedelta64("NaT") if _missing(one) else one for one in array], "timedelta64[ns]")
    if known and all(isinstance(one, datetime.datetime) for one in known):
        if len({one.tzinfo is None for one in known}) > 1:
            raise refuse(name, f"{name} mixes dates with and without a time zone")
        return np.array([np.datetime64("NaT") if _missing(one) else _naive(one) for one in array], "datetime64[ns]")
    return array


def _missing(one: Any) -> bool:
    """Whether an object is a missing value: None, NaN and NaT, which differ from themselves, or NA of pandas."""
    try:
        return one is None or bool(one != one)
    except TypeError:
        return True


def _naive(moment: datetime.datetime) -> datetime.datetime:
    """A date converted to UTC, without its time zone."""
    return moment if moment.tzinfo is None else moment.astimezone(datetime.timezone.utc).replace(tzinfo=None)


def columns_of(table: Any) -> str:
    """Names of the columns of a data frame, for a message; empty for anything else."""
    names = [shown(str(name)) for name in getattr(table, "columns", ())]
    return ", ".join(names[:_NAMED]) + (", …" if len(names) > _NAMED else "")


def has_columns(table: Any) -> bool:
    """Whether this is a table: a single column, such as a Series, has Arrow's interface too."""
    return any(hasattr(table, name) for name in ("columns", "column_names", "schema"))


#: Maximum number of columns named in a message.
_NAMED = 8


def _counts_rows(index: Any) -> bool:
    """Whether a pandas index counts rows, some of which may have been removed: it contains no times."""
    return type(index).__name__ == "RangeIndex" or (index.dtype.kind in "iu" and index.name is None)


def _counts(coordinate: Any) -> bool:
    """Whether an xarray coordinate counts samples and contains no times."""
    return coordinate.dtype.kind in "iu" and not unit_known(coordinate)


def check_same_rows(option: str, given: Any, beside: str, other: Any) -> None:
    """Refuses a pandas Series whose rows differ from those of its companion: they would be matched by position."""
    both = [one for one in (given, other) if _package(one) == "pandas" and hasattr(one, "index")]
    if len(both) == 2 and not both[0].index.equals(both[1].index):
        raise refuse(
            option, f"{option} has another index than {beside}: {option}.reindex({beside}.index) has its rows, {option}.to_numpy() no index"
        )


def check_every_row(given: Any, rate_hz: Scalar) -> None:
    """Refuses a labelled array with removed rows or its own times if the rows are counted with a rate."""
    if is_of_xarray(given):
        (dimension,) = given.dims
        name = time_coordinate(given, dimension)
        rate = number("rate_hz", rate_hz)
        if name is None and dimension in given.coords and _counts(given.coords[dimension]):
            steps = np.diff(given.coords[dimension].to_numpy())
            if steps.size and (steps != steps[0]).any():
                raise refuse("signal", "samples of signal are missing or out of order, where rate_hz counts them: keep them as NaN")
        elif name is not None or dimension in given.coords:
            name = dimension if name is None else name
            if rate > 0:
                check_step("rate_hz", 1 / rate, name, given.coords[name])
        return
    if _package(given) != "pandas" or not hasattr(given, "index"):
        return
    if getattr(given.index, "nlevels", 1) == 1 and _counts_rows(given.index):
        steps = np.diff(given.index.to_numpy())
        if steps.size and (steps != steps[0]).any():
            raise refuse("signal", "rows of signal are missing or out of order, where rate_hz counts them: keep them as NaN")
    elif getattr(given.index, "nlevels", 1) == 1 and given.index.to_numpy().dtype.kind in "fiumM":
        raise refuse("rate_hz", "rate_hz is given beside the index of signal, which tells the time: signal.to_numpy() has none")


def _index(axis: str, index: Any) -> Vector:
    """A pandas index as times or frequencies, converted from the unit in its name if it has one."""
    if getattr(index, "nlevels", 1) > 1:
        raise refuse(axis, f"the index has {index.nlevels} levels: give one of them, or another array, as {axis}")
    if axis != "time":
        return hertz(axis, index)
    if hasattr(index, "to_timestamp"):
        # Periods begin at their stamp.
        index = index.to_timestamp()
    if getattr(index, "tz", None) is not None:
        index = index.tz_convert(None)
    return seconds(axis, index)


def _labelled(axis: str, option: str, given: Any) -> tuple[Vector | None, Any, str | None] | None:
    """Times or frequencies, values and unit of a labelled array; None for anything else."""
    if is_of_xarray(given):
        if not hasattr(given, "ndim"):
            raise wrong_type(option, given, f"one of the variables of the {type(given).__name__} is needed")
        if given.ndim != 1:
            raise refuse(option, f"{option} has the dimensions {given.dims} where one is needed")
        convert = seconds if axis == "time" else hertz
        # A dimension without a coordinate counts samples: xarray would return their numbers.
        (dimension,) = given.dims
        timed = time_coordinate(given, dimension) if axis == "time" else None
        along = dimension if timed is None else timed
        known = along in given.coords
        return convert(axis, given.coords[along]) if known else None, given.to_numpy(), own_unit(given)
    if _package(given) == "pandas" and hasattr(given, "index"):
        if getattr(given, "ndim", 1) != 1:
            raise refuse(option, f"{option} is a DataFrame: one of its columns is needed")
        counted = _counts_rows(given.index) if axis == "time" else type(given.index).__name__ == "RangeIndex"
        return None if counted else _index(axis, given.index), given.to_numpy(), None
    return None


def named(given: Any, own: str | None, told: str | None) -> tuple[str | None, str | None]:
    """Unit of samples, as given or else from their name, and the unit of the numbers themselves."""
    of_numbers = own or unit_of_samples(_named_unit(given)) or told
    return of_numbers if told is None else told, of_numbers


def unit_of_samples(named: str | None) -> str | None:
    """The unit in the name of samples, unless it is a unit of time or frequency; angular velocities are samples."""
    other = named and any(_core.unit_factor(named, of) for of in ("s", "Hz"))
    return None if not named or other and samples_in(named)[1] != "velocity" else named


@functools.lru_cache
def samples_in(unit: str) -> tuple[str, str, bool]:
    """How :func:`ringdown` reads samples in a unit: resulting unit, kind, and whether they were levels in dB."""
    samples = np.array([0.0, 1.0, 0.5, 2.0, 0.5, 1.0, 0.0, 1.5])
    read = _core.record_of_arrays(np.arange(8.0), samples, None, None, unit or None, None)
    return read.unit, read.kind, not np.array_equal(read.signal, samples)


def frequency_and_response(labelled: Any) -> tuple[Vector | None, Any, str | None]:
    """Frequencies, response and unit of a labelled array; None for anything else."""
    return _labelled("frequency", "frequency", labelled) or (None, None, None)


def is_labelled(given: Any) -> bool:
    """Whether this is a Series of pandas or an array of xarray, which has its times or the like."""
    return is_of_xarray(given) or _package(given) == "pandas" and hasattr(given, "index")


def drive_and_amplitude(given: Any) -> tuple[Any, Any]:
    """Levels and amplitudes of a labelled array; two times None for anything else."""
    if not is_labelled(given):
        return None, None
    if is_of_xarray(given):
        if not hasattr(given, "ndim"):
            raise wrong_type("drive", given, f"one of the variables of the {type(given).__name__} is needed")
        if given.ndim != 1:
            raise refuse("drive", f"drive has the dimensions {given.dims} where one is needed")
        (dimension,) = given.dims
        return (given.coords[dimension], given) if dimension in given.coords else (None, None)
    if getattr(given, "ndim", 1) != 1:
        raise refuse("drive", f"drive is a table of one column: the column itself is needed; there is {columns_of(given)}")
    if getattr(given.index, "nlevels", 1) > 1:
        raise refuse("drive", f"the index has {given.index.nlevels} levels: give one of them, or another array, as drive")
    return (None, None) if type(given.index).__name__ == "RangeIndex" else (given.index, given)


def time_and_signal(time: Any, signal: Any) -> tuple[Vector | None, Any, str | None]:
    """Times, signal and the unit of a labelled array.

    A pandas Series has its times in its index, an xarray DataArray in the
    coordinate of its one dimension and its unit in ``attrs["units"]``; arrays of
    pint and astropy have their unit.
    """
    given = time if signal is None else signal
    times, values, unit = _labelled("time", "signal", given) or (None, given, own_unit(given))
    if signal is not None and time is not None:
        indexed = hasattr(time, "to_numpy") and hasattr(time, "nlevels")
        times = _index("time", time) if indexed else seconds("time", time)
    return times, values, unit


def unit_of_one(value: Any) -> str | None:
    """The unit of a single value: empty for an explicit pure number, None if it states no unit."""
    if isinstance(value, (list, tuple)) and len(value):
        # A value and its standard error.
        return unit_of_one(value[0])
    if isinstance(value, (int, float)):
        return None
    if hasattr(value, "std_error"):
        # A parameter of an answer.
        unit = getattr(value, "unit", None)
        return None if unit is None else str(unit)
    if is_of_xarray(value):
        return own_unit(value)
    measured = _measured(value)
    return None if measured is None else measured[1]


def factor(name: str, own: str | None, samples: str | None) -> float:
    """Factor that converts a value from its own unit to that of its option, or to that of the samples."""
    wanted = _units.of_option(name) if samples is None else samples
    # If the samples have no unit, a parameter of them has none either.
    if own is None or own == wanted or samples is not None and not own:
        return 1.0
    if samples is None and not wanted:
        found = _core.unit_factor(own, "1")
    else:
        found = _core.unit_factor(own, wanted) if own and wanted else None
    if found is not None:
        return found
    given = f"{name} is in {own!r}" if own else f"{name} is a pure number"
    if samples is None:
        raise refuse(name, f"{given} where {f'a value in {wanted}' if wanted else 'a pure number'} is needed")
    beside = f"in {samples!r}" if samples else "in no unit: give unit"
    raise refuse(name, f"{given}, what it belongs to {beside}")


def number(name: str, value: Any, samples: str | None = None) -> float:
    """A number of any numeric type; one with a unit is converted to that of its option.

    `samples` is the unit of the samples, for an option in that unit; empty if it is unknown.
    """
    own = unit_of_one(value)
    if own is not None:
        held = value.value if hasattr(value, "std_error") else numbers(value)
        return factor(name, own, samples) * _float(name, held)
    return _float(name, value)


def _float(name: str, value: Any) -> float:
    try:
        return float(value)
    except OverflowError:
        raise refuse(name, f"{name}={shown(value)}: beyond all numbers of double precision") from None
    except (TypeError, ValueError):
        raise wrong_type(name, value, "a number is needed") from None


def optional(name: str, value: Scalar | None) -> float | None:
    """A number or nothing."""
    return None if value is None else number(name, value)


def of_samples(name: str, value: Any, unit: str, uncertain: bool = False) -> Any:
    """A value with its own unit, converted to that of the samples; anything else unchanged."""
    if uncertain and isinstance(value, (list, tuple)):
        return tuple(of_samples(name, one, unit) for one in value)
    if unit_of_one(value) is None:
        return value
    return pair(name, value, unit) if uncertain else number(name, value, unit)


def whole(name: str, value: int | None) -> int | None:
    """A count or nothing."""
    if value is None:
        return None
    count = operator.index(value)
    if not 0 <= count < 1 << 32:
        raise refuse(name, f"{name}={shown(count)}: a whole number from zero to {(1 << 32) - 1} is needed")
    return count


def pair(name: str, value: Uncertain | None, samples: str | None = None) -> float | tuple[float, float] | None:
    """A value with or without its standard error."""
    given: Any = value
    if hasattr(given, "std_error"):
        scale = factor(name, unit_of_one(given), samples)
        return scale * _float(name, given.value), scale * _float(name, given.std_error)
    if hasattr(type(given), "__len__") and getattr(given, "ndim", 1) != 0:
        if len(given) != 2:
            raise wrong_type(name, value, "a number, or a number and its standard error")
        first, error = given
        return number(name, first, samples), number(name, error, samples)
    return None if given is None else number(name, given, samples)


def band(value: Band | None) -> tuple[float, float] | None:
    """Lower and upper limit."""
    if value is None:
        return None
    low, high = (number("band_hz", one) for one in value)
    if low >= high:
        raise refuse("band_hz", f"band_hz={shown(value)}: a rising pair of frequencies is needed")
    return low, high


def constants(given: Mapping[str, Uncertain | None]) -> dict[str, float | tuple[float, float] | None]:
    """Mechanical constants in the form that the extension takes."""
    return {name: pair(name, value) for name, value in given.items()}


def path_like(source: object) -> bool:
    """Whether this names a file."""
    return isinstance(source, (str, os.PathLike))
