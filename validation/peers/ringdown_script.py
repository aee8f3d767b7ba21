"""What a SciPy user would write for one file: ringdown_script.py FILE.csv"""

import sys

import numpy as np
from scipy.optimize import curve_fit

import decay


def analyse(path):
    time, signal = np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)
    time -= time[0]
    span = time[-1]
    offset = signal.mean()
    spectrum = np.fft.rfft((signal - offset) * np.hanning(signal.size))
    peak = np.abs(spectrum).argmax()
    half = np.abs(signal - offset)[: signal.size // 10].max()
    start = [half, 0.1 * half, 1.0 / span, 2 * np.pi * peak / span, np.angle(spectrum[peak]) + np.pi * peak, offset]

    best, covariance = curve_fit(decay.waveform, time, signal, start, jac=decay.waveform_jacobian)
    return best, np.sqrt(np.diag(covariance))


if __name__ == "__main__":
    best, errors = analyse(sys.argv[1])
    a, c, d, w, p, b = best
    names = ["amplitude", "c", "decay_rate_per_s", "omega", "phase", "offset"]
    for name, value, error in zip(names, best, errors):
        print(f"{name} = {value:.6g} +- {error:.2g}")
    print(f"friction_displacement = {c * np.tanh(np.pi * d / (2 * w)):.6g}")
