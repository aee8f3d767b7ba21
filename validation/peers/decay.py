"""Decay with viscous and sliding loss as a SciPy user would fit it.

    x(t) = [(A + C) exp(-d t) - C] cos(w t + p) + b

with d the decay rate, C = x_F coth(pi d / 2 w), x_F the friction displacement: equations (15) and (16) of
Vitorino, Vieira and Rodrigues, Effect of sliding friction in harmonic oscillators.
"""

import numpy as np


def waveform(time, a, c, d, w, p, b):
    return ((a + c) * np.exp(-d * time) - c) * np.cos(w * time + p) + b


def waveform_jacobian(time, a, c, d, w, p, b):
    decay = np.exp(-d * time)
    cosine = np.cos(w * time + p)
    by_phase = (c - (a + c) * decay) * np.sin(w * time + p)
    by_a = decay * cosine
    columns = [by_a, by_a - cosine, -(a + c) * time * by_a, time * by_phase, by_phase, np.ones_like(time)]
    return np.stack(columns, axis=-1)


class SharedWaveform:
    """The same, as fast as SciPy was seen to get.

    What model and derivatives both need at the same parameters is computed
    once, and nothing of the size of the data is allocated for derivatives.
    Use with `col_deriv=1`, which spares a transposed copy.
    """

    def __init__(self, time):
        self.time = time
        self.seen = None
        self.jacobian_rows = np.empty((6, time.size))

    def parts(self, d, w, p):
        if self.seen != (d, w, p):
            self.decay = np.exp(-d * self.time)
            self.phase = w * self.time + p
            self.cosine = np.cos(self.phase)
            self.seen = (d, w, p)
        return self.decay, self.cosine

    def value(self, _, a, c, d, w, p, b):
        decay, cosine = self.parts(d, w, p)
        return ((a + c) * decay - c) * cosine + b

    def jacobian(self, _, a, c, d, w, p, b):
        decay, cosine = self.parts(d, w, p)
        rows = self.jacobian_rows
        np.multiply(decay, cosine, out=rows[0])
        np.subtract(rows[0], cosine, out=rows[1])
        np.multiply(rows[0], self.time, out=rows[2])
        rows[2] *= -(a + c)
        np.sin(self.phase, out=rows[4])
        rows[4] *= c - (a + c) * decay
        np.multiply(rows[4], self.time, out=rows[3])
        rows[5] = 1.0
        return rows


def envelope(time, a, c, d):
    return (a + c) * np.exp(-d * time) - c


def envelope_jacobian(time, a, c, d):
    decay = np.exp(-d * time)
    return np.stack([decay, decay - 1.0, -(a + c) * time * decay], axis=-1)


def read(path):
    """Times and values as the benchmark wrote them: two runs of doubles, one after the other."""
    time, signal = np.fromfile(path).reshape(2, -1)
    return time.copy(), signal.copy()
