"""Amplitudes over drive levels, from every kind of array that has both."""

import numpy as np
import pytest
import slipfit

DRIVE = np.arange(0.1, 1.3, 0.1)
AMPLITUDE = np.maximum(40 * (DRIVE - 0.35), 0) + 0.02 * (np.arange(12) * 7 % 5)


@pytest.fixture(scope="module")
def expected():
    return slipfit.levels(DRIVE, AMPLITUDE, unit="nm", drive_unit="V")


def test_labelled_arrays_have_both(expected):
    pandas, xarray = pytest.importorskip("pandas"), pytest.importorskip("xarray")
    series = pandas.Series(AMPLITUDE, index=pandas.Index(DRIVE, name="drive (V)"), name="R (nm)")
    assert slipfit.levels(series) == expected
    bare = pandas.Series(AMPLITUDE, index=DRIVE)
    assert slipfit.levels(bare, unit="nm", drive_unit="V") == expected
    array = xarray.DataArray(AMPLITUDE, dims="u", coords={"u": ("u", DRIVE, {"units": "V"})}, attrs={"units": "nm"})
    assert slipfit.levels(array) == expected
    turned = slipfit.levels(pandas.Series(AMPLITUDE * np.exp(2j), index=series.index, name="R (nm)"))
    assert turned.parameters.threshold.value == pytest.approx(expected.parameters.threshold.value)
    errors = pandas.Series(np.full(12, 0.05), index=series.index)
    assert slipfit.levels(series, std_error=errors) == slipfit.levels(DRIVE, AMPLITUDE, std_error=errors.to_numpy(), unit="nm", drive_unit="V")
    with pytest.raises(slipfit.OptionError, match="std_error has another index than amplitude"):
        slipfit.levels(series, std_error=errors[::-1])


def test_columns_of_a_table_are_known_by_their_names(expected):
    pandas, polars, pa = (pytest.importorskip(name) for name in ("pandas", "polars", "pyarrow"))
    columns = {"drive (V)": DRIVE, "R (nm)": AMPLITUDE}
    swapped = dict(reversed(columns.items()))
    for held in (columns, swapped):
        for table in (pandas.DataFrame(held), polars.DataFrame(held), pa.table(held)):
            for name, quantity in expected.parameters.items():
                assert slipfit.levels(table).parameters[name].value == pytest.approx(quantity.value, rel=1e-12), name
                assert slipfit.levels(table).parameters[name].unit == quantity.unit
    plain = pandas.DataFrame({"drive": DRIVE, "amplitude": AMPLITUDE})
    assert slipfit.levels(plain, unit="nm", drive_unit="V").parameters == expected.parameters


def test_what_has_not_both_is_refused():
    pandas, xarray = pytest.importorskip("pandas"), pytest.importorskip("xarray")
    frame = pandas.DataFrame({"a": DRIVE, "b": AMPLITUDE})
    several = pandas.MultiIndex.from_arrays([DRIVE, DRIVE])
    for wrong, option, words in (
        (pandas.Series(AMPLITUDE), "amplitude", "levels need amplitudes"),
        (xarray.DataArray(AMPLITUDE, dims="u"), "amplitude", "levels need amplitudes"),
        (xarray.DataArray(np.zeros((3, 4))), "drive", "where one is needed"),
        (xarray.Dataset({"a": ("u", DRIVE)}), "drive", "one of the variables of the Dataset"),
        (pandas.Series(AMPLITUDE, index=several), "drive", "the index has 2 levels"),
        (pandas.Series(AMPLITUDE, index=pandas.to_datetime(DRIVE, unit="s")), "drive", "drive holds times"),
        (pandas.Series(["x"] * 12, index=DRIVE), "amplitude", "does not hold numbers"),
        (frame, "drive", "give the columns themselves"),
        (frame[["a"]], "drive", "table of one column: the column itself is needed; there is 'a'"),
        (frame.set_axis(["a", "a"], axis=1), "drive", "several columns of one name"),
        (frame.assign(b="x"), "drive", "b does not hold numbers"),
        (frame[:0], "drive", "no rows|columns themselves"),
    ):
        with pytest.raises(slipfit.OptionError, match=words) as raised:
            slipfit.levels(wrong)
        assert raised.value.option == option, words
    with pytest.raises(slipfit.OptionError, match="std_error is given beside a table"):
        slipfit.levels(frame, std_error=DRIVE)
