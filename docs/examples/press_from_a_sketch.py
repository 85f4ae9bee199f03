"""What does the press on my sketch do?

A table says where the pins are, by coordinates or lengths, and which pins each link has, as on a drawing. Here it is a
knuckle press. What is its stroke, how fast does it meet the sheet, and what force does a newton metre on the crank hold
there?
"""

import pinpress as pp

press = pp.build(
    units="mm",
    frame="O T",
    pins={
        "O": [-900, 0],
        "T": [0, 500],
        "A": {"from": "O", "length": 80, "angle": 90},
        "K": {"A": 820, "T": 500, "side": "down"},
        "W": {"K": 500, "x": 0, "side": "down"},
    },
    links={
        "crank": {"pins": "O A", "mass": 90, "com": [20, 0], "inertia": 0.6},
        "coupler": {"pins": "A K", "section": "120 x 80", "overhang": 60},
        "upper_link": {"pins": "T K", "section": "160 x 120", "overhang": 80},
        "lower_link": {"pins": "K W", "section": "160 x 120", "overhang": 80},
        "slide": {"pins": "W", "guide": "up", "mass": 900},
    },
    drive="O",
)
motion = pp.cycle(press, speed=40 * pp.RPM, points=720)
ends = pp.dead_centres(press)
print(f"stroke {1e3 * ends.stroke:.1f} mm, quick return {pp.measures.quick_return_ratio(motion):.2f}")
print(f"10 mm above the bottom: {1e3 * pp.measures.speed_at(motion, 0.010):.0f} mm/s")
print(f"there each N m on the crank holds {pp.measures.mechanical_advantage(motion, 0.010):.1f} N on the slide")

figure = pp.plots.draw(motion, "position", "velocity", "acceleration")
