"""Makes stack.h5 and stack.npy beside this file: two rows of three pixels, 128 amplitudes each.

    pip install h5py==3.16.0 numpy==2.4.6
    python make.py

Pixel (y, x) loses amplitude as A = e^(-d t) - a (1 - e^(-d t))/d with d = 0.5 (1 + y) per s and
a = 0.05 x nm/s, every 20 ms, with 1 pm of noise (PCG64, seed 7). The same numbers stand in both files; those of
stack.h5 are packed, with time as the first axis, beside a data set that is no stack.
"""

from pathlib import Path

import h5py
import numpy as np

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
