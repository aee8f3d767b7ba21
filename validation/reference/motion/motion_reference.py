"""Forty-digit references for the exact motion of an oscillator with friction.

    x'' + 2 delta x' + omega_0^2 (x + x_F sgn x') = omega_0^2 x_0 cos(omega t)

Plain formulas at 60 digits: between events the steady solution of the drive plus a
decaying oscillation; events by scanning velocity (or pull) on a grid and closing in by
bisection and secants. Nothing is shared with the library's way of computing.

    python3 motion_reference.py decay  > free_decay.txt
    python3 motion_reference.py driven > driven.txt
    python3 motion_reference.py steady > steady.txt
"""

import sys

from mpmath import mp, mpf, mpc, cos, sin, exp, sqrt, pi, atan2, coth, nstr, sinh, cosh

mp.dps = 60
DIGITS = 40


def text(x):
    return nstr(x, DIGITS, min_fixed=-1, max_fixed=1)


# ---------------------------------------------------------------- free decay

DECAYS = [
    # delta, x_F, x_S, X_0, turning points
    (1 / (2 * 0.6), 1e-3, 1e-3, 1.0, [1, 2]),
    (0.25, 1e-4, 2e-4, 1.0, [1, 2, 5, 8]),
    (0.01, 1e-6, 1e-6, 1.0, [1, 10, 100, 300]),
    (0.005, 0.01, 0.013, 1.0, [1, 10, 30]),
    (1 / 2e3, 1e-4, 1e-4, 1.0, [1, 10, 100, 1000]),
    (1 / 2e5, 2e-5, 2e-5, 1.0, [1, 100, 1000, 10000]),
    (1 / 2e7, 4.5e-5, 5e-5, 1.0, [1, 100, 1000, 10000]),
    (1e-12, 4e-5, 4e-5, 1.0, [1, 100, 1000, 10000]),
    (0.0, 3e-5, 3e-5, 1.0, [1, 100, 1000, 10000]),
    (1e-5, 0.0, 0.0, 1.0, [1, 100, 1000, 10000]),
]


def decay():
    print("# omega_0 = 1; released at rest from X_0 at t = 0")
    print("# delta x_F x_S X_0 n time_of_turn turning_point t x(t) v(t)   (t between turns n and n+1, or after the stop)")
    for delta, x_f, x_s, x_0, wanted in DECAYS:
        d, f = mpf(delta), mpf(x_f)
        w = sqrt(1 - d * d)
        half = pi / w
        keep = exp(-d * half)
        x, n = mpf(x_0), 0
        while n <= wanted[-1]:
            if abs(x) <= mpf(x_s) and x_s > 0:
                t = float(n * half + 1)
                print(repr(delta), repr(x_f), repr(x_s), repr(x_0), n,
                      text(n * half), text(x), repr(t), text(x), text(mpf(0)))
                break
            if n in wanted or n == 0:
                t = float(n * half + half * mpf("0.37"))
                u = mpf(t) - n * half
                s = 1 if x > 0 else -1
                a = x - s * f
                e = exp(-d * u)
                y = s * f + e * a * (cos(w * u) + d / w * sin(w * u))
                v = -e * a / w * sin(w * u)
                print(repr(delta), repr(x_f), repr(x_s), repr(x_0), n,
                      text(n * half), text(x), repr(t), text(y), text(v))
            s = 1 if x > 0 else -1
            x = -s * (keep * abs(x) - (1 + keep) * f)
            n += 1


# -------------------------------------------------------------------- driven

DRIVEN = [
    # delta, x_F, x_S, omega, x(0), v(0), cycles; x_0 = 1, omega_0 = 1
    (1 / 1.2, 0.2, 0.2, 0.8, 0.0, 0.0, [1, 10, 1000]),
    (1 / 1.2, 0.6, 0.75, 0.5, 0.3, 0.0, [1, 10, 1000]),
    (0.1, 0.3, 0.3, 1.0, 2.0, 0.5, [1, 10, 100, 1000]),
    (0.01, 0.3926990816987241, 0.3926990816987241, 0.97, 11.0, 0.0, [1, 10, 100, 1000]),
    (0.01, 0.7068583470577035, 0.7068583470577035, 0.97, 0.0, 0.0, [1, 10, 100, 1000]),
    (0.05, 0.5, 0.65, 0.3, 0.0, 0.0, [1, 10, 100, 1000]),
    (0.01, 0.2, 0.2, 1 / 3, 0.5, 0.0, [1, 10, 100, 1000]),
    (1 / 2e4, 0.3, 0.3, 1.0, 0.0, 0.0, [1, 10, 100, 1000]),
    (1 / 2e7, 0.0, 0.0, 1.0, 0.0, 0.0, [1, 10, 100, 1000]),
    (1 / 2e7, 0.4, 0.4, 1.0, 0.0, 0.0, [1, 10, 100, 1000]),
    (1 / 2e7, 0.75, 0.8, 1.0, 0.0, 0.0, [1, 10, 100, 1000]),
    (1 / 2e7, 0.6, 0.6, 1.001, 3.0, 1.0, [1, 10, 100, 1000]),
    (1 / 2e3, 0.95, 0.97, 0.7, 0.0, 0.0, [1, 10, 100, 1000]),
    (0.02, 0.4, 0.4, 2.5, 0.7, 0.0, [1, 10, 100, 1000]),
]


class Driven:
    def __init__(self, delta, x_f, x_s, omega):
        self.d, self.f, self.xs, self.w = mpf(delta), mpf(x_f), mpf(x_s), mpf(omega)
        self.wd = sqrt(1 - self.d**2)
        self.steady = 1 / mpc(1 - self.w**2, 2 * self.d * self.w)

    def particular(self, t):
        z = self.steady * mpc(cos(self.w * t), sin(self.w * t))
        return z.real, -self.w * z.imag

    def arc(self, t0, x0, v0, s):
        p, pv = self.particular(t0)
        a = x0 + s * self.f - p
        b = (v0 - pv + self.d * a) / self.wd

        def state(t):
            u = t - t0
            q, qv = self.particular(t)
            e = exp(-self.d * u)
            c, n = cos(self.wd * u), sin(self.wd * u)
            y = e * (a * c + b * n)
            yv = e * ((b * self.wd - self.d * a) * c - (a * self.wd + self.d * b) * n)
            return q - s * self.f + y, qv + yv

        return state

    def pull(self, t, x):
        return cos(self.w * t) - x


def close_in(f, a, b, fa, fb):
    """Zero of f between a and b (Illinois rule, then secants)."""
    tiny = mpf(10) ** (-mp.dps + 6)
    side = 0
    for _ in range(400):
        c = (fa * b - fb * a) / (fa - fb)
        fc = f(c)
        if fc == 0 or abs(b - a) < tiny * max(1, abs(a)):
            return c
        if fc * fb > 0:
            if abs(c - b) < tiny * max(1, abs(b)):
                return c
            b, fb = c, fc
            if side == -1:
                fa /= 2
            side = -1
        else:
            if abs(c - a) < tiny * max(1, abs(a)):
                return c
            a, fa = c, fc
            if side == 1:
                fb /= 2
            side = 1
    raise RuntimeError("no convergence")


def run(delta, x_f, x_s, omega, x, v, cycles):
    m = Driven(delta, x_f, x_s, omega)
    t, x, v = mpf(0), mpf(x), mpf(v)
    stops = 0
    outputs = [float(n * 2 * pi / m.w) for n in cycles]
    step = min(pi / m.wd, pi / m.w) / 24
    rows = []
    direction = 0 if v == 0 else (1 if v > 0 else -1)
    if direction == 0 and abs(m.pull(t, x)) > m.xs:
        direction = 1 if m.pull(t, x) > 0 else -1
    k = 0
    while k < len(outputs):
        if direction == 0:
            hold = lambda q: m.xs - abs(m.pull(q, x))
            a = t
            fa = None
            release = None
            # Leave the stop itself, which may lie on the border of the zone.
            while a < mpf(outputs[-1]):
                b = a + step
                fb = hold(b)
                if fb < 0:
                    lo = a
                    if fa is None or fa <= 0:
                        lo = a + step * mpf(10) ** -12
                        fa = hold(lo)
                        assert fa > 0
                    release = close_in(hold, lo, b, fa, fb)
                    break
                a, fa = b, fb
            end = release if release is not None else mpf(outputs[-1]) + 1
            while k < len(outputs) and mpf(outputs[k]) <= end:
                rows.append((cycles[k], outputs[k], x, mpf(0), stops))
                k += 1
            if release is None:
                break
            t = release
            direction = 1 if m.pull(t, x) > 0 else -1
            v = mpf(0)
        else:
            state = m.arc(t, x, v, direction)
            g = lambda q: direction * state(q)[1]
            # Velocity grows from zero: begin a little into the arc.
            a = t + step * (mpf(10) ** -9 if v == 0 else 0)
            fa = g(a)
            assert fa > 0, (delta, x_f, omega, nstr(t, 20), nstr(fa, 10))
            while True:
                b = a + step
                fb = g(b)
                if fb <= 0:
                    break
                a, fa = b, fb
            end = close_in(g, a, b, fa, fb)
            while k < len(outputs) and mpf(outputs[k]) <= end:
                q = mpf(outputs[k])
                y, yv = state(q)
                rows.append((cycles[k], outputs[k], y, yv, stops))
                k += 1
            x, v = state(end)[0], mpf(0)
            t = end
            e = m.pull(t, x)
            if abs(e) > m.xs:
                direction = 1 if e > 0 else -1
            else:
                direction = 0
                stops += 1
    for n, q, y, yv, s in rows:
        print(repr(delta), repr(x_f), repr(x_s), repr(omega), START[0], START[1], n, repr(q),
              text(y), text(yv), s, flush=True)


START = (0, 0)


def driven():
    global START
    print("# omega_0 = 1, x_0 = 1; drive cos(omega t); start at t = 0")
    print("# delta x_F x_S omega x(0) v(0) cycles t x(t) v(t) stops_so_far")
    for delta, x_f, x_s, omega, x, v, cycles in DRIVEN:
        START = (repr(x), repr(v))
        run(delta, x_f, x_s, omega, x, v, cycles)


# -------------------------------------------------------------------- steady

STEADY = [(0.01, b, w) for b, w in
          [(0.5, 0.97), (0.9, 0.97), (0.9, 1.0), (0.9, 1.01), (0.8, 1.03)]]
STEADY += [(0.25, 0.3, 1.0), (1 / 2e7, 0.5, 1.0), (1 / 2e7, 0.9, 1.0), (1 / 2e4, 0.99, 0.9999),
           (1 / 1.2, 0.1, 0.9), (0.01, 0.0, 1.02)]


def steady():
    """The periodic motion with two turns a cycle and no stop (Den Hartog), and a check
    of each by its own boundary conditions."""
    print("# omega_0 = 1, x_0 = 1, x_F = pi beta/4 rounded to a double; exact periodic motion")
    print("# delta x_F omega turning_point |X1| phi_1 lag")
    for delta, beta, omega in STEADY:
        d, w = mpf(delta), mpf(omega)
        x_f_double = float(mpf(beta) * pi / 4)
        f = mpf(x_f_double)
        wd = sqrt(1 - d * d)
        y, th = pi * d / w, pi * wd / w
        n = cosh(y) + cos(th)
        g = (sinh(y) - d / wd * sin(th)) / n
        h = sin(th) / (w * wd * n)
        dd = mpc(1 - w * w, 2 * d * w)
        x = sqrt(1 / abs(dd) ** 2 - (h * f) ** 2) - g * f
        p, q = x + g * f, h * f
        x1 = mpc(p, -q) - mpc(0, 1) * (4 * f / pi) / dd
        u = mpc(p, -q) * dd
        # The half cycle from the crest: x -> -x, velocity zero at both ends.
        a = x - f - p
        b = (d * a - w * q) / wd
        e = exp(-y)
        end = f - p + e * (a * cos(th) + b * sin(th))
        endv = -w * q + e * ((b * wd - d * a) * cos(th) - (a * wd + d * b) * sin(th))
        assert abs(end + x) < mpf(10) ** -45 * (1 + abs(x)), nstr(end + x)
        assert abs(endv) < mpf(10) ** -45 * (1 + abs(x)), nstr(endv)
        phi = -atan2(x1.imag, x1.real)
        lag = -atan2((x1 / u).imag, (x1 / u).real)
        print(repr(delta), repr(x_f_double), repr(omega), text(x), text(abs(x1)), text(phi), text(lag))


if __name__ == "__main__":
    {"decay": decay, "driven": driven, "steady": steady}[sys.argv[1]]()
