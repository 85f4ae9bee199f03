"""Presses on springs of one stiffness, and what drives them."""

import tempfile
from functools import cache
from pathlib import Path

import pinpress as pp
from pinpress.pin_table.templates import template

from .. import texts

RPM, SPEED = pp.RPM, 300 * pp.RPM
WHEEL = pp.drives.Flywheel(40.0)
BLANK = pp.loads.Blanking(1.25e6, 0.010, 0.005)


def stiffness_of(press, stiffness=2e9, pins=(), **more):
    """Every bearing alike; guides, or these pins, hold against turning."""
    held = pins or [joint for joint, axis in zip(press.joints, press.axes, strict=True) if not axis.turns]
    return pp.elasticity.Stiffness(dict.fromkeys(press.bearings, stiffness), moments=dict.fromkeys(held, 0.1 * stiffness), **more)


def springs(press, stiffness=2e9, pins=(), **more):
    return pp.elasticity.Elastic(stiffness_of(press, stiffness, pins, **more))


@cache
def rssp():
    """The template: a rod with a universal joint at the crank and a ball at the slide."""
    path = Path(tempfile.mkdtemp(dir=texts.FILES)) / "rssp.yaml"
    path.write_bytes(template("rssp"))
    return pp.build(path)


PINS = ("O", "B_cross", "B", "slide_guide")  # of the template, with its crank O, rod and slide


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
