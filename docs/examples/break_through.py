"""How hard does the press snap through when the sheet breaks?

While the press blanks, it is a loaded spring. When the sheet breaks, it throws the slide down. The example puts the
six-bar on springs and shows how far the slide dives, and with how much reverse load. Press makers name 10 % of the
nominal force as what a press tolerates, and severe damage from 15 % (Sutherland Presses). Springs, damping and die are
assumed here. What the maker of your press says decides.
"""

import numpy as np

import pinpress as pp

press = pp.load("zxn2_3000b")
springs = pp.elasticity.Stiffness(
    bearings={"A": 3e9, "B": 4e9, "C": 4e9, "D": 5e9, "E": 6e9, "F": 6e9, "slide_guide": 2e9},  # N/m
    rods=[pp.elasticity.Rod("rod", ("E", "F"), 2.1e11 * 0.060 / 0.480)],  # E A / l
    frame=4e9,
)
angle = pp.dead_centres(press).bottom_angle - np.radians(20)  # on the way down
states = pp.elasticity.compliance(press, springs, angle=[angle])
mass, stiffness = states.effective_mass[0] + 1500, 1 / states.compliance[0]  # kg with the upper die, N/m
snap = pp.elasticity.snap_through(1.5e6, stiffness, mass=mass, damping_ratio=0.04, break_time=1e-3, clearance=1e-4)
print(snap)
allowed = pp.elasticity.permissible_breakthrough(300e3, 1 / states.compliance, mass=mass, damping_ratio=0.04, break_time=1e-3)
print(f"a reverse load of 300 kN, 10 % of nominal, allows a break-through at {allowed[0] / 1e3:.0f} kN")

figure = pp.plots.draw({"1500 kN": snap}, "spring_force")
