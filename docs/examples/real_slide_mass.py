"""How heavy is my slide really?

Crank angle and motor torque of the idle press, recorded at three speeds, show the mass of slide and upper die as they
are today, and the friction at the crank, with intervals. The mass contains a part of the rod, and is no load for a
crane: for lifting, weigh the slide or ask its maker.
"""

import pinpress as pp

press = pp.load("zxn2_3000b")
columns = {"angle": "crank [deg]", "torque": "motor [N m]", "ratio": 20.7}
runs = [pp.measured.record(f"../records/{strokes}.csv", **columns) for strokes in (21, 42, 63)]
found = pp.measured.identify(press, runs, friction=("crank", "gibs"), cylinder=True)

drawn = press.model.inertias[press.model.getJointId("slide_guide")].mass
low, high = found.intervals["slide mass"]
print(f"slide: {found.values['slide mass']:.0f} kg, with 95 % between {low:.0f} and {high:.0f}; the drawing says {drawn:.0f}")
print(f"{found.learnt:.1f} of {len(found.parameters)} parameters learnt")

figure = pp.plots.draw(pp.measured.identifiability(press, runs, friction=("crank", "gibs"), cylinder=True), "doubt")
