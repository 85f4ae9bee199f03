"""A press on its mounts: vibration of its frame, and the force on the floor.

    mounts = [pp.foundation.Mount((x, y, -1.3), (2e7, 2e7, 5e7), loss_factor=0.1) for x in (-0.6, 0.6) for y in (-0.5, 0.5)]
    frame = pp.foundation.Frame(mass=15000.0, centre=(0.0, 0.1, -0.35), inertia=(9000.0, 8000.0, 4000.0))
    system = pp.foundation.mounted(press, frame, mounts)  # sag, load of every mount
    print(pp.foundation.modes(system))  # natural frequencies, damping
    pp.foundation.steady_response(system, reactions, points={"top": (0.0, 0.0, 0.9)})

The model is linear: a rigid frame with six degrees of freedom, bed and crown joined by columns with twelve, or a reduced finite-element
model (`beam_frame`, `read_frame`), with attachments and rotors (`Attachment`, `Rotor`), on springs and dampers. `Reactions.shaking_force`
and `shaking_moment` excite it. In `lifting_response` the mounts can press but not pull. The module `mounted_press` lists what the model
neglects.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
