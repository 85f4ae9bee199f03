"""What loads refuse when they are made and when they meet a motion, each with its message: a table of (call, message)."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from support.generators.random_linkages import four_bar
from support.texts import load, shipped

import pinpress as pp
from pinpress.loads import (
    BalanceCylinder,
    Blanking,
    ConstantForce,
    DeepDrawing,
    ElasticDie,
    ForceStroke,
    HydraulicCushion,
    Idle,
    Impact,
    ImpactDamper,
    PneumaticCushion,
    RateSensitiveBlanking,
    TimeForce,
    TwoSidedStop,
    orifice_coefficient,
    pick_up_force,
    step,
)

NAN, INF = math.nan, math.inf
K, C, D = 4e7, 3e4, 2e-3
SPEED = 300 * pp.RPM
BLANK = RateSensitiveBlanking(3e4, 0.04, 0.02, sensitivity=0.05, reference_speed=1e-3, peak=0.03, remaining=0.4, stripping=2e3)
SCENARIOS = [
    ConstantForce,
    lambda f, h: Blanking(f, 0.01, 0.005, stripping=0.1 * f),
    DeepDrawing,
    lambda f, h: ElasticDie(h, 1e3 * f, 0.1 * f),
]
SCENARIOS += [lambda f, h: ForceStroke([0.0, 0.004, 0.012], np.multiply.outer([1.0, 2.0, 0.5], f))]


def cylinder(**more):
    return BalanceCylinder(0.12, 6e5, 0.01, **more)


def moved(loads, **more):
    press = shipped("jf75g_125")
    return pp.inverse_dynamics(press, pp.cycle(press, SPEED, **{"points": 6} | more), loads)


def standing(loads):
    """A motion without times."""
    press = shipped("jf75g_125")
    return pp.inverse_dynamics(press, pp.servo_cycle(press, speed=[1.0, -1.0], angle=[0.0, 1.0], acceleration=0.0), loads)


def without_slide(given):
    press = load(four_bar(1.0, 0.3, 0.9, 0.8, 1.0).urdf("O"))
    return pp.inverse_dynamics(press, pp.cycle(press, 1.0, points=4), [given])


REFUSALS = [
    (partial(ConstantForce, -1.0, 0.001), "ConstantForce: force is -1.0; give a finite number that is not negative"),
    (partial(ConstantForce, NAN, 0.001), "ConstantForce: force is nan; give a finite number"),
    (partial(ConstantForce, 1.0, -0.001), "ConstantForce: height is -0.001; give the height above bottom dead centre"),
    (partial(ConstantForce, 1.0, INF), "ConstantForce: height is inf"),
    (partial(ConstantForce, 1.0, [0.1, 0.2]), r"ConstantForce: height has shape \(2,\); give a finite number"),
    (partial(ConstantForce, 1.0, None), "ConstantForce: height is None"),
    (partial(ConstantForce, [], 0.1), r"ConstantForce: force has shape \(0,\)"),
    (partial(ConstantForce, [[1.0]], 0.1), r"ConstantForce: force has shape \(1, 1\)"),
    (partial(ConstantForce, True, 0.1), "ConstantForce: force is True"),
    (partial(Idle, datum="top"), "Idle: datum is 'top'; give a finite number"),
    (partial(Idle, datum=NAN), "Idle: datum is nan"),
    (partial(Blanking, "1 MN", 0.01, 0.005), "Blanking: force is '1 MN'; give a finite number"),
    (partial(Blanking, [1.0, -1.0], 0.01, 0.005), "Blanking: force is"),
    (partial(Blanking, 1.0, 0.005, 0.01), "Blanking: start is 0.005, not above end, 0.01"),
    (partial(Blanking, 1.0, 0.005, 0.005), "Blanking: start is 0.005, not above end, 0.005"),
    (partial(Blanking, 1.0, 5e-324, 0.0), "Blanking: start is"),
    (partial(Blanking, 1.0, NAN, 0.0), "Blanking: start is nan"),
    (partial(Blanking, 1.0, 0.01, [0.005]), r"Blanking: end has shape \(1,\)"),
    (partial(Blanking, 1.0, 0.01, 0.005, -1.0), "Blanking: stripping is -1.0"),
    (partial(Blanking, [1.0, 2.0], 0.01, 0.005, [1.0, 2.0, 3.0]), "Blanking: force and stripping are for different numbers of scenarios"),
    (partial(DeepDrawing, -1.0, 0.01), "DeepDrawing: force is -1.0"),
    (partial(DeepDrawing, 1.0, 0.0), "DeepDrawing: start is 0, not above end, 0"),
    (partial(DeepDrawing, 1.0, 1e308, -1e308), "DeepDrawing: start is"),
    (partial(DeepDrawing, 1.0, 0.01, datum=[1.0, 2.0]), r"DeepDrawing: datum has shape \(2,\)"),
    (partial(ForceStroke, [0.1], [1.0]), r"ForceStroke: heights has shape \(1,\)"),
    (partial(ForceStroke, 0.1, 1.0), r"ForceStroke: heights has shape \(\)"),
    (partial(ForceStroke, [0.1, 0.2], [1.0, 2.0, 3.0]), r"ForceStroke: forces has shape \(3,\); give one force for each of the 2"),
    (partial(ForceStroke, [0.1, 0.2], 1.0), r"ForceStroke: forces has shape \(\)"),
    (partial(ForceStroke, [0.1, 0.2, 0.2], [1.0, 2.0, 3.0]), "ForceStroke: heights neither rises nor falls throughout"),
    (partial(ForceStroke, [0.1, 0.3, 0.2], [1.0, 2.0, 3.0]), "ForceStroke: heights neither rises nor falls throughout"),
    (partial(ForceStroke, [0.2, 0.3, 0.1], [1.0, 2.0, 3.0]), "ForceStroke: heights neither rises nor falls throughout"),
    (partial(ForceStroke, [0.1, NAN], [1.0, 2.0]), "ForceStroke: heights is"),
    (partial(ForceStroke, [0.1, 0.2], [1.0, INF]), "ForceStroke: forces is"),
    (partial(ForceStroke, [0.1, "x"], [1.0, 2.0]), "ForceStroke: heights is .*; give finite numbers"),
    (partial(ForceStroke, [[0.1, 0.2], [0.3]], [1.0, 2.0]), "ForceStroke: heights is .*; give finite numbers"),
    (partial(ForceStroke, [0.0, 1e-300], [0.0, 1e300]), "ForceStroke: heights are too close together"),
    (partial(ForceStroke, [0.0, 1e-300, 1.0], [0.0, 1e300, 0.0]), "ForceStroke: heights are too close together"),
    (partial(ElasticDie, 0.01, 0.0), "ElasticDie: stiffness is 0.0; give a finite number that is positive"),
    (partial(ElasticDie, 0.01, [1.0, 0.0]), "ElasticDie: stiffness is"),
    (partial(ElasticDie, 0.01, -1.0), "ElasticDie: stiffness is -1.0"),
    (partial(ElasticDie, 0.01, 1.0, -1.0), "ElasticDie: damping is -1.0"),
    (partial(ElasticDie, 0.01, [1.0, 2.0], [1.0]), "ElasticDie: stiffness and damping are for different numbers of scenarios"),
    (partial(ElasticDie, NAN, 1.0), "ElasticDie: height is nan"),
    (partial(TimeForce, 5.0), "TimeForce: force is 5.0; give a function of time"),
    (partial(TimeForce, abs, [NAN]), "TimeForce: edges is"),
    (partial(TimeForce, abs, 0.1), r"TimeForce: edges has shape \(\)"),
    (partial(TimeForce, abs, "now"), "TimeForce: edges is 'now'"),
    (partial(step, 0.0, 1.0, 0.0, 1.0, 1.0), "step: x1 is 1, not above x0, 1"),
    (partial(step, 0.0, 1.0, 0.0, 0.5, 1.0), "step: x1 is 0.5, not above x0, 1"),
    (partial(step, NAN, 0.0, 0.0, 0.5, 1.0), "step: x is not finite"),
    (partial(step, [0.0, NAN, 1.0], 0.0, 0.0, 0.5, 1.0), "step: x is not finite"),
    (partial(step, 0.0, 0.0, INF, 0.5, 1.0), "step: h0 is inf: give one finite number"),
    (partial(step, 0.0, 0.0, 0.0, 5e-324, 1.0), "step: x0 and x1 are too near"),
    (partial(step, "x", 0.0, 0.0, 0.5, 1.0), "step: x is not a number or an array of numbers, but text"),
    (partial(step, 0.0, 0.0, [0.0, 1.0], 0.5, 1.0), "step: h0 is .*: give one finite number"),
    (lambda: Impact(0.01, K, 0.9), "Impact: exponent is 0.9; give 1 .a spring. to 10"),
    (lambda: Impact(0.01, K, 11.0), "exponent is 11"),
    (lambda: Impact(0.01, K, 1.5, C), "Impact: depth is missing; give the depth"),
    (lambda: Impact(0.01, K, 1.5, C, 0.0), "Impact: depth is 0.0; give a finite number that is positive"),
    (lambda: Impact(0.01, 0.0), "Impact: stiffness is 0.0"),
    (lambda: Impact(0.01, [K, K], 1.5, [C, C, C], D), "stiffness and damping are for different numbers of scenarios"),
    (lambda: TwoSidedStop(0.02, 0.01, K), "TwoSidedStop: upper is 0.01, not above lower, 0.02"),
    (lambda: TwoSidedStop(0.02, 0.03, K, damping=C), "TwoSidedStop: depth is missing"),
    (lambda: pick_up_force(0.0, 0.3, 1e8), "mass is 0"),
    (lambda: pick_up_force(1.0, 0.3, -1e8), "stiffness is -1"),
    (lambda: pick_up_force(1.0, np.nan, 1e8), "speed is nan"),
    (lambda: pick_up_force(1.0, 0.3, 1e8, preload=-1.0), "preload is -1 N: give a force that is not negative"),
    (lambda: ImpactDamper([0.0], [1e4]), "1 heights and 1 coefficients; give two or more"),
    (lambda: ImpactDamper([0.0, 0.1], [1e4]), "2 heights and 1 coefficients"),
    (lambda: ImpactDamper([0.0, 0.1, 0.1], [1e4, 1e4, 1e4]), "heights neither rises nor falls"),
    (lambda: ImpactDamper([0.0, 0.1], [1e4, -1e4]), "coefficients is .* not negative"),
    (lambda: ImpactDamper([0.0, 0.1], [1e4, 1e4], 0.5), "exponent is 0.5; give 1"),
    (lambda: HydraulicCushion(-1.0, 0.01), "HydraulicCushion: force is -1.0"),
    (lambda: HydraulicCushion(1.0, 0.01, 1e-320), "HydraulicCushion: rise is"),
    (lambda: orifice_coefficient(0.01, 0.02), "orifice is 0.02 m, not smaller than the piston, 0.01 m"),
    (lambda: orifice_coefficient(0.02, 0.01, discharge=1.2), "discharge is 1.2"),
    (lambda: orifice_coefficient(0.02, -0.01), "orifice is -0.01"),
    (lambda: cylinder(rod=0.12), "rod is 0.12 m, not thinner than the bore, 0.12 m"),
    (lambda: cylinder(exponent=0.9), "exponent is 0.9; give 1 .isothermal. to 1.4"),
    (lambda: cylinder(exponent=2.0), "exponent is 2; give 1"),
    (lambda: cylinder(count=0), "count is 0; give the number of cylinders"),
    (lambda: cylinder(count=1.5), "count is 1.5; give the number of cylinders"),
    (lambda: BalanceCylinder(0.12, -6e5, 0.01), "pressure is -600000.0; give a finite number that is positive"),
    (lambda: BalanceCylinder(1e200, 6e5, 0.01), "bore is 1e[+]200 m; give that of one cylinder"),
    (lambda: PneumaticCushion(0.12, 6e5, 0.0, 0.01), "PneumaticCushion: volume is 0.0"),
    (lambda: cylinder().pressure_at("high"), "BalanceCylinder: heights is not a number"),
    (lambda: replace(BLANK, start=0.02), "start, peak and end are 0.02, 0.03 and 0.02; give heights .m. that fall"),
    (lambda: replace(BLANK, peak=0.05), "start, peak and end are"),
    (lambda: replace(BLANK, peak=0.01), "start, peak and end are"),
    (lambda: replace(BLANK, sensitivity=1.0), "sensitivity is 1; steels have 0.01 to 0.06"),
    (lambda: replace(BLANK, sensitivity=-0.1), "sensitivity is -0.1; give a finite number that is not negative"),
    (lambda: replace(BLANK, reference_speed=0.0), "reference_speed is 0.0"),
    (lambda: replace(BLANK, remaining=1.1), "remaining is 1.1; give the share"),
    (lambda: replace(BLANK, peak=None), "remaining is 0.4, but the force does not fall: give peak"),
    (lambda: replace(BLANK, force=[1.0, 2.0], stripping=[1.0, 2.0, 3.0]), "different numbers of scenarios"),
    (lambda: moved([BalanceCylinder(0.2, 6e5, 0.0005, height=0.03)], points=36), "the slide has swept all of its volume; give the volume"),
    (lambda: standing([TimeForce(abs)]), "no motion in time"),
    (lambda: moved([TimeForce(lambda time: np.ones(3))]), r"TimeForce: force has shape \(3,\); give \(1,\)"),
    (lambda: moved([TimeForce(lambda time: 1e3 * np.arange(1.0, 7.0))]), "TimeForce: force"),
    (lambda: moved([TimeForce(lambda time: 1e3 * np.arange(1.0, 3.0))]), "TimeForce: force"),
    (lambda: moved([TimeForce(lambda time: NAN + 0.0 * time)]), "TimeForce: force at time 0 s is nan; give finite numbers"),
    (lambda: moved([TimeForce(lambda time: "strong")]), "TimeForce: force is 'strong'; give finite numbers"),
    (lambda: moved([ConstantForce]), "give a PointForce, PointMoment, SpringDamper, TorsionSpring, a load"),
    (lambda: moved(DeepDrawing(1.0, 0.01)), r"loads is one DeepDrawing: give a list, loads=\[...\]"),
    (lambda: moved(2 * [DeepDrawing(1e308, 0.03)], points=64), "not finite"),
    (lambda: without_slide(Blanking(1.0, 0.01, 0.005)), "four_bar has no slide"),
    (lambda: without_slide(DeepDrawing(1.0, 1.0, datum=0.0)), "four_bar has no slide"),
    (lambda: without_slide(TimeForce(abs)), "four_bar has no slide"),
    *(
        (partial(moved, [make(np.ones(count), 0.004)]), rf"its force has shape \({count},\), for scenarios")
        for make in SCENARIOS
        for count in (1, 6)  # also as many as the motion has states
    ),
]


@pytest.mark.parametrize(("call", "message"), REFUSALS, ids=[message for _, message in REFUSALS])
def test_refusals(call, message):
    with pytest.raises(pp.PinpressError, match=message):
        call()
