"""Fit of an amplitude trace: envelope_fit.py curve_fit|curve_fit_jacobian|lmfit DATA A C d (start)."""

import sys

import numpy as np

import decay
from serve import serve

peer, path = sys.argv[1:3]
time, signal = decay.read(path)
start = [float(word) for word in sys.argv[3:6]]

if peer == "lmfit":
    from lmfit import Model

    model = Model(decay.envelope)
    parameters = model.make_params(a=start[0], c=start[1], d=start[2])

    def work():
        best = model.fit(signal, parameters, time=time).params.values()
        return [one.value for one in best], [one.stderr for one in best]

else:
    from scipy.optimize import curve_fit

    jacobian = decay.envelope_jacobian if peer == "curve_fit_jacobian" else None

    def work():
        best, covariance = curve_fit(decay.envelope, time, signal, start, jac=jacobian)
        return best, np.sqrt(np.diag(covariance))


serve(work)
