"""Random scenes solved by every method that takes them: a difference that nobody announces is an error.

    python tests/support/second_opinion.py [--scenes 1000] [--seed 0]
        [--kind runs couplings starts batches steady engines machines cuts written]

A refusal announces, and so does a warning that a run is not determined. Runs are also judged by themselves: their first state, how far the
crank moves between states, inverse dynamics of their motion, and energies by Pinocchio.
"""

# ruff: noqa: T201
import argparse
import contextlib
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # `support`

import numpy as np
import pinocchio as pin
from support.generators import random_linkages, random_scenes, same_linkage
from support.generators.random_scenes import Scene
from support.generators.same_linkage import Same

import pinpress as pp

AGREED = 1e-6  # of an angle of 1 rad, of the largest speed
REFERENCE = 1e-9  # tolerance of the methods that judge the default one
BATCHED = 1e-8  # of a batch, whose runs are solved to 1e-11
FORCES = 1e-9  # of the largest force
FINE = 1e-12  # theirs where errors grow
STATES = 121
DOUBTS = ("not determined to its tolerance", "unstable equilibrium")
"""Warnings that say that another method may end elsewhere."""


@dataclass(frozen=True)
class Verdict:
    """What methods said of a scene. word: agree, announced, refused (all), partly (some refuse), disagree."""

    word: str
    detail: str = ""


def heard(call: Callable[[], Any]) -> tuple[Any, str, bool]:
    """Result or None, the refusal, and whether a warning doubts the result."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            result, refusal = call(), ""
        except pp.PinpressError as error:
            result, refusal = None, str(error)
    return result, refusal, any(doubt in str(warning.message) for warning in caught for doubt in DOUBTS)


def of_run(scene: Scene) -> Verdict:
    """By the default method, and by "implicit" and "constraint" at a tolerance of 1e-9, or 1e-12 where these differ."""
    verdict, detail = _of_run(scene, REFERENCE)
    if verdict in ("disagree", "partly"):  # errors of a start or step may grow: then a smaller tolerance brings methods together
        verdict, detail = _of_run(scene, FINE)
    return Verdict(verdict, detail)


def _of_run(scene: Scene, tolerance: float) -> tuple[str, str]:
    methods = {"auto": {}, "implicit": {"tolerance": tolerance}, "constraint": {"tolerance": tolerance}}
    if "friction" in scene.given or scene.press.loses_power or scene.press.structure.curves:
        del methods["constraint"]  # which knows neither friction nor cams
    runs, refusals, doubted = {}, {}, False
    for method, options in methods.items():
        if any("the linkage locks" in said or "where its limits are" in said for said in refusals.values()):
            break  # all joints go on through a lock, which is said
        run, refusal, doubt = heard(
            lambda method=method, options=options: pp.simulate(
                scene.press, scene.duration, method=method, points=STATES, **options, **scene.given
            )
        )
        doubted |= doubt
        if run is None:
            if "simulate it with method=" not in refusal:  # else this method does not take the scene, and says which does
                refusals[method] = refusal
        else:
            runs[method] = run
    signs = {method: sign for method, run in runs.items() if (sign := sign_of_fault(scene, run))}
    if signs:
        return "disagree", str(signs)
    apart = max((difference(one, other) for one in runs.values() for other in runs.values()), default=0.0)
    if apart > AGREED:
        ends = {method: (float(run.crank_angle[-1]), float(run.crank_speed[-1])) for method, run in runs.items()}
        return "announced" if doubted else "disagree", f"apart {apart:.3g}: {ends} {refusals}"
    if not runs:
        return "refused", str(refusals)
    return ("partly", f"{sorted(runs)} end, {refusals}") if refusals else ("agree", "")


def difference(one: Any, other: Any) -> float:
    """Largest difference of two runs: of the angle by 1 rad or its travel, of the speed by the largest."""
    angle = np.abs(one.crank_angle - other.crank_angle).max() / max(1.0, np.ptp(one.crank_angle))
    return float(max(angle, np.abs(one.crank_speed - other.crank_speed).max() / max(np.abs(one.crank_speed).max(), 1e-6)))


def sign_of_fault(scene: Scene, run: Any) -> str:
    """What is wrong with a run by itself, as text; its energies by Pinocchio."""
    asked = scene.given["angle"], scene.given["speed"]
    first = float(run.crank_angle[0]), float(run.crank_speed[0])
    if np.abs(np.subtract(first, asked)).max() > 1e-9 * (1 + max(map(abs, asked))):
        return f"begins at {first} instead of {asked}"
    between = run.trajectory.at(np.linspace(0.0, scene.duration, 20 * STATES)).speed
    fastest = np.abs(between[scene.press.joints.index(scene.press.driver) if len(between) > 1 else 0]).max()
    paces = np.abs(np.diff(run.crank_angle)) / np.diff(run.time)
    if paces.max() > 1.01 * fastest + 1e-9:
        return f"moves {paces.max():.6g} rad/s from state to state, at speeds of at most {fastest:.6g} rad/s"
    if (missing := missing_torque(scene, run)) > 1e-6:
        return f"torques of inverse dynamics differ by a share of {missing:.3g}"
    return beyond_its_drive(scene, run)


def missing_torque(scene: Scene, run: Any) -> float:
    """The share of the torque which drive and couplings do not have that inverse dynamics asks for, in most states of the motion."""
    drive, wheel = scene.given.get("drive"), scene.given.get("flywheel")
    if {"clutch", "brake"} & scene.given.keys() or any(isinstance(load, pp.loads.ElasticDie) for load in scene.given.get("loads", ())):
        return 0.0  # what they transmit is no column
    acting, rubbing = scene.given.get("loads", ()), scene.given.get("friction", {})
    needed = pp.inverse_dynamics(scene.press, run, acting, rubbing, bearings=()).driving_torque
    turned = sum(part.inertia for part in (drive, wheel) if part is not None) * run.crank_acceleration
    weights = 1e-3 * pin.computeTotalMass(scene.press.model) * 9.81 * scene.press.size
    size = weights + max(np.abs(torque).max() for torque in (needed, turned, run.drive_torque))
    moving = np.abs(run.crank_speed) > 1e-3 * np.abs(run.crank_speed).max()
    return float(np.quantile(np.abs(needed + turned - run.drive_torque)[moving] / size, 0.9)) if moving.any() else 0.0


def beyond_its_drive(scene: Scene, run: Any) -> str:
    """More energy than the start and the drive at its synchronous or no-load speed have, where nothing else gives any."""
    drive, wheel = scene.given.get("drive"), scene.given.get("flywheel")
    motor = getattr(drive, "drive", drive)
    givers = (
        pp.loads.ConstantForce,  # acts both ways
        pp.loads.PointForce,
        pp.loads.SpringDamper,
        pp.loads.PneumaticCushion,
        pp.loads.HydraulicCushion,
        pp.loads.ElasticDie,
        pp.loads.Impact,
    )
    if "clutch" in scene.given or any(isinstance(load, givers) for load in scene.given.get("loads", ())):
        return ""
    free = {pp.drives.InductionMotor: 50 * np.pi, random_scenes.DirectCurrent: getattr(motor, "free", 0.0)}.get(type(motor), 0.0)
    if drive is not None and not free:
        return ""
    model = scene.press.model
    data = model.createData()
    kinetic = np.array([pin.computeKineticEnergy(model, data, q, v) for q, v in zip(run.q, run.v, strict=True)])
    potential = np.array([pin.computePotentialEnergy(model, data, q) for q in run.q])
    inertia = sum(part.inertia for part in (drive, wheel) if part is not None)
    own = np.divide(2 * kinetic, run.crank_speed**2, out=np.zeros_like(kinetic), where=run.crank_speed != 0).max()
    total = kinetic + 0.5 * inertia * run.crank_speed**2 + potential
    free_speed = free / drive.ratio if drive is not None else 0.0
    most = max(total[0], 0.5 * (own + inertia) * free_speed**2 + potential.max())
    if total.max() > most + 1e-6 * (abs(most) + np.ptp(potential)):
        return f"energy rises to {total.max():.6g} J, and nothing gives more than {most:.6g} J"
    return ""


def of_batch(scene: Scene) -> Verdict:
    """Four scenarios of speed, flywheel and torque at once, and one by one, at the tolerance that both have by default."""
    given, spread = dict(scene.given), np.array([0.7, 0.9, 1.0, 1.3])
    given["speed"] = given["speed"] * spread[::-1]
    if "flywheel" in given:
        given["flywheel"] = replace(given["flywheel"], inertia=given["flywheel"].inertia * spread)
    batch, refusal, doubted = heard(lambda: pp.simulate_batch(scene.press, scene.duration, points=STATES, **given))
    words, details = [], []
    for k in range(len(spread)):
        alone = {**given, "speed": float(given["speed"][k])}
        if "flywheel" in given:
            alone["flywheel"] = replace(given["flywheel"], inertia=float(given["flywheel"].inertia[k]))
        run, said, doubt = heard(lambda alone=alone: pp.simulate(scene.press, scene.duration, points=STATES, **alone))
        error = refusal if batch is None else str(batch.errors[k] or "")
        if bool(error) != (run is None):
            words.append("partly")
            details.append(f"{k}: together {error or 'ends'}, alone {said or 'ends'}")
        elif run is None:
            words.append("refused")
        else:
            column = Column(batch.crank_angle[:, k], batch.crank_speed[:, k])
            apart = difference(run, column)
            words.append("agree" if apart <= BATCHED else "announced" if doubt or doubted else "disagree")
            details += [f"{k}: {apart:.3g}"] if apart > BATCHED else []
    return Verdict(max(words, key=WORDS.index), "; ".join(details))


@dataclass(frozen=True)
class Column:
    crank_angle: Any
    crank_speed: Any


def of_steady_state(scene: Scene) -> Verdict:
    """The period that is said to repeat itself, run over time by "implicit" from its first state, comes back."""
    parts = {name: scene.given[name] for name in ("drive", "flywheel", "loads", "friction") if name in scene.given}
    angle, speed = scene.given["angle"], free_speed(scene)
    steady, refusal, _ = heard(lambda: pp.steady_state(scene.press, speed, angle=angle, points=STATES, **parts))
    if steady is None:
        return Verdict("refused", refusal)
    period, first = float(steady.time[-1]), float(steady.crank_speed[0])
    run, refusal, doubted = heard(
        lambda: pp.simulate(scene.press, period, angle=angle, speed=first, method="implicit", tolerance=REFERENCE, points=STATES, **parts)
    )
    if run is None:
        return Verdict("partly", f"the steady state of {period:.6g} s from {first:.6g} rad/s, run over time: {refusal}")
    apart = difference(steady, run)
    if apart > AGREED:
        return Verdict("announced" if doubted else "disagree", f"one period is {apart:.3g} apart from {first:.6g} rad/s")
    if steady.trajectory.turns < 0.9:
        return Verdict("disagree", "it makes no turn")
    return Verdict("agree")


def free_speed(scene: Scene) -> float:
    """The largest speed that the drive turns the press at [rad/s], a little less."""
    drive = scene.given["drive"]
    speeds = np.linspace(0.05, 1.5, 60) * random_scenes.turning_speed(drive)
    driving = [speed for speed in map(float, speeds) if float(drive.torque(speed)) * speed > 0]
    return 0.97 * driving[-1] if driving else float(speeds[-1])


def of_engines(scene: Scene) -> Verdict:
    """All forces of random states by every engine, and of the linkage written in other ways: turned, mirrored, with other names."""
    press, given = scene.press, dict(scene.given)
    acting, friction = given.pop("loads"), given.pop("friction")
    results, refusals = {}, {}
    for engine in press.engines:
        result, refusal, _ = heard(
            lambda engine=engine: pp.inverse_dynamics(press, pp.servo_cycle(press, **given, engine=engine), acting, friction, engine=engine)
        )
        if result is None:
            refusals[engine] = refusal
        else:
            results[engine] = result
    if refusals:
        return Verdict("partly" if results else "refused", str(refusals))
    first = next(iter(results.values()))
    apart = {engine: worst_force(press, first, other) for engine, other in results.items() if other is not first}
    random = np.random.default_rng(scene.seed)
    for way in same_linkage.WAYS:
        same = way(press, random)
        other, refusal, _ = heard(lambda same=same: in_other(same, given, acting, friction))
        if other is None:
            return Verdict("partly", f"{way.__name__}: {refusal}")
        apart[way.__name__] = worst_force(press, first, other, same)
    worst = {name: share for name, share in apart.items() if not share <= FORCES}
    return Verdict("disagree" if worst else "agree", str(worst))


def in_other(same: Same, given: dict[str, Any], acting: Any, friction: Any) -> Any:
    """The forces of the same states of the same linkage."""
    press = same.press
    states = {name: values * same.sense for name, values in given.items()}
    named = {same.names.get(name, name): law for name, law in friction.items()}
    return pp.inverse_dynamics(press, pp.servo_cycle(press, **states), [load_in_other(same, load) for load in acting], named)


def load_in_other(same: Same, load: Any) -> Any:
    """A load on the same linkage: points of links are in their own axes, which a mirror alone turns, but the frame's world axes turn."""
    own = same.vectors if np.linalg.det(same.vectors) < 0 else np.eye(3)
    if isinstance(load, pp.loads.PointForce):
        point = tuple(map(float, own @ load.point))
        return replace(load, link=same.names.get(load.link, load.link), force=tuple(map(float, same.vectors @ load.force)), point=point)
    if isinstance(load, pp.loads.SpringDamper):
        ends = (tuple(map(float, own @ point)) for point in (load.point1, load.point2))
        return replace(
            load,
            **dict(
                zip(("link1", "link2", "point1", "point2"), (*(same.names.get(n, n) for n in (load.link1, load.link2)), *ends), strict=True)
            ),
        )
    return load


def worst_force(press: Any, one: Any, other: Any, same: Same | None = None) -> float:
    """Largest difference of two results, as a share of the largest force, or of that on an arm as long as the press."""
    same = same or Same(press)
    force, moment = random_linkages.peaks(press, one)
    force = max(force, 1e-3 * 9.81 * pin.computeTotalMass(press.model))
    moment = max(moment, force * press.size)
    forces = [(one.shaking_force @ same.vectors.T, other.shaking_force)]
    moments = [(same.moments(one.shaking_moment), other.shaking_moment), (same.sense * one.driving_torque, other.driving_torque)]
    for name in (*press.bearings, *(contact.name for contact in press.contacts if contact.name)):
        new = same.names.get(name, name)
        forces.append((one.bearing_force[name] @ same.vectors.T, other.bearing_force[new]))
        moments.append((same.moments(one.bearing_moment[name]), other.bearing_moment[new]))
    return max(max(np.abs(a - b).max() for a, b in pairs) / size for pairs, size in ((forces, force), (moments, moment)))


def of_cut(scene: Scene) -> Verdict:
    """Forces in the plane and the torque of a linkage whose loops are cut in two ways. (Pins that close loops carry no moments across.)"""
    given = dict(scene.given)
    other, normal = given.pop("other"), given.pop("normal")
    one, two = (pp.inverse_dynamics(press, pp.servo_cycle(press, **given)) for press in (scene.press, other))
    force, moment = random_linkages.peaks(scene.press, one)
    flat = np.eye(3) - np.outer(normal, normal)
    apart = [np.abs(one.driving_torque - two.driving_torque).max() / moment]
    apart += [np.abs((one.shaking_force - two.shaking_force) @ flat).max() / force]
    apart += [np.abs((one.shaking_moment - two.shaking_moment) @ normal).max() / moment]
    for name in scene.press.bearings:  # the sign is that of the link to which the force is given
        mine, its = one.bearing_force[name] @ flat, two.bearing_force[name] @ flat
        apart.append(min(np.abs(mine - its).max(), np.abs(mine + its).max()) / force)
    return Verdict("agree" if max(apart) <= FORCES else "disagree", f"{max(apart):.3g}")


def of_same_run(scene: Scene) -> Verdict:
    """The default run of a press, and of the same press written in other ways."""
    one, refusal, doubted = heard(lambda: pp.simulate(scene.press, scene.duration, points=STATES, **scene.given))
    random = np.random.default_rng(scene.seed)
    words, details = ["refused" if one is None else "agree"], []
    for way in same_linkage.WAYS:
        same = way(scene.press, random)
        given = {name: in_other_words(same, name, part) for name, part in scene.given.items()}
        other, said, doubt = heard(lambda same=same, given=given: pp.simulate(same.press, scene.duration, points=STATES, **given))
        if (one is None) != (other is None):
            words.append("partly")
            details.append(f"{way.__name__}: {said or 'ends'}, as written: {refusal or 'ends'}")
        elif one is not None:
            apart = difference(one, Column(same.sense * other.crank_angle, same.sense * other.crank_speed))
            if apart > AGREED:
                words.append("announced" if doubted or doubt else "disagree")
                details.append(f"{way.__name__}: {apart:.3g}")
    return Verdict(max(words, key=WORDS.index), "; ".join(details))


def in_other_words(same: Same, name: str, part: Any) -> Any:
    """What is given to a run of the same linkage."""
    if name in ("angle", "speed"):
        return same.sense * part
    if name == "loads":
        return [load_in_other(same, load) for load in part]
    if name == "friction":
        return {same.names.get(bearing, bearing): law for bearing, law in part.items()}
    if same.sense > 0:
        return part
    if name == "drive":
        return pp.drives.Geared(part, -1.0) if not isinstance(part, pp.drives.Geared) else replace(part, ratio=-part.ratio)
    if name == "flywheel":
        return replace(part, speed=None if part.speed is None else -part.speed)
    points = {end: point for end in ("closes", "opens") if (point := getattr(part, end)) is not None and point.angle is not None}
    return replace(part, **{end: replace(point, angle=-point.angle) for end, point in points.items()})


WORDS = ("agree", "refused", "announced", "partly", "disagree")
KINDS = {
    "runs": (random_scenes.scene, of_run),
    "couplings": (random_scenes.coupled, of_run),
    "starts": (random_scenes.started, of_run),
    "batches": (random_scenes.batch, of_batch),
    "steady": (random_scenes.steady, of_steady_state),
    "engines": (random_scenes.states, of_engines),
    "machines": (random_scenes.machine, of_run),
    "cuts": (random_scenes.cut, of_cut),
    "written": (random_scenes.scene, of_same_run),
}


def opinions(kind: str, seeds: Iterable[int], tell: Callable[[str], None] = lambda text: None) -> Iterator[Verdict]:
    """A verdict a seed; what is no agreement is told."""
    draw, judge = KINDS[kind]
    for seed in seeds:
        scene, refusal, _ = heard(lambda seed=seed: draw(seed))
        verdict = Verdict("refused", refusal) if scene is None else heard(lambda scene=scene: judge(scene))[0]
        if verdict.word in ("disagree", "partly"):
            tell(f"{verdict.word}: {scene}\n    {verdict.detail}")
        yield verdict


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--scenes", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kind", nargs="+", choices=KINDS, default=list(KINDS))
    asked = parser.parse_args()
    for kind in asked.kind:
        began, counts = time.process_time(), Counter()
        with contextlib.suppress(KeyboardInterrupt):  # what was counted until then
            for verdict in opinions(kind, range(asked.seed, asked.seed + asked.scenes), partial(print, flush=True)):
                counts[verdict.word] += 1
        print(f"{kind}: {counts.total()} scenes, {dict(counts)}, {time.process_time() - began:.0f} s", flush=True)


if __name__ == "__main__":
    main()
