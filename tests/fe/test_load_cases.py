"""Load cases of a link: an independent script's values, balance of every link, and what CalculiX makes of the file."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from support.presses.machine_presses import arbor, geared, planetary, spindle
from support.texts import shipped

import pinpress as pp
from pinpress.fe import LinkLoads, load_cases

BAR = (0.4, 0.06, 0.08)  # m, along x, y, z
MASS = 15.0


def with_bar() -> pp.Linkage:
    """crank_slide with a prism as its rod."""
    press = shipped("crank_slide")
    inertias = [each.copy() for each in press.model.inertias]
    squares = np.square(BAR)
    inertias[2] = pin.Inertia(MASS, np.array([0.2, 0.0, 0.0]), np.diag(MASS / 12 * (squares.sum() - squares)))
    return press.with_inertias(inertias)


def of_rod(press: pp.Linkage, force: float) -> LinkLoads:
    """The rod at 60 deg, 10 rad/s and 7 rad/s2, under a force up on the slide."""
    motion = pp.servo_cycle(press, [np.radians(60.0)], speed=[10.0], acceleration=[7.0])
    loads = [pp.loads.PointForce("slide", (0.0, 0.0, force))] if force else []
    return load_cases(press, pp.inverse_dynamics(press, motion, loads), "rod", at="states")


def test_rod_of_a_crank_slide() -> None:
    """Values of an independent NumPy script in maximal coordinates, to all printed digits."""
    cases = of_rod(with_bar(), 1e5)
    assert cases.force["P"][0, [0, 2]] == pytest.approx([100757.0369266, -65.38291245151], rel=1e-13, abs=2e-10)
    assert cases.force["W"][0, [0, 2]] == pytest.approx([-100960.7250739, -43.62941078639], rel=1e-12, abs=2e-10)
    assert cases.origin_acceleration[0, [0, 2]] == pytest.approx([-3.674022300331, -9.326926617953], rel=1e-12)
    assert cases.gravity[0, [0, 2]] == pytest.approx([9.577318665081, 2.123927302781], rel=1e-12)
    # about y, which points away from the reader, a counter-clockwise turn is negative
    assert cases.angular_velocity[0] == pytest.approx([0.0, 1.28036879933, 0.0], abs=1e-11)
    assert cases.angular_acceleration[0] == pytest.approx([0.0, -20.9168285244, 0.0], abs=1e-10)
    assert cases.point["W"][0] == pytest.approx([0.4, 0.0, 0.0], abs=1e-15)
    unloaded = of_rod(shipped("crank_slide"), 0.0)
    assert unloaded.force["P"][0, [0, 2]] == pytest.approx([-1672.55979271, -64.96457588], abs=5e-9)
    assert unloaded.force["W"][0, [0, 2]] == pytest.approx([1468.87164544, -44.04774736], abs=5e-9)


def test_every_link_is_in_balance_under_friction_process_and_load_edges() -> None:
    press = shipped("zxn2_3000b")
    friction = {"A": pp.loads.Friction(0.05, 0.1), "E": pp.loads.Friction(0.05, 0.1)}
    draw = pp.loads.DeepDrawing(3e6, 0.013)
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 60 * pp.RPM, points=180), [draw], friction)
    for link in (each for each in press.links if each != press.root):
        for at in ("extremes", [1.0, 2.0, -5.0], "states"):
            force, moment = load_cases(press, reactions, link, at).residual
            assert force.max() < 1e-8
            assert moment.max() < 1e-8
    cases = load_cases(press, reactions, "rod")
    assert load_cases(press, reactions, "rod", "peak E").force["E"][0] in cases.force["E"]
    assert np.linalg.norm(cases.force["E"], axis=1).max() == cases.largest["E"][0]
    field = cases.body_force(np.array([[0.1, 0.0, 0.2]]))
    assert field.shape == (len(cases.remark), 1, 3)


def test_a_gear_is_in_balance_with_the_teeth() -> None:
    press = shipped("jf75g_125_two_point")
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 10.0, points=24), [pp.loads.DeepDrawing(5e5, 0.01)])
    for link in (each for each in press.links if each != press.root):
        force, moment = load_cases(press, reactions, link, "states").residual
        assert max(force.max(), moment.max()) < 1e-7


@pytest.mark.parametrize("press", [geared(0.95), arbor(0.95), spindle(0.05)], ids=lambda press: press.name)
def test_links_with_teeth_racks_and_threads_are_in_balance_with_their_losses(press: pp.Linkage) -> None:
    motion = pp.servo_cycle(press, np.linspace(0.1, 0.5, 5), speed=2.0, acceleration=3.0)
    whole = pp.inverse_dynamics(press, motion, [pp.loads.PointForce("slide", (0.0, 0.0, 1e4))])
    for link in (each for each in press.links if each != press.root):
        force, moment = load_cases(press, whole, link, "states").residual
        assert max(force.max(), moment.max()) < 1e-10


def test_planets_that_stand_for_three_are_refused() -> None:
    press = planetary()
    whole = pp.inverse_dynamics(press, pp.servo_cycle(press, np.linspace(0.1, 0.5, 5), speed=2.0, acceleration=3.0))
    with pytest.raises(pp.PinpressError, match=r"what acts on planet is not in balance: .* planets that stand for several"):
        load_cases(press, whole, "planet", "states")


def test_angles_are_met_exactly_also_where_the_speed_changes() -> None:
    press = shipped("crank_slide")
    time = np.linspace(0.0, 1.0, 101)
    motion = pp.servo_cycle(press, 6.0 * time + 0.5 * np.sin(5 * time), time=time)
    cases = load_cases(press, pp.inverse_dynamics(press, motion), "rod", at=[0.3, 4.0])
    assert cases.place == pytest.approx([0.3, 4.0], abs=1e-12)


# ----------------------------------------------------------------------------------------------------------------------------- CalculiX

STIFFNESS = 1e3  # N/mm of the springs that hold the bar


def mesh(file: Path, along: int) -> dict[str, int]:
    """A bar of C3D20 elements in mm with the rod's mass, held by six soft springs; returns the nodes of P and W."""
    count, size = np.array([along, 2, 2]), 1e3 * np.array(BAR)
    half = size / count / 2
    start, numbers = np.array([0.0, -size[1] / 2, -size[2] / 2]), dict[tuple[int, ...], int]()
    corners = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
    edges = [
        (1, 0, 0),
        (2, 1, 0),
        (1, 2, 0),
        (0, 1, 0),
        (1, 0, 2),
        (2, 1, 2),
        (1, 2, 2),
        (0, 1, 2),
        (0, 0, 1),
        (2, 0, 1),
        (2, 2, 1),
        (0, 2, 1),
    ]
    elements = []
    for cell in np.ndindex(*count):
        places = [tuple(int(2 * c + o) for c, o in zip(cell, offset, strict=True)) for offset in [*corners, *edges]]
        elements.append([numbers.setdefault(place, len(numbers) + 1) for place in places])
    lines = ["*NODE, NSET=NALL"]
    lines += [f"{n}, " + ", ".join(f"{each:.9g}" for each in start + half * place) for place, n in numbers.items()]
    lines.append("*ELEMENT, TYPE=C3D20, ELSET=EALL")
    for number, nodes in enumerate(elements, 1):
        lines += [f"{number}, " + ", ".join(map(str, nodes[:10])) + ",", ", ".join(map(str, nodes[10:]))]
    density = MASS * 1e-3 / float(size.prod())
    lines += [
        "*MATERIAL, NAME=STEEL",
        "*ELASTIC",
        "210000., 0.3",
        "*DENSITY",
        f"{density:.12g}",
        "*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL",
    ]
    one, two, three = numbers[0, 0, 0], numbers[2 * along, 0, 0], numbers[0, 0, 4]
    held = [(one, 1), (one, 2), (one, 3), (two, 2), (two, 3), (three, 2)]
    for k, (node, direction) in enumerate(held, 1):
        lines += [f"*ELEMENT, TYPE=SPRING1, ELSET=S{k}", f"{9000 + k}, {node}", f"*SPRING, ELSET=S{k}", f"{direction}", f"{STIFFNESS}"]
    lines += ["*NSET, NSET=SUPPORTS", f"{one}, {two}, {three}"]
    file.write_text("\n".join(lines) + "\n")
    return {"P": numbers[0, 2, 2], "W": numbers[2 * along, 2, 2]}


def supports(folder: Path, cases: LinkLoads, along: int) -> np.ndarray:
    """Forces (3, 3) [N] of the springs on the bar at (0, -, -), (400, -, -) and (0, -, +), computed by CalculiX."""
    nodes = mesh(folder / "rod.inp", along)
    cases.write_inp(folder / "cases.inp", mesh=folder / "rod.inp", nodes=nodes)
    deck = (folder / "cases.inp").read_text().replace("*NODE FILE", "*NODE PRINT, NSET=SUPPORTS\nU\n*NODE FILE")
    (folder / "cases.inp").write_text(deck)
    done = subprocess.run(["ccx", "cases"], cwd=folder, capture_output=True, text=True, check=False, env={"OMP_NUM_THREADS": "1"})
    assert "Job finished" in done.stdout, done.stdout[-2000:]
    rows = re.findall(r"^ +(\d+) +(\S+) +(\S+) +(\S+)$", (folder / "cases.dat").read_text(), re.MULTILINE)
    found = {int(row[0]): -STIFFNESS * np.array(row[1:], float) for row in rows}
    ends = [np.array(found[node]) for node in sorted(found, key=list(found).index)]
    return np.array(ends)


@pytest.mark.parametrize("along", [5, 10])
@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (Debian: calculix-ccx) is not installed")
def test_calculix_finds_nothing_left_for_the_supports(tmp_path: Path, along: int) -> None:
    """But for the couple of the angular acceleration within elements, which is alpha x sum of m_e (dx^2 + dz^2)/12."""
    cases = of_rod(with_bar(), 1e5)
    forces = supports(tmp_path, cases, along)
    rows = forces * [[1, 1, 1], [0, 1, 1], [0, 1, 0]]  # the directions that springs hold
    assert np.abs(rows.sum(axis=0)).max() < 2e-6  # of 1e5 N
    left = 20.9168285244 * MASS / 12 * ((BAR[0] / along) ** 2 + (BAR[2] / 2) ** 2) / BAR[0]  # N, on the length of the bar
    assert abs(rows[1, 2]) == pytest.approx(left, rel=1e-4)


# ------------------------------------------------------------------------------------------------------------------------------- mistakes


def reactions(press: pp.Linkage, **more: object) -> pp.Reactions:
    return pp.inverse_dynamics(press, pp.cycle(press, 10.0, points=24), **more)


def test_refused(tmp_path: Path) -> None:
    press = shipped("crank_slide")
    whole, cases = reactions(press), of_rod(press, 0.0)
    nodes = mesh(tmp_path / "rod.inp", 2)
    (tmp_path / "empty.inp").write_text("*NODE\n1, 0, 0, 0\n")
    (tmp_path / "odd.inp").write_text("*NODE\n1, 0, x, 0\n")

    def write(file: str, of: dict[str, int]) -> None:
        cases.write_inp(tmp_path / "out.inp", mesh=tmp_path / file, nodes=of)

    refused = [
        (lambda: load_cases(press, whole, "frame"), "frame is the frame, which does not move"),
        (lambda: load_cases(press, whole, "bar"), "no link 'bar'"),
        (lambda: load_cases(press, reactions(press, bearings=["W"]), "rod"), "the reactions leave out O, P, slide_guide"),
        (lambda: load_cases(press, whole, "rod", "peak O"), "no force on rod 'O'"),
        (lambda: load_cases(press, whole, "rod", "largest"), "at is 'largest': give 'extremes'"),
        (lambda: load_cases(shipped("zxn2_3000b"), whole, "rod"), "zxn2_3000b"),
        (lambda: write("rod.inp", {"P": 1}), "nodes lacks W: give the node at which each force acts"),
        (lambda: write("rod.inp", {"P": 1, "W": 99999}), "has no node 99999, at which W acts"),
        (lambda: write("rod.inp", nodes | {"O": 1}), "no force on the link 'O'"),
        (lambda: write("none.inp", nodes), "cannot be read"),
        (lambda: write("empty.inp", nodes), "has no *ELEMENT"),
        (lambda: write("odd.inp", nodes), "line 2: '1, 0, x, 0' is no line of *NODE"),
    ]
    for call, message in refused:
        with pytest.raises(pp.PinpressError) as error:
            call()
        assert message in str(error.value)
