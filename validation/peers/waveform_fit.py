"""SciPy curve_fit of all samples, analytic Jacobian: waveform_fit.py plain|shared DATA A C d w p b (start)."""

import sys

import numpy as np
from scipy.optimize import curve_fit

import decay
from serve import serve

way, path = sys.argv[1:3]
time, signal = decay.read(path)
start = [float(word) for word in sys.argv[3:9]]
model = decay.SharedWaveform(time)


def work():
    model.seen = None
    if way == "plain":
        best, covariance = curve_fit(decay.waveform, time, signal, start, jac=decay.waveform_jacobian)
    else:
        best, covariance = curve_fit(model.value, time, signal, start, jac=model.jacobian, col_deriv=1)
    return best, np.sqrt(np.diag(covariance))


serve(work)
