"""Files by the million, from a store that the test starts, with what goes wrong there."""

import multiprocessing
import os
import signal
import time
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

import numpy as np
import pytest
import slipfit

pa = pytest.importorskip("pyarrow")
pytestmark = pytest.mark.filterwarnings("default")

KEYS = {"access_key": "loopback", "secret_key": "loopback"}
GOOD = 12


def text(number):
    swing = slipfit.simulate.decay(
        frequency_hz=1.2, q_factor=80, friction_displacement=1e-3 * (1 + number % 3),
        amplitude=0.4, duration_s=30, rate_hz=40, unit="rad",
    )  # fmt: skip
    noise = 5e-4 * np.random.default_rng(number).standard_normal(len(swing))
    rows = zip(swing.time_s, swing.signal + noise)
    return "time (s),angle (rad)\n" + "".join(f"{t:.3f},{x:.7f}\n" for t, x in rows)


@pytest.fixture(scope="module")
def contents():
    """Files of a run: good ones, one of garbage, an empty one, one cut off within its header."""
    good = {f"run-{i:03}.csv": text(i).encode() for i in range(GOOD)}
    return good | {"run-900.csv": b"\x00\xff poison \x93NUMPY" * 40, "run-901.csv": b"", "run-902.csv": b"time (s),an"}


@pytest.fixture(scope="module")
def store(contents):
    """An S3-compatible store on the loopback interface, with the files in a bucket."""
    server_of = pytest.importorskip("moto.server")
    boto3 = pytest.importorskip("boto3")
    server = server_of.ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    server.start()
    host, port = server.get_host_and_port()
    endpoint = f"http://{host}:{port}"
    client = boto3.client(
        "s3", endpoint_url=endpoint, region_name="us-east-1",
        aws_access_key_id=KEYS["access_key"], aws_secret_access_key=KEYS["secret_key"],
    )  # fmt: skip
    client.create_bucket(Bucket="bucket")
    for name, data in contents.items():
        client.put_object(Bucket="bucket", Key=f"runs/{name}", Body=data)
    client.put_object(Bucket="bucket", Key="runs/notes.txt", Body=b"not one of them")
    yield endpoint
    server.stop()


def judged(found, contents):
    """Every file once; good ones as the analysis of their bytes has them, the others with reasons."""
    rows = {row["file"].rpartition("/")[2]: row for row in found.to_pylist()}
    assert found.num_rows == len(rows) == len(contents)
    for name, data in contents.items():
        row = rows[name]
        if name >= "run-900":
            assert row["status"] == "failed"
            assert row["reason"], name
            continue
        answer = slipfit.ringdown(slipfit.read(data, name))
        x_f = answer.parameters.friction_displacement
        assert row["friction_displacement"] == x_f.value
        assert row["friction_displacement_std_error"] == x_f.std_error
        for name in ("frequency_hz", "decay_rate_per_s"):
            assert row[name] == getattr(answer.parameters, name).value
        assert row["frequency_low_hz"] == answer.parameters.frequency_hz.interval_95[0]
        assert (row["unit"], row["sliding_detected"]) == ("rad", answer.sliding.detected)


def test_arrow_reads_a_store(store, contents):
    from pyarrow import fs
    from slipfit.engines import arrow

    held = fs.S3FileSystem(endpoint_override=store, scheme="http", region="us-east-1", **KEYS)
    judged(arrow.ringdown_files("s3://bucket/runs/*.csv", filesystem=held).read_all(), contents)
    with pytest.raises(slipfit.OptionError, match="no file fits"):
        arrow.ringdown_files("s3://bucket/runs/*.wav", filesystem=held)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"model": "coulomb"}, "no loss model is called `coulomb`"),
        ({"model": 5}, "model=5: a text is needed"),
        ({"law": "any"}, "no law `any`"),
        ({"band_hz": (3, 1)}, "rising pair"),
        ({"start_s": 5, "end_s": 3}, "end_s = 3 is outside times after start_s"),
        ({"min_amplitude": -1}, "min_amplitude = -1 must be a positive number"),
        ({"lockin_order": 2}, "give both"),
        ({"kind": "smell"}, "kind='smell': one of displacement"),
        ({"rate_hz": 0}, "a positive number of samples"),
        ({"mass": 1, "stiffness": 1}, "mass are both given"),
        ({"stiffness": -1}, "stiffness = -1 is outside"),
        ({"signal": "x"}, "signal is given beside files"),
    ],
)
def test_options_that_answer_no_file_are_refused_at_once(tmp_path, options, words):
    from slipfit.engines import arrow

    (tmp_path / "run.csv").write_text(text(0))
    with pytest.raises(slipfit.OptionError, match=words) as raised:
        arrow.ringdown_files(f"{tmp_path}/*.csv", **options)
    assert raised.value.option in options
    with pytest.raises(TypeError, match="colour"):
        arrow.ringdown_files(f"{tmp_path}/*.csv", colour="red")


def test_files_are_read_as_the_options_say(tmp_path):
    """Those of :func:`slipfit.ringdown`, which takes the rate and the unit of a file too."""
    from slipfit.engines import arrow

    values = [row.split(",")[1] for row in text(0).splitlines()[1:]]
    (tmp_path / "run.txt").write_text("\n".join(values))
    rows = arrow.ringdown_files(f"{tmp_path}/*.txt", rate_hz=40, unit="mm", kind="displacement").read_all().to_pylist()
    answer = slipfit.ringdown(tmp_path / "run.txt", rate_hz=40, unit="mm", kind="displacement")
    assert rows[0]["unit"] == "mm" and rows[0]["status"] != "failed"
    assert rows[0]["friction_displacement"] == answer.parameters.friction_displacement.value


def test_daft_reads_a_store(store, contents):
    daft = pytest.importorskip("daft")
    from slipfit.engines import daft as engine

    config = daft.io.IOConfig(
        s3=daft.io.S3Config(
            endpoint_url=store, region_name="us-east-1", key_id=KEYS["access_key"], access_key=KEYS["secret_key"]
        )
    )
    found = engine.ringdown_files("s3://bucket/runs/*.csv", io_config=config).to_arrow()
    judged(found, contents)


def test_a_folder_is_a_store(contents, tmp_path):
    from slipfit.engines import arrow

    for name, data in contents.items():
        (tmp_path / name).write_bytes(data)
    judged(arrow.ringdown_files(f"{tmp_path}/*.csv").read_all(), contents)


def test_options_reach_every_file(contents):
    from slipfit.engines import _rows

    found = _rows.of_files(["run-000.csv"], [contents["run-000.csv"]], model="viscous").to_pylist()
    assert found[0]["model"] == "viscous"
    assert _rows.of_files(["x"], [None]).to_pylist()[0]["reason"] == "the file could not be fetched"


def work(name, data, mark):
    """A row; the first worker that comes to the poison dies of it, as by the system's killer."""
    if name == "run-005.csv" and not os.path.exists(mark):
        with open(mark, "x"):
            os.kill(os.getpid(), signal.SIGKILL)
    from slipfit.engines import _rows

    return _rows.of_file(name, data)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no worker can be killed so")
def test_a_killed_worker_loses_nothing_and_repeats_nothing(contents, tmp_path):
    """As engines do it: what a dead worker held is given to others, what was done stays done."""
    done, mark = {}, str(tmp_path / "mark")
    deaths = 0
    while len(done) < len(contents):
        with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
            left = {name: pool.submit(work, name, data, mark) for name, data in contents.items() if name not in done}
            for name, future in left.items():
                try:
                    assert name not in done
                    done[name] = future.result(timeout=120)
                except BrokenProcessPool:
                    deaths += 1
        assert deaths, "nobody died"
    from slipfit.engines import _rows

    judged(pa.Table.from_pylist(list(done.values()), schema=_rows.schema()), contents)


def peak_bytes():
    resource = pytest.importorskip("resource")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def test_a_row_of_a_million_samples_among_small_ones():
    """The long row has its answer, the small ones theirs, and memory is that of the table, not of its square."""
    t = 1e-3 * np.arange(1_000_000)
    long = np.exp(-2e-3 * t) + 0.01 * np.random.default_rng(1).standard_normal(len(t))
    small = [np.exp(-2 * t[:128]) + 0.01 * np.random.default_rng(i).standard_normal(128) for i in range(400)]
    rows = [*small[:200], long, *small[200:]]
    lists = pa.array(rows, pa.large_list(pa.float64()))
    before, begun = peak_bytes(), time.perf_counter()
    answers = slipfit.fit_batch(pa.table({"trace": lists}), amplitude="trace", dt=1e-3)
    assert time.perf_counter() - begun < 60
    assert peak_bytes() - before < 200e6
    assert len(answers) == 401
    assert set(answers["samples"][[0, 199, 201, 400]].tolist()) == {128}
    assert answers["samples"][200] == 1_000_000
    alone = slipfit.fit_batch(pa.table({"trace": lists.slice(200, 1)}), amplitude="trace", dt=1e-3)
    # By the kernel of one trace, or by that of many of one length: within what both promise.
    error = alone["decay_rate_std_error_per_s"][0]
    assert abs(answers["decay_rate_per_s"][200] - alone["decay_rate_per_s"][0]) < 1e-6 * error


@pytest.mark.parametrize("make", ["pint", "astropy", "unyt", "slipfit"])
def test_a_least_amplitude_is_taken_in_its_unit(tmp_path, make):
    from slipfit.engines import arrow

    def value(number, unit):
        if make == "pint":
            return pytest.importorskip("pint").Quantity(number, unit)
        if make == "astropy":
            return number * pytest.importorskip("astropy.units").Unit(unit)
        if make == "unyt":
            return pytest.importorskip("unyt").unyt_quantity(number, unit)
        return slipfit.Quantity(number, 0.0, (number, number), number, unit)

    (tmp_path / "in_rad.csv").write_text(text(0))
    (tmp_path / "in_volts.csv").write_text(text(0).replace("angle (rad)", "output (V)"))
    found = arrow.ringdown_files(f"{tmp_path}/*.csv", min_amplitude=value(50.0, "mrad"), start_s=value(1000.0, "ms"))
    rad, volts = found.read_all().to_pylist()
    plain = slipfit.ringdown(tmp_path / "in_rad.csv", min_amplitude=0.05, start_s=1)
    assert rad["end_s"] == plain.segment.end_s and rad["status"] in ("done", "warned")
    assert volts["status"] == "failed" and "min_amplitude is in 'mrad', what it belongs to in 'V'" in volts["reason"]
    with pytest.raises(slipfit.OptionError, match="min_amplitude is in 's', what it belongs to in 'rad'"):
        arrow.ringdown_files(f"{tmp_path}/*.csv", unit="rad", min_amplitude=value(1.0, "s"))
    with pytest.raises(slipfit.OptionError, match="start_s is in 'mm' where a value in s is needed"):
        arrow.ringdown_files(f"{tmp_path}/*.csv", start_s=value(1.0, "mm"))
