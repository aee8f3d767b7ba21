"""What was read is copied, pickled and compared."""

import copy
import json
import pickle

import numpy as np
import pytest
import slipfit
from conftest import ROOT

EXAMPLES = ROOT / "examples"


def readings(folder):
    """One of each: from files, bytes, arrays and several files."""
    swing = np.exp(-0.05 * np.arange(0, 30, 0.05)) * np.cos(6.3 * np.arange(0, 30, 0.05))
    yield slipfit.read(EXAMPLES / "classroom_pendulum.csv")
    yield slipfit.read(EXAMPLES / "tuning_fork_9nN.csv", unit="m", kind="envelope")
    yield slipfit.read((EXAMPLES / "classroom_pendulum.csv").read_bytes(), name="pendulum.csv")
    yield slipfit.read_curve(EXAMPLES / "tuning_fork_9nN_sweep.csv")
    yield slipfit.read_levels(EXAMPLES / "tuning_fork_9nN_levels.csv")
    yield slipfit.simulate.decay(frequency_hz=8, q_factor=90, amplitude=1, duration_s=6, rate_hz=200)
    time = np.arange(0, 2, 1e-3)
    for hz in (9.0, 10.0, 11.0, 12.0):
        size = 1 / abs(10.2 - hz)
        columns = np.c_[time, size * np.cos(2 * np.pi * hz * time), np.cos(2 * np.pi * hz * time)]
        np.savetxt(folder / f"{hz}.csv", columns, delimiter=",", header="time (s),x (m),drive (V)", comments="")
    yield slipfit.read_curve(folder)
    arrays = slipfit.ringdown(0.05 * np.arange(len(swing)), swing, unit="m")
    assert arrays == pickle.loads(pickle.dumps(arrays))


def test_readings_are_copied_pickled_and_compared(tmp_path):
    every = list(readings(tmp_path))
    for reading in every:
        for same in (copy.copy(reading), copy.deepcopy(reading), pickle.loads(pickle.dumps(reading))):
            assert same == reading and hash(same) == hash(reading), reading
            assert repr(same) == repr(reading) and same.notes == reading.notes
    assert all(a != b for i, a in enumerate(every) for b in every[:i])
    assert every[0] != "a record"
    again = pickle.loads(pickle.dumps(every[0]))
    assert slipfit.ringdown(again).to_json() == slipfit.ringdown(every[0]).to_json()


def test_a_pickle_holds_the_numbers_that_were_read(tmp_path):
    path = tmp_path / "swing.csv"
    path.write_bytes((EXAMPLES / "classroom_pendulum.csv").read_bytes())
    record = slipfit.read(path)
    held = pickle.dumps(record)
    path.write_bytes(path.read_bytes() + b"60.5,0\n")
    assert pickle.loads(held) == record
    with pytest.raises(RuntimeError, match="has changed since it was read"):
        pickle.dumps(record)
    path.unlink()
    assert json.loads(slipfit.ringdown(pickle.loads(held)).to_json())["input"]["path"] == str(path)
    with pytest.raises(FileNotFoundError):
        pickle.dumps(record)


def test_what_was_read_is_a_frame_with_its_units():
    pytest.importorskip("pandas")
    swing = slipfit.read(EXAMPLES / "classroom_pendulum.csv")
    frame = swing.to_dataframe()
    assert list(frame) == ["time (s)", "displacement (rad)"] and len(frame) == len(swing)
    assert np.array_equal(frame["time (s)"], swing.time_s) and np.array_equal(frame["displacement (rad)"], swing.signal)
    # Given back it is the same record.
    again = slipfit.ringdown(frame["time (s)"], frame["displacement (rad)"])
    assert again.parameters == slipfit.ringdown(swing).parameters
    time = 0.01 * np.arange(500)
    rows = np.c_[time, np.exp(-time) * np.cos(time), np.exp(-time) * np.sin(time)]
    text = "t (s),x (mV),y (mV)\n" + "".join(",".join(map(repr, map(float, row))) + "\n" for row in rows)
    lock_in = slipfit.read(text.encode(), kind="lock-in").to_dataframe()
    assert list(lock_in) == ["time (s)", "x (mV)", "y (mV)"]
    assert np.array_equal(lock_in["y (mV)"], rows[:, 2])
    curve = slipfit.read_curve(b"f (Hz),R (mm),phase (deg)\n" + b"".join(b"%d,%d,%d\n" % (f, f % 7, -f) for f in range(1, 30)))
    assert list(curve.to_dataframe()) == ["frequency (Hz)", "amplitude (mm)", "phase (rad)"]
    assert curve.to_dataframe()["phase (rad)"][9] == pytest.approx(np.radians(-10))
    levels = slipfit.read_levels(b"drive (V),A\n1,0.1\n2,0.9\n3,2.1\n4,3\n")
    assert levels.to_dataframe().to_dict("list") == {"drive (V)": [1, 2, 3, 4], "amplitude": [0.1, 0.9, 2.1, 3]}


def test_what_was_read_is_drawn():
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    swing = slipfit.read(EXAMPLES / "classroom_pendulum.csv")
    (ax,) = swing.plot()
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time [s]", "displacement [rad]")
    assert np.array_equal(ax.lines[0].get_xydata(), np.c_[swing.time_s, swing.signal])
    curve = slipfit.read_curve(b"f (Hz),R (mm),phase (deg)\n" + b"".join(b"%d,%d,%d\n" % (f, f % 7, -f) for f in range(1, 30)))
    assert [ax.get_ylabel() for ax in curve.plot()] == ["amplitude [mm]", "phase [rad]"]
    own = plt.subplots()[1]
    assert curve.plot(own) == [own] and len(own.lines) == 1
    with pytest.raises(slipfit.OptionTypeError, match="matplotlib Axes are needed"):
        swing.plot("red")
    plt.close("all")
