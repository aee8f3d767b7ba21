"""Forty-digit references for drives other than one harmonic.

    x'' + 2 delta x' + x + x_F sgn x' = U(t)          (omega_0 = 1)

U is a sum of harmonics, a harmonic switched off at a phase, or straight lines between
samples. Between two events, or two changes of the drive, the motion is the steady
solution of each part plus a decaying oscillation, at 60 digits; events are found on a
grid and closed in on. Nothing is shared with the library's way of computing.

    python3 drives_reference.py > drives.txt
"""

from mpmath import cos, exp, mp, mpc, mpf, pi, sin, sqrt

from motion_reference import close_in, text

mp.dps = 60

# name, delta, x_F, x_S, drive, x(0), v(0), output times in cycles of 2 pi/first omega
# tones: (amplitude, omega, phase) ...; off: the same and the time of switching off;
# samples: (step, values of one cycle), repeated, straight lines between
CASES = [
    ("two tones, sliding", 0.05, 0.2, 0.2,
     ("tones", [(1.0, 0.9, 0.3), (0.5, 2.7, 1.0)]), 0.0, 0.0, [1, 10, 100, 1000]),
    ("two tones, sticking", 0.1, 0.5, 0.6,
     ("tones", [(1.0, 0.4, 0.0), (0.4, 1.2, 2.0)]), 0.2, 0.0, [1, 10, 100, 1000]),
    ("three tones, incommensurate", 0.02, 0.3, 0.35,
     ("tones", [(0.8, 1.0, 0.0), (0.4, 0.6180339887498949, 0.5), (0.3, 2.23606797749979, 1.5)]),
     0.0, 0.4, [1, 10, 100, 1000]),
    ("two tones, high Q", 1 / 2e5, 0.3, 0.3,
     ("tones", [(1.0, 1.0, 0.0), (0.2, 3.0, 0.7)]), 0.0, 0.0, [1, 10, 100, 1000]),
    ("off at a phase after 1000 cycles, sliding", 1 / 2e3, 0.3, 0.3,
     ("off", [(1.0, 1.0, 0.0)], 6284.1), 0.0, 0.0, [1000, 1000.5, 1010, 1100, 1300]),
    ("off at a phase after 1000 cycles, sticking drive", 0.05, 0.5, 0.65,
     ("off", [(1.0, 0.3, 0.0)], 20947.3), 0.0, 0.0, [1000, 1000.2, 1000.5, 1001]),
    ("off at another phase, low Q", 0.2, 0.1, 0.12,
     ("off", [(1.0, 0.8, 0.4)], 7855.7), 0.1, 0.0, [1000, 1000.3, 1000.5, 1001]),
    ("samples of a triangle, sliding", 0.05, 0.2, 0.2,
     ("samples", 1.75, [0.0, 1.0, 0.0, -1.0]), 0.3, 0.0, [1, 10, 100, 1000]),
    ("samples of a trapeze, sticking", 0.1, 0.4, 0.5,
     ("samples", 3.0, [0.0, 1.0, 1.0, 0.0, -1.0, -1.0]), 0.0, 0.0, [1, 10, 100, 1000]),
]


class Stage:
    """U = offset + slope (t - start) + tones, from `start` to `end`."""

    def __init__(self, start, end, offset=0, slope=0, tones=()):
        self.start, self.end = mpf(start), mpf(end)
        self.offset, self.slope = mpf(offset), mpf(slope)
        self.tones = [(mpf(a), mpf(w), mpf(p)) for a, w, p in tones]

    def value(self, t):
        return self.offset + self.slope * (t - self.start) + sum(a * cos(w * t + p) for a, w, p in self.tones)

    def steady(self, d, t):
        x = self.offset + self.slope * (t - self.start) - 2 * d * self.slope
        v = self.slope
        for a, w, p in self.tones:
            z = a * mpc(cos(w * t + p), sin(w * t + p)) / mpc(1 - w * w, 2 * d * w)
            x, v = x + z.real, v - w * z.imag
        return x, v


def stages(drive, last):
    kind = drive[0]
    if kind == "tones":
        yield Stage(0, last + 1, tones=drive[1])
    elif kind == "off":
        yield Stage(0, drive[2], tones=drive[1])
        yield Stage(drive[2], last + 1)
    else:
        _, step, values = drive
        n = 0
        while n * step <= last:
            # Times as the doubles n*step, which are exact here.
            a, b = mpf(values[n % len(values)]), mpf(values[(n + 1) % len(values)])
            yield Stage(n * step, (n + 1) * step, a, (b - a) / mpf(step))
            n += 1


def run(number, name, delta, x_f, x_s, drive, x_0, v_0, cycles):
    d, f, xs = mpf(delta), mpf(x_f), mpf(x_s)
    wd = sqrt(1 - d * d)
    if drive[0] == "samples":
        period, fastest = drive[1] * len(drive[2]), mpf(1)
    else:
        period, fastest = float(2 * pi / mpf(drive[1][0][1])), max(mpf(w) for _, w, _ in drive[1])
    outputs = [float(n * period) for n in cycles]
    step = pi / max(wd, fastest) / 24
    t, x, v, k, stops = mpf(0), mpf(x_0), mpf(v_0), 0, 0
    direction = None

    def decide(stage):
        e = stage.value(t) - x
        return 0 if abs(e) <= xs else (1 if e > 0 else -1)

    def give(q, y, yv):
        print(number, n_of(k), repr(outputs[k]), text(y), text(yv), stops, flush=True)

    def n_of(i):
        return repr(float(cycles[i]))

    for stage in stages(drive, outputs[-1]):
        if direction is None:
            direction = decide(stage) if v == 0 else (1 if v > 0 else -1)
        elif v == 0:
            # A kink or a jump of the drive: at rest it may set the mass in motion, or change nothing.
            new = decide(stage)
            direction = new if direction == 0 or new == 0 else direction
        while t < stage.end and k < len(outputs):
            if direction == 0:
                hold = lambda q: xs - abs(stage.value(q) - x)
                a, fa, end, released = t, None, stage.end, False
                while a < stage.end:
                    b = min(a + step, stage.end)
                    fb = hold(b)
                    if fb < 0:
                        lo = a
                        if fa is None or fa <= 0:
                            lo = a + (b - a) * mpf(10) ** -12
                            fa = hold(lo)
                            assert fa > 0, (name, float(t))
                        end, released = close_in(hold, lo, b, fa, fb), True
                        break
                    a, fa = b, fb
                while k < len(outputs) and mpf(outputs[k]) <= end:
                    give(mpf(outputs[k]), x, mpf(0))
                    k += 1
                t = end
                if released:
                    direction = 1 if stage.value(t) - x > 0 else -1
            else:
                s = direction
                p, pv = stage.steady(d, t)
                a0 = x + s * f - p
                b0 = (v - pv + d * a0) / wd
                t0 = t

                def state(q):
                    u = q - t0
                    y, yv = stage.steady(d, q)
                    e = exp(-d * u)
                    c, n = cos(wd * u), sin(wd * u)
                    return (y - s * f + e * (a0 * c + b0 * n),
                            yv + e * ((b0 * wd - d * a0) * c - (a0 * wd + d * b0) * n))

                g = lambda q: s * state(q)[1]
                a = t + (step * mpf(10) ** -9 if v == 0 else 0)
                fa = g(a)
                assert fa > 0, (name, float(t), float(fa))
                end, turned = stage.end, False
                while a < stage.end:
                    b = min(a + step, stage.end)
                    fb = g(b)
                    if fb <= 0:
                        end, turned = close_in(g, a, b, fa, fb), True
                        break
                    a, fa = b, fb
                while k < len(outputs) and mpf(outputs[k]) <= end:
                    y, yv = state(mpf(outputs[k]))
                    give(mpf(outputs[k]), y, yv)
                    k += 1
                x, v = state(end)
                t = end
                if turned:
                    v = mpf(0)
                    direction = decide(stage)
                    stops += direction == 0
                else:
                    break
        if k == len(outputs):
            return


def main():
    print("# omega_0 = 1; start at t = 0; cases by their number in drives_reference.py, from 0:")
    for i, case in enumerate(CASES):
        print("#", i, *map(repr, case))
    print("# case cycles t x(t) v(t) stops_so_far")
    for i, case in enumerate(CASES):
        run(i, *case)


if __name__ == "__main__":
    main()
