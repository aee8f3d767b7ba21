"""Streams of answers: read once, by one reader, to their end or to an error."""

import gc
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import slipfit

pa = pytest.importorskip("pyarrow")

DT = 0.01
LISTS = pa.list_(pa.float64())


def batches(count, rows=2, samples=200, name="amplitude", fails=False):
    """A reader of so many batches of decays; it may fail at its end."""
    t = DT * np.arange(samples)
    schema = pa.schema({name: LISTS})

    def made():
        for number in range(count):
            traces = [(1 + number) * np.exp(-0.5 * t)] * rows
            yield pa.record_batch([pa.array(traces, LISTS)], schema=schema)
        if fails:
            raise RuntimeError("the disk is gone")

    return pa.RecordBatchReader.from_batches(schema, made())


def slow():
    """Two batches that take some tenths of a second each to be analysed."""
    t = np.arange(30_000)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(len(t))
    trace = np.cos(0.05 * t) * np.exp(-1e-4 * t) + noise
    rows = pa.FixedSizeListArray.from_arrays(pa.array(np.tile(trace, 60)), len(trace))
    batch = pa.record_batch({"x": rows})
    return pa.RecordBatchReader.from_batches(batch.schema, [batch] * 2)


ANALYSE = {"signal": "x", "dt": 1e-3, "method": "analyse"}


@pytest.mark.parametrize(
    ("options", "option"),
    [
        ({"amplitude": "b", "dt": DT}, "amplitude"),
        ({"amplitude": "amplitude", "dt": "b"}, "dt"),
        ({"amplitude": "amplitude", "dt": 0}, "dt"),
        ({"amplitude": "amplitude", "time": "b"}, "time"),
        ({"amplitude": "amplitude", "dt": DT, "keep": ["b"]}, "keep"),
        ({"signal": "amplitude", "dt": DT}, "method"),
        ({"amplitude": "amplitude", "dt": DT, "kind": "velocity"}, "kind"),
    ],
)
def test_what_is_wrong_with_the_table_is_said_at_the_call(options, option):
    """As of a batch, with its option, before anything is read; of a table without rows as well."""
    source = batches(1)
    with pytest.raises(slipfit.OptionError) as streamed:
        slipfit.fit_stream(source, **options)
    with pytest.raises(slipfit.OptionError) as whole:
        slipfit.fit_batch(batches(0), **options)
    assert streamed.value.option == whole.value.option == option
    assert streamed.value.value == whole.value.value == options.get(option)
    assert str(streamed.value) == str(whole.value)


def test_an_error_of_the_source_is_that_of_a_batch():
    source = batches(2, fails=True)
    answers = slipfit.fit_stream(source, amplitude="amplitude", dt=DT)
    assert [len(next(answers)), len(next(answers))] == [2, 2]
    with pytest.raises(slipfit.SlipfitError, match="the disk is gone") as streamed:
        next(answers)
    other = batches(2, fails=True)
    with pytest.raises(slipfit.SlipfitError, match="the disk is gone") as whole:
        slipfit.fit_batch(other, amplitude="amplitude", dt=DT)
    assert (streamed.value.option, streamed.value.code) == (whole.value.option, whole.value.code) == ("table", "arrow")
    assert streamed.value.value is source and whole.value.value is other
    # What is lost does not look like an end.
    with pytest.raises(slipfit.OptionError, match="broke off"):
        next(answers)
    with pytest.raises(slipfit.OptionError, match="broke off"):
        pa.RecordBatchReader.from_stream(answers)


def test_a_stream_that_was_read_or_handed_on_says_so():
    answers = slipfit.fit_stream(batches(2), amplitude="amplitude", dt=DT)
    assert [len(one) for one in answers] == [2, 2]
    assert list(answers) == [], "an iterator stays at its end"
    with pytest.raises(slipfit.OptionError, match="has been read"):
        pa.RecordBatchReader.from_stream(answers)
    answers = slipfit.fit_stream(batches(2), amplitude="amplitude", dt=DT)
    reader = pa.RecordBatchReader.from_stream(answers)
    with pytest.raises(slipfit.OptionError, match="has been read"):
        next(answers)
    assert reader.read_all().num_rows == 4
    assert repr(answers) == f"<ArrowStream: {len(answers.column_names)} columns>"


def test_a_stream_that_was_interrupted_has_no_end():
    if not hasattr(signal, "setitimer"):
        pytest.skip("no timer of this system sends signals")
    answers = slipfit.fit_stream(slow(), **ANALYSE)
    old = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.02)
        with pytest.raises(KeyboardInterrupt):
            list(answers)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, old)
    with pytest.raises(slipfit.OptionError, match="interruption"):
        next(answers)


def test_two_threads_do_not_halve_a_stream():
    answers = slipfit.fit_stream(slow(), **ANALYSE)
    rows, errors = [], []
    begun = threading.Barrier(2)

    def read():
        begun.wait()
        try:
            rows.extend(len(one) for one in answers)
        except slipfit.OptionError as error:
            errors.append(error.code)

    threads = [threading.Thread(target=read) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert rows == [60, 60]
    assert errors in ([], ["busy"]), "the other one is told, or came after the end"


@pytest.mark.parametrize(
    "work",
    [
        lambda: slipfit.fit_batch(slow(), **ANALYSE),
        lambda: list(slipfit.fit_stream(slow(), **ANALYSE)),
        lambda: pa.RecordBatchReader.from_stream(slipfit.fit_stream(slow(), **ANALYSE)).read_all(),
    ],
    ids=["batch", "stream", "reader"],
)
def test_other_threads_go_on(work):
    """The interpreter's lock is not held: another thread counts while the batch is computed."""
    counted, done = 0, threading.Event()

    def count():
        nonlocal counted
        while not done.wait(1e-3):
            counted += 1

    other = threading.Thread(target=count)
    other.start()
    begun = time.perf_counter()
    work()
    seconds = time.perf_counter() - begun
    done.set()
    other.join()
    # One count a millisecond where it is never held; a tenth of that on a machine that does other things as well.
    assert counted > 100 * seconds, (counted, seconds)


def test_memory_is_that_of_a_batch():
    psutil = pytest.importorskip("psutil")
    process = psutil.Process()
    held = []
    # 4 MB a batch, 240 MB in all; what the process holds beside them goes up and down.
    for answers in slipfit.fit_stream(batches(60, rows=1000, samples=500), amplitude="amplitude", dt=DT):
        assert len(answers) == 1000
        gc.collect()
        held.append(process.memory_info().rss)
    assert max(held[10:]) - held[10] < 80e6


FORKED = """
import multiprocessing, warnings
import numpy as np, pyarrow as pa, slipfit
warnings.simplefilter("ignore")
t = 0.01 * np.arange(200)
table = pa.table({"amplitude": list(np.exp(-0.5 * t) * np.ones((4000, 1)))})
options = {"amplitude": "amplitude", "dt": 0.01}
swing = slipfit.simulate.decay(
    frequency_hz=5, q_factor=800, amplitude=0.4, duration_s=400, rate_hz=500, noise_rms=1e-4
)

def work(_):
    rows = len(slipfit.fit_batch(table, **options))
    stream = pa.RecordBatchReader.from_stream(slipfit.fit_stream(table, **options))
    return rows, stream.read_all().num_rows, hash(slipfit.ringdown(swing))

if __name__ == "__main__":
    here = work(0)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map(work, range(4)) == [here] * 4
    print("done")
"""


def test_a_forked_process_computes(tmp_path):
    """Threads stay with the parent of a fork: its child has its own, where it would wait for ever."""
    if "fork" not in multiprocessing.get_all_start_methods():
        pytest.skip("processes are not forked here")
    script = tmp_path / "forked.py"
    script.write_text(FORKED)
    environment = {**os.environ, "PYTHONHASHSEED": "0"}
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=120, env=environment)
    assert done.returncode == 0 and done.stdout == "done\n", done.stderr


def tables(count=3):
    """Tables of two rows each."""
    fall = np.exp(-0.01 * np.arange(200))
    return [pa.table({"id": [2 * at, 2 * at + 1], "a": [fall.tolist(), (0.5 * fall).tolist()]}) for at in range(count)]


def test_tables_one_after_the_other_are_a_stream():
    polars, pandas = pytest.importorskip("polars"), pytest.importorskip("pandas")
    held = tables()
    options = {"amplitude": "a", "dt": 0.01, "keep": "id"}
    expected = slipfit.fit_batch(pa.concat_tables(held), **options)
    batches = [batch for table in held for batch in table.to_batches()]
    frames = [table.to_pandas().set_index(np.array([7, 8]) + at) for at, table in enumerate(held)]
    assert isinstance(frames[0], pandas.DataFrame)
    dictionaries = [{name: table[name].to_pylist() for name in ("id", "a")} for table in held]
    for several in (held, tuple(held), batches, [polars.from_arrow(one) for one in held], frames, dictionaries):
        for given in (several, iter(several), (one for one in several)):
            assert [row for part in slipfit.fit_stream(given, **options) for row in part["id"]] == list(range(6))
        assert slipfit.fit_batch(several, **options)["id"].tolist() == list(range(6))
    assert slipfit.fit_batch(iter(held), **options) == expected
    arrays = [np.array(table["a"].to_pylist()) for table in held]
    assert [len(part) for part in slipfit.fit_stream(iter(arrays), amplitude="a", dt=0.01)] == [2, 2, 2]
    # One array, a list of traces and a dictionary are one table, as for fit_batch.
    for one in (arrays[0], list(arrays[0]), {"a": arrays[0]}):
        assert [len(part) for part in slipfit.fit_stream(one, amplitude="a", dt=0.01)] == [2]
    assert [len(part) for part in slipfit.fit_stream([], amplitude="a", dt=0.01)] in ([], [0])


def test_a_table_is_taken_when_it_is_read():
    taken = []

    def source():
        for table in tables(5):
            taken.append(len(taken))
            yield table

    stream = slipfit.fit_stream(source(), amplitude="a", dt=0.01)
    assert len(taken) == 1
    for at, part in enumerate(stream):
        assert len(part) == 2 and len(taken) == at + 1


def test_later_tables_have_the_columns_of_the_first():
    first = tables(1)[0]

    def unit(of):
        return first.cast(pa.schema([first.schema.field("id"), first.schema.field("a").with_metadata({"unit": of})]))

    for second, words in (
        (first.rename_columns(["id", "b"]), r"table\[1\] has the columns \['id', 'b'\], the first has \['id', 'a'\]"),
        (unit("mV"), r"column 'a' of table\[1\] is in 'mV', that of the first in no unit"),
        (first.set_column(1, "a", pa.array([["x"], ["y"]])), "has other types of columns than the first"),
        (3, r"table\[1\] must be a table"),
        (None, r"table\[1\] must be a table"),
        (np.zeros(3), r"table\[1\] must be a table"),
    ):
        stream = slipfit.fit_stream(iter([first, second]), amplitude="a", dt=0.01)
        assert len(next(stream)) == 2
        with pytest.raises(slipfit.SlipfitError, match=words) as raised:
            next(stream)
        assert raised.value.option == "table"
    # Columns in another order, or of a narrower type, are the same columns.
    other = first.select(["a", "id"]).set_column(0, "a", first["a"].cast(pa.large_list(pa.float32())))
    assert [len(part) for part in slipfit.fit_stream([first, other], amplitude="a", dt=0.01)] == [2, 2]
    mixed = slipfit.fit_batch([unit("mV"), unit("mV")], amplitude="a", dt=0.01)
    assert mixed.units["initial_amplitude"] == "mV"
    for empty in (iter([]), iter([3]), iter([[1.0, 2.0]])):
        with pytest.raises(slipfit.OptionError) as raised:
            slipfit.fit_stream(empty, amplitude="a", dt=0.01)
        assert raised.value.option == "table"
