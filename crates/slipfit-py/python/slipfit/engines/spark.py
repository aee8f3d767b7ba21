"""Spark."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from .. import _batch
from .._arguments import public
from . import _rows

if TYPE_CHECKING:
    import pyarrow as pa
    from pyspark.sql import DataFrame, SparkSession


@public
def fit(frame: DataFrame, **options: Any) -> DataFrame:
    """Applies :func:`slipfit.fit_batch` to every row, with ``mapInArrow``; workers need the package.

    Parameters
    ----------
    frame : pyspark.sql.DataFrame
        Must have the columns that the options name.
    **options
        Those of :func:`slipfit.fit_batch`.
    """
    import pyarrow as pa
    from pyspark.sql.pandas.types import from_arrow_schema, to_arrow_schema

    def losses(batches: Iterator[pa.RecordBatch]) -> Iterator[pa.RecordBatch]:
        for batch in batches:
            yield from _batch.fit_batch(batch, **options).to_pyarrow().to_batches()

    empty = to_arrow_schema(frame.schema).empty_table()
    answer: pa.Schema = _batch.fit_batch(empty, **options).to_pyarrow().schema
    return frame.mapInArrow(losses, from_arrow_schema(answer))


@public
def ringdown_files(spark: SparkSession, pattern: str, **options: Any) -> DataFrame:
    """Analyses every file that matches a pattern, with ``binaryFile``; one row per file.

    Parameters
    ----------
    spark : pyspark.sql.SparkSession
        The Spark instance to use; workers need the package.
    pattern : str
        Anything Spark reads: ``s3a://bucket/runs/*.csv``.
    **options
        Those of :func:`slipfit.ringdown`.
    """
    from pyspark.sql.pandas.types import from_arrow_schema

    options = _rows.checked(options)

    def analysed(batches: Iterator[pa.RecordBatch]) -> Iterator[pa.RecordBatch]:
        for batch in batches:
            held = (batch["path"].to_pylist(), batch["content"].to_pylist())
            yield from _rows.of_files(*held, **options).to_batches()

    files = spark.read.format("binaryFile").load(pattern).select("path", "content")
    return files.mapInArrow(analysed, from_arrow_schema(_rows.schema()))
