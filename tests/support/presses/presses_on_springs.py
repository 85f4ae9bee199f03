"""Presses on springs of one stiffness, and what drives them."""

import pinpress as pp

from .. import texts

RPM, SPEED = pp.RPM, 300 * pp.RPM
WHEEL = pp.drives.Flywheel(40.0)
BLANK = pp.loads.Blanking(1.25e6, 0.010, 0.005)


def springs(press, stiffness=2e9, **more):
    guides = [joint for joint, axis in zip(press.joints, press.axes, strict=True) if not axis.turns]
    moments = dict.fromkeys(guides, 0.1 * stiffness)
    return pp.elasticity.Elastic(pp.elasticity.Stiffness(dict.fromkeys(press.bearings, stiffness), moments=moments, **more))


def induction(power=3e4, ratio=4.8, efficiency=1.0):
    return pp.drives.Geared(pp.drives.InductionMotor(power, 1465 * RPM, inertia=0.1), ratio, 0.0, efficiency)


def jf75g():
    return texts.shipped("jf75g_125_plain")


def pendulum(rest):
    """A crank of 100 kg m2 that next to nothing hangs on."""
    text = texts.shipped("crank_slide").text.decode().replace('<origin xyz="0.030 0 0"/>', "", 1)
    for mass, moment in (("20", 100.0), ("15", rest), ("100", rest)):
        at = text.index(f'<mass value="{mass}"/>')
        end = text.index("/>", text.index("<inertia ", at))
        kept = mass if mass == "20" else rest
        text = (
            text[:at] + f'<mass value="{kept}"/><inertia ixx="{moment}" ixy="0" ixz="0" iyy="{moment}" iyz="0" izz="{moment}"' + text[end:]
        )
    return texts.load(text, gravity=(0.0, 0.0, 0.0))
