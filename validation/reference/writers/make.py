"""Writes one ring-down by the programs people keep tables with, in their versions, packings and byte orders.

    python make.py FOLDER

Every file holds the ring-down of `../formats/make.py`

    t = k / 50 s, k = 0 .. 399
    x = round(0.2 exp(-0.15 t) cos(2 pi 1.5 t), 6)        in rad

with a constant column beside it, in single precision where the name ends in `_f4`. Files named `constant_...` hold 65536
numbers round(25 exp(-k / 20000) cos(k / 50)) of eight bits beside constants, which pack ten thousandfold. `sound...` hold
one second at 8 kHz of 16 bits, round(26000 exp(-3 t) cos(2 pi 200 t)), as phones pack it.
"""

import sys
import warnings
from pathlib import Path

import av
import duckdb
import h5py
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.feather
import pyarrow.parquet as pq
import scipy.io
import soundfile

warnings.simplefilter("ignore")
out = Path(sys.argv[1])
out.mkdir(parents=True, exist_ok=True)

k = np.arange(400)
t = k / 50
x = np.round(0.2 * np.exp(-0.15 * t) * np.cos(2 * np.pi * 1.5 * t), 6)
names = ("time_s", "angle_rad", "gain")
columns = dict(zip(names, (t, x, np.full(400, 2.5))))
long = np.arange(1 << 16)
constants = {
    "x": np.round(25 * np.exp(-long / 20000) * np.cos(long / 50)).astype(np.int8),
    "gain": np.ones(long.size),
    "offset": np.zeros(long.size),
}

# pyarrow: Arrow IPC
table = pa.table({**columns, "label": pa.array(["swing"] * 400).dictionary_encode()})
for packing in (None, "lz4", "zstd"):
    for version in ("V4", "V5"):
        options = pa.ipc.IpcWriteOptions(compression=packing, metadata_version=getattr(pa.ipc.MetadataVersion, version))
        with pa.OSFile(str(out / f"pyarrow_{packing or 'plain'}_{version}.arrow"), "wb") as sink:
            with pa.ipc.new_file(sink, table.schema, options=options) as writer:
                for batch in table.to_batches(max_chunksize=150):
                    writer.write_batch(batch)
options = pa.ipc.IpcWriteOptions(use_legacy_format=True, metadata_version=pa.ipc.MetadataVersion.V4)
with pa.OSFile(str(out / "pyarrow_legacy.arrows"), "wb") as sink, pa.ipc.new_stream(sink, table.schema, options=options) as w:
    w.write_table(table)
decimal = pa.array(np.round(x * 1e6).astype(np.int64)).cast(pa.decimal128(20, 0))
decimal = pa.Array.from_buffers(pa.decimal128(20, 6), 400, decimal.buffers())
clock = pa.array((k * 20).astype(np.int32), pa.time32("ms"))
pa.feather.write_feather(pa.table({"time": clock, "angle_rad": decimal}), out / "pyarrow_decimal.feather", compression="zstd")
for packing in ("lz4", "zstd"):
    pa.feather.write_feather(pa.table(constants), out / f"constant_{packing}.feather", compression=packing, chunksize=1 << 16)

# pyarrow: Parquet
plain = pa.table(columns)
for packing in ("none", "snappy", "gzip", "zstd", "lz4", "brotli"):
    pq.write_table(plain, out / f"pyarrow_{packing}.parquet", compression=packing, data_page_version="2.0")
    pq.write_table(pa.table(constants), out / f"constant_{packing}.parquet", compression=packing)
pq.write_table(plain, out / "pyarrow_split.parquet", use_dictionary=False, use_byte_stream_split=True)
stamps = pa.array((k * 20_000_000).astype("datetime64[ns]"))
scaled = pa.array(np.round(x * 1e6).astype(np.int32))
delta = pa.table({"stamp": stamps, "angle_rad": x, "n": scaled})
encoding = {"stamp": "DELTA_BINARY_PACKED", "n": "DELTA_BINARY_PACKED", "angle_rad": "PLAIN"}
pq.write_table(delta, out / "pyarrow_delta.parquet", use_dictionary=False, column_encoding=encoding)
pq.write_table(delta, out / "pyarrow_int96.parquet", use_deprecated_int96_timestamps=True, version="1.0")
for whole in (False, True):
    pq.write_table(
        pa.table({"time_s": t, "angle_rad": decimal}),
        out / f"pyarrow_decimal_{'integer' if whole else 'bytes'}.parquet",
        store_decimal_as_integer=whole,
    )

# polars
frame = pl.DataFrame(columns).with_columns(label=pl.lit("swing").cast(pl.Categorical))
for packing in ("uncompressed", "lz4", "zstd"):
    frame.write_ipc(out / f"polars_{packing}.arrow", compression=packing)
    for level in ("oldest", "newest"):
        frame.write_ipc_stream(
            out / f"polars_{packing}_{level}.arrows", compression=packing, compat_level=getattr(pl.CompatLevel, level)()
        )
for packing in ("uncompressed", "snappy", "gzip", "zstd", "lz4", "brotli"):
    frame.write_parquet(out / f"polars_{packing}.parquet", compression=packing)
pl.DataFrame(constants).write_ipc(out / "constant_polars.arrow", compression="zstd")

# pandas
data = pd.DataFrame(columns)
data.to_feather(out / "pandas.feather")
data.set_index("time_s").to_parquet(out / "pandas_index.parquet", engine="pyarrow")
data.to_parquet(out / "pandas_fastparquet.parquet", engine="fastparquet", compression="zstd")
stamped = data.assign(time=pd.to_datetime(k * 20, unit="ms")).drop(columns="time_s")
stamped.to_parquet(out / "pandas_fastparquet_stamps.parquet", engine="fastparquet")
data.to_csv(out / "pandas.csv")
data[["time_s", "angle_rad"]].to_excel(out / "pandas.ods", engine="odf", index=False)
data.assign(time=pd.to_datetime(k * 20, unit="ms"))[["time", "angle_rad"]].to_excel(
    out / "pandas_stamps.ods", engine="odf", index=False
)
for form in ("fixed", "table"):
    data.to_hdf(out / f"pandas_{form}.h5", key="swing", mode="w", format=form, complevel=5, complib="zlib")

# DuckDB
db = duckdb.connect()
db.register("data", data)
for packing in ("uncompressed", "snappy", "gzip", "zstd", "lz4", "brotli"):
    for version in ("V1", "V2"):
        target = out / f"duckdb_{packing}_{version}.parquet"
        db.execute(f"copy data to '{target}' (format parquet, compression {packing}, parquet_version {version})")
typed = "select (time_s * 1000)::uinteger as time_ms, angle_rad::decimal(9, 6) as angle_rad, 1.5 as gain from data"
db.execute(f"copy ({typed}) to '{out / 'duckdb_decimal.parquet'}' (format parquet)")
typed = "select make_timestamp((time_s * 1000000)::bigint) as stamp, angle_rad::decimal(30, 6) as angle_rad from data"
db.execute(f"copy ({typed}) to '{out / 'duckdb_stamps.parquet'}' (format parquet)")
db.execute(f"copy data to '{out / 'duckdb.csv'}'")

# h5py
filters = {
    "contiguous": {},
    "gzip": {"compression": "gzip", "compression_opts": 9},
    "shuffle": {"compression": "gzip", "shuffle": True, "fletcher32": True},
    "lzf": {"compression": "lzf"},
    "lzf_shuffle": {"compression": "lzf", "shuffle": True},
}
for name, how in filters.items():
    for version in ("earliest", "v108", "latest"):
        with h5py.File(out / f"h5py_{name}_{version}.h5", "w", libver=(version, "latest")) as h:
            for column, values in columns.items():
                h.create_dataset(column, data=values, chunks=(100,) if how else None, **how)
for kind, order in ((">f8", "big"), ("<f8", "little"), (">f4", "big"), ("<f4", "little")):
    with h5py.File(out / f"h5py_{order}_{'f4' if '4' in kind else 'f8'}.h5", "w", track_order=True) as h:
        h.create_dataset("time_s", data=t.astype(kind), maxshape=(None,), chunks=(64,))
        h.create_dataset("angle_rad", data=x.astype(kind), maxshape=(None,), chunks=(64,))
with h5py.File(out / "h5py_scaled.h5", "w") as h:
    h.create_dataset("time_ms", data=(k * 20).astype(">i4"), scaleoffset=0, chunks=(100,))
    h.create_dataset("angle_rad", data=x, scaleoffset=6, chunks=(100,))
for packing in ("gzip", "lzf"):
    with h5py.File(out / f"constant_{packing}.h5", "w") as h:
        for column, values in constants.items():
            h.create_dataset(column, data=values, chunks=(1 << 15,), compression=packing)

# scipy
for packed in (False, True):
    for shape in ("row", "column"):
        name = f"scipy_{'packed' if packed else 'plain'}_{shape}.mat"
        scipy.io.savemat(out / name, {n: columns[n] for n in names[:2]}, do_compression=packed, oned_as=shape)
scipy.io.savemat(out / "scipy_f4.mat", {"time_s": t.astype(">f4"), "angle_rad": x.astype("<f4")})
scipy.io.savemat(out / "scipy_big.mat", {"time_s": t.astype(">f8"), "angle_rad": x.astype(">f8")})

# Sound, by the codecs of FFmpeg
wave = np.round(26000 * np.exp(-3 * np.arange(8000) / 8000) * np.cos(2 * np.pi * 200 * np.arange(8000) / 8000))
for name, codec in (
    ("sound.flac", "flac"), ("sound.m4a", "aac"), ("sound_alac.m4a", "alac"), ("sound.aac", "aac"), ("sound.mp3", "libmp3lame"),
):
    with av.open(str(out / name), "w") as container:
        stream = container.add_stream(codec, rate=8000, layout="mono")
        form = stream.codec_context.codec.audio_formats[0].name
        sound = av.AudioFrame.from_ndarray(wave.astype(np.int16)[None, :], format="s16", layout="mono")
        sound.sample_rate = 8000
        for part in av.AudioResampler(format=form, layout="mono", rate=8000).resample(sound):
            container.mux(stream.encode(part))
        container.mux(stream.encode(None))
soundfile.write(out / "sound.ogg", wave / 32768, 8000, format="OGG", subtype="VORBIS")
