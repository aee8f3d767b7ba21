"""Tables of traces, one trace per row."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Annotated, Any, Literal, NoReturn, get_args

import numpy as np
from numpy.typing import NDArray

from . import _core, _input
from ._arguments import public, shown, wrong_type
from ._analyses import _INTERVAL, _ringdown_choices
from ._errors import OptionError, SlipfitError
from .typing import Band, Interval, Motion, PerRow, Scalar

if TYPE_CHECKING:
    import pandas as pd
    import polars as pl
    import pyarrow as pa
    from typing_extensions import Self

_NUMBERS = "a number or the name of a column is needed"
_DT = "a number of seconds, a duration or the name of a column is needed"


class ArrowTable:
    """A table of answers, one row per trace.

    Anything that reads Arrow's C interface accepts it:
    ``pyarrow.table(answers)``, ``polars.DataFrame(answers)``, ``pandas.DataFrame.from_arrow(answers)``.
    A column is ``answers["decay_rate_per_s"]``, ``dict(answers)`` has all of them. :attr:`units` has the unit of
    each, which Arrow's schema holds in the column's metadata: ``table.field(name).metadata[b"unit"]`` in pyarrow,
    also in a Parquet file that it writes. A notebook shows the first and last rows of a table.

    Examples
    --------
    >>> import numpy as np, slipfit
    >>> t = 0.01 * np.arange(200)
    >>> answers = slipfit.fit_batch(np.exp(-t)[np.newaxis], amplitude="amplitude", dt=0.01, unit="nm")
    >>> answers.units["decay_rate_per_s"], answers.units["sliding_rate"], answers.units.get("samples")
    ('1/s', 'nm/s', None)
    """

    def __init__(self, held: _core.ArrowTable) -> None:
        self._held = held

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """The table as a stream of Arrow's C interface."""
        return self._held.__arrow_c_stream__(requested_schema)

    def __arrow_c_schema__(self) -> Any:
        """The types of the columns by Arrow's C interface."""
        return self._held.__arrow_c_schema__()

    def __reduce__(self) -> tuple[Any, ...]:
        return _of_bytes, (self._held.to_bytes(),)

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        # A table of answers is immutable; its columns are returned as copies.
        return self

    def __eq__(self, other: object) -> bool:
        return self._held == other._held if isinstance(other, ArrowTable) else NotImplemented

    # A table is compared by its rows, like arrays of NumPy and pyarrow.
    __hash__ = None  # type: ignore[assignment]

    def __len__(self) -> int:
        return len(self._held)

    @property
    def column_names(self) -> list[str]:
        """Names of the columns, in order."""
        return self._held.column_names

    @property
    def columns(self) -> list[str]:
        """Names of the columns, in order, as in a data frame."""
        return self.column_names

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns."""
        return len(self), len(self.column_names)

    @property
    def units(self) -> dict[str, str]:
        """Units of the columns by name; pure numbers and texts have none."""
        held = self._held.units
        return {name: held[name] for name in self.column_names if name in held}

    def __contains__(self, name: object) -> bool:
        return name in self.column_names

    def __iter__(self) -> Iterator[str]:
        return iter(self.column_names)

    def keys(self) -> list[str]:
        """Names of the columns, as in a dictionary: ``dict(answers)`` holds an array for each."""
        return self.column_names

    def values(self) -> list[NDArray[Any]]:
        """Columns as arrays, as in a dictionary; one that cannot be an array raises as ``answers[name]`` does."""
        return [self[name] for name in self]

    def items(self) -> list[tuple[str, NDArray[Any]]]:
        """Names and columns, as in a dictionary."""
        return [(name, self[name]) for name in self]

    def get(self, name: str, default: Any = None) -> Any:
        """A column as an array, or the default if there is none of this name."""
        return self[name] if name in self else default

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NoReturn:
        # NumPy, and pandas through it, would make an array of the names.
        raise wrong_type("table", self, "a column is an array, answers[name]; to_pandas() has rows")

    def __getitem__(self, name: str) -> NDArray[Any]:
        """A column as an array; a missing number is NaN, a missing flag False.

        Kept columns keep their type, except that integers with gaps become doubles; columns that are neither
        numbers, flags nor texts are available from :meth:`to_pyarrow`.
        """
        if not isinstance(name, str):
            known = ", ".join(self.column_names)
            raise wrong_type("name", name, f"the name of a column is needed, one of {known}; to_pandas() has rows")
        try:
            values = self._held.column(name)
        except KeyError:
            raise KeyError(f"no column {name!r}; there are {', '.join(self)}") from None
        if isinstance(values, np.ndarray):
            return values
        return np.array(values, dtype=object if None in values else np.str_)

    def to_pyarrow(self) -> pa.Table:
        """The table as a pyarrow Table."""
        import pyarrow as pa

        return pa.table(self)

    def to_polars(self) -> pl.DataFrame:
        """The table as a polars DataFrame."""
        import polars as pl

        return pl.DataFrame(self)

    def to_pandas(self) -> pd.DataFrame:
        """The table as a pandas DataFrame (through pyarrow), with its units in ``attrs["units"]``."""
        frame: pd.DataFrame = self.to_pyarrow().to_pandas()
        frame.attrs["units"] = self.units
        return frame

    def __repr__(self) -> str:
        return f"<ArrowTable: {len(self)} rows, {len(self.column_names)} columns>"

    def _repr_html_(self) -> str:
        units, rows = self.units, len(self)
        shown = (range(rows),) if rows <= 2 * _SHOWN else (range(_SHOWN), range(rows - _SHOWN, rows))
        parts = [(range_, ArrowTable(self._held.rows(range_.start, len(range_)))) for range_ in shown]
        head = "".join(f"<th>{escape(name)}</th>" for name in self)
        below = "".join(f"<th>{escape(units.get(name, ''))}</th>" for name in self)
        bodies = []
        for range_, part in parts:
            columns = [part._cells(name) for name in self]
            lines = zip(range_, *columns)
            bodies.append("".join(f"<tr><th>{at}</th>{''.join(f'<td>{escape(c)}</td>' for c in cells)}</tr>" for at, *cells in lines))
        gap = f"<tr><th>⋮</th>{'<td>⋮</td>' * len(self.column_names)}</tr>"
        return (
            f"<table><thead><tr><th></th>{head}</tr><tr><th></th>{below}</tr></thead>"
            f"<tbody>{gap.join(bodies)}</tbody></table><p>{rows} rows × {len(self.column_names)} columns</p>"
        )

    def _cells(self, name: str) -> list[str]:
        """A column as short texts."""
        try:
            values = self[name]
        except OptionError:
            # Dates and lists, which only their own packages can show.
            return ["…"] * len(self)
        numbers = values.dtype.kind == "f"
        texts = (f"{value:.6g}" if numbers else "" if value is None else str(value) for value in values.tolist())
        return [text if len(text) <= _LONGEST else text[:_LONGEST] + "…" for text in texts]


#: Number of rows that a notebook shows at either end of a table, and of letters of a text.
_SHOWN, _LONGEST = 5, 60


def _of_bytes(held: bytes) -> ArrowTable:
    return ArrowTable(_core.ArrowTable.of_bytes(held))


class ArrowStream:
    """Answers to the batches of a stream, each computed when it is requested.

    It can be read once: as a stream of Arrow's C interface
    (``pyarrow.RecordBatchReader.from_stream(answers)``), or batch by batch in a loop.
    """

    def __init__(self, held: _core.ArrowStream, table: Any = None) -> None:
        self._held = held
        self._table = table

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """The answers as a stream of Arrow's C interface."""
        return self._held.__arrow_c_stream__(requested_schema)

    def __arrow_c_schema__(self) -> Any:
        """The types of the columns by Arrow's C interface."""
        return self._held.__arrow_c_schema__()

    @property
    def column_names(self) -> list[str]:
        """Names of the columns, in order."""
        return self._held.column_names

    def __iter__(self) -> Iterator[ArrowTable]:
        return self

    def __next__(self) -> ArrowTable:
        try:
            return ArrowTable(self._held.next_batch())
        except SlipfitError as error:
            # Reported as an error of the call that named it.
            if error.details.get("option") == "table":
                error.details["value"] = self._table
            raise

    def __repr__(self) -> str:
        return f"<ArrowStream: {len(self.column_names)} columns>"


def _per_row(name: str, value: PerRow | None) -> float | str | None:
    return value if value is None or isinstance(value, str) else _input.optional(name, value)


def _labelled(table: Any, options: dict[str, Any]) -> Any:
    """The rows of an xarray array with time as the last axis, and the options not given that the array states."""
    if _several(table):
        return table
    rows = isinstance(table, (list, tuple))
    own = _rows_unit(table) if rows else _input.own_unit(table)
    options["unit"] = _input.named(table, own, _input.unit_told("table", own, options["unit"] or None))[0] or ""
    if rows:
        return [row if row is None else _input.alike("table", row, own) for row in table] if own else _input.numbers(table)
    if not _input.is_of_xarray(table) or getattr(table, "ndim", 0) != 2:
        return _input.numbers(table)
    name = _input.time_dimension(table)
    if name is None:
        return table
    timed = _input.time_coordinate(table, name)
    if timed is not None and options["time"] is None and not isinstance(options["dt"], str):
        options["dt"] = _input.step_of(table.coords[timed], timed, options["dt"], "give a table with a column of times")
    return table.transpose(..., name)


def _rows_unit(rows: Any) -> str | None:
    """The unit of traces in a list, that of the first one; either all state a unit or none does."""
    units = [_input.own_unit(row) for row in rows if row is not None]
    own = next(filter(None, units), None)
    if own is not None and None in units:
        raise _input.refuse("table", f"table has traces in {own!r} and traces without a unit: each needs one, or none")
    return own


def _table(table: Any, column: str) -> Any:
    """Arrays with one trace per row, or columns by name, as a table; anything else unchanged."""
    if _input.is_of_xarray(table) and hasattr(table, "ndim"):
        table = table.to_numpy()
    if _several(table):
        return _joined(iter(table), column)
    if isinstance(table, np.ndarray):
        table = _input.unmasked(table)
        if table.ndim != 2 or table.dtype.kind not in "fiu":
            raise _input.refuse(
                "table", f"table is an array of {table.dtype} of the shape {table.shape}: real numbers (rows, samples)"
            )
        columns: Mapping[Any, Any] = {column: table}
    elif isinstance(table, (list, tuple)):
        if not all(map(_is_trace, table)):
            raise wrong_type("table", table, "a list of traces needs an array or a list of numbers for each")
        columns = {column: table}
    elif isinstance(table, Mapping) and not hasattr(table, "__arrow_c_stream__"):
        columns = table
    else:
        return table
    import pyarrow as pa

    arrays, fields = [], []
    try:
        for name, values in columns.items():
            rows = isinstance(values, (list, tuple))
            own = _rows_unit(values) if rows else _input.own_unit(values)
            if rows and own:
                values = [row if row is None else _input.alike("table", row, own) for row in values]
            held = _column(values)
            arrays.append(held if isinstance(held, (pa.Array, pa.ChunkedArray)) else pa.array(held))
            fields.append(pa.field(str(name), arrays[-1].type, metadata={"unit": own} if own else None))
        return pa.table(arrays, schema=pa.schema(fields))
    except (pa.ArrowException, TypeError, ValueError, LookupError) as error:
        raise wrong_type("table", table, f"columns of one length, one trace or number a row, are needed ({error})") from None


def _several(table: Any) -> bool:
    """Whether these are tables one after the other, and not one table."""
    if hasattr(table, "__arrow_c_stream__"):
        return False
    if isinstance(table, (list, tuple)):
        # The first decides: a list may hold a million traces.
        return _is_table(next((one for one in table if one is not None), None))
    return isinstance(table, Iterator)


def _is_table(one: Any) -> bool:
    exported = hasattr(one, "__arrow_c_stream__") or hasattr(one, "__arrow_c_array__")
    return isinstance(one, Mapping) or exported and _input.has_columns(one)


def _joined(tables: Iterator[Any], column: str) -> pa.RecordBatchReader:
    """Tables one after the other as one stream, each taken when it is read; the first has the columns of all."""
    import pyarrow as pa

    def converted(at: int, one: Any) -> pa.Table:
        if not (_is_table(one) or isinstance(one, np.ndarray) and one.ndim == 2):
            raise wrong_type("table", one, f"table[{at}] must be a table or an array of traces")
        try:
            held = _table(one, column)
            return held if isinstance(held, pa.Table) else pa.table(held)
        except (pa.ArrowException, TypeError, ValueError, LookupError) as error:
            raise _input.refuse("table", f"table[{at}] cannot be taken: {error}") from None

    first = next(tables, None)
    if first is None:
        raise _input.refuse("table", "table has no batch, and none has columns")
    begun = converted(0, first)
    # Packages describe their indices there, which differ between batches.
    schema = begun.schema.remove_metadata()

    def batches() -> Iterator[pa.RecordBatch]:
        yield from begun.replace_schema_metadata().to_batches()
        for at, one in enumerate(tables, 1):
            yield from _like(converted(at, one), schema, at).to_batches()

    return pa.RecordBatchReader.from_batches(schema, batches())


def _like(table: pa.Table, schema: pa.Schema, at: int) -> pa.Table:
    """A later table with the columns of the first, in their types and units."""
    import pyarrow as pa

    found = table.schema
    if sorted(found.names) != sorted(schema.names):
        raise _input.refuse("table", f"table[{at}] has the columns {found.names}, the first has {schema.names}")
    for field in schema:
        units = [(one.metadata or {}).get(b"unit") for one in (found.field(field.name), field)]
        if units[0] != units[1]:
            own, wanted = ("no unit" if unit is None else repr(unit.decode()) for unit in units)
            raise _input.refuse("table", f"column {field.name!r} of table[{at}] is in {own}, that of the first in {wanted}")
    try:
        return table.select(schema.names).cast(schema)
    except (pa.ArrowException, ValueError) as error:
        raise _input.refuse("table", f"table[{at}] has other types of columns than the first: {error}") from None


def _is_trace(row: Any) -> bool:
    if isinstance(row, (list, tuple)):
        return not any(isinstance(one, (list, tuple, np.ndarray)) for one in row)
    return row is None or np.ndim(row) == 1


def _cell(one: Any) -> Any:
    """A trace as pyarrow accepts it; anything else unchanged."""
    if isinstance(one, (set, frozenset)):
        raise TypeError("a set has no order")
    if isinstance(one, (list, tuple)) or not np.ndim(one):
        return one
    return _native(np.asarray(_input.unmasked(_input.numbers(one))))


def _native(array: NDArray[Any]) -> NDArray[Any]:
    """Numbers in a type that pyarrow has; anything else unchanged."""
    if array.dtype.kind == "f" and array.dtype.itemsize > 8:
        return array.astype(np.float64)
    return array.astype(array.dtype.newbyteorder("="), copy=False) if array.dtype.kind in "fiu" else array


def _column(values: Any) -> Any:
    """A column of a table: numbers, or one trace per row."""
    import pyarrow as pa

    if isinstance(values, (list, tuple)):
        return pa.array([_cell(one) for one in values])
    if isinstance(values, (str, bytes)):
        raise TypeError("a text is no column")
    if isinstance(values, (set, frozenset)):
        raise TypeError("a set has no order")
    values = values.to_numpy() if _input.is_of_xarray(values) else _input.numbers(values)
    if not isinstance(values, np.ndarray):
        return values
    values = _input.unmasked(values)
    if values.ndim < 2:
        return pa.array(_native(values))
    if values.ndim > 2 or values.dtype.kind not in "fiu":
        raise TypeError(f"an array of {values.dtype} of the shape {values.shape}")
    if not values.shape[1]:
        return pa.array([[]] * values.shape[0], pa.list_(pa.float64()))
    flat = pa.array(np.ascontiguousarray(_native(values)).reshape(-1))
    return pa.FixedSizeListArray.from_arrays(flat, values.shape[1])


def _choices(
    amplitude: str | None = None,
    x: str | None = None,
    y: str | None = None,
    signal: str | None = None,
    kind: str | None = None,
    dt: PerRow | Interval | None = None,
    time: str | None = None,
    frequency_hz: PerRow | None = None,
    min_amplitude: PerRow | None = None,
    method: str = "fit",
    unit: str = "",
    keep: Sequence[str] = (),
    **analysis: Any,
) -> dict[str, Any]:
    _check_columns(amplitude, x, y, signal, kind, method, frequency_hz, dt, time, analysis)
    # A value with a unit is converted once the unit of the traces is known.
    least = min_amplitude if _input.unit_of_one(min_amplitude) is None else None
    return {
        "amplitude": amplitude, "x": x, "y": y, "signal": signal, "kind": kind,
        "dt": dt if isinstance(dt, str) else _input.interval("dt", dt), "time": time,
        "frequency_hz": _per_row("frequency_hz", frequency_hz),
        "min_amplitude": _per_row("min_amplitude", least), "method": method, "unit": unit, "levels": False,
        "factors": {}, "keep": [keep] if isinstance(keep, str) else list(keep),
        "ringdown": _ringdown_choices(**analysis),
    }  # fmt: skip


def _source(table: Any, *, min_amplitude: Any, **options: Any) -> tuple[_core.Source, dict[str, Any]]:
    """The table with the choices of its analysis."""
    table = _labelled(table, options)
    choices = _choices(min_amplitude=min_amplitude, **options)
    column = choices["amplitude"] or choices["signal"] or "x"
    return _taken(_table(table, column), choices, min_amplitude), choices


def _taken(table: Any, choices: dict[str, Any], min_amplitude: Any) -> _core.Source:
    """The table; the units that its columns state are added to the choices."""
    source = _core.Source(table, choices)
    stated, timed = source.units, source.timed
    role = next(name for name in ("amplitude", "x", "signal") if choices[name] is not None)

    def known(option: str) -> str | None:
        """The unit of the column that an option names: its own or that of its name."""
        column = choices[option]
        return stated.get(column) or _core.unit_of_name(column) if isinstance(column, str) else None

    own = stated.get(choices[role])
    told = _input.unit_told(role, own, choices["unit"] or None)
    of_numbers = own or _input.unit_of_samples(known(role)) or told
    unit, kind, levels = _input.samples_in(told or of_numbers or "")
    if levels and role != "amplitude":
        raise _input.refuse(
            role, f"{role} is in {told or of_numbers!r}, levels of amplitudes: give them as amplitude=…; X, Y and oscillations have signs"
        )
    if role == "signal" and choices["kind"] is None and kind in get_args(Motion):
        choices["kind"] = kind
    choices["unit"], choices["levels"] = unit, levels

    def factor(option: str, wanted: str, words: str) -> float:
        column, own = choices[option], known(option)
        if not own or column in timed:
            return 1.0
        named = None if stated.get(column) else column
        return _input.factor_to(option, own, wanted, words, named, "a column that is renamed has none")

    factors = {"dt": factor("dt", "s", _input.TIMES), "time": factor("time", "s", _input.TIMES)}
    factors["frequency_hz"] = factor("frequency_hz", "Hz", _input.FREQUENCIES)
    factors["y"] = _input.factor_alike("y", _input.unit_of_samples(known("y")), of_numbers)
    factors["min_amplitude"] = _input.factor("min_amplitude", known("min_amplitude"), unit)
    choices["factors"] = {choices[option]: number for option, number in factors.items() if number != 1}
    if choices["min_amplitude"] is None:
        choices["min_amplitude"] = _input.of_samples("min_amplitude", min_amplitude, unit)
    return source


def _check_columns(
    amplitude: str | None,
    x: str | None,
    y: str | None,
    signal: str | None,
    kind: str | None,
    method: str,
    frequency_hz: PerRow | None,
    dt: PerRow | Interval | None,
    time: str | None,
    analysis: dict[str, Any],
) -> None:
    """Refuses options that contradict each other, and names both."""

    def told(**option: Any) -> str:
        return " and ".join(f"{name}={shown(value)}" for name, value in option.items())

    traces = {"amplitude": amplitude, "x": x, "signal": signal}
    named = {name: column for name, column in traces.items() if column is not None}
    if len(named) > 1:
        raise _input.refuse(list(named)[-1], f"{told(**named)}: one of them is needed")
    if y is not None and x is None:
        beside = f"y={y!r} beside {told(**named)}" if named else f"y={y!r} without x"
        raise _input.refuse("y", f"{beside}: x=… and y=… are the two outputs of a lock-in")
    if x is not None and y is None:
        raise _input.refuse("y", f"x={x!r} without y: x=… and y=… are the two outputs of a lock-in, amplitude=… stands alone")
    if x is not None and x == y:
        raise _input.refuse("y", f"x={x!r} and y={y!r}: X and Y of a lock-in are two columns; amplitude=… stands alone")
    if kind is not None and signal is None and named:
        raise _input.refuse("kind", f"{told(kind=kind, **named)}: kind says what signal=… is, and there is none")
    if kind is not None and kind not in get_args(Motion):
        raise _input.refuse("kind", f"{told(kind=kind)}: one of {', '.join(get_args(Motion))}")
    given = [name for name in analysis if analysis[name] is not None]
    if given and method == "fit":
        raise _input.refuse(given[0], f"{given[0]} is an option of method='analyse'; fit has one model")
    if signal is not None and method == "fit":
        what = "an oscillation needs the method analyse; fit takes amplitudes, or x and y"
        raise _input.refuse("method", f"{told(method=method, signal=signal)}: {what}")
    if signal is not None and frequency_hz is not None:
        what = "an oscillation has a frequency of its own; frequency_hz is for amplitudes, or x and y"
        raise _input.refuse("frequency_hz", f"{told(frequency_hz=frequency_hz, signal=signal)}: {what}")
    if named and signal is None and analysis.get("band_hz") is not None:
        what = "a band is for signal=…; amplitudes, or x and y, are those of one frequency already"
        raise _input.refuse("band_hz", f"{told(band_hz=analysis['band_hz'], **named)}: {what}")
    if dt is not None and time is not None:
        raise _input.refuse("time", f"{told(dt=dt, time=time)}: one of them is needed")
    for name, column in (*named.items(), ("y", y)):
        if time is not None and column == time:
            raise _input.refuse("time", f"{told(time=time)} and {name}={time!r}: they are two columns")


@public
def fit_batch(
    table: Any,
    *,
    amplitude: str | None = None,
    x: str | None = None,
    y: str | None = None,
    signal: str | None = None,
    kind: Literal["displacement", "velocity", "acceleration"] | None = None,
    dt: Annotated[PerRow | Interval | None, _DT] = None,
    time: Annotated[str | None, "the name of a column of lists of times is needed"] = None,
    frequency_hz: Annotated[PerRow | None, _NUMBERS] = None,
    min_amplitude: Annotated[PerRow | None, _NUMBERS] = None,
    method: Literal["fit", "analyse"] = "fit",
    unit: str = "",
    keep: Sequence[str] = (),
    model: str | None = None,
    band_hz: Band | None = None,
    start_s: Annotated[Interval | None, _INTERVAL] = None,
    end_s: Annotated[Interval | None, _INTERVAL] = None,
    lockin_time_constant_s: Scalar | None = None,
    lockin_order: int | None = None,
) -> ArrowTable:
    """Separates viscous from sliding loss in every trace of a table.

    A row that cannot be fitted is returned with its reason: order and count are
    those of the table. All cores are used, and columns of doubles are not
    copied.

    Parameters
    ----------
    table : object with Arrow's C interface, array, list or dictionary
        A pyarrow Table or RecordBatch, a polars or pandas DataFrame, a DuckDB
        or Daft relation, with one trace per row: lists, large lists or
        fixed-size lists of any real numbers. Null and NaN are left out and
        counted. A NumPy or xarray array of shape (rows, samples) is taken as
        the column that `amplitude` or `signal` names (through pyarrow, without a copy);
        in xarray a dimension called ``time`` or ``t``, or the one with a coordinate of
        times, may come first, and the unit is taken over. A list of traces, which may
        differ in length, is taken likewise; a dictionary has columns by name, traces as a list or
        an array of shape (rows, samples). Tables with the same columns in a list, or from an iterator, are
        joined. Columns encoded as dictionaries, as the categories of pandas, or in runs are decoded.
        The unit of a column is stated by its metadata,
        as in tables of answers, or by its name: ``x (nm)``, ``dt (ms)``.
    amplitude : str
        Column of amplitudes; or
    x, y : str
        columns of X and Y of a lock-in; or
    signal : str
        column of the oscillation itself, for ``method="analyse"``.
    kind : str, optional
        What `signal` is: ``displacement``, ``velocity``, ``acceleration``; determined by
        the unit if not given.
    dt : float, quantity, duration or str
        Sampling interval [s], or the column of it, numbers or durations. For an
        xarray array with a coordinate of uniform times, the interval is that of the
        coordinate and no other is accepted.
    time : str
        Column of lists of times [s], instead of `dt`; or of dates, which each row counts from its
        first one, or of durations.
    frequency_hz : float, quantity or str, optional
        Frequency of the oscillation [Hz], which amplitudes do not contain: with
        it, sliding friction is given as a friction displacement.
    min_amplitude : float, quantity or str, optional
        A trace is used up to its first amplitude below this one; samples
        after the motion has stopped belong to no decay.
    method : str
        ``fit``: amplitudes ``A_0 exp(-delta t) - a0 (1 - exp(-delta t))/delta``,
        one loss model, no comparison, errors for white noise. ``analyse``:
        the whole analysis of :func:`ringdown`.
    unit : str
        Unit of the traces, to which a `min_amplitude` with its own unit is
        converted, and which determines the units of the columns of the answer
        (:attr:`ArrowTable.units`). Levels in dB, dBm and the like are converted to
        amplitudes, 20 dB per decade.
    keep : sequence of str
        Columns of the table to be placed before those of the answer.
    model, band_hz, start_s, end_s, lockin_time_constant_s, lockin_order : optional
        Options of ``method="analyse"``, see :func:`ringdown`.

    Returns
    -------
    ArrowTable
        ``status`` (``done``, ``warned``, ``failed``), ``reason`` (codes of the
        warnings, or why it failed), then ``decay_rate_per_s``, ``sliding_rate``,
        ``friction_displacement`` and ``initial_amplitude``, each with its
        ``_std_error``, ``_low`` and ``_high`` (95 %) before the unit
        (``decay_rate_low_per_s``, ``sliding_rate_low``), ``correlation`` of
        the two losses, ``residual_rms``, ``sliding_detected``,
        ``sliding_p_value``, ``samples`` used and ``samples_left_out``; for
        ``analyse`` also ``model``, ``frequency_hz`` (``frequency_low_hz``),
        ``start_s``, ``end_s``.

    Raises
    ------
    OptionError
        For a column that is missing or of the wrong type, or an option out of range.

    Examples
    --------
    >>> import numpy as np, slipfit
    >>> t = 0.01 * np.arange(200)
    >>> traces = np.array([1 - 0.1 * t, 1 - 0.2 * t, np.full_like(t, np.nan)])
    >>> answers = slipfit.fit_batch(traces, amplitude="amplitude", dt=0.01)
    >>> answers["sliding_rate"].round(9).tolist()
    [0.1, 0.2, nan]
    >>> str(answers["reason"][2])
    '0 usable samples; at least 4 are needed'
    """
    source, choices = _source(
        table, amplitude=amplitude, x=x, y=y, signal=signal, kind=kind, dt=dt, time=time,
        frequency_hz=frequency_hz, min_amplitude=min_amplitude, method=method, unit=unit, keep=keep,
        model=model, band_hz=band_hz, start_s=start_s, end_s=end_s,
        lockin_time_constant_s=lockin_time_constant_s, lockin_order=lockin_order,
    )  # fmt: skip
    return ArrowTable(_core.fit_batch(source, choices))


def answer_schema(**options: Any) -> ArrowTable:
    """The answer to zero traces with these options, which must be valid for :func:`fit_batch`."""
    return fit_batch(np.empty((0, 1)), **options)


@public
def fit_stream(
    table: Any,
    *,
    amplitude: str | None = None,
    x: str | None = None,
    y: str | None = None,
    signal: str | None = None,
    kind: Literal["displacement", "velocity", "acceleration"] | None = None,
    dt: Annotated[PerRow | Interval | None, _DT] = None,
    time: Annotated[str | None, "the name of a column of lists of times is needed"] = None,
    frequency_hz: Annotated[PerRow | None, _NUMBERS] = None,
    min_amplitude: Annotated[PerRow | None, _NUMBERS] = None,
    method: Literal["fit", "analyse"] = "fit",
    unit: str = "",
    keep: Sequence[str] = (),
    model: str | None = None,
    band_hz: Band | None = None,
    start_s: Annotated[Interval | None, _INTERVAL] = None,
    end_s: Annotated[Interval | None, _INTERVAL] = None,
    lockin_time_constant_s: Scalar | None = None,
    lockin_order: int | None = None,
) -> ArrowStream:
    """Applies :func:`fit_batch` to the batches of a stream as they arrive.

    No more than one batch and its answers are held. An error of the table as a whole, such as a missing
    column, is raised at once; an error of its source when it occurs.

    Parameters
    ----------
    table : object with Arrow's C interface, iterator or list of tables
        For example a pyarrow RecordBatchReader; it is read once. An iterator of tables, record batches, data
        frames or arrays, all with the columns of the first, is read (through pyarrow) one at a time. Anything
        else as for :func:`fit_batch`.
    amplitude, x, y, signal, kind, dt, time, frequency_hz, min_amplitude, method, unit, keep : optional
        As for :func:`fit_batch`.
    model, band_hz, start_s, end_s, lockin_time_constant_s, lockin_order : optional
        Options of ``method="analyse"``, see :func:`ringdown`.

    Returns
    -------
    ArrowStream
        The answers, which can be read once.

    Raises
    ------
    OptionError
        For a column that is missing or of the wrong type, or an option out of range.

    Examples
    --------
    >>> import pyarrow as pa, slipfit
    >>> trace = [1 - 0.001 * i for i in range(200)]
    >>> batches = [pa.record_batch({"amplitude": [trace] * rows}) for rows in (2, 3)]
    >>> source = pa.RecordBatchReader.from_batches(batches[0].schema, batches)
    >>> [len(answers) for answers in slipfit.fit_stream(source, amplitude="amplitude", dt=0.01)]
    [2, 3]
    """
    source, choices = _source(
        table, amplitude=amplitude, x=x, y=y, signal=signal, kind=kind, dt=dt, time=time,
        frequency_hz=frequency_hz, min_amplitude=min_amplitude, method=method, unit=unit, keep=keep,
        model=model, band_hz=band_hz, start_s=start_s, end_s=end_s,
        lockin_time_constant_s=lockin_time_constant_s, lockin_order=lockin_order,
    )  # fmt: skip
    return ArrowStream(_core.fit_stream(source, choices), table)
