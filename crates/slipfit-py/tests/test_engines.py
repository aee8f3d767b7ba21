"""The recipes of docs/engines.md, in each engine's local mode; skipped where it is not installed."""

import os
import shutil
import sys

import numpy as np
import pytest
import slipfit

pa = pytest.importorskip("pyarrow")
pytestmark = pytest.mark.filterwarnings("default")

DT = 0.01
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
    return slipfit.fit_batch(table, amplitude="trace", dt=DT, keep=["id"]).to_pyarrow()


def fit(table):
    return slipfit.fit_batch(table, amplitude="trace", dt=DT, keep=["id"])


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
    answers = slipfit.fit_stream(source, amplitude="trace", dt=DT, keep=["id"])
    dataset.write_dataset(pa.RecordBatchReader.from_stream(answers), tmp_path / "out", format="parquet")
    same(dataset.dataset(tmp_path / "out").to_table(), expected)


def test_polars(table, expected, tmp_path):
    pl = pytest.importorskip("polars")
    pl.from_arrow(table).write_parquet(tmp_path / "traces.parquet")
    traces = pl.scan_parquet(tmp_path / "traces.parquet")
    schema = fit(traces.head(0).collect()).to_polars().schema
    answers = traces.map_batches(lambda frame: fit(frame).to_polars(), schema=dict(schema))
    same(answers.collect().to_arrow(), expected)


def test_duckdb(table, expected):
    duckdb = pytest.importorskip("duckdb")
    # A connection cannot answer while its last answer is being read: the source has one of its own.
    source = duckdb.connect().from_arrow(table).to_arrow_reader(500)
    answers = pa.RecordBatchReader.from_stream(
        slipfit.fit_stream(source, amplitude="trace", dt=DT, keep=["id"])
    )
    found = duckdb.sql("select * from answers where status <> 'failed'").to_arrow_table()
    same(found, expected)


def test_dask(table, expected):
    dd = pytest.importorskip("dask.dataframe")
    import dask

    with dask.config.set({"dataframe.convert-string": False}):
        traces = dd.from_pandas(table.to_pandas(), npartitions=4)
        meta = fit(table.slice(0, 0)).to_pandas()
        answers = traces.map_partitions(lambda frame: fit(frame).to_pandas(), meta=meta)
        found = answers.compute(scheduler="threads")
    same(pa.Table.from_pandas(found, preserve_index=False), expected)


def test_daft(table, expected):
    daft = pytest.importorskip("daft")
    fields = fit(table.slice(0, 0)).to_pyarrow().schema

    @daft.func.batch(return_dtype=daft.DataType.from_arrow_type(pa.struct(list(fields))))
    def losses(number, trace):
        batch = pa.table({"id": number.to_arrow(), "trace": trace.to_arrow()})
        return fit(batch).to_pyarrow().to_struct_array().combine_chunks()

    frame = daft.from_arrow(table)
    answers = frame.select(losses(frame["id"], frame["trace"]).alias("answer"))
    found = pa.Table.from_struct_array(answers.to_arrow()["answer"].combine_chunks())
    same(found, expected)


def test_spark(table, expected, monkeypatch):
    sql = pytest.importorskip("pyspark.sql")
    if shutil.which("java") is None:
        pytest.skip("Spark needs Java")
    from pyspark.sql.pandas.types import from_arrow_schema

    monkeypatch.setenv("PYSPARK_PYTHON", sys.executable)

    def answers(batches):
        # Workers know this function by what it says, not by its module.
        import slipfit

        for batch in batches:
            found = slipfit.fit_batch(batch, amplitude="trace", dt=0.01, keep=["id"])
            yield from found.to_pyarrow().to_batches()

    spark = (
        sql.SparkSession.builder.master("local[2]").config("spark.ui.enabled", "false")
        .config("spark.sql.shuffle.partitions", "2").getOrCreate()
    )  # fmt: skip
    try:
        schema = from_arrow_schema(fit(table.slice(0, 0)).to_pyarrow().schema)
        found = spark.createDataFrame(table).mapInArrow(answers, schema).toArrow()
    finally:
        spark.stop()
    same(found, expected)
