"""Random runs with clutch, brake, loads that act one way, friction and gears with losses, about as strong as the weights of the press."""

import numpy as np
from support import texts

import pinpress as pp

# rated power, speed, inertia and ratio of a motor; flywheels from and to [kg m2]
PRESSES = {
    "crank_slide": (2.2e3, 1430, 0.01, 15.0, 0.03, 50.0),
    "zxn2_3000b": (75e3, 1485, 1.2, 20.7, 30.0, 6000.0),
    "eccentric_blocks": (30e3, 1470, 0.3, 20.0, 3.0, 2000.0),
    "jf75g_125": (30e3, 1470, 0.3, 10.0, 1.0, 500.0),
    "pirica_double_knuckle": (30e3, 1470, 0.3, 20.0, 3.0, 2000.0),
}


def holding_torque(press):
    """The largest torque that the weights take at the crank [N m]."""
    angle, rest = np.linspace(0, 2 * np.pi, 41), np.zeros(41)
    motion = pp.servo_cycle(press, angle, speed=rest, acceleration=rest)
    return float(np.abs(pp.inverse_dynamics(press, motion, bearings=()).driving_torque).max())


def coupled_run(random):
    """A press, and the arguments of `simulate`."""
    name = str(random.choice(list(PRESSES), p=[0.4, 0.3, 0.1, 0.1, 0.1]))
    power, rated, rotor, ratio, least, most = PRESSES[name]
    press = texts.shipped(name)
    stroke, holds = pp.dead_centres(press).stroke, holding_torque(press)
    sign = lambda: float(random.choice([-1, 1]))  # noqa: E731
    share = lambda low, high: float(np.exp(random.uniform(np.log(low), np.log(high))))  # noqa: E731
    angle = float(random.uniform(-3.14, 3.14))
    given = {
        "angle": angle,
        "speed": float(random.choice([0.0, 0.0, random.uniform(-0.5, 0.5), random.uniform(-6, 6)])),
        "flywheel": pp.drives.Flywheel(share(least, most), speed=float(random.uniform(-6, 6)) if random.random() < 0.3 else None),
    }
    motor = pp.drives.InductionMotor(power, rated * pp.RPM, inertia=rotor)
    efficiency = float(random.choice([1.0, 0.95, 0.8]))
    drive = random.choice(["none", "induction", "constant", "geared"], p=[0.3, 0.4, 0.15, 0.15])
    if drive == "induction":
        given["drive"] = pp.drives.Geared(motor, ratio * float(random.choice([1, 1, 1, -1])), efficiency=efficiency)
    elif drive == "constant":
        given["drive"] = pp.drives.ConstantTorque(sign() * holds * share(0.03, 3))
    elif drive == "geared":
        given["drive"] = pp.drives.Geared(pp.drives.ConstantTorque(0.1 * sign() * holds * share(0.03, 3)), 10.0, efficiency=efficiency)

    def switch():
        at_time = {"time": float(random.uniform(0.02, 0.4))}
        return pp.drives.SwitchPoint(**(at_time if random.random() < 0.7 else {"angle": angle + float(random.uniform(-1, 1))}))

    def coupling(kind):
        return kind(
            holds * share(0.03, 3),
            closes=switch() if random.random() < 0.35 else None,
            opens=switch() if random.random() < 0.4 else None,
            rise=float(random.uniform(0.005, 0.1)) if random.random() < 0.3 else 0.0,
        )

    which = random.choice(["brake", "clutch", "both", "none"], p=[0.45, 0.2, 0.25, 0.1])
    if which in ("brake", "both"):
        given["brake"] = coupling(pp.drives.Brake)
    if which in ("clutch", "both"):
        given["clutch"] = coupling(pp.drives.Clutch)
    start, force = float(random.uniform(0.1, 0.9) * stroke), lambda: holds / (0.5 * stroke) * share(0.02, 2)
    loads = [
        [],
        [pp.loads.DeepDrawing(force(), start)],
        [pp.loads.Blanking(force(), start, start * float(random.uniform(0.2, 0.9)))],
        [pp.loads.Blanking(force(), start, start * float(random.uniform(0.2, 0.9)), stripping=0.1 * force())],
        [pp.loads.ElasticDie(0.1 * start, force() / (0.05 * start), damping=0.02 * force() / stroke)],
        [pp.loads.ForceStroke([0, 0.5 * start, start], [force(), force(), 0.0])],
    ]
    given["loads"] = loads[random.integers(len(loads))]
    if random.random() < 0.15:
        given["friction"] = {press.driver: pp.loads.Friction(float(random.uniform(0.02, 0.2)), radius=float(0.05 * stroke))}
    return press, given
