"""dask."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .. import _batch
from .._arguments import public

if TYPE_CHECKING:
    import dask.dataframe as dd


@public
def fit(frame: dd.DataFrame, **options: Any) -> Any:
    """Applies :func:`slipfit.fit_batch` to every row of a ``dask.dataframe``, with ``map_partitions``.

    Columns of lists stay lists with ``dask.config.set({"dataframe.convert-string": False})``.

    Parameters
    ----------
    frame : dask.dataframe.DataFrame
        Must have the columns that the options name.
    **options
        Those of :func:`slipfit.fit_batch`.
    """
    import pyarrow as pa

    lists = {options.get(name) for name in ("amplitude", "x", "y", "signal", "time")}
    # The type of an empty pandas column does not show that it holds lists.
    kinds = {c: pa.list_(pa.float64()) if c in lists else None for c in frame.columns}
    empty = pa.table({c: pa.array([], kind or _kind(frame._meta[c])) for c, kind in kinds.items()})
    meta = _batch.fit_batch(empty, **options).to_pandas()
    # Its methods have no types.
    untyped: Any = frame
    return untyped.map_partitions(lambda part: _batch.fit_batch(part, **options).to_pandas(), meta=meta)


def _kind(column: Any) -> Any:
    import pyarrow as pa

    return pa.Schema.from_pandas(column.to_frame(), preserve_index=False).field(0).type
