"""What is made from motions of presses that repeat themselves only after several turns: vibration on mounts, runs, recordings, plots,
designs and files. Against the crank-slider alone for the one that its motor turns through a gear pair, or against sums over all turns."""

from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators import period_presses
from support.generators.frames import uneven
from support.generators.period_presses import TURNS
from support.in_browser import data_in
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress import foundation
from pinpress.balancing.classical import compare_harmonics
from pinpress.cli.main import main
from pinpress.kinematics import measures
from pinpress.kinematics.described import along_motion
from pinpress.plots.loci import _quarters
from pinpress.ratings import Capacities, rate
from pinpress.synthesis import synthesise

SPEED = 31.0
LATER = ("geared_down", "third", "one_and_a_half")  # as the first
CAM = """<link name="cam"><inertial><origin xyz="{0} 0 0"/><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
    </inertial></link><joint name="G" type="continuous"><parent link="frame"/><child link="cam"/><origin xyz="0.6 0 0"/>
    <axis xyz="0 -1 0"/><mimic joint="O" multiplier="0.5"/></joint></robot>"""


@pytest.fixture(scope="module", params=rest_exhaustive(("half", *LATER), "half"))
def name(request):
    return request.param


@pytest.fixture(scope="module")
def press(name):
    return period_presses.repeating(name)


@pytest.fixture(scope="module")
def driven():
    return period_presses.geared_down()


@pytest.fixture(scope="module")
def alone():
    return texts.shipped("crank_slide")


def cam_shaft(eccentricity):
    """The crank-slider with a shaft on no loop that turns half as fast."""
    return texts.load(texts.shipped("crank_slide").text.decode().replace("</robot>", CAM.format(eccentricity)))


# Mounts


def test_moving_mass_is_the_mean_over_all_turns(press, name):
    system = foundation.mounted(press, *uneven())
    states = 200 * TURNS[name]
    motion = pp.servo_cycle(press, speed=SPEED, angle=2 * np.pi * TURNS[name] * np.arange(states) / states)
    data, mean = press.model.createData(), np.zeros((6, 6))
    for q in motion.q:
        pin.forwardKinematics(press.model, data, q)
        mean += sum(place.act(body).matrix() for place, body in zip(data.oMi, press.model.inertias, strict=True)) / states
    np.testing.assert_allclose(system.press_inertia, mean, atol=1e-11 * np.abs(mean).max())


def test_vibration_of_a_press_that_is_geared_down(driven, alone):
    points = {"top": (0.3, 0.2, 1.5)}
    systems = [foundation.mounted(each, *uneven()) for each in (driven, alone)]
    results = [pp.inverse_dynamics(each, pp.cycle(each, speed, points=540)) for each, speed in ((driven, 3 * 20.0), (alone, 20.0))]
    mine, theirs = (foundation.steady_response(*each, points=points) for each in zip(systems, results, strict=True))
    assert abs(mine.period / theirs.period - 1) < 1e-14
    size = np.abs(theirs.acceleration["top"]).max()
    np.testing.assert_allclose(mine.acceleration["top"], theirs.acceleration["top"], atol=1e-8 * size)
    fast, slow = (
        foundation.over_speeds(system, k * np.array([10.0, 20.0]), points=points) for system, k in zip(systems, (3, 1), strict=True)
    )
    np.testing.assert_allclose(fast.rms["top"], slow.rms["top"], rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(fast.peak["top"], slow.peak["top"], rtol=1e-3, atol=1e-9)  # of other states
    np.testing.assert_allclose(fast.shaking_force, slow.shaking_force, rtol=1e-7)
    np.testing.assert_allclose(fast.floor_force, slow.floor_force, rtol=1e-7)


def test_vibration_over_all_turns(press):
    """The frame's response at one speed among several is the steady response at this speed, which has half and third orders in it."""
    points = {"top": (0.3, 0.2, 1.5)}
    system = foundation.mounted(press, *uneven())
    response = foundation.steady_response(system, pp.inverse_dynamics(press, pp.cycle(press, SPEED)), points=points)
    assert abs(response.period - 2 * np.pi * press.period_turns / SPEED) < 1e-14
    some = foundation.over_speeds(system, [0.5 * SPEED, SPEED], points=points)
    np.testing.assert_allclose(some.rms["top"][1], response.rms("top"), rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(some.peak["top"][1], np.abs(response.acceleration["top"]).max(axis=0), rtol=1e-7, atol=1e-12)
    one_turn = pp.inverse_dynamics(press, pp.servo_cycle(press, speed=SPEED, angle=np.radians(np.arange(360.0))))
    with pytest.raises(pp.PinpressError, match="no period"):
        foundation.steady_response(system, one_turn, points=points)


@pytest.mark.parametrize("name", ["half", "geared_down"])
def test_vibration_of_a_run_that_is_steady(name):
    press = period_presses.repeating(name)
    drive = pp.drives.InductionMotor(5e3, 40.0, poles=14)
    loads = [pp.loads.ConstantForce(2e3, 0.02)]
    run = pp.steady_state(press, 39.5, drive=drive, flywheel=pp.drives.Flywheel(30.0), loads=loads, points=721)
    assert abs(abs(run.crank_angle[-1] - run.crank_angle[0]) - 2 * np.pi * TURNS[name]) < 1e-9
    system = foundation.mounted(press, *uneven())
    response = foundation.steady_response(system, pp.inverse_dynamics(press, run, loads), points={"top": (0.3, 0.2, 1.5)})
    assert response.period == run.time[-1]


# Runs


def test_strokes_are_periods(press, name):
    run = pp.simulate(
        press, 1.7, speed=SPEED, drive=pp.drives.InductionMotor(5e3, 40.0, poles=14), flywheel=pp.drives.Flywheel(30.0), points=20_001
    )
    strokes = pp.measures.stroke_duties(run)
    assert len(strokes) == int((run.crank_angle[-1] - run.crank_angle[0]) / (2 * np.pi * TURNS[name])) > 1
    for k, stroke in enumerate(strokes):
        for time, turns in ((stroke.start, k * TURNS[name]), (stroke.start + stroke.duration, (k + 1) * TURNS[name])):
            assert abs(np.interp(time, run.time, run.crank_angle) - 2 * np.pi * turns) < 1e-6
        during = (run.time >= stroke.start) & (run.time <= stroke.start + stroke.duration)
        assert abs(stroke.lowest_speed / run.crank_speed[during].min() - 1) < 1e-4
        assert abs(stroke.highest_speed / run.crank_speed[during].max() - 1) < 1e-4
    assert len(pp.measures.stroke_duties(pp.simulate(press, 1.0, speed=0.5, flywheel=pp.drives.Flywheel(1e4)))) == 0


# A slide that is back before other links


@pytest.fixture(scope="module")
def with_cam():
    """The textbook crank-slider; an unbalanced shaft beside it turns half as fast."""
    return cam_shaft(0.1)


def test_measures_of_a_slide_that_is_back_before_other_links(with_cam, alone):
    assert (with_cam.period_turns, pp.dead_centres(with_cam).turns) == (2, 1)
    mine, theirs = pp.cycle(with_cam, SPEED), pp.cycle(alone, SPEED)
    asked = [(each,) for each in (measures.stroke, measures.quick_return_ratio, measures.speed_ratio)]
    asked += [(measures.speed_variation, 0.05), (measures.speed_at, 0.02), (measures.mechanical_advantage, 0.02)]
    for measure, *given in (*asked, (measures.dwell_angle, 0.001), (measures.dwell_time, 0.001)):
        assert measure(mine, *given) == pytest.approx(measure(theirs, *given), rel=1e-9)
    run = pp.simulate(with_cam, 1.0, speed=SPEED, flywheel=pp.drives.Flywheel(50.0))
    assert len(pp.measures.stroke_duties(run)) == int(run.crank_angle[-1] / (2 * np.pi)) > 3


@pytest.mark.exhaustive
@pytest.mark.parametrize("speed", [SPEED, -SPEED])
def test_ratings_of_a_slide_that_is_back_before_other_links(with_cam, alone, speed):
    """The process force alone does not know of the shaft; at speed the worse of two strokes counts."""
    capacities = Capacities(1e5, torque=900.0, motor_power=1e3)
    mine, theirs = rate(with_cam, speed, capacities), rate(alone, speed, capacities)
    np.testing.assert_allclose(mine.crank_angle, theirs.crank_angle, atol=1e-9)
    np.testing.assert_allclose(mine.force, theirs.force, rtol=1e-9)
    assert mine.energies == pytest.approx(theirs.energies, rel=1e-14)
    assert str(mine).splitlines()[0].split(",")[1] == str(theirs).splitlines()[0].split(",")[1]  # strokes/min
    assert mine.speed_limit.strokes_per_minute == pytest.approx(mine.speed_limit.speed / pp.RPM)
    found = rate(with_cam, speed, capacities, at_speed=True, points=19)
    needed = np.abs(found.travel_per_angle)
    signs = np.sign(speed)
    idle = [
        pp.inverse_dynamics(with_cam, pp.servo_cycle(with_cam, speed=speed, angle=found.crank_angle + turn)).driving_torque
        for turn in (0, 2 * np.pi)
    ]
    assert np.abs(idle[1] - idle[0]).max() > 1.0
    with np.errstate(divide="ignore"):
        permitted = [(900.0 - signs * torque) / needed for torque in idle]  # the process force asks for torque the way that the crank turns
    np.testing.assert_allclose(found.limits["torque"], np.minimum(np.minimum(*permitted), 1e5), rtol=1e-7)


def test_bottom_dead_centre_that_each_stroke_moves_otherwise_is_refused(with_cam):
    with pytest.raises(pp.PinpressError, match="repeats its motion after 1 turns, other links only after 2"):
        pp.elasticity.dead_centre_shift(with_cam, pp.elasticity.Stiffness({"W": 1e9}), speed=[SPEED])


# Pictures


def test_a_recording_is_closed_after_the_period(press, name, tmp_path):
    turns = TURNS[name]
    data = data_in(pp.record(press, pp.cycle(press, SPEED, points=24 * turns), tmp_path / "whole.html"))
    assert len(data["time"]) == data["turn"] == 24 * turns + 1
    assert data["period"] == 360 * turns
    assert abs(data["crank"][-1] - 360 * turns) < 1e-6
    assert abs(data["height"][-1] - data["height"][0]) < 1e-9
    one_turn = pp.servo_cycle(press, speed=SPEED, angle=2 * np.pi * np.arange(24) / 24)
    assert len(data_in(pp.record(press, one_turn, tmp_path / "part.html"))["time"]) == 24  # the next turn is another one
    longer = pp.servo_cycle(press, speed=SPEED, angle=2 * np.pi * np.arange(48 * turns + 1) / 24)
    assert data_in(pp.record(press, longer, tmp_path / "longer.html"))["turn"] == 24 * turns + 1  # paths are drawn once


def test_a_balanced_shaft_does_not_count_but_is_seen(tmp_path):
    """One turn is a period of motion and forces; a picture of it does not come back before the shaft."""
    press = cam_shaft(0.0)
    assert press.period_turns == 1
    one, two = pp.cycle(press, SPEED, points=24), pp.servo_cycle(press, speed=SPEED, angle=2 * np.pi * np.arange(48) / 24)
    torque = pp.inverse_dynamics(press, two).driving_torque
    np.testing.assert_allclose(torque[24:], torque[:24], atol=1e-10)
    assert len(data_in(pp.record(press, one, tmp_path / "one.html"))["time"]) == 24


def test_plots_over_the_period(press, name):
    turns = TURNS[name]
    for way in (1.0, -1.0):
        motion = pp.cycle(press, way * SPEED)
        over = along_motion(motion)
        assert over.quantity == "rad"
        assert over.period == pytest.approx(way * 2 * np.pi * turns)
        marked = _quarters(motion)
        assert [degrees for degrees, _ in marked] == list(range(0, 360 * turns, 90))
        np.testing.assert_allclose([motion.shown_position[state] for _, state in marked], [degrees for degrees, _ in marked], atol=1e-9)
    run = pp.servo_cycle(press, speed=SPEED, angle=np.radians(np.arange(360 * turns + 50.0)))
    assert along_motion(run).quantity == "s"  # more than a period
    assert {state for _, state in _quarters(run)} <= set(range(50, 360 * turns + 50))  # of the last one


@pytest.mark.exhaustive
def test_bars_of_fractional_orders(press, name):
    figure = pp.plots.draw(pp.inverse_dynamics(press, pp.cycle(press, SPEED)), "shaking", "harmonics")
    bars: list[Any] = list(figure.axes[1].patches)
    found = pp.measures.harmonics(pp.cycle(press, SPEED), pp.inverse_dynamics(press, pp.cycle(press, SPEED)).shaking_force)
    assert len(bars) == 2 * (len(found.orders) - 1)
    middles = sorted(bar.get_x() + 0.5 * bar.get_width() for bar in bars)
    np.testing.assert_allclose(np.mean(np.reshape(middles, (-1, 2)), axis=1), found.orders[1:], atol=1e-12)
    assert middles[2] - middles[1] > max(bar.get_width() for bar in bars) * (1 - 1e-9)  # they do not overlap
    assert list(figure.axes[1].get_xticks()) == list(range(1, 13))


@pytest.mark.exhaustive
def test_a_report_beside_a_press_with_another_period(press, alone, tmp_path):
    mine, theirs = (pp.inverse_dynamics(each, pp.cycle(each, SPEED)) for each in (press, alone))
    for first, second in ((mine, theirs), (theirs, mine)):
        page = pp.report(first._press, first.motion, tmp_path / "report.html", reactions=first, before=second)
        blocks = (block for section in data_in(page)["report"]["sections"] for block in section["blocks"])
        (drawn,) = (block for block in blocks if block.get("title") == "Harmonics of the shaking force")
        assert drawn["places"] == pytest.approx(sorted({*pp.measures.harmonics(mine.motion, mine.shaking_force).orders[1:], *range(1, 13)}))
        for shown, result in ((drawn["bars"], first), (drawn["before"], second)):
            found = pp.measures.harmonics(result.motion, result.shaking_force)
            known = dict(zip(found.orders, found.amplitude[:, 2], strict=True))
            scale = max(shown["z"]) / found.amplitude[1:, 2].max()
            np.testing.assert_allclose(
                shown["z"], [scale * known.get(order, 0.0) for order in drawn["places"]], atol=1e-9 * max(shown["z"])
            )


def test_a_balanced_shaft_that_carries_another_counts():
    """What it carries goes round with it."""
    carried = (
        '<link name="planet"><inertial><mass value="3"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
        '<joint name="H" type="continuous"><parent link="cam"/><child link="planet"/><origin xyz="0.2 0 0"/><axis xyz="0 -1 0"/>'
        '<mimic joint="O"/></joint></robot>'
    )
    press = texts.load(cam_shaft(0.0).text.decode().replace("</robot>", carried))
    assert press.period_turns == 2
    motion = pp.cycle(press, SPEED)
    torque = pp.inverse_dynamics(press, motion).driving_torque
    assert np.abs(torque[360:] - torque[:360]).max() > 1.0


# Designs


def test_what_an_arrangement_does_to_fractional_orders(press, name):
    before = pp.inverse_dynamics(press, pp.cycle(press, SPEED))
    heavier = press.with_inertias([pin.Inertia(2 * body.mass, body.lever, 2 * body.inertia) for body in press.model.inertias])
    after = pp.inverse_dynamics(heavier, pp.cycle(heavier, SPEED))
    found = pp.measures.harmonics(before.motion, before.shaking_force, orders=6)
    vertical = [change for change in compare_harmonics(before, after) if change.quantity == "force along the slide"]
    assert [change.order for change in vertical] == pytest.approx(list(found.orders[1:]))
    np.testing.assert_allclose([change.before for change in vertical], found.amplitude[1:, 2], rtol=1e-9, atol=1e-8)
    np.testing.assert_allclose([change.after for change in vertical], 2 * found.amplitude[1:, 2], rtol=1e-9, atol=1e-8)
    if press.name == "geared_five_bar":
        assert max(change.before for change in vertical if change.order % 1) > 1.0


@pytest.mark.exhaustive
def test_synthesis_judges_all_turns():
    """The largest stroke of the slide's rod length within bounds is that of brute force at the bounds, over both turns."""
    press = period_presses.repeating("half")
    found = synthesise(
        press, {"P.frame.z": (-0.02, 0.0, 0.02)}, minimise=lambda trial: -measures.stroke(trial.motion), speed=SPEED, points=360
    )
    strokes = [pp.dead_centres(pp.derivatives.reshaped(press, {("P", "frame"): np.array([0.15, 0.0, z])})).stroke for z in (-0.02, 0.02)]
    assert found.value == pytest.approx(-max(strokes), rel=1e-6)
    assert pp.dead_centres(found.press).stroke == pytest.approx(max(strokes), rel=1e-6)
    assert found.press.period_turns == 2


def test_a_counterweight_that_is_back_later_is_refused_on_a_motion_that_is_shorter():
    """Over one turn it could seem to do good, and harm in the next; over two turns it does no good, and stays away."""
    press = cam_shaft(0.0)
    regions = [pp.balancing.CounterweightRegion("cam", (0.0, 50.0), radius=0.2)]
    with pytest.raises(pp.PinpressError, match=r"counterweight on a geared shaft .* only after 2 turns"):
        pp.balancing.balance(press, pp.cycle(press, SPEED, points=90), regions=regions, minimise=pp.balancing.Range("shaking_force", "x"))
    both = pp.servo_cycle(press, speed=SPEED, angle=2 * np.pi * np.arange(180) / 90)
    result = pp.balancing.balance(
        press,
        both,
        regions=[*regions, pp.balancing.CounterweightRegion("crank", (0.0, 50.0), radius=0.2)],
        minimise=pp.balancing.Range("shaking_force", "x"),
    )
    assert result.reactions_after[0].motion.period_turns == result.press.period_turns
    given = pp.balancing.balance(
        press,
        both,
        regions=[pp.balancing.CounterweightRegion("cam", (5.0, 5.0), at=(0.1, 0.0, 0.0))],
        minimise=pp.balancing.Range("shaking_force", "x"),
    )
    assert given.reactions_after[0].motion.period_turns == given.press.period_turns == 2


# Commands


@pytest.mark.exhaustive
def test_commands(press, name, tmp_path, capsys):
    file = str(texts.file(press.text.decode()))
    assert main(["analyse", file, "--speed", "60r/min", "--out", str(tmp_path / "out")]) == 0
    assert f"{720 * TURNS[name]} crank angles" in capsys.readouterr().out
    assert len((tmp_path / "out" / "cycle.csv").read_text().splitlines()) == 720 * TURNS[name] + 1
    assert main(["record", file, "--speed", "60r/min", "--out", str(tmp_path / "press.html"), "--no-forces"]) == 0
    assert len(data_in(tmp_path / "press.html")["time"]) == 360 * TURNS[name] + 1


@pytest.mark.parametrize(
    ("degrees", "speed", "name", "time"),
    [(400, 60, "crank_slide", 1 / 9), (400, 60, "half", 10 / 9), (-10, 60, "third", 3 - 1 / 36), (-400, -120, "half", 5 / 9)],
)
def test_time_of_a_picture(degrees, speed, name, time, tmp_path, monkeypatch):
    """A picture at an angle is that of the instant in the recording, which is one period, at which the crank stands there."""
    file = str(texts.file(period_presses.repeating(name).text.decode())) if name in TURNS else name
    times = []
    monkeypatch.setattr("pinpress.visual.film.image", lambda page, path, time: times.append(time))
    words = ["--speed", f"{speed}r/min", "--at", f"{degrees}deg", "--no-forces"]
    assert main(["record", file, "--png", str(tmp_path / "press.png"), *words]) == 0
    assert times == [pytest.approx(time, rel=1e-9)]


# No period


@pytest.mark.exhaustive
def test_a_linkage_that_is_never_back_has_no_dead_centres():
    press = period_presses.five_bar(0.5**0.5)
    for ask in (pp.dead_centres, lambda press: pp.cycle(press, SPEED), lambda press: press.period_turns):
        with pytest.raises(pp.PinpressError, match="not back at its drawn pose after 128 turns"):
            ask(press)
    with pytest.raises(pp.PinpressError, match="the linkage of the motion has no period after which all is where it was"):
        pp.measures.stroke(pp.servo_cycle(press, speed=1.0, angle=np.arange(360) * (2 * np.pi / 360)))
    some = pp.servo_cycle(press, speed=SPEED, angle=np.linspace(0.0, 20.0, 50))
    assert some.period_turns is None
    np.testing.assert_allclose(some.shown_position, np.degrees(some.crank_angle))


@pytest.mark.exhaustive
def test_a_linkage_that_locks_after_more_than_a_turn_has_no_cycle():
    """With short rods it turns 439 degrees backwards and locks: the turn that it makes is not said to be all."""
    links = "".join(period_presses.LINK.format(*link, 0.02) for link in period_presses.LINKS)
    text = period_presses.FIVE_BAR.format(links=links, ratio="0.5")
    press = texts.load(text.replace("-0.35", "-0.15").replace("-0.28", "-0.08").replace("-0.65", "-0.45"))
    assert press.branch.angles[0] < -2 * np.pi
    assert pp.servo_cycle(press, speed=-SPEED, angle=-np.linspace(0.0, 7.0, 20)).period_turns is None
    for ask in (pp.dead_centres, lambda press: pp.cycle(press, SPEED), lambda press: pp.cycle(press, -SPEED)):
        with pytest.raises(pp.SingularityError, match="the linkage locks"):
            ask(press)
