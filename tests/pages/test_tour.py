"""The tour: its code and commands run as written and print what the page shows; its press moves as the closed form says."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import page_blocks

import pinpress as pp

DOCS = Path(__file__).resolve().parents[2] / "docs"
CRANK, COUPLER, UPPER, LOWER = 0.090, 0.650, 0.300, 0.360  # m, from the page's first table
SHAFT = 0.750 - 0.250j  # x + i z
STEEL = 7850.0  # kg/m3


pytestmark = pytest.mark.exhaustive  # all of them stand on one run of the whole page


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[dict[str, Any], list[page_blocks.Shown]]]:
    """The names that a reader has at the end, and what was shown and printed on the way."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("tour"))
        names: dict[str, Any] = {}
        yield names, list(page_blocks.run((DOCS / "tour.md").read_text(encoding="utf-8"), names))


def test_prints_what_the_page_shows(session: tuple[dict[str, Any], list[page_blocks.Shown]]) -> None:
    shown = session[1]
    for each in shown:
        assert each.same, f"line {each.block.line} shows\n{each.wanted}\nbut prints\n{each.printed}"
    assert sum(bool(each.wanted) for each in shown) > 8
    assert any("below" in each.printed for each in shown)  # the page claims nothing that fails
    assert not any("False" in each.printed for each in shown)


def test_writes_what_it_says(session: tuple[dict[str, Any], list[page_blocks.Shown]]) -> None:
    for name, least in (
        ("recording.html", 300_000),
        ("knuckle.html", 1_000_000),
        ("report.html", 1_000_000),
        ("cycle.csv", 100_000),
        ("out/recording.html", 300_000),
    ):
        assert Path(name).stat().st_size > least
    for drawn in ("knuckle.svg", "short.svg"):
        assert "<circle" in Path(drawn).read_text(encoding="utf-8")


def test_urdf_by_hand_is_the_press_of_the_table(session: tuple[dict[str, Any], list[page_blocks.Shown]]) -> None:
    """Masses and angles of the file have six digits."""
    by_hand = pp.load(DOCS / "tour" / "knuckle.urdf")
    torque = pp.inverse_dynamics(by_hand, pp.cycle(by_hand, speed=60 * pp.RPM, points=720)).driving_torque
    wanted = session[0]["reactions"].driving_torque
    np.testing.assert_allclose(torque, wanted, atol=1e-6 * np.abs(wanted).max())


def test_masses_are_those_of_steel_prisms(session: tuple[dict[str, Any], list[page_blocks.Shown]]) -> None:
    """Length over all, height, width [m] from the table's sections and overhangs; moments of inertia by sums over slices of the prism."""
    press = session[0]["press"]
    sizes = {
        "O": (CRANK + 0.16, 0.160, 0.100),
        "P": (COUPLER + 0.12, 0.120, 0.090),
        "U": (UPPER + 0.16, 0.200, 0.140),
        "K": (LOWER + 0.16, 0.200, 0.140),
        "slide_guide": (0.360, 0.420, 0.400),
    }
    for joint, size in sizes.items():
        inertia = press.model.inertias[press.model.getJointId(joint)]
        mass = STEEL * np.prod(size)
        assert inertia.mass == pytest.approx(mass, abs=5e-4)  # as printed, three digits
        slices = (np.arange(2000) + 0.5) / 2000 - 0.5
        squares = [mass * np.mean((side * slices) ** 2) for side in size]  # about the middle planes
        about = [squares[1] + squares[2], squares[0] + squares[1], squares[0] + squares[2]]
        np.testing.assert_allclose(np.diag(inertia.inertia), about, atol=6e-5, rtol=1e-6)  # four digits


def test_moves_as_the_closed_form_says(session: tuple[dict[str, Any], list[page_blocks.Shown]]) -> None:
    """Position by two intersections of circles; speed and acceleration from these alone, by the spectrum of a turn."""
    motion = session[0]["motion"]
    speed, count = 60 * 2 * np.pi / 60, len(motion.crank_angle)
    height = slide(2 * np.pi * np.arange(count) / count)
    np.testing.assert_allclose(motion.slide_position, height, atol=1e-13)
    orders = np.fft.rfftfreq(count, 1 / count)
    spectrum = np.fft.rfft(height)
    for derivative, found in ((1, motion.slide_velocity), (2, motion.slide_acceleration)):
        wanted = np.fft.irfft(spectrum * (1j * orders * speed) ** derivative, count)
        np.testing.assert_allclose(found, wanted, atol=1e-8)  # the second derivative of 1e-16 to order 360: 4e-9


def test_load_acts_through_the_slope(session: tuple[dict[str, Any], list[page_blocks.Shown]]) -> None:
    """Virtual work: what the coining force adds to the torque is - F dz/dq, with the slope of the closed form."""
    names = session[0]
    motion, bottom = names["motion"], names["ends"].bottom_position
    above = slide(motion.crank_angle) - bottom
    force = np.interp(above, [0.0, 0.0005, 0.001, 0.002], [1.6e6, 0.7e6, 0.3e6, 0.0]) * (slope(motion.crank_angle) < 0)
    added = names["loaded"].driving_torque - names["reactions"].driving_torque
    np.testing.assert_allclose(added, -force * slope(motion.crank_angle), atol=1e-6 * np.abs(added).max())


def slide(angle: np.ndarray) -> np.ndarray:
    """Position of the slide at crank angles (n,) [m]: law of cosines at the frame pin, then Pythagoras; analytic in the angle."""
    x, z = SHAFT.real + CRANK * np.cos(angle), SHAFT.imag + CRANK * np.sin(angle)
    square = x**2 + z**2
    foot = (UPPER**2 - COUPLER**2 + square) / (2 * square)  # share of the line from U to P, and across it
    across = np.sqrt(UPPER**2 / square - foot**2)
    knee_x, knee_z = foot * x + across * z, foot * z - across * x
    return np.asarray(knee_z - np.sqrt(LOWER**2 - knee_x**2))


def slope(angle: np.ndarray) -> np.ndarray:
    """dz/dq (n,) [m/rad] by the complex step."""
    return np.asarray(slide(angle + 1e-30j).imag / 1e-30)
