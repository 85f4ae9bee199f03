"""A press on its mounts: vibration of its frame, and the force on the floor; `pinpress.foundation.<function>`.

    pad = foundation.RubberPad(length=0.2, width=0.2, thickness=0.01, hardness=65, loss_factor=0.15, stiffening=1.3)
    mounts = [foundation.pad_mount((x, y, -1.3), pad) for x in (-0.55, 0.55) for y in (-0.5, 0.6)]
    frame = foundation.Frame(mass=15000, centre=(0, 0.1, -0.35), inertia=(9000, 8000, 4000))
    system = foundation.mounted(press, frame, mounts)                          # sag, load of every mount, pressure
    print(foundation.modes(system))                                            # natural frequencies, damping
    idle = foundation.steady_response(system, reactions, points={"top": (0, 0, 0.9)})    # one turn of cycle, or one of steady_state
    shock = foundation.time_response(system, reactions_of_a_run, points={"top": (0, 0, 0.9)}, flywheel=pp.drives.Flywheel(136))
    foundation.over_speeds(system, np.linspace(200, 400, 41) * pp.RPM, {"top": (0, 0, 0.9)})
    foundation.isolate(press, frame, mounts, speeds, transmitted=0.1, sag=0.02)

A linear model of small vibrations: a rigid frame with six degrees of freedom, or bed and crown joined by columns with twelve, on springs
and dampers, shaken by `Reactions.shaking_force` and `shaking_moment`. `mounted_press` says what it is and what it leaves out.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
