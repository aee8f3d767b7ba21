"""What a SciPy user would write for many files, a process a core: many_files.py FILE.csv..."""

import os

# Each process has a core of its own: more threads would only wait for each other.
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"

import multiprocessing
import sys

from ringdown_script import analyse

if __name__ == "__main__":
    with multiprocessing.Pool() as pool:
        for path, (best, _) in zip(sys.argv[1:], pool.imap(analyse, sys.argv[1:], chunksize=8)):
            print(path, *best)
