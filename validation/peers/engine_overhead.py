"""What an engine adds to the bare fit: engine_overhead.py [TRACES] [ENGINE …].

Writes a Parquet file of so many traces of 512 amplitudes (200 000 if not said) to a folder of the system's,
lets each engine read it and fit every row, and prints processor time and elapsed time a trace, all threads and
processes together, in microseconds. Each engine runs in a process of its own; its start is timed apart.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time

SAMPLES = 512
OPTIONS = {"amplitude": "trace", "dt": 1e-3, "keep": ["id"]}
ENGINES = ["memory", "arrow", "polars", "duckdb", "dask", "daft"]


def make(path, rows):
    import numpy as np
    import pyarrow as pa
    import pyarrow.parquet as pq

    rng = np.random.default_rng(1)
    t = 1e-3 * np.arange(SAMPLES)
    with pq.ParquetWriter(path, pa.schema([("id", pa.int64()), ("trace", pa.list_(pa.float64()))])) as file:
        for first in range(0, rows, 5000):
            delta, sliding = rng.uniform(1, 4, (5000, 1)), rng.uniform(0, 0.4, (5000, 1))
            fall = np.exp(-delta * t)
            traces = fall - sliding * (1 - fall) / delta + 0.01 * rng.standard_normal((5000, SAMPLES))
            lists = pa.FixedSizeListArray.from_arrays(pa.array(traces.reshape(-1)), SAMPLES)
            ids = pa.array(range(first, first + 5000))
            file.write_table(pa.table([ids, lists.cast(pa.list_(pa.float64()))], schema=file.schema))


def cpu():
    own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


def one(engine, path):
    import pyarrow as pa
    import pyarrow.parquet as pq
    import slipfit

    if engine == "memory":
        table = pq.read_table(path)
        work = lambda: len(slipfit.fit_batch(table, **OPTIONS))
    elif engine == "arrow":
        import pyarrow.dataset as ds

        def work():
            source = ds.dataset(path).scanner(columns=["id", "trace"]).to_reader()
            answers = pa.RecordBatchReader.from_stream(slipfit.fit_stream(source, **OPTIONS))
            return sum(batch.num_rows for batch in answers)

    elif engine == "polars":
        import polars as pl
        from slipfit.engines import polars as called

        work = lambda: called.fit(pl.scan_parquet(path), **OPTIONS).collect().height
    elif engine == "duckdb":
        import duckdb
        from slipfit.engines import duckdb as called

        def work():
            relation = duckdb.connect().sql(f"select id, trace from '{path}'")
            return called.fit(relation, **OPTIONS).read_all().num_rows

    elif engine == "dask":
        import dask
        import dask.dataframe as dd
        from slipfit.engines import dask as called

        dask.config.set({"dataframe.convert-string": False, "scheduler": "threads"})
        work = lambda: len(called.fit(dd.read_parquet(path, split_row_groups=True), **OPTIONS).compute())
    else:
        import daft
        from slipfit.engines import daft as called

        work = lambda: len(called.fit(daft.read_parquet(path), **OPTIONS).to_arrow())
    begun, used = time.perf_counter(), cpu()
    rows = work()
    print(rows, cpu() - used, time.perf_counter() - begun)


if sys.argv[1:2] == ["--one"]:
    one(*sys.argv[2:])
else:
    rows = int(sys.argv[1]) if len(sys.argv) > 1 else 200_000
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "traces.parquet")
        make(path, rows)
        print(f"{rows} traces, {os.path.getsize(path) / rows:.0f} bytes each in Parquet")
        for engine in sys.argv[2:] or ENGINES:
            begun = time.perf_counter()
            said = subprocess.run([sys.executable, __file__, "--one", engine, path], capture_output=True, text=True)
            if said.returncode:
                print(f"{engine}: {said.stderr.strip().splitlines()[-1]}")
                continue
            found, used, took = (float(word) for word in said.stdout.split()[-3:])
            start = time.perf_counter() - begun - took
            each = 1e6 / rows
            print(f"{engine}: {found:.0f} rows, {used * each:.2f} µs of processor, {took * each:.2f} µs elapsed, {start:.1f} s to start")
