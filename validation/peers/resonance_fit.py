"""Fit of a complex resonance curve: resonance_fit.py least_squares|curve_fit|lmfit DATA START.

DATA holds angular frequencies, real and imaginary parts as doubles. START, and the answer, are
decay rate, friction displacement, natural angular frequency, drive amplitude, phase offset.

SciPy fits the exact fundamental of viscous damping and sliding friction (Den Hartog's closed
form, two turns a cycle), lmfit its own Lorentzian to the squared amplitude.
"""

import sys

import numpy as np

from serve import serve

peer, path = sys.argv[1:3]
omega, re, im = np.fromfile(path).reshape(3, -1)
data = re + 1j * im
start = np.array([float(word) for word in sys.argv[3:8]])


def response(omega, delta, x_f, omega_0, x_0, phase):
    """What a lock-in shows at `omega`, everything computed once."""
    omega_d = np.sqrt((omega_0 - delta) * (omega_0 + delta))
    half = 0.5 * np.pi / omega
    sin_half = np.sin(half * (omega - omega_d))
    cos_half = np.cos(half * (omega - omega_d))
    sinh_half = np.sinh(half * delta)
    h = omega_0**2 * sin_half * cos_half / (omega * omega_d * (sinh_half**2 + sin_half**2))
    d = (omega_0**2 - omega**2 + 2j * delta * omega) / omega_0**2
    q = h * x_f
    p = np.sqrt(x_0**2 / (d.real**2 + d.imag**2) - q**2)
    z = (x_0 + (4 / np.pi) * (x_f / x_0) * d.conj() * (q - 1j * p)) / d
    return z * np.exp(1j * phase)


if peer == "lmfit":
    from lmfit.models import LorentzianModel

    power = np.abs(data) ** 2
    model = LorentzianModel()
    delta, omega_0 = start[0], start[2]
    guess = model.make_params(amplitude=np.pi * delta * power.max(), center=omega_0, sigma=delta)

    def work():
        best = model.fit(power, guess, x=omega).params
        names = ("sigma", "center")
        return [best[name].value for name in names], [best[name].stderr for name in names]

elif peer == "curve_fit":
    from scipy.optimize import curve_fit

    both = data.view(float)

    def model(omega, *parameters):
        return response(omega, *parameters).view(float)

    def work():
        best, covariance = curve_fit(model, omega, both, start)
        return best, np.sqrt(np.diag(covariance))

else:
    from scipy.optimize import least_squares

    def residual(parameters):
        return (response(omega, *parameters) - data).view(float)

    def work():
        found = least_squares(residual, start, x_scale="jac")
        variance = 2 * found.cost / (found.fun.size - start.size)
        covariance = variance * np.linalg.inv(found.jac.T @ found.jac)
        return found.x, np.sqrt(np.diag(covariance))


serve(work)
