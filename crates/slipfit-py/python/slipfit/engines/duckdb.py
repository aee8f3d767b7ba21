"""DuckDB."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .. import _batch, _input
from .._arguments import public

if TYPE_CHECKING:
    import duckdb
    import pyarrow as pa


@public
def fit(relation: duckdb.DuckDBPyRelation, *, rows: int = 4096, **options: Any) -> pa.RecordBatchReader:
    """Applies :func:`slipfit.fit_batch` to every row of a relation, as it is read.

    The answers are a stream that ``duckdb.sql("select … from answers")`` reads by the name of
    the variable, from another connection, because a connection cannot run a query while its last result is read.

    Parameters
    ----------
    relation : duckdb.DuckDBPyRelation
        Must have the columns that the options name.
    rows : int
        Number of rows held at a time.
    **options
        Those of :func:`slipfit.fit_batch`.
    """
    import pyarrow as pa

    if rows < 1:
        raise _input.refuse("rows", f"rows={rows}: at least one is held")
    return pa.RecordBatchReader.from_stream(_batch.fit_stream(relation.to_arrow_reader(rows), **options))
