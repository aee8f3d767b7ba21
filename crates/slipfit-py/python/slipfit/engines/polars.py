"""polars."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .. import _batch
from .._arguments import public

if TYPE_CHECKING:
    import polars as pl


@public
def fit(frame: pl.LazyFrame, **options: Any) -> pl.LazyFrame:
    """Applies :func:`slipfit.fit_batch` to every row, with ``map_batches``.

    Parameters
    ----------
    frame : polars.LazyFrame
        Must have the columns that the options name.
    **options
        Those of :func:`slipfit.fit_batch`.
    """
    empty = frame.head(0).collect()
    schema = _batch.fit_batch(empty, **options).to_polars().schema
    # polars requires the schema as a plain dictionary.
    return frame.map_batches(
        lambda part: _batch.fit_batch(part, **options).to_polars(), schema=dict(schema), streamable=True
    )
