"""Daft."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .. import _batch
from .._arguments import public
from . import _rows

if TYPE_CHECKING:
    import daft
    import pyarrow as pa


@public
def fit(frame: daft.DataFrame, **options: Any) -> daft.DataFrame:
    """Applies :func:`slipfit.fit_batch` to every row of a frame.

    Parameters
    ----------
    frame : daft.DataFrame
        Must have the columns that the options name; only these are passed to the fit.
    **options
        Those of :func:`slipfit.fit_batch`.

    Returns
    -------
    daft.DataFrame
        Lazy; the columns of the answer, after those of ``keep``.
    """
    import daft
    import pyarrow as pa

    keep = options.get("keep", ())
    named = [v for k, v in options.items() if k in _COLUMNS and isinstance(v, str)]
    columns = list(dict.fromkeys([*([keep] if isinstance(keep, str) else keep), *named]))
    kinds = frame.schema().to_pyarrow_schema()
    # If a column is missing, the error of the fit names it and lists the existing ones.
    fields = list(_batch.fit_batch(kinds.empty_table(), **options).to_pyarrow().schema)

    @daft.func.batch(return_dtype=daft.DataType.from_arrow_type(pa.struct(fields)))
    def losses(*series: daft.Series) -> pa.Array:
        batch = pa.table({name: one.to_arrow() for name, one in zip(columns, series)})
        return _batch.fit_batch(batch, **options).to_pyarrow().to_struct_array().combine_chunks()

    return _spread(frame.select(losses(*(frame[name] for name in columns)).alias("answer")), fields)


#: Options that may name a column.
_COLUMNS = ("amplitude", "x", "y", "signal", "dt", "time", "frequency_hz", "min_amplitude")


@public
def ringdown_files(pattern: str, *, io_config: Any = None, **options: Any) -> daft.DataFrame:
    """Analyses every file that matches a pattern, in any store that Daft reads; one row per file.

    Parameters
    ----------
    pattern : str
        ``s3://bucket/runs/*.csv`` and the like.
    io_config : daft.io.IOConfig, optional
        Endpoint and keys.
    **options
        Those of :func:`slipfit.ringdown`.

    Returns
    -------
    daft.DataFrame
        Lazy; columns file, status, reason, model, unit, parameters, evidence. The row of a file
        that cannot be fetched, read or analysed contains the reason.
    """
    import daft
    import pyarrow as pa
    from daft.functions import download

    options = _rows.checked(options)
    fields = list(_rows.schema())

    @daft.func.batch(return_dtype=daft.DataType.from_arrow_type(pa.struct(fields)))
    def analysed(path: daft.Series, contents: daft.Series) -> pa.Array:
        found = _rows.of_files(path.to_pylist(), contents.to_pylist(), **options)
        return found.to_struct_array().combine_chunks()

    files = daft.from_glob_path(pattern, io_config=io_config)
    contents = download(files["path"], on_error="null", io_config=io_config)
    return _spread(files.select(analysed(files["path"], contents).alias("answer")), fields)


def _spread(frame: daft.DataFrame, fields: list[pa.Field]) -> daft.DataFrame:
    """Expands the fields of the single column to columns."""
    return frame.select(*(frame["answer"].get(field.name).alias(field.name) for field in fields))
