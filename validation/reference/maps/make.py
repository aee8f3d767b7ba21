"""Makes stack.h5, stack.npy and three stores of zarr beside this file: two rows of three pixels, 128 amplitudes each.

    pip install h5py==3.16.0 numpy==2.4.6 zarr==3.1.6
    python make.py

Pixel (y, x) loses amplitude as A = e^(-d t) - a (1 - e^(-d t))/d with d = 0.5 (1 + y) per s and
a = 0.05 x nm/s, every 20 ms, with 1 pm of noise (PCG64, seed 7). The same numbers stand in all of them; those of
stack.h5 are packed, with time as the first axis, beside a data set that is no stack. So are those of blosc.zarr, of
version 2 as zarr-python wrote it before version 3; fortran.zarr has its chunks in Fortran order, and stack.zarr is what
version 3 writes by default, with a last chunk that is not full.
"""

from pathlib import Path

import h5py
import numcodecs
import numpy as np
import zarr

here = Path(__file__).parent
t = 0.02 * np.arange(128)
y, x = np.meshgrid(np.arange(2), np.arange(3), indexing="ij")
d, a = 0.5 * (1 + y)[..., None], 0.05 * x[..., None]
stack = np.exp(-d * t) - a * (1 - np.exp(-d * t)) / d
stack += 1e-3 * np.random.Generator(np.random.PCG64(7)).standard_normal(stack.shape)
stack = stack.astype(np.float32)

np.save(here / "stack.npy", stack)
with h5py.File(here / "stack.h5", "w") as file:
    moved = np.moveaxis(stack, -1, 0)
    held = file.create_dataset("scan/amplitude", data=moved, chunks=(32, 2, 3), compression="gzip", shuffle=True)
    held.attrs["units"] = "nm"
    file["scan/topography"] = np.zeros((2, 3), np.float32)

held = zarr.create_array(here / "stack.zarr", data=stack, chunks=(2, 2, 50), overwrite=True)
held.attrs["units"] = "nm"
group = zarr.create_group(here / "blosc.zarr", zarr_format=2, overwrite=True)
lz4 = numcodecs.Blosc(cname="lz4", clevel=5, shuffle=numcodecs.Blosc.SHUFFLE)
group.create_array("scan/amplitude", data=moved, chunks=(100, 2, 3), compressors=lz4).attrs["units"] = "nm"
group.create_array("scan/topography", data=np.zeros((2, 3), np.float32))
zarr.create_array(
    here / "fortran.zarr", data=stack.astype(">f4"), chunks=(2, 3, 64), zarr_format=2, order="F",
    compressors=numcodecs.Zlib(), overwrite=True,
)  # fmt: skip
