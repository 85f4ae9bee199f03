"""Which servo motor for 25 parts a minute, drawn at 0.2 m/s?

The motors are those of a catalogue, tried from the smallest on behind four gears. For each motor the best motion is the
one that heats it least, with a proof. The first motor that is not overheated by it is the answer. It has no reserve:
friction, a warm room and other motions are left out. A motor at rest does not hold a slide
safely: that is the brake's task.
"""

import pinpress as pp
from pinpress import servo

press = pp.load("zxn2_3000b")
catalogue = servo.read_motors("../servo_motors.csv")  # yours; this one is an example
drawing = pp.loads.DeepDrawing(force=1.5e6, start=0.060)
slow = servo.SlideSpeed(0.2, heights=(0.060, 0.0))  # m/s while it draws
wanted = {"ratios": [40, 50, 60, 80], "time": 60 / 25, "limits": [slow], "gear_inertia": 50.0}
chosen = servo.choose_motor(press, catalogue, [drawing], **wanted, points=360)

use = chosen.use
print(f"{chosen.motor.name} behind a gear of {use.ratio:g}: {use.rms_torque:.0f} N m rms")
print(f"{100 * use.thermal:.0f} % of its permanent torque, {100 * use.peak:.0f} % of its peak torque")

figure = pp.plots.draw(chosen, "plane")
