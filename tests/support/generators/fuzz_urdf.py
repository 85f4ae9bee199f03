"""Mutated URDF files: each must be refused with a PinpressError, or be a linkage whose motion and forces hold good.

    python tests/support/generators/fuzz_urdf.py --cases 20000 --seed 1
    python tests/support/generators/fuzz_urdf.py --seed 1 --case 417         # one case again: its text, and what comes of it

A case is given by seed and number. Cases run in a process of their own, which is started again where one crashes or hangs.
"""

# ruff: noqa: T201
import argparse
import math
import multiprocessing
import re
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable
from functools import cache, partial
from multiprocessing.connection import Connection
from pathlib import Path
from xml.etree import ElementTree

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # `support`, that it draws linkages from
import numpy as np
import pinocchio as pin

import pinpress as pp

SHIPPED = Path(__file__).resolve().parents[3] / "urdf"
ROBOTS = Path(__file__).resolve().parents[2] / "reference" / "robots"  # in the dialects of other programs
SECONDS = 60.0  # that a case may take
ANGLES = np.array([0.0, 0.37, 1.9, -0.8])
NUMBER = re.compile(r"(?<=[\"\s])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?=[\"\s])")
TOKEN = re.compile(r"<[^<>]*>|[^<>]+")
NUMBERS = (
    "nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e400",
    "1e-320",
    "-0",
    "0",
    "",
    "1",
    "-1",
    "1e-9",
    "1e9",
    "0,5",
    "0x1p3",
    "1e",
    "1.5.2",
)
NAMES = ("", " ", "universe", "root_joint", "frame", "Crank", "slide ", "a\tb", "曲柄", "&lt;", "x" * 300)
TAGS = (
    "robot",
    "link",
    "joint",
    "loop_joint",
    "inertial",
    "mass",
    "inertia",
    "origin",
    "axis",
    "limit",
    "mimic",
    "link1",
    "gazebo",
    "visual",
)
TYPES = ("revolute", "continuous", "prismatic", "fixed", "spherical", "planar", "floating")
AXES = ("1 0 0", "0 1 0", "0 0 1", "0 -1 0", "0.6 0 0.8", "0 -0.999999999 0", "0 0 0")


# ------------------------------------------------------------------------------------------------------------------------ what is mutated


@cache
def bases() -> dict[str, str]:
    """Valid files: the shipped ones, with and without what is drawn, and small ones with every kind of loop and gear pair."""
    from support.generators.malformed_linkages import GEAR, GOES, TRANSMISSION, pinned
    from support.generators.spatial_linkages import bennett, four_bar

    shipped = {path.stem: path.read_text(encoding="utf-8") for path in sorted(SHIPPED.glob("*.urdf"))}
    small = {
        "goes": GOES,
        "two_drivers": GOES.replace(GEAR, "").replace(TRANSMISSION, TRANSMISSION + '<transmission><joint name="G"/></transmission>'),
        "wheel_twice": pinned("revolute", 'link="wheel"', 'link="frame" xyz="0.5 0 0"', '<axis xyz="0 -1 0"/>'),
        "bennett": bennett(),
        **{f"four_bar_{kind}": four_bar(kind) for kind in ("spherical", "revolute", "fixed")},
    }
    bare = {
        f"{name}_bare": re.sub(r"<!--.*?-->|<visual.*?</visual>|\n\s*(?=\n)", "", text, flags=re.DOTALL) for name, text in shipped.items()
    }
    alone = [path for path in sorted(ROBOTS.glob("*.urdf")) if path.stem not in ("15_flat_zero_pose", "19_no_driver")]  # without arguments
    robots = {path.stem: path.read_text(encoding="utf-8") for path in alone}
    return shipped | bare | small | robots


def case(seed: int, number: int) -> tuple[str, str, bytes]:
    """The name of the file that is mutated, what is done to it, and the result."""
    rng = np.random.default_rng([seed, number])
    name = str(rng.choice(sorted(bases())))
    text, done = bases()[name], []
    for _ in range(pick(rng, (1, 1, 1, 2, 3))):
        mutation = MUTATIONS[int(rng.integers(len(MUTATIONS)))]
        done.append(mutation.__name__)
        text = mutation(text, rng)
    data = text.encode("utf-8", "surrogateescape")
    if rng.random() < 0.1:
        done.append("byte")
        data = byte(data, rng)
    return name, " ".join(done), data


def pick(rng, choices):
    return choices[int(rng.integers(len(choices)))]


def byte(data: bytes, rng) -> bytes:
    """One byte flipped, taken out or put in."""
    place, kind = int(rng.integers(len(data) + 1)), int(rng.integers(3))
    new = b"" if kind == 0 else bytes([int(rng.integers(256))])
    return data[:place] + new + data[place + (kind < 2) :]


def number(text: str, rng) -> str:
    """A number replaced, scaled or moved a little."""
    found = list(NUMBER.finditer(text))
    if not found:
        return text
    match = pick(rng, found)
    value = float(match[0])
    near = value + rng.normal() * 10.0 ** rng.integers(-12, 0)
    scaled = value * 10.0 ** rng.integers(-3, 4)
    changed = (pick(rng, NUMBERS), *map(repr, map(float, (scaled, -value, near, near))))
    return text[: match.start()] + pick(rng, changed) + text[match.end() :]


def token(text: str, rng) -> str:
    """A tag, or what is between tags, taken out, doubled or exchanged with another."""
    tokens = TOKEN.findall(text)
    i, j, kind = int(rng.integers(len(tokens))), int(rng.integers(len(tokens))), int(rng.integers(3))
    if kind == 0:
        tokens[i] = ""
    elif kind == 1:
        tokens[j] += tokens[i]
    else:
        tokens[i], tokens[j] = tokens[j], tokens[i]
    return "".join(tokens)


def white(text: str, rng) -> str:
    """White space put in, or lines ended in another way."""
    place = int(rng.integers(len(text) + 1))
    kind = pick(rng, (" ", "\n", "\t", "\u00a0", "\r\n", "ends"))
    return text.replace("\n", pick(rng, ("\r\n", "\r", " "))) if kind == "ends" else text[:place] + kind + text[place:]


def name(text: str, rng) -> str:
    """An attribute, or a word in one, given another name."""
    found = list(re.finditer(r"(?<=\s)([\w:]+)=\"([^\"]*)\"", text))
    if not found:
        return text
    match, other = pick(rng, found), pick(rng, found)
    key, value = match.groups()
    changed = (
        f'{other[1]}="{value}"',
        f'{key}="{other[2]}"',
        f'{key}="{pick(rng, NAMES)}"',
        f'{key}="{value}" {other[0]}',
        f'{key.upper()}="{value}"',
        "",
    )
    return text[: match.start()] + pick(rng, changed) + text[match.end() :]


def tag(text: str, rng) -> str:
    """An element given another tag: both ends of it, or all elements that have it."""
    found = re.findall(r"<(\w+)", text)
    if not found:
        return text
    old, new = pick(rng, found), pick(rng, TAGS)
    return re.sub(rf"(</?){old}\b", rf"\g<1>{new}", text, count=int(rng.integers(3)))


def element(text: str, rng) -> str:
    """An element taken out, doubled or moved to another place."""
    try:
        robot = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError):
        return text
    pairs = [(parent, child) for parent in robot.iter() for child in parent]
    if not pairs:
        return text
    parent, child = pick(rng, pairs)
    kind = int(rng.integers(3))
    target = parent if rng.random() < 0.5 else pick(rng, list(robot.iter()))
    if kind != 1 and child not in list(target.iter()) and target not in list(child.iter()):
        parent.remove(child)
    if kind != 0 and target not in list(child.iter()):
        target.insert(int(rng.integers(len(target) + 1)), child)
    return ElementTree.tostring(robot, encoding="unicode")


def structure(text: str, rng) -> str:
    """Something else that a linkage may be: another type, axis or link, one more loop, gear pair or driver."""
    links, joints = (re.findall(rf'<{kind} name="([^"]*)"', text) or ["x"] for kind in ("link", "joint"))
    axis = pick(rng, ("", '<axis xyz="0 -1 0"/>'))
    loop = (
        f'<loop_joint name="new{rng.integers(99)}" type="{pick(rng, TYPES)}"><link1 link="{pick(rng, links)}" xyz="{pick(rng, AXES)}"/>'
        f'<link2 link="{pick(rng, links)}"/>{axis}</loop_joint>'
    )
    mimic = f'<mimic joint="{pick(rng, joints)}" multiplier="{pick(rng, ("1", "-1", "0.5", "0", "2", "1e-9"))}"/>'
    changes = (
        (r'type="\w+"', f'type="{pick(rng, TYPES)}"'),
        (r"<axis[^>]*>", f'<axis xyz="{pick(rng, AXES)}"/>'),
        (r'link="[^"]*"', f'link="{pick(rng, links)}"'),
        (r'joint name="[^"]*"', f'joint name="{pick(rng, joints)}"'),
        (r"</joint>", f"{mimic}</joint>"),
        (r"</robot>", f"{loop}</robot>"),
        (r"</robot>", f'<transmission name="t"><joint name="{pick(rng, joints)}"/></transmission></robot>'),
    )
    pattern, new = pick(rng, changes)
    found = list(re.finditer(pattern, text))
    if not found:
        return text
    match = pick(rng, found)
    return text[: match.start()] + new + text[match.end() :]


MUTATIONS = (number, number, number, token, white, name, name, tag, element, element, structure, structure, structure)


# --------------------------------------------------------------------------------------------------------------------- how it is judged


def judge(data: bytes, folder: Path) -> str:
    """What comes of a file: "refused", or what was computed of it; AssertionError, or any other, where that is wrong."""
    file = folder / "case.urdf"
    file.write_bytes(data)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", pp.PinpressWarning)  # a file may be legal, and hardly meant
        press, refusal = loaded(file)
        errors = pp.check(file).errors
        if press is None:
            if "no driver; its mobility" in refusal:
                return "refused"  # check goes on with the drivers that it proposes
            assert errors, f"load refuses it, check does not: {refusal}"
            assert refusal.startswith(str(errors[0].error)), f"load says {refusal}, check {errors[0].error}"
            assert "Pinocchio cannot read it" not in refusal, refusal
            return "refused"
        assert not errors, f"check finds an error, load does not: {errors[0]}"
        assert math.isclose(model_mass(press), written_mass(data), rel_tol=1e-12), f"mass {model_mass(press)} kg, not {written_mass(data)}"
        return moves(press, data)


def loaded(file: Path) -> tuple[pp.Linkage | None, str]:
    """The linkage, or why it is refused."""
    try:
        return pp.load(file), ""
    except pp.PinpressError as error:
        return None, str(error)


def moves(press: pp.Linkage, data: bytes) -> str:
    """Compute a few states of a linkage, or only the drawn one where it locks."""
    count = len(press.drivers)
    for angles in (ANGLES, ANGLES[:1]):
        angle = angles if count == 1 else np.multiply.outer(angles, 0.3 * np.ones(count))
        try:
            motion = pp.servo_cycle(press, speed=2.0, angle=angle, acceleration=3.0)
            result = pp.inverse_dynamics(press, motion)
            residual = np.abs(result.power_residual).max()
        except pp.PinpressError:
            continue
        arrays = [motion.q, motion.v, motion.a, result.driving_torque, result.shaking_force, result.shaking_moment]
        arrays += [*result.bearing_force.values(), *result.bearing_moment.values(), *result.coupling_torque.values()]
        assert all(np.isfinite(array).all() for array in arrays), "something is not finite"
        allowed = max(1e-9 * press.size, press.structure.tolerance)  # that of redundant equations of rounded numbers, which are warned of
        assert motion.closure_error.max() <= allowed, f"closure error {motion.closure_error.max():.3g} m"
        loops = [loop for loop in ElementTree.fromstring(data).findall("loop_joint") if loop.find("link2") is not None]
        gap = max((gap_of(press, loop, q) for loop in loops for q in motion.q), default=0.0)
        assert gap <= allowed, f"a loop is {gap:.3g} m open, of a linkage of {press.size:.3g} m"
        assert residual <= 1e-7, f"power residual {residual:.3g}"
        return result.engine if len(angles) > 1 else f"{result.engine}, drawn pose alone"
    return "locked"


def model_mass(press: pp.Linkage) -> float:
    return math.fsum(inertia.mass for inertia in press.model.inertias)


def written_mass(data: bytes) -> float:
    """Of a repeated element the first counts: only equal ones are read."""
    masses = (link.find("inertial/mass") for link in ElementTree.fromstring(data).findall("link"))
    return math.fsum(float(mass.get("value")) for mass in masses if mass is not None)


def gap_of(press: pp.Linkage, loop: ElementTree.Element, q: np.ndarray) -> float:
    """Distance of the two sides of a loop [m], by Pinocchio's kinematics and the numbers of the text."""
    model, data = press.model, press.model.createData()
    pin.framesForwardKinematics(model, data, q)
    ends = [
        data.oMf[model.getFrameId(end.get("link"), pin.BODY)].act(np.array(end.get("xyz", "0 0 0").split(), dtype=float))
        for end in (loop.find("link1"), loop.find("link2"))
    ]
    return float(np.linalg.norm(ends[0] - ends[1]))


# ------------------------------------------------------------------------------------------------------------------------------- running


def outcome(seed: int, number: int) -> tuple[bool, str]:
    """Whether a case is as it should be, and what came of it."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            return True, judge(case(seed, number)[2], Path(folder))
        except Exception as error:  # whatever it is, it is to be reported
            return False, f"{type(error).__name__}: {error}"


class Worker:
    """A process that runs a task, number by number. Where it crashes or hangs, that is said, and another process goes on."""

    def __init__(self, task: Callable[[int], tuple[bool, str]], seconds: float = SECONDS) -> None:
        self.task, self.seconds = task, seconds
        self._start()

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.connection, other = context.Pipe()
        self.process = context.Process(target=_work, args=(other, self.task), daemon=True)
        self.process.start()
        other.close()
        self.connection.recv()  # it is there: what it takes to start is not counted

    def __call__(self, number: int) -> tuple[bool, str]:
        self.connection.send(number)
        try:
            if self.connection.poll(self.seconds):
                return self.connection.recv()
            said = f"hangs: no end after {self.seconds:g} s"
        except EOFError:
            self.process.join()
            said = f"crashes: exit code {self.process.exitcode}"
        self.stop()
        self._start()
        return False, said

    def stop(self) -> None:
        self.process.kill()
        self.process.join()


def _work(connection: Connection, task: Callable[[int], tuple[bool, str]]) -> None:
    connection.send(None)
    while True:
        connection.send(task(connection.recv()))


def run(cases: range, seed: int) -> tuple[Counter[str], dict[int, str]]:
    """How many cases came to what; the numbers of those that went wrong, and what was said of them."""
    worker, counted, wrong = Worker(partial(outcome, seed)), Counter(), {}
    try:
        for number in cases:
            good, said = worker(number)
            if good:
                counted[said] += 1
            else:
                wrong[number] = f"{said} ({': '.join(case(seed, number)[:2])})"
                print(f"seed {seed}, case {number}: {wrong[number]}", flush=True)
    finally:
        worker.stop()
    return counted, wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", type=int, help="only this case, here and now, with its text")
    options = parser.parse_args()
    if options.case is not None:
        based, done, data = case(options.seed, options.case)
        print(data.decode("utf-8", "backslashreplace"), f"\n{based}: {done}")
        with tempfile.TemporaryDirectory() as folder:
            print(judge(data, Path(folder)))
        return 0
    counted, wrong = run(range(options.first, options.first + options.cases), options.seed)
    print(", ".join(f"{count} {said}" for said, count in counted.most_common()), f"; {len(wrong)} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
