"""Python prints the numbers that the command prints, to the last bit."""

import json
import subprocess

import numpy as np
import pytest
import slipfit
from conftest import ROOT, real_files

EXAMPLES = ROOT / "examples"


def by_command(command, *arguments):
    """JSON of the command, or what it says of a failure."""
    run = subprocess.run(
        [command, *map(str, arguments), "--json", "-", "--quiet"], capture_output=True, text=True, check=False
    )
    assert run.returncode in (0, 2), run.stderr
    return run.stdout if run.returncode == 0 else None, run.stderr


def by_package(analyse, path):
    try:
        return analyse(str(path)).to_json()
    except slipfit.SlipfitError:
        return None


def same(command, name, analyse, path):
    expected, complaint = by_command(command, name, path)
    found = by_package(analyse, path)
    assert (found is None) == (expected is None), complaint or "the command has an answer"
    assert found == expected
    return found is not None


@pytest.mark.parametrize("path", real_files("ringdown"))
def test_measured_ringdowns(command, path):
    same(command, "ringdown", slipfit.ringdown, path)


@pytest.mark.parametrize("path", real_files("simulated"))
def test_simulated_ringdowns(command, path):
    same(command, "ringdown", slipfit.ringdown, path)


@pytest.mark.parametrize("path", real_files("sweep"))
def test_measured_sweeps(command, path):
    same(command, "resonance", slipfit.resonance, path)


@pytest.mark.parametrize("name", ["tuning_fork_9nN.csv", "tuning_fork_12nN.csv", "classroom_pendulum.csv"])
def test_examples_of_ringdowns(command, name):
    assert same(command, "ringdown", slipfit.ringdown, EXAMPLES / name)


def test_example_of_a_curve_with_its_reference(command):
    curve, free = EXAMPLES / "tuning_fork_9nN_sweep.csv", EXAMPLES / "tuning_fork_free_sweep.csv"
    expected, _ = by_command(command, "resonance", curve, "--reference", free, "--stiffness", "12000(300)")
    answer = slipfit.resonance(str(curve), reference=str(free), stiffness=(12000, 300))
    assert answer.to_json() == expected


def test_example_of_levels(command):
    assert same(command, "levels", slipfit.levels, EXAMPLES / "tuning_fork_9nN_levels.csv")


def test_options_mean_what_they_mean_to_the_command(command):
    path = EXAMPLES / "classroom_pendulum.csv"
    expected, _ = by_command(
        command, "ringdown", path, "--start", "2", "--end", "20", "--model", "viscous+sliding", "--unit", "rad",
        "--inertia", "0.2(1)",
    )  # fmt: skip
    record = slipfit.read(str(path), unit="rad")
    answer = slipfit.ringdown(record, start_s=2, end_s=20, model="viscous+sliding", inertia=(0.2, 0.1))
    assert answer.to_json() == expected


def test_arrays_are_the_file_that_numpy_saves(command, tmp_path, swing):
    time, signal = swing
    table = np.empty(len(time), dtype=[("time_s", "<f8"), ("signal", "<f8")])
    table["time_s"], table["signal"] = time, signal
    path = tmp_path / "arrays.npy"
    np.save(path, table)
    expected, _ = by_command(
        command, "ringdown", path, "--time", "1", "--signal", "2", "--unit", "rad", "--time-unit", "s"
    )
    expected = json.loads(expected)
    found = slipfit.ringdown(time, signal, unit="rad").to_dict()
    assert expected["input"].pop("path") == str(path)
    assert found["input"].pop("path") == "arrays"
    assert found == expected


def test_terminal_report_is_that_of_the_command(command):
    path = EXAMPLES / "tuning_fork_9nN.csv"
    run = subprocess.run([command, "ringdown", str(path)], capture_output=True, text=True, check=True)
    report = str(slipfit.ringdown(str(path)))
    table = run.stdout.split("\n  read")[0]
    assert report.startswith(table)


def test_series_gives_the_table_of_the_command(command):
    expected, _ = by_command(command, "series", EXAMPLES / "tuning_fork.toml")
    expected = json.loads(expected)
    measurements = []
    free = slipfit.read_curve(str(EXAMPLES / "tuning_fork_free_sweep.csv"))
    for one in expected["measurements"]:
        path = one["path"]
        if one["kind"] == "ringdown":
            data, reference = slipfit.read(path), None
        elif one["kind"] == "sweep":
            data, reference = slipfit.read_curve(path), free if "free" not in path else None
        else:
            data, reference = slipfit.read_levels(path), None
        row = next(r for r in expected["table"] if r["condition"] == one["condition"])
        value = None if row["value"] is None else (row["value"], row["value_std_error"])
        measurements.append(
            slipfit.Measurement(data, condition=one["condition"], value=value, name=one["name"], reference=reference)
        )
    constant = expected["calibration"]
    given = {} if constant is None else {constant["kind"]: (constant["value"], constant["std_error"])}
    found = slipfit.series(
        measurements, shared=expected["shared"], condition=expected["condition"],
        condition_unit=expected["condition_unit"], unit=expected["unit"], title=expected["title"], **given,
    ).to_dict()  # fmt: skip
    for key in ("manifest",):
        expected.pop(key), found.pop(key)
    for one in expected["measurements"] + found["measurements"]:
        one.pop("notes")
    assert found == expected
