"""No answer that a second method contradicts: random scenes with fixed seeds, solved by every method that takes them.

`python tests/support/second_opinion.py` explores thousands of others.
"""

from dataclasses import replace

import pytest
from support import second_opinion, texts
from support.generators import random_scenes

import pinpress as pp

SCENES = {"runs": 80, "machines": 40, "couplings": 12, "starts": 30, "batches": 12, "steady": 30, "engines": 24, "cuts": 30, "written": 40}
REFUSED_BY_SOME: dict[str, set[int]] = {}
"""Seeds of the scenes that one method solves and another refuses: a seed may leave this list, and none may join it."""


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")  # numbers at random are often hardly meant
@pytest.mark.parametrize(
    ("kind", "seed"),
    [
        pytest.param(kind, seed, marks=[pytest.mark.exhaustive] if seed else [])  # the first of each kind is run by default
        for kind, count in SCENES.items()
        for seed in range(count)
    ],
)
def test_methods_agree(kind: str, seed: int) -> None:
    told: list[str] = []
    (verdict,) = second_opinion.opinions(kind, [seed], told.append)
    assert verdict.word != "disagree", "\n".join(told)
    assert verdict.word != "partly" or seed in REFUSED_BY_SOME.get(kind, set()), "\n".join(told)


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
def test_a_crank_that_the_losses_of_its_gears_hold_rests_under_a_drive_of_ones_own() -> None:
    """A direct-current motor behind gears of 0.8: whichever side its torque at rest is taken from, it is the speed's."""
    scene = random_scenes.scene(1082)
    verdict = next(iter(second_opinion.opinions("runs", [1082])))
    assert scene.given["speed"] == 0.0
    assert isinstance(scene.given["drive"].drive, random_scenes.DirectCurrent)
    assert verdict.word == "agree", verdict.detail


def test_a_wrong_run_shows() -> None:
    """Without a second method: a jump of the crank, torques of other speeds, another start, energy from nowhere."""
    press = texts.shipped("crank_slide")
    motor = pp.drives.Geared(pp.drives.InductionMotor(2.2e3, 1430 * pp.RPM, inertia=0.01), 15.0)
    given = {"angle": 1.0, "speed": 3.0, "drive": motor, "flywheel": pp.drives.Flywheel(5.0)}
    scene = random_scenes.Scene(0, press.name, press, 0.3, given)
    run = pp.simulate(press, scene.duration, points=41, **given)
    assert second_opinion.sign_of_fault(scene, run) == ""
    for changes, words in (
        ({"crank_angle": run.crank_angle + 2.0 * (run.time > 0.2)}, "from state to state"),
        ({"drive_torque": 1.01 * run.drive_torque}, "torques of inverse dynamics differ"),
        ({"crank_speed": run.crank_speed + 1e-6}, "begins at"),
    ):
        assert words in second_opinion.sign_of_fault(scene, replace(run, **changes))
    coasting = replace(scene, given={**given, "drive": None})
    assert "energy rises" in second_opinion.beyond_its_drive(coasting, run)
