"""Ten strokes of the JF75G-125 under motor, flywheel and blanking, for sweeps whose workers must be able to import it."""

import numpy as np

import pinpress as pp

PRESS = pp.load("jf75g_125")
SPEED = 1500 / 4.9 * pp.RPM  # at which the motor idles
DURATION, STATES = 2.0, 121


def parts(inertia, force, power):
    """Drive, flywheel and loads of one run or of many."""
    motor = pp.drives.InductionMotor(rated_power=power, rated_speed=1465 * pp.RPM)
    loads = [pp.loads.Blanking(force, start=0.010, end=0.005)]
    return {"drive": pp.drives.Geared(motor, ratio=4.9), "flywheel": pp.drives.Flywheel(inertia), "loads": loads}


def strokes_at_once(inertia, force, power):
    """Many runs, as arrays (n,): lowest speed of the crank [rad/s], works of motor and load [J], share of energy that is missing."""
    runs = pp.simulate_batch(PRESS, DURATION, speed=SPEED, points=STATES, **parts(inertia, force, power))
    return {
        "lowest_speed": runs.crank_speed.min(axis=0),
        "drive_work": runs.drive_work,
        "load_work": runs.load_work,
        "energy_error": runs.energy_error,
        "error": runs.errors,
    }


def strokes(inertia, force, power):
    """The same of one run."""
    run = pp.simulate(PRESS, DURATION, speed=SPEED, points=STATES, **parts(inertia, force, power))
    return {
        "lowest_speed": run.crank_speed.min(),
        "drive_work": run.drive_work[-1],
        "load_work": run.load_work[-1],
        "energy_error": run.stats.energy_error,
    }


def grid(points):
    """About so many points: inertia at the crank [kg m2], blanking force [N], rated power of the motor [W]."""
    count = max(2, round(points ** (1 / 3)))
    ranges = {"inertia": (100.0, 200.0), "force": (0.0, 250e3), "power": (30e3, 60e3)}
    return {name: np.linspace(*ends, count) for name, ends in ranges.items()}


def nothing(inertia, force, power):
    """As many results, without work."""
    return dict.fromkeys(("lowest_speed", "drive_work", "load_work", "energy_error"), inertia)
