"""Random planar linkages with gears whose teeth mesh on moving carriers, in planes that stand anyhow."""

import numpy as np
import pinocchio as pin
from support.generators.random_linkages import UPRIGHT, Drawing
from support.texts import load

import pinpress as pp


def random_gears(seed: int, kind: str) -> pp.Linkage:
    """A slide that a planetary gear or a lever gear moves; of a "lever gear by a loop" the rod hangs on the slide, so that only a loop
    joins it to its carrier."""
    random = np.random.default_rng(seed)
    world = UPRIGHT if seed % 2 else pin.exp3(random.uniform(-2, 2, 3))
    drawing = Drawing(kind, world=world)
    angle = f'pressure_angle="{random.uniform(10, 30)}"'
    if kind == "planetary":
        sun, planet = ((20, 20), (40, 20), (20, 40), (20, 30), (30, 15))[int(random.integers(5))]
        radius = random.uniform(0.1, 0.3)
        centre = radius * np.exp(1j * random.uniform(0, 6.28))
        on = str(random.choice(["planet", "carrier"]))
        pivot = centre * random.uniform(0.5, 1.2) + (on == "planet") * radius * 0.3 * np.exp(1j * random.uniform(0, 6.28))
        wrist = complex(random.uniform(-0.2, 0.2) * radius, -random.uniform(3, 6) * radius)
        drawing.joint("S", "frame", "sun", 0j)
        drawing.joint("C", "frame", "carrier", 0j)
        drawing.joint("P", "carrier", "planet", centre, sense=int(random.choice([-1, 1])))
        drawing.joint("B", on, "rod", pivot)
        drawing.joint("G", "frame", "slide", wrist, along=1j)
        drawing.loop("W", "rod", "slide", wrist)
        pairs = [("sun", "planet", sun, planet), ("frame", "planet", -sun - 2 * planet, planet)]
        centers = {"sun": 0j, "carrier": 0.4 * centre, "planet": centre, "rod": 0.5 * (pivot + wrist), "slide": wrist}
        carrier, driver = "carrier", str(random.choice(["S", "C"]))
    else:
        teeth, geared = int(random.choice([-120, -60, 20, 40, 60])), int(random.choice([20, 30, 40]))
        crank = random.uniform(0.05, 0.2) * np.exp(1j * random.uniform(0, 6.28))
        wrist = complex(random.uniform(3, 6) * abs(crank), random.uniform(-0.3, 0.3) * abs(crank))
        drawing.joint("A", "frame", "crank", 0j)
        drawing.joint("A1", "frame", "wheel", 0j, sense=int(random.choice([-1, 1])))
        drawing.joint("G", "frame", "slide", wrist, along=1.0 + 0j)
        if kind == "lever gear":
            drawing.joint("B", "crank", "rod", crank)
            drawing.loop("W", "rod", "slide", wrist)
        else:
            drawing.joint("W", "slide", "rod", wrist)
            drawing.loop("B", "crank", "rod", crank)
        pairs = [("wheel", "rod", teeth, geared)]
        centers = {"crank": 0.5 * crank, "wheel": 0j, "rod": 0.5 * (crank + wrist), "slide": wrist}
        carrier, driver = "crank", "A1"
    for k, (first, second, z1, z2) in enumerate(pairs):
        bodies = f'gear1="{first}" gear2="{second}" teeth1="{z1}" teeth2="{z2}" carrier="{carrier}"'
        drawing.elements.append(f'<gear_mesh name="teeth{k}" {bodies} {angle}/>')
    for link, at in centers.items():
        drawing.body(link, 10 ** random.uniform(0.5, 2), at + 0.1 * abs(wrist) * complex(*random.normal(size=2)))
    return load(drawing.urdf(driver))


def geared_cranks(seed: int, pressure_angle: float = 0.0) -> pp.Linkage:
    """Two geared cranks that draw one slide, which its guide holds too: one equation is redundant, of teeth and rods together."""
    drawing, random = Drawing("geared_cranks"), np.random.default_rng(seed)
    sides = {"L": -0.2, "R": 0.2}
    for side, x in sides.items():
        drawing.joint(f"O{side}", "frame", f"crank{side}", complex(x, 0))
        drawing.joint(f"P{side}", f"crank{side}", f"rod{side}", complex(1.3 * x, 0.05))
    drawing.joint("G", "frame", "slide", -0.8j, along=1j)
    for side, x in sides.items():
        drawing.loop(f"W{side}", f"rod{side}", "slide", complex(0.9 * x, -0.8))
        drawing.body(f"crank{side}", 10 ** random.uniform(0.5, 2), complex(x, 0) + 0.05 * complex(*random.normal(size=2)))
        drawing.body(f"rod{side}", 10 ** random.uniform(0.5, 2), complex(x, -0.4) + 0.05 * complex(*random.normal(size=2)))
    drawing.body("slide", 10 ** random.uniform(0.5, 2), -0.8j)
    gears = 'gear1="crankL" gear2="crankR" teeth1="30" teeth2="30" carrier="frame"'
    drawing.elements.append(f'<gear_mesh name="teeth" {gears} pressure_angle="{pressure_angle}"/>')
    return load(drawing.urdf("OL"))
