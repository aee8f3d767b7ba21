"""Times of every make are seconds, or refused."""

import datetime

import numpy as np
import pytest
import slipfit

UTC = datetime.timezone.utc


@pytest.fixture(scope="module")
def hz(answer):
    return answer.parameters.frequency_hz.value


def found(time, signal):
    return slipfit.ringdown(time, signal, unit="rad").parameters.frequency_hz.value


@pytest.mark.parametrize(
    ("unit", "count"), [("ms", 20), ("us", 20_000), ("ns", 20_000_000), ("ps", 20), ("fs", 20), ("as", 20)]
)
@pytest.mark.parametrize("dates", [False, True])
def test_durations_and_dates_of_every_unit(swing, hz, unit, count, dates):
    """Each keeps its digits, whatever a nanosecond is to it."""
    per_second = {"ms": 1e3, "us": 1e6, "ns": 1e9, "ps": 1e12, "fs": 1e15, "as": 1e18}[unit]
    times = (count * np.arange(len(swing[1]))).astype(f"timedelta64[{unit}]")
    if dates:
        times = np.datetime64(0, unit) + times
    # The swing was sampled every 0.02 s.
    assert found(times, swing[1]) == pytest.approx(hz * 0.02 * per_second / count, rel=1e-9)


@pytest.mark.parametrize("unit", ["s", "m", "h", "D", "W"])
def test_long_units_are_not_cut_off(swing, hz, unit):
    """Centuries and more, which nanoseconds in 64 bits do not reach."""
    seconds = {"s": 1, "m": 60, "h": 3600, "D": 86400, "W": 604800}[unit]
    times = np.datetime64("0001-01-01", unit) + 50 * np.arange(len(swing[1])).astype(f"timedelta64[{unit}]")
    assert found(times, swing[1]) == pytest.approx(hz * 0.02 / (50 * seconds), rel=1e-9)


def test_months_of_dates_have_their_days_and_months_alone_have_none(swing):
    months = np.datetime64("2001-01", "M") + np.arange(len(swing[1]))
    days = months.astype("datetime64[D]")
    assert found(months, swing[1]) == found(days, swing[1])
    for times, words in ((np.arange(9).astype("timedelta64[M]"), "months"), (np.arange(9).astype("timedelta64"), "no unit")):
        with pytest.raises(slipfit.OptionError, match=words) as raised:
            slipfit.ringdown(times, np.arange(9))
        assert raised.value.option == "time"


def test_missing_dates_are_missing_times(swing):
    times = (20 * np.arange(len(swing[1]))).astype("timedelta64[ms]")
    times[[5, 9]] = np.timedelta64("NaT")
    answer = slipfit.ringdown(times, swing[1])
    assert answer.to_dict()["input"]["rows_skipped"] == 2


def test_dates_with_and_without_a_zone_are_not_mixed(swing):
    dates = [datetime.datetime(2026, 3, 29, tzinfo=UTC) + datetime.timedelta(seconds=t) for t in swing[0]]
    dates[7] = dates[7].replace(tzinfo=None)
    with pytest.raises(slipfit.OptionError, match="with and without a time zone") as raised:
        slipfit.ringdown(dates, swing[1])
    assert raised.value.option == "time"


def test_a_labelled_array_of_times_is_in_its_unit(swing, hz):
    xarray = pytest.importorskip("xarray")
    time, signal = swing
    for scale, unit in ((1e3, "ms"), (1e6, "us"), (1.0, None)):
        attrs = {} if unit is None else {"units": unit}
        times = xarray.DataArray(scale * time, dims="t", attrs=attrs)
        assert found(times, signal) == pytest.approx(hz, rel=1e-9)
        assert found(times, xarray.DataArray(signal, dims="t")) == pytest.approx(hz, rel=1e-9)
        start = {"initial_amplitude": 1, "offset_amplitude": 0, "decay_rate_per_s": 1}
        fit = slipfit.fit_envelope(times, np.exp(-0.1 * time) - 0.001, **start)
        assert fit.best.decay_rate_per_s == pytest.approx(0.1, rel=1e-6)
    with pytest.raises(slipfit.OptionError, match="fortnights"):
        slipfit.ringdown(xarray.DataArray(time, dims="t", attrs={"units": "fortnights"}), signal)


def test_rows_of_pandas_that_are_counted_are_no_times(swing, hz):
    pandas = pytest.importorskip("pandas")
    time, signal = swing
    whole = pandas.Series(signal)
    holes = pandas.Series(np.where(np.arange(len(signal)) == 7, np.nan, signal))
    for series in (whole, whole[::2], whole[whole.index != 7], holes.dropna(), whole.sample(frac=1, random_state=1)):
        with pytest.raises(slipfit.OptionError, match="no times"):
            slipfit.ringdown(series)
    assert slipfit.ringdown(whole, rate_hz=50).parameters.frequency_hz.value == pytest.approx(hz, rel=1e-9)
    # A rate counts rows: where some were taken out the samples would close up.
    for series in (whole[whole.index != 7], holes.dropna(), whole.sample(frac=1, random_state=1)):
        with pytest.raises(slipfit.OptionError, match="missing or out of order") as raised:
            slipfit.ringdown(series, rate_hz=50)
        assert raised.value.option == "signal"
    assert slipfit.ringdown(holes, rate_hz=50).to_dict()["input"]["rows_skipped"] == 1
    assert slipfit.ringdown(whole[::2], rate_hz=25).parameters.frequency_hz.value == pytest.approx(hz, rel=1e-4)
    # Whole seconds with a name are times.
    seconds = pandas.Series(signal, index=pandas.Index(np.arange(len(signal)), name="t"))
    assert found(seconds, None) == pytest.approx(hz * 0.02, rel=1e-9)
    periods = pandas.Series(signal, index=pandas.period_range("2026-03-29", periods=len(signal), freq="20ms"))
    assert found(periods, None) == pytest.approx(hz, rel=1e-9)
    levels = pandas.Series(signal, index=pandas.MultiIndex.from_arrays([time, time]))
    with pytest.raises(slipfit.OptionError, match="2 levels"):
        slipfit.ringdown(levels)


def test_a_table_alone_is_not_said_to_lack_times(swing):
    polars = pytest.importorskip("polars")
    time, signal = swing
    frame = polars.DataFrame({"t": time, "x": signal})
    for table in (frame, frame.to_pandas(), frame.to_arrow(), np.column_stack(swing)):
        with pytest.raises(slipfit.OptionError, match="of 2 columns: one is needed as time, one as signal") as raised:
            slipfit.ringdown(table)
        assert (raised.value.option, raised.value.value is table) == ("time", True)
    with pytest.raises(slipfit.OptionError, match="one dimension"):
        slipfit.ringdown((time, signal))
    with pytest.raises(slipfit.OptionTypeError, match="an array is needed"):
        slipfit.ringdown({"t": time, "x": signal})


@pytest.mark.parametrize("value", [np.str_("50"), np.timedelta64(500, "ms"), np.datetime64(5, "s"), np.void(b"12345678")])
def test_scalars_of_numpy_that_are_no_numbers_are_refused(swing, value):
    for option, words in (("rate_hz", "a number is needed"), ("start_s", "a number of seconds or a duration is needed")):
        if option == "start_s" and value.dtype.kind == "m":
            continue
        with pytest.raises(slipfit.OptionTypeError, match=words) as raised:
            slipfit.ringdown(signal=swing[1], **{"rate_hz": 50, option: value})
        assert raised.value.option == option


def test_instants_may_be_durations(swing):
    """As an interval may be one."""
    time, signal = swing
    wanted = slipfit.ringdown(time, signal, start_s=2, end_s=30)
    assert slipfit.ringdown(time, signal, start_s=np.timedelta64(2, "s"), end_s=datetime.timedelta(seconds=30)) == wanted
    options = {"signal": "x", "dt": 0.02, "method": "analyse"}
    rows = slipfit.fit_batch([signal], start_s=2, end_s=30, **options)
    assert slipfit.fit_batch([signal], start_s=np.timedelta64(2, "s"), end_s=datetime.timedelta(seconds=30), **options) == rows
    with pytest.raises(slipfit.OptionError, match="months"):
        slipfit.ringdown(time, signal, start_s=np.timedelta64(2, "M"))


def test_a_rate_beside_other_times_of_xarray_is_refused(swing):
    """It was taken in their place, as one of pandas is not."""
    xr = pytest.importorskip("xarray")
    time, signal = swing
    wanted = slipfit.ringdown(signal=signal, rate_hz=50)
    sampled = 0.02 * np.arange(len(signal))
    stamps = np.datetime64("2026-01-01", "ms") + (20 * np.arange(len(signal))).astype("timedelta64[ms]")
    for coordinate in (sampled, sampled.astype("f4"), stamps.astype("datetime64[ns]"), ("time", 1e3 * sampled, {"units": "ms"})):
        held = xr.DataArray(signal, dims="time", coords={"time": coordinate})
        assert slipfit.ringdown(held, rate_hz=50) == wanted
        for rate in (100, 49.9):
            with pytest.raises(slipfit.OptionError, match="beside the coordinate 'time', whose step is 0.02 s") as raised:
                slipfit.ringdown(held, rate_hz=rate)
            assert (raised.value.option, raised.value.value) == ("rate_hz", rate)
        assert slipfit.ringdown(held.drop_vars("time"), rate_hz=100).parameters.frequency_hz.value == pytest.approx(
            2 * wanted.parameters.frequency_hz.value, rel=1e-9
        )
    counted = xr.DataArray(signal, dims="sample", coords={"sample": np.arange(len(signal))})
    assert slipfit.ringdown(counted, rate_hz=50) == wanted
    with pytest.raises(slipfit.OptionError, match="missing or out of order"):
        slipfit.ringdown(counted[np.arange(len(signal)) != 7], rate_hz=50)
    # A coordinate beside the dimension tells the times as well.
    beside = xr.DataArray(signal, dims="frame", coords={"time": ("frame", time)})
    assert slipfit.ringdown(beside) == slipfit.ringdown(time, signal)


@pytest.mark.parametrize("take", ["Series", "index", "array"])
def test_dates_with_a_zone_are_times_of_every_fit(swing, take):
    """An index of dates with a zone was no argument of the bare fits, its array none of any."""
    pandas = pytest.importorskip("pandas")
    time, signal = swing
    index = pandas.DatetimeIndex(pandas.to_datetime("2026-03-29T00:59:50+00:00") + pandas.to_timedelta(time, unit="s")).tz_convert("Europe/Berlin")
    times = {"Series": pandas.Series(index), "index": index, "array": index.array}[take]
    hz = slipfit.ringdown(time, signal).parameters.frequency_hz.value
    assert slipfit.ringdown(times, signal).parameters.frequency_hz.value == pytest.approx(hz, rel=1e-9)
    start = {"initial_amplitude": 1, "offset_amplitude": 0, "decay_rate_per_s": 0.1}
    amplitude = 1.4 * np.exp(-0.1 * time) - 0.01
    found, wanted = (slipfit.fit_envelope(t, amplitude, **start) for t in (times, time))
    assert found.best.decay_rate_per_s == pytest.approx(wanted.best.decay_rate_per_s, rel=1e-6)
    found, wanted = (slipfit.fit_waveform(t, signal, initial_amplitude=0.4, frequency_hz=hz) for t in (times, time))
    assert found.best.frequency_hz == pytest.approx(wanted.best.frequency_hz, rel=1e-9)


def test_times_that_go_back_are_refused(swing):
    """Of several runs in one array one was taken, and two samples in the wrong order were sorted, with a note that no one reads."""
    xr, pandas = pytest.importorskip("xarray"), pytest.importorskip("pandas")
    time, signal = swing
    swapped = time.copy()
    swapped[[700, 701]] = swapped[[701, 700]]
    runs = np.concatenate([time[:900], time[: len(time) - 900]])
    holed = swapped.copy()
    holed[3] = np.nan
    for times, index in ((swapped, 701), (runs, 900), (holed, 701)):
        for given in ((times, signal), (pandas.Series(signal, index=times),), (xr.DataArray(signal, dims="t", coords={"t": times}),)):
            with pytest.raises(slipfit.OptionError, match=f"goes backwards, .* at index {index}: sort") as raised:
                slipfit.ringdown(*given)
            error = raised.value
            assert (error.option, error.index, error.code) == ("time", index, "time_backwards")
            assert error.next < error.previous
        with pytest.raises(slipfit.OptionError) as raised:
            slipfit.fit_waveform(times[4:], signal[4:], initial_amplitude=0.4, frequency_hz=1.2)
        assert raised.value.index == index - 4
    twice = time.copy()
    twice[700] = twice[699]
    assert slipfit.ringdown(twice, signal).parameters.frequency_hz.value > 0
