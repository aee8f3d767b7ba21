"""The peers' side of the benchmark: asked for n repetitions, tells their mean time and the answer."""

import sys
from time import perf_counter


def serve(work):
    """Answer each line `n` on stdin with one line of numbers on stdout.

    First the mean time of `n` calls of `work` in seconds, then what it
    returned: estimates, followed by as many standard errors.
    """
    work()  # imports, caches and page faults are paid before the first question
    print("ready", flush=True)
    for line in sys.stdin:
        repetitions = int(line)
        begun = perf_counter()
        for _ in range(repetitions):
            estimates, errors = work()
        seconds = (perf_counter() - begun) / repetitions
        print(*map(repr, map(float, [seconds, *estimates, *errors])), flush=True)
