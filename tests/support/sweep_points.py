"""Functions that are swept in other processes, which must be able to import them."""

import faulthandler
import os
import signal
import time

import numpy as np


def product(a, b):
    return {"product": a * b, "larger": max(a, b), "even": (a * b) % 2 == 0, "which": "a" if a > b else "b, or, both"}


def fails_at_odd(a):
    if a % 2:
        raise ValueError(f'{a} is odd,\nwhich is "bad"')
    return {"half": a // 2}


def doubled(a):
    return {"twice": 2 * a}


def raises_at_1(a, error):
    if a == 1:
        raise error
    return doubled(a)


def dies(a, at, how, log):
    """Twice a, but at some points the process ends; every call is logged."""
    descriptor = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(descriptor, f"{a}\n".encode())
    os.close(descriptor)
    if a in at:
        if how == "exit":
            os._exit(1)
        faulthandler.disable()  # it would print
        os.kill(os.getpid(), signal.SIGKILL if how == "kill" else signal.SIGSEGV)
    return doubled(a)


def dies_at_once(a, at, how, log):
    """The same of many points: the process ends where one of them is among these."""
    return {"twice": np.array([dies(each, at, how, log)["twice"] for each in a.tolist()])}


def hypotenuse(a, b):
    """Of many points."""
    return {"c": np.hypot(a, b)}


def logged(a, log, pause):
    """Twice a, after a while; every execution is logged."""
    descriptor = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(descriptor, f"{a},{os.getpid()}\n".encode())
    os.close(descriptor)
    time.sleep(pause)
    return {"twice": 2 * a, "process": os.getpid()}


def logged_at_once(a, b, log, pause):
    """The hypotenuses of many points, after a while; every execution is logged."""
    logged(a[0], log, pause)
    return hypotenuse(a, b)


WORDS = ["plain", "two\nlines", 'say "x", or y', "é 滑块", "\r", "7"]


def told(k):
    if k % 5 == 3:
        raise ValueError(f'not {k},\nor "{k}"')
    return {"number": 0.1 * k, "word": WORDS[k % 6], "even": k % 2 == 0, "whole": k}
