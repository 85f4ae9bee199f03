"""What if the crank turns across the slide?

The linkage is in space: a crank about x, a rod between two ball joints, a slide that moves upwards. The table of pins
has three coordinates. Everything works as in the plane: dead centres, torque, the force in every ball.
"""

import numpy as np

import pinpress as pp

press = pp.build(
    units="mm",
    frame="O",
    pins={
        "O": {"x": 0, "y": 0, "z": 0, "axis": "x"},
        "B": {"x": 60, "y": -80, "z": 0, "joint": "ball"},
        "S": {"x": 150, "y": 30, "z": -420, "joint": "ball"},
    },
    links={
        "crank": {"pins": "O B", "mass": 12, "com": {"x": 30, "y": -30}, "inertia": [0.04, 0.03, 0.05]},
        "rod": {"pins": "B S", "mass": 6},
        "slide": {"pins": "S", "guide": "up", "mass": 60},
    },
    drive="O",
)
motion = pp.cycle(press, speed=200 * pp.RPM, points=360)
reactions = pp.inverse_dynamics(press, motion)
print(f"stroke {1e3 * pp.dead_centres(press).stroke:.1f} mm, torque up to {reactions.driving_torque.max():.0f} N m")
for name in ("B", "S"):
    print(f"ball {name}: up to {np.linalg.norm(reactions.bearing_force[name], axis=1).max():.0f} N")
x, y, _ = np.abs(reactions.bearing_force["slide_guide"]).max(axis=0)
print(f"the guide carries up to {x:.0f} N along x and {y:.0f} N along y")

figure = pp.plots.draw(reactions, "bearings", "moments")
