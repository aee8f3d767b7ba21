"""The calls of docs/engines.md, in each engine's local mode; skipped where it is not installed."""

import os
import shutil
import sys

import numpy as np
import pytest
import slipfit

pa = pytest.importorskip("pyarrow")
pytestmark = pytest.mark.filterwarnings("default")

DT = 0.01
OPTIONS = {"amplitude": "trace", "dt": DT, "keep": ["id"]}
ROWS = int(os.environ.get("SLIPFIT_ENGINE_ROWS", 2000))


@pytest.fixture(scope="module")
def table():
    random = np.random.default_rng(9)
    time = DT * np.arange(128)
    sliding, delta = random.uniform(0, 0.2, (ROWS, 1)), random.uniform(0.2, 1.0, (ROWS, 1))
    fall = np.exp(-delta * time)
    traces = fall - sliding * (1 - fall) / delta + 0.01 * random.standard_normal((ROWS, 128))
    lists = pa.FixedSizeListArray.from_arrays(pa.array(traces.reshape(-1)), 128).cast(pa.list_(pa.float64()))
    return pa.table({"id": np.arange(ROWS), "trace": lists})


@pytest.fixture(scope="module")
def expected(table):
    return slipfit.fit_batch(table, **OPTIONS).to_pyarrow()


def same(found, expected):
    """Every row once, with the same numbers."""
    found = found.sort_by("id")
    assert found["id"].to_pylist() == expected["id"].to_pylist()
    for name in ("sliding_rate", "decay_rate_per_s", "status"):
        assert found[name].to_pylist() == expected[name].to_pylist(), name


def test_arrow_dataset(table, expected, tmp_path):
    dataset = pytest.importorskip("pyarrow.dataset")
    dataset.write_dataset(table, tmp_path / "in", format="parquet", max_rows_per_file=500, max_rows_per_group=500)
    source = dataset.dataset(tmp_path / "in").scanner(columns=["id", "trace"]).to_reader()
    answers = slipfit.fit_stream(source, **OPTIONS)
    dataset.write_dataset(pa.RecordBatchReader.from_stream(answers), tmp_path / "out", format="parquet")
    same(dataset.dataset(tmp_path / "out").to_table(), expected)


def test_polars(table, expected, tmp_path):
    pl = pytest.importorskip("polars")
    from slipfit.engines import polars as engine

    pl.from_arrow(table).write_parquet(tmp_path / "traces.parquet")
    answers = engine.fit(pl.scan_parquet(tmp_path / "traces.parquet"), **OPTIONS)
    same(answers.collect().to_arrow(), expected)


def test_duckdb(table, expected):
    duckdb = pytest.importorskip("duckdb")
    from slipfit.engines import duckdb as engine

    # A connection cannot answer while its last answer is being read: the source has one of its own.
    answers = engine.fit(duckdb.connect().from_arrow(table), rows=500, **OPTIONS)
    assert isinstance(answers, pa.RecordBatchReader)
    found = duckdb.sql("select * from answers where status <> 'failed'").to_arrow_table()
    same(found, expected)


def test_dask(table, expected):
    dd = pytest.importorskip("dask.dataframe")
    import dask
    from slipfit.engines import dask as engine

    with dask.config.set({"dataframe.convert-string": False}):
        traces = dd.from_pandas(table.to_pandas(), npartitions=4)
        found = engine.fit(traces, **OPTIONS).compute(scheduler="threads")
    same(pa.Table.from_pandas(found, preserve_index=False), expected)


def test_parts_without_traces_end_no_job(table):
    """Of a part without rows, or with missing traces only, pandas does not say that it holds lists."""
    dd = pytest.importorskip("dask.dataframe")
    import dask
    from slipfit.engines import dask as engine

    frame = table.slice(0, 40).to_pandas()
    frame.loc[frame.index < 10, "trace"] = None
    with dask.config.set({"dataframe.convert-string": False}):
        traces = dd.from_pandas(frame, npartitions=4)
        found = engine.fit(traces, **OPTIONS).compute(scheduler="threads")
        assert (found["status"].tolist()[:10], len(found)) == (["failed"] * 10, 40)
        late = engine.fit(traces[traces["id"] >= frame["id"][30]], **OPTIONS).compute(scheduler="threads")
        assert len(late) == 10


def test_daft(table, expected):
    daft = pytest.importorskip("daft")
    from slipfit.engines import daft as engine

    found = engine.fit(daft.from_arrow(table), **OPTIONS).to_arrow()
    same(found, expected)


def test_spark(table, expected, monkeypatch):
    sql = pytest.importorskip("pyspark.sql")
    if shutil.which("java") is None:
        pytest.skip("Spark needs Java")
    from slipfit.engines import spark as engine

    monkeypatch.setenv("PYSPARK_PYTHON", sys.executable)
    spark = (
        sql.SparkSession.builder.master("local[2]").config("spark.ui.enabled", "false")
        .config("spark.sql.shuffle.partitions", "2").getOrCreate()
    )  # fmt: skip
    try:
        found = engine.fit(spark.createDataFrame(table), **OPTIONS).toArrow()
    finally:
        spark.stop()
    same(found, expected)
