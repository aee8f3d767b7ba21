"""Writes one small file of each format, by programs other than slipfit.

    python make.py FOLDER

Every file holds the same ring-down unless its name says otherwise:

    t = k / 50 s, k = 0 .. 399
    x = round(0.2 exp(-0.15 t) cos(2 pi 1.5 t), 6)        in m

Formats that are written by a library are written by the library most people
use for them; the texts are laid out as the programs named write them.
"""

import gzip
import io
import json
import struct
import sys
import zipfile
from pathlib import Path

import h5py
import numpy as np
import openpyxl
import polars
import pyarrow as pa
import pyarrow.feather
import pyarrow.parquet as pq
import scipy.io
import scipy.io.wavfile
import xlwt

out = Path(sys.argv[1])
out.mkdir(parents=True, exist_ok=True)

k = np.arange(400)
t = k / 50
x = np.round(0.2 * np.exp(-0.15 * t) * np.cos(2 * np.pi * 1.5 * t), 6)
v = np.gradient(x, t)
f = np.linspace(99, 101, 201)
r = 1 / np.hypot(1 - (f / 100) ** 2, 0.002)


def text(name, lines, encoding="utf-8"):
    (out / name).write_bytes(("\n".join(lines) + "\n").encode(encoding))


def rows(form, *columns):
    return [form.format(*values) for values in zip(*columns)]


# MATLAB
scipy.io.savemat(out / "vectors.mat", {"t": t, "x": x})
scipy.io.savemat(out / "packed.mat", {"t": t[:, None], "x": x[:, None]}, do_compression=True)
scipy.io.savemat(out / "struct.mat", {"run": {"time": t, "angle": x, "unit": "rad", "inner": {"other": np.arange(7.0)}}})
cells = np.empty((1, 2), dtype=object)
cells[0, 0], cells[0, 1] = np.column_stack([t, x]), np.column_stack([t, 2 * x])
scipy.io.savemat(out / "cells.mat", {"runs": cells})
scipy.io.savemat(out / "integers.mat", {"fs": 50.0, "counts": np.round(x * 1e6).astype(np.int32)})

# Sound
scipy.io.wavfile.write(out / "stereo16.wav", 50, np.column_stack([np.round(x * 1e5), 0 * x]).astype(np.int16))
scipy.io.wavfile.write(out / "bytes8.wav", 50, np.round(128 + 500 * x).astype(np.uint8))
scipy.io.wavfile.write(out / "float32.wav", 50, x.astype(np.float32))

# NumPy
np.save(out / "columns.npy", np.column_stack([t, x]))
np.save(out / "fortran.npy", np.asfortranarray(np.column_stack([t, x])))
np.save(out / "wide.npy", np.vstack([t, x]).astype(">f8"))
np.save(out / "fields.npy", np.array(list(zip(k, t, x)), dtype=[("n", "<i4"), ("time_s", "<f8"), ("angle_rad", "<f8")]))
np.save(out / "half.npy", x.astype(np.float16))
np.savez(out / "arrays.npz", time=t, displacement=x, gain=np.float64(3))
np.savez_compressed(out / "packed.npz", time=t, displacement=x)

# HDF5
with h5py.File(out / "groups.h5", "w") as h:
    for run, gain in (("run1", 1), ("run2", 2)):
        g = h.create_group(run)
        g.attrs["operator"] = "nobody"
        g.create_dataset("time", data=t, chunks=(64,), compression="gzip", shuffle=True).attrs["units"] = "s"
        g.create_dataset("angle", data=gain * x, chunks=(64,), compression="gzip").attrs["units"] = "rad"
with h5py.File(out / "compound.h5", "w", libver="latest") as h:
    h["swing"] = np.array(list(zip(t, x)), dtype=[("time", "<f8"), ("angle", "<f4")])
with h5py.File(out / "big_endian.h5", "w") as h:
    h.create_dataset("t", data=t.astype(">f8"))
    h.create_dataset("counts", data=np.round(x * 1e6).astype(">i4"))
with h5py.File(out / "matlab73.mat", "w", userblock_size=512) as h:
    h.create_dataset("t", data=t[None, :])
    h.create_dataset("x", data=x[None, :])
with open(out / "matlab73.mat", "r+b") as h:
    h.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")

# Parquet and Arrow
table = pa.table({"Time (s)": t, "Angle (rad)": x, "label": ["a"] * 400})
pq.write_table(table, out / "snappy.parquet", compression="snappy")
pq.write_table(table, out / "gzip_groups.parquet", compression="gzip", row_group_size=150)
gaps = pa.array([None if i % 50 == 49 else a for i, a in enumerate(x)])
stamps = pa.array((k * 20_000).astype("datetime64[us]"))
pq.write_table(pa.table({"stamp": stamps, "x": gaps, "n": pa.array(k, pa.int32())}), out / "stamps_gaps.parquet")
polars.DataFrame({"time_s": t, "x_mm": 1000 * x}).write_parquet(out / "polars.parquet")
pa.feather.write_feather(table, out / "lz4.feather", compression="lz4")
pa.feather.write_feather(table, out / "zstd.feather", compression="zstd")
with pa.OSFile(str(out / "plain.arrows"), "wb") as sink, pa.ipc.new_stream(sink, table.schema) as writer:
    for batch in table.to_batches(max_chunksize=150):
        writer.write_batch(batch)

# Excel
book = openpyxl.Workbook()
book.active.title = "Notes"
book.active.append(["measured by nobody"])
sheet = book.create_sheet("Swing")
sheet.append(["Pendulum, first run"])
sheet.append(["Time (s)", "Angle (rad)"])
for a in zip(t, x):
    sheet.append([float(a[0]), float(a[1])])
second = book.create_sheet("Second")
second.append(["Time (s)", "Angle (rad)"])
for a in zip(t, 2 * x):
    second.append([float(a[0]), float(a[1])])
book.save(out / "sheets.xlsx")
book = xlwt.Workbook()
for name, gain in (("Raw Data", 1), ("Other", 2)):
    sheet = book.add_sheet(name)
    for c, head in enumerate(("Time (s)", "Acceleration x (m/s^2)", "Größe µ (V)")):
        sheet.write(0, c, head)
    for i, a in enumerate(zip(t, gain * x, np.zeros_like(x))):
        for c, value in enumerate(a):
            sheet.write(i + 1, c, float(value))
book.save(out / "sheets.xls")

# phyphox: the five dialects of its text, and the archive with a pause in it
def phyphox(separator, comma):
    head = separator.join(['"Time (s)"', '"Acceleration x (m/s^2)"', '"Absolute acceleration (m/s^2)"'])
    lines = [head]
    for a, b in zip(t, x):
        cells = [f"{value:.9E}".replace("E+0", "E").replace("E-0", "E-").replace("E+", "E") for value in (a, b, abs(b))]
        lines.append(separator.join(c.replace(".", ",") if comma else c for c in cells))
    return lines


for name, separator, comma in (
    ("comma_point", ",", False),
    ("semicolon_point", ";", False),
    ("semicolon_comma", ";", True),
    ("tab_point", "\t", False),
    ("tab_comma", "\t", True),
):
    text(f"phyphox_{name}.csv", phyphox(separator, comma))
with zipfile.ZipFile(out / "phyphox.zip", "w", zipfile.ZIP_DEFLATED) as z:
    z.writestr("Raw Data.csv", "\n".join(phyphox(",", False)))
    z.writestr(
        "meta/time.csv",
        '"event","experiment time","system time","system time text"\n'
        '"START",0.000000000E0,1759650000.000,"2025-10-05 10:20:00.000 UTC+02:00"\n'
        '"PAUSE",4.010000000E0,1759650004.010,"2025-10-05 10:20:04.010 UTC+02:00"\n'
        '"START",4.010000000E0,1759650006.010,"2025-10-05 10:20:06.010 UTC+02:00"\n'
        '"PAUSE",7.990000000E0,1759650009.990,"2025-10-05 10:20:09.990 UTC+02:00"\n',
    )
    z.writestr("meta/device.csv", '"property","value"\n"deviceModel","none"\n')

# Tracker: a table with two tracks, one with an angle, and a project
text(
    "tracker_two.txt",
    ["#multi:", "mass A\t\t\tmass B\t", "t\tx\ty\tx\ty"] + rows("{:.3f}\t{:.6f}\t{:.6f}\t{:.6f}\t", t, x, 0 * x, 2 * x),
)
text("tracker_angle.txt", ["mass A;;", "t;θ;ω"] + [a.replace(".", ",") for a in rows("{:.3f};{:.6f};{:.6f}", t, x, v)])
frames = "".join(
    f'<property name="[{n}]" type="object"><object class="org.opensourcephysics.cabrillo.tracker.PointMass$FrameData">'
    f'<property name="n" type="int">{n}</property><property name="x" type="double">{float(320 + 500 * a)!r}</property>'
    f'<property name="y" type="double">{240.0!r}</property></object></property>'
    for n, a in enumerate(x)
)
text(
    "tracker.trk",
    [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<object class="org.opensourcephysics.cabrillo.tracker.TrackerPanel">',
        '<property name="videoclip" type="object"><object class="org.opensourcephysics.media.core.VideoClip">',
        '<property name="startframe" type="int">0</property></object></property>',
        '<property name="clipcontrol" type="object"><object class="org.opensourcephysics.media.core.ClipControl">',
        '<property name="delta_t" type="double">20.0</property></object></property>',
        '<property name="coords" type="object"><object class="org.opensourcephysics.media.core.ImageCoordSystem">',
        '<property name="framedata" type="array"><property name="[0]" type="object"><object class="FrameData">',
        '<property name="xorigin" type="double">320.0</property><property name="yorigin" type="double">240.0</property>',
        '<property name="angle" type="double">0.0</property><property name="xscale" type="double">500.0</property>',
        '<property name="yscale" type="double">500.0</property></object></property></property></object></property>',
        '<property name="tracks" type="collection"><property name="item" type="object">',
        '<object class="org.opensourcephysics.cabrillo.tracker.PointMass">',
        '<property name="name" type="string">mass A</property>',
        f'<property name="framedata" type="array" class="[LFrameData;">{frames}</property>',
        "</object></property></property></object>",
    ],
)

# Schools and instruments
text("vernier.csv", ["Latest: Time (s),Latest: Position (m),Data Set 2:Time(s),Data Set 2:Position(m)"] + rows("{:.2f},{:.6f},{:.2f},{:.6f}", t, x, t, 2 * x))
text("vernier_comma.csv", ["Latest: Time (s);Latest: Position (m)"] + [a.replace(".", ",") for a in rows("{:.2f};{:.6f}", t, x)])
text("capstone.csv", ["Time (s) Run #1,Angle (rad) Run #1,Time (s) Run #2,Angle (rad) Run #2"] + rows("{:.2f},{:.6f},{:.2f},{:.6f}", t, x, t, 2 * x), "utf-8-sig")
text("labone.csv", ["chunk;timestamp;x;y;freq;phase;dio;trigger;auxin0;auxin1"] + rows("0;{};{:.9g};{:.9g};32768.0;0.0;0;0;0.0;0.0", 1234567 + k * 1_200_000, np.exp(-0.15 * t) * 1e-3, 1e-6 * np.sin(k)))
text("nanonis.dat", ["Experiment\tdata log", "Sampling\t50", "Comment\ta, b: c", "", "[DATA]", "Time (s)\tAmplitude (m)\tPhase (deg)"] + rows("{:.6E}\t{:.6E}\t{:.6E}", t, 1e-9 * np.exp(-0.15 * t), 0 * t))
raw = np.round(x / 0.5 * 2**31).astype("<i4").tobytes()
header = "\r\n".join(
    ["[DataSet]", "Version=2", "GroupCount=1", "Gr0-Ch0=DataSet-0:0", "[DataSet-0:0]", "Version=1", "Points=400", "Lines=1", "Frame=Time trace"]
    + ["Dim0Name=Time", "Dim0Unit=s", "Dim0Range=7.98", "Dim0Min=0", "Dim2Name=Deflection", "Dim2Unit=m", "Dim2Range=1.0", "Dim2Min=-0.5"]
    + ["SaveMode=Binary", "SaveBits=32", "SaveSign=Signed", "SaveOrder=Intel", "", "#!"]
)
(out / "nanosurf.nid").write_bytes(header.encode("latin-1") + raw)
text("moku.csv", ["% Moku:Go Data Logger", "% Acquisition rate: 50 Hz, precision mode", "%", "% Time (s), Input 1 (V), Input 2 (V)"] + rows("{:.10e}, {:.10e}, {:.10e}", t, x, 0 * x))
level = 20 * np.log10(0.01 * np.exp(-0.15 * t))
text("keysight_zero_span.csv", ["Trace", "Swept SA", "Number of Points,400", "Sweep Time,7.98", "Start Frequency,1000000000", "Stop Frequency,1000000000", "RBW,1000", "X Axis Unit,s", "Y Axis Unit,dBm", "DATA"] + rows("{:.4f},{:.4f}", t, level))
text("siglent_zero_span.csv", ["Siglent Technologies,SSA3032X", "Center Frequency,1.000000000 GHz", "Span,0 Hz", "RBW,1.000 kHz", "Sweep Time,7.98 s", "Points,400", "Reference Level,0.00 dBm", "Trace A"] + rows("{:.4f}", level))
text("klipper.csv", ["#time,accel_x,accel_y,accel_z"] + rows("{:.6f},{:.6f},{:.6f},{:.6f}", 100 + t, 9000 * x, 10 * np.sin(k), 9800 + 0 * x))
text("sweep.s1p", ["! made by hand", "# MHz S RI R 50"] + rows("{:.6f} {:.9f} {:.9f}", f, 0.5 - r / 2000, 0 * f))
text("sweep.s2p", ["! two ports", "# MHz S DB R 50"] + rows("{:.6f} -1 0 {:.6f} 10 {:.6f} 10 -1 0", f, 20 * np.log10(r / 600), 20 * np.log10(r / 600)) + ["! noise", "99.0 1 0.1 20 0.2", "100.0 1 0.1 20 0.2"])
(out / "packed.csv.gz").write_bytes(gzip.compress(("Time (s);Angle (rad)\n" + "\n".join(rows("{:.2f};{:.6f}", t, x))).encode(), mtime=0))
text("objects.json", [json.dumps([{"t (s)": a, "angle (rad)": b} for a, b in zip(t.tolist(), x.tolist())])])
text("lists.json", [json.dumps({"fs": 50, "angle (rad)": x.tolist()})])

# A rate beside the samples, and complex responses over frequency
z = 0.004 / (1 - (f / 100) ** 2 + 0.002j)
np.savez(out / "rate.npz", x=x, fs=np.float64(50))
np.savez(out / "interval.npz", x=x, dt=np.array([0.02]))
np.savez(out / "complex.npz", f=f, z=z)
scipy.io.savemat(out / "complex.mat", {"f": f, "H": z.astype(np.complex64)})
scipy.io.savemat(out / "interval.mat", {"x": x.astype(np.float32), "Tstart": -0.1, "Tinterval": 0.02, "Length": 400})
with h5py.File(out / "complex.h5", "w") as h:
    h["frequency"], h["response"] = f, z
with h5py.File(out / "rate_attribute.h5", "w") as h:
    position = h.create_dataset("data/position", data=x)
    position.attrs["sample_rate"], position.attrs["units"] = 50.0, "m"
with h5py.File(out / "waveform.h5", "w") as h:
    channel = h.create_group("Waveforms/Channel 1")
    channel["Channel 1 Data"] = np.round(x * 1e5).astype(np.int16)
    channel.attrs.update({"XInc": 0.02, "XOrg": 0.0, "XUnits": "Second", "YInc": 1e-5, "YOrg": 0.0, "YUnits": "Volt"})
