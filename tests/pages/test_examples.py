"""The examples of the manual answer as their pages say, to the printed digit."""

import json
import runpy
from functools import cache
from pathlib import Path

import example_pages
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.oracles import balance_by_hand as six_bar
from support.sampling import rest_exhaustive

DOCS = Path(__file__).resolve().parents[2] / "docs"
QUICK = ("press_from_a_sketch", "bearing_forces", "permissible_force", "my_own_robot")
LONGEST = 60  # lines


@pytest.mark.parametrize("name", rest_exhaustive(example_pages.NAMES, *QUICK))
def test_example_answers_as_its_page_says(name: str) -> None:
    plt = pytest.importorskip("matplotlib.pyplot")
    printed, figure = example_pages.run(name)
    assert example_pages.section(name, printed) in page_of(name), "python docs/make.py example_pages"
    assert figure.axes
    plt.close("all")


def page_of(name: str) -> str:
    (group,) = (group for group, (_, names) in example_pages.GROUPS.items() if name in names)
    return (DOCS / "examples" / f"{group}.md").read_text(encoding="utf-8")


def test_every_example_is_listed_short_and_has_section_picture_and_notebook() -> None:
    folder = DOCS / "examples"
    for kind in ("py", "svg", "ipynb"):
        assert {path.stem for path in folder.glob(f"*.{kind}")} == set(example_pages.NAMES), kind
    assert {path.stem for path in folder.glob("*.md")} == set(example_pages.GROUPS)
    for name in example_pages.NAMES:
        assert len(example_pages.script(name).splitlines()) <= LONGEST
        assert example_pages.parts(name)[0].endswith("?")
        assert f"\n## {example_pages.parts(name)[0]}\n" in page_of(name)
    assert (DOCS / "examples.md").read_text(encoding="utf-8") == example_pages.index(), "python docs/make.py example_pages"


@pytest.mark.parametrize("name", example_pages.NAMES)
def test_notebook_has_the_code_of_its_script(name: str) -> None:
    notebook = (DOCS / "examples" / f"{name}.ipynb").read_text(encoding="utf-8")
    assert notebook == example_pages.notebook(name), "python docs/make.py example_pages"
    cells = json.loads(notebook)["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    shown = code[-1] == "figure"
    assert "\n".join(code[:-1] if shown else code).split() == example_pages.parts(name)[2].split()
    assert shown != ("pyplot" in code[0])  # a notebook shows figures of pyplot by itself


STATES = 720
ORDER = np.fft.fftfreq(STATES, 1 / STATES)


@cache
def six_bar_at_its_crank() -> tuple[np.ndarray, np.ndarray]:
    """Fourier series of the inertia at the crank [kg m2] and of the potential energy [J], from the closed form of the six-bar."""
    inertias = {"crank": 31.5, "coupler": 37.4, "rocker": 183.0, "rod": 5.33, "slide": 0.0}  # kg m2, those of the press's URDF
    inertia, energy, frames = np.zeros(STATES), np.zeros(STATES), six_bar.links(STATES)
    for link, mass, place in six_bar.BODIES:
        centre = frames[link][0] + frames[link][1] * place
        velocity, turn = (np.fft.ifft(1j * ORDER * np.fft.fft(curve)) for curve in (centre, frames[link][1]))
        inertia += mass * abs(velocity) ** 2 + inertias[link] * abs(turn) ** 2
        energy += mass * six_bar.GRAVITY * centre.imag
    return np.fft.fft(inertia) / STATES, np.fft.fft(energy) / STATES


def stop_by_hand(signal: float, torque: float) -> float:
    """Time to standstill of the six-bar at 50 r/min, braked 30 ms after a signal [deg] and fully after 80 ms, by its reduced equation."""
    inertia, energy = six_bar_at_its_crank()

    def rates(time: float, state: np.ndarray) -> list[float]:
        wave = np.exp(1j * ORDER * state[0])
        forces = 1j * ORDER * (inertia * state[1] ** 2 / 2 + energy) @ wave
        return [state[1], -(forces.real + torque * np.clip((time - 0.030) / 0.050, 0.0, 1.0)) / (inertia @ wave).real]

    def speed(_: float, state: np.ndarray) -> float:
        return float(state[1])

    speed.terminal = True  # type: ignore[attr-defined]
    start = [np.radians(signal), 50 * np.pi / 30]
    return float(solve_ivp(rates, (0.0, 3.0), start, "DOP853", events=speed, rtol=1e-10, atol=1e-11, max_step=0.02).t[-1])


@pytest.mark.exhaustive
def test_emergency_stop_names_where_the_brake_does_not_hold_the_worst_signal_and_the_formula_of_the_norm() -> None:
    plt = pytest.importorskip("matplotlib.pyplot")
    printed = page_of("emergency_stop")
    names = runpy.run_path(str(DOCS / "examples" / "emergency_stop.py"))
    plt.close("all")
    wave = np.exp(1j * np.outer(np.radians(np.arange(3600) / 10), ORDER))
    loose = np.abs((wave @ (1j * ORDER * six_bar_at_its_crank()[1])).real) > 12.5e3  # half of the springs of 25 kN m
    edges = np.flatnonzero(np.diff(loose)) / 10
    assert "does not hold from {:.0f} to {:.0f} deg, {:.0f} to {:.0f} deg".format(*edges) in printed
    for signal, torque in ((178.3, 25e3), (185.3, 32e3), (158.5, 16e3), (270.0, 25e3)):
        assert names["stopping_time"](signal, torque) == pytest.approx(stop_by_hand(signal, torque), abs=1e-7)
    worst = max(stop_by_hand(signal, 16e3) for signal in np.arange(155.5, 334.5, 3.0))  # the page refines, so it is later
    assert 0.0 <= -names["worst"].fun - worst < 1e-3
    # the published example (Rockwell 450L-UM001, p. 72: T 0.32 s, d 14 mm), and each branch and bound of ISO 13855:2010, 6.2.3, by hand
    cases = {(0.32, 14): 512.0, (0.238, 14): 476.0, (0.238, 30): 508.8, (0.04, 14): 100.0, (0.26, 14): 500.0, (0.268, 40): 636.8}
    for (time, resolution), distance in cases.items():
        assert names["formula"](time, resolution) == pytest.approx(distance, rel=1e-12)
