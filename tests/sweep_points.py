"""Functions that are swept in other processes, which must be able to import them."""

import os
import time


def product(a, b):
    return {"product": a * b, "larger": max(a, b), "even": (a * b) % 2 == 0, "which": "a" if a > b else "b, or, both"}


def fails_at_odd(a):
    if a % 2:
        raise ValueError(f'{a} is odd,\nwhich is "bad"')
    return {"half": a // 2}


def dies(a, at):
    if a == at:
        time.sleep(0.5)  # the other points are done by then
        os._exit(1)
    return {"twice": 2 * a}


def logged(a, log, pause):
    """Twice a, after a while; every execution is logged."""
    descriptor = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(descriptor, f"{a},{os.getpid()}\n".encode())
    os.close(descriptor)
    time.sleep(pause)
    return {"twice": 2 * a, "process": os.getpid()}
