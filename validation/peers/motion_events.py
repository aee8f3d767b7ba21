"""Exact motion as a heyoka user computes it: motion_events.py decay|dense|stick ARGUMENTS (see below).

    decay DELTA X_F UNTIL              turning points of a free decay from x = 1, by a terminal event
    dense DELTA X_F UNTIL SAMPLES      the same motion on an even grid
    stick DELTA X_F X_S OMEGA UNTIL    base driven by cos(omega t), stops and releases by terminal events

omega_0 = 1 throughout; tolerance is heyoka's default, the precision of a double. All in one
system with parameters that the events change, so that the loop stays in compiled code.
"""

import math
import sys

import heyoka
import numpy as np

from serve import serve

way = sys.argv[1]
numbers = [float(word) for word in sys.argv[2:]]
x, v = heyoka.make_vars("x", "v")
# Direction of motion, and whether there is any.
s, moves = heyoka.par[0], heyoka.par[1]
seen = [0]

if way in ("decay", "dense"):
    delta, x_f, until = numbers[:3]

    def turn(ta, _):
        seen[0] += 1
        ta.pars[0] = -ta.pars[0]
        return True

    # An event in one direction only: the start, where velocity is zero, is none.
    event = heyoka.t_event(s * v, callback=turn, direction=heyoka.event_direction.negative)
    system = [(x, v), (v, -2.0 * delta * v - x - x_f * s)]
    ta = heyoka.taylor_adaptive(system, [1.0, 0.0], pars=[-1.0], t_events=[event])
    grid = np.linspace(0.0, until, int(numbers[3])) if way == "dense" else None

    def work():
        seen[0] = 0
        ta.time = 0.0
        ta.state[:] = [1.0, 0.0]
        ta.pars[0] = -1.0
        ta.reset_cooldowns()
        if way == "dense":
            outcome, *_, out = ta.propagate_grid(grid)
            answer = [out[-1, 0], float(len(out))]
        else:
            outcome = ta.propagate_until(until)[0]
            answer = [ta.state[0], float(seen[0])]
        assert outcome == heyoka.taylor_outcome.time_limit
        return answer, [0.0, 0.0]

else:
    delta, x_f, x_s, omega, until = numbers
    pull = heyoka.cos(omega * heyoka.time) - x

    def pull_now(ta):
        return math.cos(omega * ta.time) - ta.state[0]

    def turn(ta, _):
        seen[0] += 1
        ta.state[1] = 0.0
        now = pull_now(ta)
        if abs(now) <= x_s:
            ta.pars[:] = [0.0, 0.0]
        else:
            ta.pars[0] = math.copysign(1.0, now)
        return True

    def release(ta, _):
        seen[0] += 1
        ta.pars[:] = [math.copysign(1.0, pull_now(ta)), 1.0]
        return True

    events = [
        heyoka.t_event(s * v, callback=turn, direction=heyoka.event_direction.negative),
        # Out of reach while it slides.
        heyoka.t_event(
            pull * pull - x_s * x_s + 1e3 * moves,
            callback=release,
            direction=heyoka.event_direction.positive,
        ),
    ]
    system = [(x, moves * v), (v, moves * (-2.0 * delta * v + pull - x_f * s))]
    ta = heyoka.taylor_adaptive(system, [0.0, 0.0], pars=[1.0, 1.0], t_events=events)

    def work():
        seen[0] = 0
        ta.time = 0.0
        ta.state[:] = [0.0, 0.0]
        ta.pars[:] = [1.0, 1.0]
        ta.reset_cooldowns()
        outcome = ta.propagate_until(until)[0]
        assert outcome == heyoka.taylor_outcome.time_limit
        return [ta.state[0], float(seen[0])], [0.0, 0.0]


serve(work)
