"""Maps: a trace in each pixel, whatever holds them."""

import subprocess

import numpy as np
import pytest
import slipfit
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

pytest.importorskip("pyarrow")
xr = pytest.importorskip("xarray")

DT = 0.01


@pytest.fixture(scope="module")
def friction():
    return np.linspace(0, 0.2, 12 * 7).reshape(12, 7)


@pytest.fixture(scope="module")
def stack(friction):
    fall = np.exp(-0.5 * DT * np.arange(150))
    noise = 1e-3 * np.random.default_rng(11).standard_normal((12, 7, 150))
    return fall - friction[..., None] * (1 - fall) / 0.5 + noise


def test_every_order_of_axes_gives_one_map(stack, friction):
    found = slipfit.fit_map(stack, DT, unit="nm", frequency_hz=50)
    assert found["sliding_rate"].dims == ("y", "x")
    error = found["sliding_rate_std_error"].values
    assert (np.abs(found["sliding_rate"].values - friction) < 5 * error).all()
    assert found["friction_displacement"].attrs["units"] == "nm"
    assert found["sliding_rate"].attrs["units"] == "nm/s"
    assert found["decay_rate_per_s"].attrs["units"] == "1/s"
    assert (found["status"] != "failed").all()
    xr.testing.assert_identical(found, slipfit.fit_map(np.moveaxis(stack, 2, 0), DT, axis=0, unit="nm", frequency_hz=50))
    xr.testing.assert_identical(found, slipfit.fit_map(np.moveaxis(stack, 2, 1), DT, axis=1, unit="nm", frequency_hz=50))


def test_blocks_join_to_the_whole(stack, tmp_path, monkeypatch):
    whole = slipfit.fit_map(stack, DT)
    monkeypatch.setattr("slipfit._map._BLOCK", 5 * 7 * 150 * 8)
    path = tmp_path / "stack.npy"
    np.save(path, stack)
    seen = []
    found = slipfit.fit_map(np.load(path, mmap_mode="r"), DT, progress=lambda done, all: seen.append((done, all)))
    xr.testing.assert_identical(found, whole)
    assert seen == [(35, 84), (70, 84), (84, 84)]


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_files_are_read_block_by_block(stack, tmp_path, monkeypatch, axis):
    """What NumPy, h5py and zarr-python wrote, open or by its path, is the map of the array."""
    h5py, zarr = pytest.importorskip("h5py"), pytest.importorskip("zarr")
    monkeypatch.setattr("slipfit._map._BLOCK", 5 * 7 * 150 * 8)
    turned = np.moveaxis(stack, 2, axis)
    whole = slipfit.fit_map(turned, DT, axis=axis, unit="nm")
    np.save(tmp_path / "stack.npy", turned)
    held = zarr.create_array(tmp_path / "plain.zarr", data=turned, chunks=(5, 5, 5))
    held.attrs["units"] = "nm"
    with h5py.File(tmp_path / "stack.h5", "w") as file:
        file.create_dataset("scan/amplitude", data=turned, chunks=(5, 5, 5), compression="gzip").attrs["units"] = "nm"
        file["scan/other"] = np.zeros((2, 2, 2))
        xr.testing.assert_identical(slipfit.fit_map(file["scan/amplitude"], DT, axis=axis, unit="nm"), whole)
    xr.testing.assert_identical(slipfit.fit_map(held, DT, axis=axis, unit="nm"), whole)
    xr.testing.assert_identical(slipfit.fit_map(tmp_path / "stack.npy", DT, axis=axis, unit="nm"), whole)
    xr.testing.assert_identical(slipfit.fit_map(str(tmp_path / "plain.zarr"), DT, axis=axis), whole)
    from_hdf5 = slipfit.fit_map(tmp_path / "stack.h5", DT, axis=axis, data="scan/amplitude")
    xr.testing.assert_identical(from_hdf5, whole)
    with pytest.raises(slipfit.ReadError, match="name one of them"):
        slipfit.fit_map(tmp_path / "stack.h5", DT)
    with pytest.raises(slipfit.OptionError, match="names an array in a file"):
        slipfit.fit_map(stack, DT, data="scan/amplitude")
    with pytest.raises(slipfit.ReadError, match="holds one without a name"):
        slipfit.fit_map(tmp_path / "stack.npy", DT, data="amplitude")


def packings():
    """What zarr-python packs chunks with, by default and on demand, in both versions."""
    numcodecs, zarr = pytest.importorskip("numcodecs"), pytest.importorskip("zarr")
    for name in ("lz4", "lz4hc", "zlib", "zstd"):
        for shuffle in (0, 1):
            yield 2, numcodecs.Blosc(cname=name, shuffle=shuffle)
    yield from ((2, numcodecs.GZip()), (2, numcodecs.Zstd()), (2, None))
    yield from ((3, zarr.codecs.GzipCodec()), (3, zarr.codecs.BloscCodec(cname="lz4")), (3, None))


@pytest.mark.parametrize("kind", ["<f8", ">f4", "<i2"])
def test_stores_of_every_packing_are_read(tmp_path, kind):
    zarr = pytest.importorskip("zarr")
    numbers = np.round(1000 * np.exp(-0.02 * np.arange(200)) * np.ones((9, 11, 1))).astype(kind)
    whole = slipfit.fit_map(numbers.astype(float), DT)
    for i, (version, packing) in enumerate(packings()):
        path = tmp_path / f"{i}.zarr"
        zarr.create_array(path, data=numbers, chunks=(4, 11, 90), zarr_format=version, compressors=packing)
        xr.testing.assert_identical(slipfit.fit_map(path, DT), whole)


def test_a_map_is_written_as_zarr_and_hdf5(stack, tmp_path):
    pytest.importorskip("zarr"), pytest.importorskip("h5netcdf")
    found = slipfit.fit_map(stack, DT, unit="nm")
    found.to_zarr(tmp_path / "map.zarr", zarr_format=2)
    found.to_netcdf(tmp_path / "map.h5", engine="h5netcdf")
    for again in (xr.open_zarr(tmp_path / "map.zarr"), xr.open_dataset(tmp_path / "map.h5", engine="h5netcdf")):
        xr.testing.assert_equal(again.load(), found)
        assert again["sliding_rate"].attrs["units"] == "nm/s"
        again.close()


def test_stores_of_the_command_are_read_and_those_of_zarr_are_its_input(stack, tmp_path, command):
    zarr = pytest.importorskip("zarr")
    zarr.create_array(tmp_path / "stack.zarr", data=stack, chunks=(5, 7, 40)).attrs["units"] = "nm"
    line = [command, "map", tmp_path / "stack.zarr", "--dt", str(DT), "--table", tmp_path / "map.zarr", "--quiet"]
    subprocess.run(line, check=True)
    whole = slipfit.fit_map(stack, DT, unit="nm")
    for again in (xr.open_zarr(tmp_path / "map.zarr").load(), zarr.open_group(tmp_path / "map.zarr", mode="r")):
        assert again["sliding_rate"].shape == (12, 7)
        assert again["sliding_rate"].attrs["units"] == "nm/s"
        for name in whole:
            held = np.asarray(again[name][...])
            np.testing.assert_array_equal(held.astype(str) if held.dtype.kind == "S" else held, whole[name])


def test_labels_are_taken_over(stack):
    array = xr.DataArray(
        stack, dims=("row", "column", "time"), attrs={"units": "pm"},
        coords={"row": np.arange(12) * 0.5, "time": 3.0 + DT * np.arange(150)},
    )  # fmt: skip
    found = slipfit.fit_map(array)
    assert found.sizes == {"row": 12, "column": 7}
    np.testing.assert_array_equal(found["row"], array["row"])
    assert found["initial_amplitude"].attrs["units"] == "pm"
    turned = slipfit.fit_map(array.transpose("time", "row", "column"))
    np.testing.assert_allclose(turned["sliding_rate"], found["sliding_rate"], rtol=1e-12)
    where = {"height": (("row", "column"), stack[..., 0]), "run": 5, "index": ("time", np.arange(150))}
    beside = slipfit.fit_map(array.assign_coords(where))
    assert set(beside.coords) == {"row", "height", "run"}, "all but those over time"
    np.testing.assert_array_equal(beside["height"], stack[..., 0])
    for taken in (array.assign_coords(status=("row", np.arange(12))), array.rename(row="samples")):
        with pytest.raises(slipfit.OptionError, match="rename that dimension or coordinate"):
            slipfit.fit_map(taken)
    with pytest.raises(slipfit.OptionError, match="does not rise"):
        slipfit.fit_map(array.isel(time=slice(None, None, -1)))
    uneven = array.assign_coords(time=array["time"] ** 2)
    with pytest.raises(slipfit.OptionError, match="not even"):
        slipfit.fit_map(uneven)


def test_a_map_goes_on_where_it_was_interrupted(stack, tmp_path, monkeypatch):
    whole = slipfit.fit_map(stack, DT)
    monkeypatch.setattr("slipfit._map._BLOCK", 5 * 7 * 150 * 8)

    class Ended(Exception):
        pass

    def end(done, _):
        if done > 35:
            raise Ended

    with pytest.raises(Ended):
        slipfit.fit_map(stack, DT, resume=tmp_path, progress=end)
    # The second block was written before the end; another is cut off in the middle.
    assert len(list(tmp_path.iterdir())) == 2
    (tmp_path / "rows-5-10.npz").write_bytes((tmp_path / "rows-5-10.npz").read_bytes()[:900])
    computed = []

    def counted(traces, **options):
        computed.append(len(traces))
        return slipfit.fit_batch(traces, **options)

    monkeypatch.setattr("slipfit._map.fit_batch", counted)
    xr.testing.assert_identical(slipfit.fit_map(stack, DT, resume=tmp_path), whole)
    assert computed == [35, 14], "what is cut off and what is missing"
    computed.clear()
    other = stack.copy()
    other[11, 6, 3] += 0.5
    slipfit.fit_map(other, DT, resume=tmp_path)
    assert computed == [14], "only what changed"
    computed.clear()
    slipfit.fit_map(stack, 2 * DT, resume=tmp_path)
    assert computed == [35, 35, 14], "blocks of other options are not taken"


def test_an_oscillation_is_analysed_in_each_pixel():
    record = slipfit.simulate.decay(
        frequency_hz=8, q_factor=90, friction_displacement=0.002, amplitude=1, duration_s=6, rate_hz=200
    )
    noise = 1e-3 * np.random.default_rng(12).standard_normal((2, 1, len(record)))
    found = slipfit.fit_map(record.signal + noise, 1 / 200, kind="displacement", method="analyse", unit="nm")
    assert found["frequency_hz"].attrs["units"] == "Hz"
    np.testing.assert_allclose(found["friction_displacement"], 0.002, rtol=0.05)
    assert found["sliding_detected"].values.all()


@pytest.mark.parametrize(
    ("stack", "options", "words"),
    [
        (np.zeros((3, 4)), {"dt": 1}, r"\(y, x, t\)"),
        ([1, 2], {"dt": 1}, r"\(y, x, t\)"),
        (np.zeros((2, 2, 9)), {}, "dt is needed"),
        (np.zeros((2, 2, 9)), {"dt": 0}, "positive"),
        (np.zeros((2, 2, 9)), {"dt": 1, "axis": 3}, "axis=3"),
        (np.zeros((2, 2, 9)), {"dt": 1, "axis": "time"}, "no such dimension"),
        (np.zeros((2, 2, 9), dtype=complex), {"dt": 1}, "real numbers"),
        (np.zeros((0, 2, 9)), {"dt": 1}, "no pixels"),
        (np.zeros((2, 2, 0)), {"dt": 1}, "no samples"),
        (np.zeros((2, 2, 9)), {"dt": 1, "kind": "displacement"}, "needs the method analyse"),
        (
            np.zeros((2, 2, 9)),
            {"dt": 1, "kind": "displacement", "method": "analyse", "frequency_hz": 5},
            "frequency of its own",
        ),
    ],
)
def test_what_cannot_be_meant_is_refused(stack, options, words):
    with pytest.raises(slipfit.OptionError, match=words):
        slipfit.fit_map(stack, **options)


def test_a_map_of_one_dead_pixel_is_a_map():
    found = slipfit.fit_map(np.full((1, 1, 9), np.nan), 1.0)
    assert found["status"].item() == "failed"
    assert np.isnan(found["sliding_rate"].item())


@settings(max_examples=150, deadline=None)
@given(
    hnp.arrays(
        st.sampled_from([np.float64, np.float32, np.int16, np.uint8, np.bool_, np.complex128, object]),
        hnp.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=6),
        fill=st.just(0),
    ),
    st.sampled_from([None, 1.0, 0.0, -1.0, float("nan"), 1e300]),
    st.sampled_from([None, 0, 2, -1, 7, "t"]),
    st.sampled_from([None, 1.0, 0.0, float("inf")]),
)
def test_no_stack_does_more_than_raise(stack, dt, axis, frequency_hz):
    """A stack of one trace, of objects, of any shape: a map of as many pixels, or an exception with a code."""
    try:
        found = slipfit.fit_map(stack, dt=dt, axis=axis, frequency_hz=frequency_hz)
    except slipfit.SlipfitError as error:
        assert error.code != "internal", error
        return
    assert found["status"].size * stack.shape[2 if axis is None else axis] == stack.size
    assert set(np.unique(found["status"].values)) <= {"done", "warned", "failed"}


def test_masks_single_precision_and_numpy_scalars_are_taken(tmp_path):
    xarray = pytest.importorskip("xarray")
    t = 0.01 * np.arange(120)
    trace = np.exp(-0.5 * t) - 0.1 * (1 - np.exp(-0.5 * t)) / 0.5
    mask = np.zeros((1, 1, 120), bool)
    mask[..., 7] = True
    masked = np.ma.array(np.where(mask, 50.0, trace), mask=mask)
    assert slipfit.fit_map(masked, 0.01)["sliding_rate"].item() == pytest.approx(0.1, rel=1e-6)
    stack = trace[None, None]
    slipfit.fit_map(stack, np.float32(0.01), frequency_hz=np.int64(75000), resume=tmp_path)
    for times, units in ((t.astype("f4"), {}), (1e3 * t, {"units": "ms"})):
        labelled = xarray.DataArray(stack, dims=("y", "x", "t"), coords={"t": ("t", times, units)})
        assert slipfit.fit_map(labelled)["sliding_rate"].item() == pytest.approx(0.1, rel=1e-5)


def test_time_is_found_by_its_name_or_its_dates(stack):
    found = slipfit.fit_map(stack, DT)
    first = np.moveaxis(stack, 2, 0)
    sampled = DT * np.arange(150)
    durations = (sampled * 1e9).round().astype("timedelta64[ns]")
    for name, coordinate in (("Time", sampled), ("T", sampled), ("sampled", durations)):
        labelled = xr.DataArray(first, dims=(name, "y", "x"), coords={name: coordinate})
        for dt in (None, DT, np.timedelta64(10, "ms")):
            again = slipfit.fit_map(labelled, dt)
            assert again.sizes == {"y": 12, "x": 7}
            np.testing.assert_allclose(again["sliding_rate"], found["sliding_rate"], rtol=1e-6, atol=1e-9)


def test_a_coordinate_of_places_is_never_time(stack):
    """Of frames with times beside them the last axis, x, was taken for time."""
    found = slipfit.fit_map(stack, DT)
    first = np.moveaxis(stack, 2, 0)
    sampled = DT * np.arange(150)
    durations = (sampled * 1e9).round().astype("timedelta64[ns]")
    place = {"x": 0.5 * np.arange(7), "y": 0.5 * np.arange(12)}
    for name, coordinate in (
        ("time", ("frame", sampled)), ("t (ms)", ("frame", 1e3 * sampled)), ("when", ("frame", durations)),
        ("delay", ("frame", 1e3 * sampled, {"units": "ms"})),
    ):  # fmt: skip
        for counted in ({}, {"frame": np.arange(150)}):
            labelled = xr.DataArray(first, dims=("frame", "y", "x"), coords={name: coordinate, **place, **counted})
            for dt in (None, DT):
                again = slipfit.fit_map(labelled, dt)
                assert again.sizes == {"y": 12, "x": 7} and set(again.coords) == {"y", "x"}
                np.testing.assert_allclose(again["sliding_rate"], found["sliding_rate"], rtol=1e-6, atol=1e-9)
            with pytest.raises(slipfit.OptionError, match="dt is given as 0.02 s beside the coordinate") as raised:
                slipfit.fit_map(labelled, 2 * DT)
            assert raised.value.option == "dt"
    rows = xr.DataArray(first[:, 0], dims=("frame", "x"), coords={"time": ("frame", sampled), "x": place["x"]})
    again = slipfit.fit_batch(rows, amplitude="a")
    np.testing.assert_allclose(again["sliding_rate"], found["sliding_rate"].values[0], rtol=1e-6, atol=1e-9)
    for coords in (place, {}):
        untold = xr.DataArray(first, dims=("frame", "y", "x"), coords=coords)
        for dt in (None, DT):
            with pytest.raises(slipfit.OptionError, match="axis=… names the dimension of time") as raised:
                slipfit.fit_map(untold, dt)
            assert raised.value.option == "axis"
        again = slipfit.fit_map(untold, DT, axis="frame")
        np.testing.assert_allclose(again["sliding_rate"], found["sliding_rate"], rtol=1e-6, atol=1e-9)


def test_a_map_takes_the_options_of_the_analysis():
    """As a batch does."""
    swing = slipfit.simulate.decay(
        frequency_hz=3, q_factor=60, friction_displacement=0.01, amplitude=1, duration_s=12, rate_hz=100, noise_rms=1e-3
    )
    options = {"kind": "displacement", "method": "analyse", "dt": 0.01}
    given = {"band_hz": (2, 4), "model": "viscous+sliding", "start_s": 1.0, "end_s": np.timedelta64(6, "s")}
    found = slipfit.fit_map(swing.signal[np.newaxis, np.newaxis], **options, **given)
    row = slipfit.fit_batch([swing.signal], signal="x", **options, **given)
    assert found["model"].item() == "viscous+sliding" and found["start_s"].item() >= 1 and found["end_s"].item() <= 6
    for name in row:
        np.testing.assert_array_equal(found[name].values.reshape(-1), row[name])
    for option, value in given.items():
        with pytest.raises(slipfit.OptionError, match=f"{option} is an option of method='analyse'") as raised:
            slipfit.fit_map(swing.signal[np.newaxis, np.newaxis], 0.01, **{option: value})
        assert raised.value.option == option


def test_stacks_bring_their_unit(stack):
    pint = pytest.importorskip("pint")
    found = slipfit.fit_map(pint.UnitRegistry().Quantity(stack, "nm"), DT)
    xr.testing.assert_identical(found, slipfit.fit_map(stack, DT, unit="nm"))
    rows = pint.UnitRegistry().Quantity(stack[0], "nm")
    assert slipfit.fit_batch(rows, amplitude="a", dt=DT) == slipfit.fit_batch(stack[0], amplitude="a", dt=DT)


def test_pictures_mark_pixels_with_a_warning(stack):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    stack = stack.copy()
    stack[2, 3] = np.maximum(1 - 3 * DT * np.arange(150), 0) + 1e-3 * stack[2, 4]
    stack[5, 1] = np.nan
    found = slipfit.fit_map(xr.DataArray(stack, dims=("y", "x", "t"), coords={"x": 0.5 * np.arange(7)}), DT, unit="nm")
    assert found["status"].values[2, 3] == "warned"
    assert found["status"].values[5, 1] == "failed"
    panels = slipfit.plot_map(found)
    assert [panel.get_xlabel() for panel in panels] == ["x", "x"]
    for panel, name in zip(panels, ("sliding_rate", "decay_rate_per_s")):
        colours, cores = panel.collections
        shown = colours.get_array()
        assert shown.mask[5, 1] and shown.mask.sum() == 1
        warned = np.argwhere((found["status"] == "warned").values)
        assert len(cores.get_paths()) == len(warned)
        # The core of a pixel lies within it.
        at = warned.tolist().index([2, 3])
        low, high = cores.get_paths()[at].get_extents().get_points()
        np.testing.assert_allclose([low, high], [[1.375, 1.75], [1.625, 2.25]])
        sound = found[name].values[(found["status"] == "done").values]
        assert sound.min() <= colours.norm.vmin and colours.norm.vmax <= sound.max()
    plt.close(panels[0].figure)
    figure, ax = plt.subplots()
    assert slipfit.plot_map(found.isel(y=[5], x=[1]), "decay_rate_per_s", ax) == [ax]
    with pytest.raises(slipfit.OptionError, match="there are decay_rate_per_s, ") as raised:
        slipfit.plot_map(found, "decay")
    assert raised.value.option == "column"
    with pytest.raises(slipfit.OptionError, match="no map"):
        slipfit.plot_map(found[["sliding_rate"]])
    plt.close(figure)


def test_a_missing_array_says_which_there_are(stack, tmp_path):
    h5py, zarr = pytest.importorskip("h5py"), pytest.importorskip("zarr")
    with h5py.File(tmp_path / "stack.h5", "w") as file:
        file["scan/amplitude"], file["scan/x"] = stack, np.zeros(3)
    with h5py.File(tmp_path / "flat.h5", "w") as file:
        file["flat"] = np.zeros((3, 4))
    group = zarr.create_group(tmp_path / "stack.zarr")
    group.create_array("scan/amplitude", data=stack)
    group.create_array("flat", data=np.zeros((3, 4)))
    shape = " × ".join(map(str, stack.shape))
    for path, name, words in (
        ("stack.h5", "amplitude", rf"no data set amplitude in it; there are /scan/amplitude \({shape}\), /scan/x \(3\)"),
        ("stack.h5", "scan", "no data set scan in it; there are /scan/amplitude"),
        ("stack.h5", "scan/amplitude/more", "no data set scan/amplitude/more in it; there are"),
        ("flat.h5", None, r"no data set in it has three axes; there are /flat \(3 × 4\)"),
        ("stack.zarr", "amplitude", rf"no array amplitude in it; there are /scan/amplitude \({shape}\), /flat \(3 × 4\)"),
        ("stack.zarr", "scan", "no array scan in it; there are"),
    ):
        with pytest.raises(slipfit.ReadError, match=words):
            slipfit.fit_map(tmp_path / path, DT, data=name)
    for name in ("/scan/amplitude", "scan/amplitude"):
        assert slipfit.fit_map(tmp_path / "stack.h5", DT, data=name).sizes["y"] == stack.shape[0]


def test_friction_of_velocities_is_a_length():
    trace = slipfit.simulate.decay(frequency_hz=5, q_factor=50, amplitude=1, duration_s=8, rate_hz=100, unit="mm")
    stack = np.gradient(trace.signal, trace.time_s)[np.newaxis, np.newaxis]
    found = slipfit.fit_map(stack, 0.01, kind="velocity", method="analyse", unit="mm/s")
    assert found["friction_displacement"].attrs["units"] == "mm"
    assert found["initial_amplitude"].attrs["units"] == "mm/s"


def test_what_is_no_stack_says_what_is(stack):
    with pytest.raises(slipfit.OptionTypeError, match="one of the variables of the Dataset is needed: 'one', 'two'"):
        slipfit.fit_map(xr.Dataset({"one": (("y", "x", "t"), stack), "two": 3}), DT)
    with pytest.raises(slipfit.OptionError, match="slipfit.fit_batch takes traces in rows"):
        slipfit.fit_map(stack[0], DT)
    for name in ("rate_hz", "fs"):
        with pytest.raises(TypeError, match=f"did you mean dt=1/{name}"):
            slipfit.fit_map(stack, **{name: 100})
    times = 1e3 * DT * np.arange(stack.shape[-1])
    labelled = xr.DataArray(np.moveaxis(stack, -1, 0), dims=("time (ms)", "y", "x"), coords={"time (ms)": times})
    xr.testing.assert_allclose(slipfit.fit_map(labelled), slipfit.fit_map(stack, DT))


def test_a_map_of_levels_is_that_of_their_amplitudes(stack):
    """An error spoke of a signal that no argument is."""
    amplitudes = np.abs(stack) + 1e-6
    levels = 20 * np.log10(amplitudes)
    plain, found = slipfit.fit_map(amplitudes, DT, unit="V"), slipfit.fit_map(levels, DT, unit="dBV")
    for name in ("sliding_rate", "decay_rate_per_s", "initial_amplitude"):
        np.testing.assert_allclose(found[name], plain[name], rtol=1e-6)
        assert found[name].attrs == plain[name].attrs
    for method, option in (("analyse", "kind"), ("fit", "method")):
        with pytest.raises(slipfit.OptionError, match=f"{option}=") as raised:
            slipfit.fit_map(levels, DT, unit="dB", kind="displacement", method=method)
        assert raised.value.option == option and "signal" not in str(raised.value)


def test_the_map_of_the_command_is_that_of_the_package(command, stack, tmp_path):
    levels = 20 * np.log10(np.abs(stack) + 1e-6)
    np.save(tmp_path / "levels.npy", levels)
    table = tmp_path / "map.npy"
    told = [command, "map", tmp_path / "levels.npy", "--dt", str(DT), "--unit", "dBm", "--table", table, "--quiet"]
    subprocess.run(told, check=True)
    found, own = np.load(table), slipfit.fit_map(levels, DT, unit="dBm")
    for name in ("sliding_rate", "decay_rate_per_s", "initial_amplitude", "residual_rms"):
        np.testing.assert_array_equal(found[name], own[name].values)
