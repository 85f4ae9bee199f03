"""The pages of the three documents: complete, within the tolerances they state, what their command writes, and right.

What is right is known from `tests/reference` (computed without pinpress), from closed forms written here, and from sums of printed numbers.
"""

import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.accuracy.peers import six_bar_script
from validation import (
    DOCUMENTS,
    chen2002,
    kong2025,
    pages,
    reproduced,
    validate,
    zhang2007_balancing,
    zhang2007_runs,
    zhang2007_search,
)
from validation.pages import BEYOND, CURVES, DATA, FINDINGS, FORMULAS, KINDS, NO_RESULT, NOT, PARTLY, REPRODUCED, Page, PageEntry, Row

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"


def reference(name):
    return json.loads((ROOT / "tests" / "reference" / f"{name}.json").read_text(encoding="utf-8"))


def numbered(chapter, *numbers):
    return [f"Fig. {chapter}-{k}" for k in numbers]


# Every table and figure of the documents, by their own numbers; where one is captioned twice, with the number it should have.
NUMBERS = {
    "kong2025": [*(f"Fig. {k}" for k in range(1, 7)), "Table 1", "Table 2", "Table 3"],
    "zhang2007": [
        *numbered(1, *range(1, 5)),
        *numbered(2, *range(1, 19)),
        *numbered(3, *range(1, 7), "7 (captioned 4-6)", 8),
        *numbered(4, *range(4, 12), "12 (captioned 4-11)"),
        *numbered(5, *range(1, 16)),
        "Table 4-1",
        "Table 5-1",
        "Table 5-2",
    ],
    "chen2002": ["Fig. 1", "Fig. 2", "Fig. 3"],
}


SHORT = rest_exhaustive(DOCUMENTS, "kong2025")  # the runs of the second and the searches of the third take seconds


@pytest.fixture(scope="module")
def made():
    """The page of a document, made when it is first asked for."""
    return cache(reproduced)


def row(page, words):
    (found,) = [each for each in page.rows if each.quantity == words]
    return found


# ---------------------------------------------------------------------------------------------------------------------- the pages


@pytest.mark.parametrize("name", SHORT)
def test_every_table_and_figure_is_there_once(made, name):
    found = [number for entry in made(name).entries for number in entry.numbers]
    assert len(found) == len(set(found))
    assert sorted(number for number in found if re.match("Fig|Table", number)) == sorted(NUMBERS[name])


@pytest.mark.parametrize("name", SHORT)
def test_what_counts_as_reproduced_is(made, name):
    held = [each for each in made(name).rows if each.within is not None]
    assert held
    for each in held:
        assert each.holds, f"{each.quantity}: {each.ours} for {each.theirs}"
    assert max(each.within for each in held) <= 1.0  # per cent


@pytest.mark.parametrize("name", SHORT)
def test_kinds_say_what_the_rows_do(made, name):
    for entry in made(name).entries:
        printed = [each.within is not None for each in entry.rows if each.number is not None and not each.source]
        assert entry.kind in KINDS
        assert {
            REPRODUCED: bool(printed) and all(printed),
            FORMULAS: not any(printed) and all(each.within is not None for each in entry.rows if each.source),
            CURVES: not printed,
            PARTLY: any(printed) and not all(printed),
            NOT: not any(printed) and bool(entry.reason),
            DATA: bool(entry.reason),
            FINDINGS: bool(entry.reason) and not printed,
            BEYOND: not printed and bool(entry.reason),
            NO_RESULT: not entry.rows and entry.draw is None,
        }[entry.kind], entry.label


@pytest.mark.parametrize("name", SHORT)
def test_docs_are_what_the_command_writes(made, name):
    written = {path.name: path.read_text(encoding="utf-8") for path in DOCS.glob(f"{name}*.md")}
    assert written == made(name).files()


@pytest.mark.exhaustive
def test_the_page_on_mounts_has_the_findings_of_the_frame(made):
    text = (ROOT / "viz" / "foundation.md").read_text(encoding="utf-8")
    (entry,) = [entry for entry in made("zhang2007").entries if entry.figure == "zhang2007_vibration"]
    assert len(entry.rows) == text.partition("| Zhang 2007 says")[2].partition("\n\n")[0].count("\n") - 1
    for each in entry.rows:
        gives, _, agrees = str(each.ours).partition(". Agrees: ")
        assert f"| {each.quantity.partition(': ')[2]} | {gives} | {agrees} |" in text


@pytest.mark.parametrize("name", SHORT)
def test_figures_of_the_docs_are_those_that_the_command_draws(made, name):
    drawn = {entry.figure for entry in made(name).entries if entry.draw is not None}
    assert {path.stem for path in (DOCS / "figures").glob("*.png") if path.stem.startswith(name)} == drawn
    shown = re.findall(r"\(figures/(\w+)\.png\)", made(name).markdown())
    assert sorted(shown) == sorted(drawn)


@pytest.mark.parametrize("name", SHORT)
def test_errata_are_complete_sentences_of_a_place(made, name):
    assert made(name).errata
    for each in made(name).errata:
        assert each.place
        assert each.wrong != each.right
        assert each.right


@pytest.mark.parametrize(
    ("name", "figures"), [("kong2025", {"torque"}), pytest.param("chen2002", {"speed", "objective"}, marks=pytest.mark.exhaustive)]
)
def test_writes_pages_and_figures(made, name, figures, tmp_path):
    names = {f"{name}_{figure}" for figure in figures}
    page = replace(made(name), entries=tuple(entry for entry in made(name).entries if entry.figure in {*names, ""}))
    written = page.write(tmp_path)
    assert {written[0].name: written[0].read_text(encoding="utf-8")} == page.files()
    assert {path.stem for path in written[1:]} == names
    assert {path.suffix for path in written[1:]} == {".png"}
    for path in written[1:]:
        assert path.read_bytes().startswith(b"\x89PNG")
        assert 5_000 < path.stat().st_size < 100_000


# -------------------------------------------------------------------------------------------------------------------- the command


def test_command_prints_and_fails_where_a_number_does_not_hold(monkeypatch, capsys):
    good = PageEntry(("Table 1",), "one", REPRODUCED, (Row("length [m]", "2.00", 2.01, 1.0),))
    page = Page("kong2025", "Kong", "", (good,), ())
    monkeypatch.setattr(validate, "reproduced", lambda name: page)
    assert validate.main(["kong2025"]) == 0
    assert "| length [m] | 2.00 | 2.01 | +0.50 % | 1 % |" in capsys.readouterr().out
    bad = replace(good, rows=(Row("length [m]", "2.00", 2.03, 1.0),))
    monkeypatch.setattr(validate, "reproduced", lambda name: replace(page, entries=(bad,)))
    assert validate.main(["kong2025"]) == 1
    assert "length [m] is 2.03, not 2.00" in capsys.readouterr().err


def test_command_refuses_unknown_documents(capsys):
    assert validate.main(["kong2026"]) == 2
    assert "kong2026" in capsys.readouterr().err


def test_command_writes(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(validate, "reproduced", lambda name: Page(name, "Short", "", (), ()))
    assert validate.main(["--out", str(tmp_path / "new")]) == 0
    assert [str(tmp_path / "new" / f"{name}.md") for name in DOCUMENTS] == capsys.readouterr().out.split()


def test_command_names_a_file_it_cannot_write(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(validate, "reproduced", lambda name: Page(name, "Short", "", (), ()))
    (tmp_path / "file").write_text("")
    assert validate.main(["chen2002", "--out", str(tmp_path / "file")]) == 2
    assert "file" in capsys.readouterr().err


# ------------------------------------------------------------------------------------------------------------------------ the rows


@pytest.mark.parametrize(
    ("given", "cells"),
    [
        (Row("a", "-2.50", -2.5), ("a", "-2.50", "-2.50", "0.00 %", "")),
        (Row("a", "-2.50", -2.6, 5.0), ("a", "-2.50", "-2.60", "-4.00 %", "5 %")),
        (Row("a", "10 000", 10001.0), ("a", "10 000", "10001", "+0.01 %", "")),
        (Row("a", "0", 0.0, 0), ("a", "0", "0", "", "rounding")),
        (Row("a", "0.0", -1e-9, None, 1), ("a", "0.0", "0.0", "", "")),
        (Row("a", "more", 1.25, places=1), ("a", "more", "1.2", "", "")),
        (Row("a", "1", None, source="formula"), ("a", "1 (formula)", "", "", "")),
        (Row("a", "", "strong"), ("a", "", "strong", "", "")),
    ],
)
def test_cells(given, cells):
    assert given.cells() == cells


@pytest.mark.parametrize(
    ("given", "holds"),
    [
        (Row("a", "100", 101.0, 1.0), True),
        (Row("a", "100", 101.1, 1.0), False),
        (Row("a", "-100", -98.9, 1.0), False),
        (Row("a", "0", 0.0, 0), True),
        (Row("a", "0", 1e-12, 0), False),
        (Row("a", "100", 200.0), None),
    ],
)
def test_holds(given, holds):
    assert given.holds is holds


@pytest.mark.parametrize(
    ("theirs", "ours", "within"), [("more", 1.0, 1.0), ("1", None, 1.0), ("1", "one", 1.0), ("0", 1.0, 1.0), ("1", 1.0, 0)]
)
def test_refuses_a_tolerance_without_numbers(theirs, ours, within):
    with pytest.raises(pp.PinpressError, match="tolerance"):
        Row("a", theirs, ours, within)


def test_table_escapes_bars():
    assert pages.table(("a",), [("|x|",)]) == "| a |\n|---|\n| \\|x\\| |"


# ------------------------------------------------------------------------------------------------------------------------ Kong 2025


@pytest.mark.exhaustive
def test_printed_numbers_that_are_held(made):
    """What the README says of the documents: printed numbers, and those of formulas and of solvers without pinpress."""
    held = {name: [each for each in made(name).rows if each.holds] for name in DOCUMENTS}
    assert {name: sum(not each.source for each in rows) for name, rows in held.items()} == {"kong2025": 11, "zhang2007": 0, "chen2002": 3}
    assert sum(bool(each.source) for rows in held.values() for each in rows) == 108


def test_kong_extremes_are_those_of_the_reference(made):
    """`reference/zxn2_3000b.json` to 1e-6: what 7200 crank angles miss of an extreme is less."""
    known = reference("zxn2_3000b")["kinematic_extremes"]
    rows = {
        "highest position [m]": known["y_max"][0],
        "lowest position [m]": known["y_min"][0],
        "highest speed upwards [m/s]": known["v_up"][0],
        "highest speed downwards [m/s]": known["v_down"][0],
        "largest acceleration upwards [m/s2]": known["a_max"][0],
        "largest acceleration downwards [m/s2]": known["a_min"][0],
        "bottom dead centre [s]": known["dead_points"]["BDC"]["t"],
        "top dead centre, crank angle [deg]": known["dead_points"]["TDC"]["theta1_deg"],
    }
    for words, expected in rows.items():
        assert row(made("kong2025"), words).ours == pytest.approx(expected, rel=1e-6), words


def test_kong_balancing_against_an_independent_solver(made):
    """Changes of the ranges [%] of centre of mass and shaking force, and of torque and force in A, by a solver without pinpress."""
    page = made("kong2025")
    found = {
        words: round(row(page, f"{words}, change [%]").ours, places)
        for words, places in {
            "range of the centre of mass, x": 2,
            "range of the centre of mass, y": 2,
            "range of the shaking force, x": 2,
            "range of the shaking force, y": 3,
        }.items()
    }
    assert list(found.values()) == [-52.19, -8.65, -47.42, -2.741]
    changes = [round(row(page, f"{name}, change of the range [%]").ours, 2) for name in kong2025.PRINTED]
    assert changes == [-1.72, -1.49, -3.43]
    moments = [row(page, f"range of the shaking moment about D, inertia alone, {when} [N m]").ours for when in ("before", "after")]
    assert np.round(moments).tolist() == [15448, 11763]


def test_kong_tables_as_printed_are_consistent(made):
    """The printed changes follow from the printed ranges, and these from the extremes but for rounding; the page shows what is printed."""
    for name, extremes in kong2025.PRINTED.items():
        first, second = kong2025.RANGES[name]
        assert 100 * (second / first - 1) == pytest.approx(float(kong2025.REDUCTION[name]), abs=1e-4)
        assert np.abs(np.subtract((first, second), -np.diff(extremes)[:, 0])).max() <= 1
    assert row(made("kong2025"), f"{kong2025.MOMENT}, before, range").theirs == "38476"  # not the difference, 38475


def test_kong_signs_are_the_papers(made):
    """M_b and the force on the frame are minus ours: of the two extremes of each row the larger one is at its place."""
    before = kong2025.state("zxn2_3000b", 1440)
    assert row(made("kong2025"), f"{kong2025.MOMENT}, before, maximum").ours == pytest.approx(
        -before.reactions.driving_torque.min(), rel=1e-4
    )
    lowest = row(made("kong2025"), f"{kong2025.UPRIGHT}, before, minimum").ours
    assert lowest == pytest.approx(-before.reactions.bearing_force["A"][:, 2].max(), rel=1e-4)


def without_inertias(monkeypatch):
    """The hand script with bodies whose mass is at their centres."""
    for name in ("J2", "J3"):
        monkeypatch.setattr(six_bar_script, name, 0.0)
    for name in ("CRANK", "ROD"):
        bodies = {balanced: (mass, place, 0.0) for balanced, (mass, place, _) in getattr(six_bar_script, name).items()}
        monkeypatch.setattr(six_bar_script, name, bodies)


@pytest.mark.parametrize(("words", "weight"), [("with G1", True), ("without G1", False)])
@pytest.mark.parametrize("inertias", ["our inertias", "inertias zero"])
def test_kong_weight_of_the_crank_by_the_hand_script(made, monkeypatch, words, weight, inertias):
    """The deviation from tables 2 and 3, by the script that shares no code with pinpress; the weight G1 is taken out of its equations."""
    if inertias == "inertias zero":
        without_inertias(monkeypatch)
    angle = np.linspace(0.0, 2 * np.pi, 7200, endpoint=False)
    deviations = []
    for balanced in (False, True):
        result = six_bar_script.six_bar(angle, 70 * np.pi / 30, 0.0, balanced)
        mass, centre, _ = six_bar_script.CRANK[balanced]
        lost = 0.0 if weight else 9.81 * mass
        moment = -(result["tau"] - lost * centre * np.cos(angle))
        curves = (moment, -result["F01x"], -(result["F01y"] - lost))
        for curve, printed in zip(curves, kong2025.PRINTED.values(), strict=True):
            scale = printed[0][0] - printed[0][1]
            deviations += [(curve.max() - printed[balanced][0]) / scale, (curve.min() - printed[balanced][1]) / scale]
    first = "rms deviation from tables 2 and 3" if inertias == "our inertias" else "the same"
    found = row(made("kong2025"), f"{first}, {words}, {inertias} [%]").ours
    assert found == pytest.approx(100 * np.sqrt(np.mean(np.square(deviations))), rel=1e-6)


@pytest.mark.exhaustive
def test_kong_no_inertias_do_better_than_the_best(made):
    """Deviations for inertias from a coarse grid, beside the least that the page states."""
    pair = [kong2025.parts(kong2025.state(name, 360)) for name in ("zxn2_3000b", "zxn2_3000b_balanced")]
    grid = np.stack(np.meshgrid(*[(0.0, 0.3, 1.0, 5.0)] * 4), axis=-1).reshape(-1, 4)
    for words, weight in (("with G1", 1.0), ("without G1", 0.0)):
        best = row(made("kong2025"), f"the same, {words}, the best of all inertias [%]").ours
        assert min(kong2025.rms_deviation(pair, weight, shares) for shares in grid) > best - 0.02  # 360 angles miss so much of extremes


@pytest.mark.exhaustive
def test_kong_force_in_a_is_the_cranks_on_the_frame():
    """With the other sign tables 2 and 3 are more than twice as far away."""
    pair = [kong2025.parts(kong2025.state(name, 360)) for name in ("zxn2_3000b", "zxn2_3000b_balanced")]
    sign = np.array([[1.0], [-1.0], [-1.0]])
    turned = [replace(each, rest=sign * each.rest, weight=sign * each.weight, inertia=sign * each.inertia) for each in pair]
    assert kong2025.rms_deviation(turned, 1.0, np.ones(4)) > 2 * kong2025.rms_deviation(pair, 1.0, np.ones(4))


def test_kong_errata_of_the_accelerations():
    """Rows 3 and 4 of (10) as printed, with right accelerations: they hold once the terms of l32 change their signs."""
    r = six_bar_script.six_bar(np.linspace(0.0, 2 * np.pi, 60, endpoint=False), 70 * np.pi / 30, 0.0)
    e, f = (0.48 * np.exp(1j * angle) for angle in (r["theta3"] - 0.75 * np.pi, r["theta4"]))  # DE and EF
    left = 1j * (e * r["alpha3"] + f * r["alpha4"]) - 1j * r["slide_acceleration"]  # row 3 + i row 4

    def right(sign):  # the last vector has zeros here
        return sign * e * r["omega3"] ** 2 + f * r["omega4"] ** 2

    assert np.abs(left - right(-1.0)).max() > 1.0
    assert np.abs(left - right(1.0)).max() < 1e-12 * np.abs(left).max()


def test_kong_errata_of_the_moments():
    """(12) to (14) as printed, with right forces: (14) holds, (12) and (13) once the terms that the page names change their signs."""
    angle = np.linspace(0.0, 2 * np.pi, 60, endpoint=False)
    r = six_bar_script.six_bar(angle, 70 * np.pi / 30, 0.0)
    turn = {k: np.exp(1j * r[f"theta{k}"]) for k in (2, 3, 4)}
    b = 1.25 - 0.2j + 0.143 * np.exp(1j * angle)
    c, e, f, d = 0.375 * turn[3], 0.48 * turn[3] * np.exp(-0.75j * np.pi), 1j * r["slide_position"], 0 * b
    s2, s3, s4 = b + 0.8456 * turn[2], (-0.0086 - 0.0038j) * turn[3], e + 0.24 * turn[4]
    f12x, f12y, f32x, f32y = -r["F21x"], -r["F21y"], -r["F23x"], -r["F23y"]
    f34x, f34y = -r["F43x"], -r["F43y"]

    def coupler(sign):
        return (
            sign * f32y * (s2 - c).real + f12y * (b - s2).real - f32x * (c - s2).imag - sign * f12x * (s2 - b).imag
        ) - six_bar_script.J2 * r["alpha2"]

    def rocker(sign):
        return (
            r["F23y"] * (c - s3).real
            + r["F43y"] * (e - s3).real
            + sign * r["F03y"] * (s3 - d).real
            - r["F23x"] * (c - s3).imag
            - sign * r["F43x"] * (s3 - e).imag
            - r["F03x"] * (d - s3).imag
        ) - six_bar_script.J3 * r["alpha3"]

    rod = (f34y * (e - s4).real + r["F54x"] * (s4 - f).imag - f34x * (e - s4).imag - r["F54y"] * (s4 - f).real) - six_bar_script.ROD[False][
        2
    ] * r["alpha4"]
    assert np.abs(rod).max() < 1e-8
    for residual in (coupler, rocker):
        assert np.abs(residual(1.0)).max() > 1e3
        assert np.abs(residual(-1.0)).max() < 1e-7


# ----------------------------------------------------------------------------------------------------------------------- Zhang 2007

MAIN, AUXILIARY = (0.015, 0.300, 52.25, 77.49, 2200.0), (0.0297, 0.600, 18.38, None, None)  # radius, rod [m], crank, rod, slide [kg]


def inertia_force(radius, length, crank, rod, slide, angle, speed):
    """Along the slide's line, of a crank with its mass at the pin and a rod with its mass half-way, at constant speed [N]."""
    ratio = radius / length
    root = np.sqrt(1 - (ratio * np.sin(angle)) ** 2)
    # second derivative of r cos q + l sqrt(1 - lambda^2 sin^2 q)
    at_slide = -radius * np.cos(angle) - length * ratio**2 * (np.cos(2 * angle) / root + (ratio * np.sin(2 * angle)) ** 2 / (4 * root**3))
    at_pin = -radius * np.cos(angle)
    return speed**2 * ((crank + rod / 2) * at_pin + (slide + rod / 2) * at_slide)


def closed_form_range(rod, counterweight, rpm=300):
    """Range of the vertical shaking force of the opposed press [N]."""
    angle, speed = np.linspace(0, 2 * np.pi, 7201), rpm * 2 * np.pi / 60
    radius, length, crank, _, _ = AUXILIARY
    main = inertia_force(*MAIN, angle, speed)
    return np.ptp(main - inertia_force(radius, length, crank, rod, counterweight, angle, speed))


@pytest.mark.exhaustive
def test_zhang_search_in_closed_form(made):
    """Every step of table 5-1, to what 720 crank angles miss of an extreme."""
    for k, (rod, counterweight, theirs) in enumerate(zhang2007_balancing.SEARCH, 1):
        found = row(made("zhang2007"), f"step {k}, m5 = {rod:g} kg, m6 = {counterweight:g} kg [N]")
        assert found.theirs == theirs
        assert found.ours == pytest.approx(closed_form_range(rod, counterweight), rel=1e-4)
    best = [row(made("zhang2007"), f"optimum, {mass} [kg]").ours for mass in ("m5", "m6")]
    assert closed_form_range(*best) == pytest.approx(0.04138, rel=2e-3)
    for rod, counterweight in ((best[0] + 1, best[1] - 1), (best[0] - 1, best[1] + 1), (best[0], best[1] + 0.01)):
        assert closed_form_range(rod, counterweight) > closed_form_range(*best)


def test_zhang_masses_change_a_press_as_they_should():
    """`ranges` from three presses against a press with these masses, and against the shipped one."""
    opposed = zhang2007_balancing.presses()["jf75g_125"]
    masses = np.array([[130.0, 1100.0], [113.31, 1045.0]])
    found = zhang2007_balancing.ranges(opposed)(masses)
    changed = zhang2007_balancing.turning(zhang2007_balancing.with_masses(opposed, 130.0, 1100.0)).shaking_force[:, 2]
    shipped = zhang2007_balancing.turning(opposed).shaking_force[:, 2]
    assert found == pytest.approx([np.ptp(changed), np.ptp(shipped)], rel=1e-9)


@pytest.mark.exhaustive
@pytest.mark.parametrize("rpm", ["300", "400"])
def test_zhang_table_5_2_against_the_reference(made, rpm):
    """The plain and the opposed press of `reference/jf75g_125.json`, to what 720 crank angles miss of an extreme."""
    known = reference("jf75g_125")["shaking"]
    plain, opposed = known["jf75g_125_plain"][rpm], known["jf75g_125"][rpm]
    names = {"vertical maximum": "Fy_max", "vertical minimum": "Fy_min", "vertical range": "Fy_range", "lateral range": "Fz_range"}
    for words, key in names.items():
        ours = row(made("zhang2007"), f"original, {rpm} r/min, {words} [N]").ours
        assert ours == pytest.approx(plain[key], abs=1e-4 * plain["Fy_range"])
    assert row(made("zhang2007"), f"improved, {rpm} r/min, vertical range [N]").ours == pytest.approx(opposed["Fy_range"], rel=1e-4)
    assert row(made("zhang2007"), f"improved, {rpm} r/min, lateral range [N]").ours == 0.0


def test_zhang_table_5_2_as_printed_is_consistent_but_for_one_maximum_or_range():
    """Range = maximum - minimum but for one: vertically at 300 r/min. Which is wrong stands open: the page has both readings."""
    for rpm, printed in (*zhang2007_balancing.BEFORE.items(), *zhang2007_balancing.AFTER.items()):
        numbers = [float(number) for number in printed]
        fits = abs(numbers[0] - numbers[1] - numbers[2]) < 0.002
        assert fits is (printed is not zhang2007_balancing.BEFORE[300]), rpm
        assert numbers[3] - numbers[4] == pytest.approx(numbers[5], abs=0.002)
    # by hand, from the printed numbers; ours is the range of the closed form below
    angle = np.linspace(0, 2 * np.pi, 7201)
    ours = np.ptp(inertia_force(*MAIN, angle, 10 * np.pi))
    readings = zhang2007_balancing._readings(ours).rows
    assert readings[0][1:-1] == ("11621.795", "77411.358", "3.3239", "3.3245", "1.1111", "1.1109", "1.3455", "28.41")
    assert readings[1][1:-1] == ("1162.795", "66952.358", "0.3326", "3.3245", "11.1054", "1.1109", "1.5557", "24.57")
    assert [each[-1] for each in readings] == ["-10.9", "+3.0"]


def test_zhang_other_lengths_in_closed_form():
    """`closed_form_ranges` with the inferred lengths beside the function of this file and beside the press itself."""
    masses = np.array([[113.31, 1045.0], [100.0, 1000.0]])
    found = zhang2007_balancing.closed_form_ranges(zhang2007_balancing.LENGTHS["inferred"], masses)
    assert found == pytest.approx([closed_form_range(*each) for each in masses], rel=1e-12)
    assert found == pytest.approx(zhang2007_balancing.ranges(zhang2007_balancing.presses()["jf75g_125"])(masses), rel=1e-4)


def test_zhang_equations_without_small_terms_are_near_the_exact_one():
    """(4.2.12) and (4.2.41) after 0.6 s, as found by an integration without pinpress: 4e-4 and 1.1e-3 rad off."""
    plain, opposed, _ = zhang2007_balancing.presses().values()
    errors = [each.ours for each in zhang2007_runs._simplified(plain, opposed)]
    assert errors == pytest.approx([4.1e-4, -1.112e-3], abs=5e-6)


@pytest.mark.exhaustive
def test_zhang_guide_force_in_closed_form(made):
    """From moments of the rod about the crank pin, with the angular acceleration that the thesis leaves out."""
    radius, length, _, rod, slide = MAIN
    speed, g = 10 * np.pi, 9.80665
    q = np.linspace(0, 2 * np.pi, 7201)
    tilt = np.arcsin(radius / length * np.sin(q))
    rate = speed * radius / length * np.cos(q) / np.cos(tilt)
    spin = np.tan(tilt) * (rate**2 - speed**2)
    # from the crank pin, x across and z up: to the slide; accelerations of pin and slide
    arm = length * np.array([-np.sin(tilt), -np.cos(tilt)])
    at_pin = speed**2 * radius * np.array([-np.sin(q), np.cos(q)])
    at_slide = np.array([0 * q, at_pin[1] + length * (np.cos(tilt) * rate**2 + np.sin(tilt) * spin)])
    centre = (at_pin + at_slide) / 2 + np.array([[0.0], [g]])
    fall = at_slide + np.array([[0.0], [g]])
    moment = (
        rod / 2 * (arm[0] * centre[1] - arm[1] * centre[0]) + slide * (arm[0] * fall[1] - arm[1] * fall[0]) - rod * length**2 / 12 * spin
    )
    found = row(made("zhang2007"), "peak of X4, the force in the slide's guide, by (3.5.24) [N]")
    assert np.abs(moment / arm[1]).max() == pytest.approx(found.ours, rel=1e-4)
    assert float(found.theirs) < 0.65 * found.ours


def test_zhang_errata_of_the_pin_forces():
    """(3.5.1) and (3.5.4) as they should be: with the forces that (3.5.2) and (3.5.3) give, the power is the rate of the energy."""
    l1, l3, e3, mass, inertia, g, speed = 0.015, 0.3, 0.29, 2277.0, 9.0, 9.80665, 31.0
    theta = np.linspace(0.0, 2 * np.pi, 73)
    alpha = np.arcsin(l1 / l3 * np.cos(theta))
    rate = -l1 / l3 * np.sin(theta) * speed / np.cos(alpha)
    second = (rate**2 * np.sin(alpha) - l1 / l3 * np.cos(theta) * speed**2) / np.cos(alpha)
    # mass centre of rod and slide (3.5.9), (3.5.11), and its derivatives
    vx, vy = (l3 - e3) * np.cos(alpha) * rate, l1 * np.cos(theta) * speed - e3 * np.sin(alpha) * rate
    ax = (l3 - e3) * (np.cos(alpha) * second - np.sin(alpha) * rate**2)
    ay = -l1 * np.sin(theta) * speed**2 - e3 * (np.sin(alpha) * second + np.cos(alpha) * rate**2)
    y2 = mass * (g + ay)  # (3.5.3)
    # (3.5.2): X4 = X2 + m x'', into (3.5.4): J alpha'' = -X4 (L3 - e3) cos(alpha) - X2 e3 cos(alpha) + Y2 e3 sin(alpha)
    x2 = (y2 * e3 * np.sin(alpha) - mass * ax * (l3 - e3) * np.cos(alpha) - inertia * second) / (l3 * np.cos(alpha))
    moment = l1 * (x2 * np.sin(theta) + y2 * np.cos(theta))  # M of (3.5.1) at constant speed, without P3
    power = mass * (vx * ax + vy * (ay + g)) + inertia * rate * second
    np.testing.assert_allclose(moment * speed, power, atol=1e-9 * np.abs(power).max())


@pytest.mark.exhaustive
def test_zhang_table_5_2_by_its_weights(made):
    """Extremes without the flywheel's weight and without any, in closed form; what the original leaves with the counterweight it has."""
    page, angle = made("zhang2007"), np.linspace(0, 2 * np.pi, 7201)
    force, mass = -inertia_force(*MAIN, angle, 10 * np.pi), sum(MAIN[2:])  # of the mechanism on the floor, upwards: on it, turned
    for words, weight in ((" without any weight", 0.0), (" without the weight of the flywheel", mass), ("", mass + 940.0)):
        for what, extreme in (("maximum", np.max), ("minimum", np.min)):
            found = row(page, f"original, 300 r/min, vertical {what}{words} [N]").ours
            assert found == pytest.approx(extreme(-force) - 9.80665 * weight, abs=1.0) or found == pytest.approx(
                extreme(force) - 9.80665 * weight, abs=1.0
            )
    ours = row(page, "original with its counterweight, 300 r/min, vertical range [N]").ours
    assert ours == pytest.approx(closed_form_range(113.31, 1045.0), rel=1e-4)


@pytest.mark.exhaustive
def test_zhang_window_of_blanking_has_two_readings(made):
    """Crank radius from a sheet of 5 mm, rod twenty times as long, in closed form."""
    for end, sine in ((0.1738, 0.707), (0.1838, 0.990)):
        first, last = (
            1 - np.cos(q) + 20 * (1 - np.sqrt(1 - (np.sin(q) / 20) ** 2)) for q in (10 * np.pi * (0.2 - 0.1616), 10 * np.pi * (0.2 - end))
        )
        radius = row(made("zhang2007"), f"window to {end} s: crank radius, rod twenty times as long [mm]").ours
        assert radius == pytest.approx(5.0 / (first - last), rel=1e-6)
        assert row(made("zhang2007"), f"window to {end} s: sine at its end, with pi / 0.0488").ours == pytest.approx(sine, abs=5e-4)


def test_zhang_forces_on_the_frame_balance():
    """Mechanism and die together put the shaking force on the frame."""
    press = zhang2007_balancing.presses()["jf75g_125_symmetric"]
    load = zhang2007_runs.laws(1250e3)["drawing"]
    found = zhang2007_runs.frame_forces(press, load)
    stroke = zhang2007_runs.run(press, load, 0.205, 2001)
    np.testing.assert_array_equal(found.run.time, stroke.time)
    down = stroke.slide_velocity < 0
    on_slide = np.where(down, zhang2007_runs.on_slide(load, stroke.slide_position - pp.dead_centres(press).bottom_position), 0.0)
    shaking = pp.inverse_dynamics(press, stroke, loads=[load]).shaking_force[:, 2] + zhang2007_balancing.weight(press)
    np.testing.assert_allclose(found.vertical, shaking + on_slide, atol=1e-6 * 1250e3)
    assert np.abs(found.vertical).max() == pytest.approx(1250e3, rel=1e-3)


def test_zhang_printed_loads_are_those_of_5_7():
    """The functions of 5.7.3 to 5.7.5 written out, with the sum over five strokes."""
    time = np.linspace(0.0, 0.9999, 20001)

    def adams(x, x0, h0, x1, h1):
        d = np.clip((x - x0) / (x1 - x0), 0, 1)
        return h0 + (h1 - h0) * d * d * (3 - 2 * d)

    def window(start, begin, shut, end):
        return adams(time, start, 0.0, begin, 1.0) * adams(time, shut, 1.0, end, 0.0)

    strokes = 0.2 * np.arange(5)
    piling = sum(window(0.0974 + s, 0.0975 + s, 0.1024 + s, 0.1025 + s) for s in strokes)
    blanking = sum(np.sin((time - 0.1616 - s) * np.pi / 0.0488) * window(0.1615 + s, 0.1616 + s, 0.1837 + s, 0.1838 + s) for s in strokes)
    drawing = sum(np.sin((time - 0.1616 - s) * np.pi / 0.0244) * window(0.1615 + s, 0.1616 + s, 0.19999 + s, 0.2 + s) for s in strokes)
    for name, wanted in {"piling": piling, "blanking": blanking, "drawing": drawing}.items():
        np.testing.assert_allclose(zhang2007_runs.printed(name).force(time), -1250 * wanted, atol=1e-6)


def test_zhang_lateral_forces_of_two_shafts_cancel():
    press = zhang2007_balancing.presses()["jf75g_125_symmetric"]
    found = zhang2007_runs.frame_forces(press, zhang2007_runs.laws(1250e3)["blanking"])
    assert np.abs(found.lateral).max() < 1e-9 * 1250e3
    # each rod carries half of the process force, at its slope
    idle = -pp.inverse_dynamics(press, found.run).bearing_force["O_left"][:, 0]
    heights = found.run.slide_position - pp.dead_centres(press).bottom_position
    force = np.where(found.run.slide_velocity < 0, zhang2007_runs.on_slide(zhang2007_runs.laws(1250e3)["blanking"], heights), 0.0)
    slope = 0.05 * np.sin(found.run.crank_angle)
    np.testing.assert_allclose(np.abs(found.shaft - idle), 0.5 * force * np.abs(slope) / np.sqrt(1 - slope**2), atol=1e-8 * 1250e3)


@pytest.mark.parametrize("name", zhang2007_runs.PEAKS)
def test_zhang_five_strokes(name):
    """Five forces in five turns, whether the press makes them in a second or not; 1250 N hardly show beside what moves."""
    press, load = zhang2007_balancing.presses()["jf75g_125_symmetric"], zhang2007_runs.laws(1250e3)[name]
    found = zhang2007_runs.five_strokes(press, load)
    acting = np.abs(found.vertical) > 0.5 * 1250e3
    begins, ends = (int((np.diff(acting.astype(int)) == way).sum()) for way in (1, -1))
    assert {begins, ends} == {5}  # piling, which begins at bottom dead centre, is cut in two: its last half is the first
    assert found.run.crank_angle[: len(found.time)][-1] == pytest.approx(10 * np.pi, abs=0.01)
    plain, shown = (zhang2007_runs.frame_forces(press, each, 1.0, 1001) for each in (zhang2007_runs.NO_LOAD, zhang2007_runs.printed(name)))
    slope = 0.05 * np.sin(plain.run.crank_angle)
    most = 0.5 * 1250 * np.abs(slope) / np.sqrt(1 - slope**2)
    assert np.abs(shown.shaft - plain.shaft).max() < most.max() + 0.02 * np.ptp(plain.shaft)  # the rods' share, and another speed


@pytest.mark.exhaustive
def test_zhang_searches_end_where_their_methods_do(made):
    """The simplex ends at the optimum of an independent solver; a search along the coordinates stalls in the valley: at its end every step
    along one mass leads up, and one along the valley down."""
    opposed = zhang2007_balancing.presses()["jf75g_125"]
    objective = zhang2007_balancing.ranges(opposed)
    found, random = zhang2007_search.searches(objective), zhang2007_search.SPREAD[0]
    for each in found.values():
        assert each.least == each.ranges.min() == pytest.approx(float(objective(each.masses[None])[0]), rel=1e-9, abs=1e-9)
    assert found["simplex"].least == pytest.approx(0.04138, rel=2e-3)
    stalled = found["step by step"]
    steps = 1e-3 * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
    assert (objective(stalled.masses + steps) > stalled.least).all()
    rod, counterweight = stalled.masses
    assert objective(np.array([[rod - 1.0, counterweight + 1.0]]))[0] < stalled.least - 1.0
    assert min(each.least for each in found.values()) >= zhang2007_search.proved(opposed).least * (1 - 1e-9)
    assert found[random].evaluations == len(zhang2007_search.tried(random)) == 1000
    assert row(made("zhang2007"), "proved optimum, range [N]").ours == pytest.approx(0.04138, rel=2e-3)


# ------------------------------------------------------------------------------------------------------------------------ Chen 2002


@pytest.mark.exhaustive
def test_chen_numbers_by_the_papers_equations(made):
    """(7) to (17) of the paper written out, over a fine grid of the working stroke."""
    l1, l3, l4, l6, h, speed = 108.0, 648.0, 220.0, 350.0, 630.0, 7.54

    def ram(q):
        s3 = np.sqrt(l6**2 + l1**2 + 2 * l1 * l6 * np.sin(q))
        theta3 = np.arccos(l1 * np.cos(q) / s3)
        theta4 = np.arcsin((h - l3 * np.sin(theta3)) / l4)
        omega3 = l1 * speed * np.cos(q - theta3) / s3
        omega4 = -l3 * omega3 * np.cos(theta3) / (l4 * np.cos(theta4))
        v = l3 * omega3 * np.sin(theta3) + l4 * omega4 * np.sin(theta4)
        return l3 * np.cos(theta3) + l4 * np.cos(theta4), v, theta4

    q = np.radians(np.linspace(-17.973159220540943, 197.97315922054094, 200001))
    x, v, theta4 = ram(q)
    page, within = made("chen2002"), ram(np.radians(np.linspace(60, 120, 60001)))[1]
    mean = (x[0] - x[-1]) * speed / np.ptp(q)
    expected = {
        "stroke [mm]": x[0] - x[-1],
        "time ratio K": np.ptp(q) / (2 * np.pi - np.ptp(q)),
        "largest speed of the working stroke [mm/s]": v.max(),
        "mean speed of the working stroke [mm/s]": mean,
        "f = v_max / v_mean, printed lengths": v.max() / mean,
        "drop of speed within it [%]": 100 * (1 - within.min() / within.max()),
        "largest pressure angle, (18) [deg]": np.degrees(np.abs(theta4).max()),
    }
    for words, value in expected.items():
        assert row(page, words).ours == pytest.approx(value, rel=1e-6), words
    # least drop over 120 mm: the speed having but one peak, that stretch which begins as fast as it ends
    assert np.count_nonzero(np.diff(np.sign(np.diff(v)))) == 1
    begin = brentq(lambda q0: ram(q0)[1] - np.interp(-(ram(q0)[0] - 120.0), -x, v), np.radians(30), np.radians(87), xtol=1e-12)
    assert row(page, "least drop of speed over any 120 mm [%]").ours == pytest.approx(100 * (1 - ram(begin)[1] / v.max()), rel=1e-6)


def test_chen_constraints_of_crank_and_guide_by_hand():
    """l1 - l6, h - l3 - l4, and s3 between l6 - l1 and l6 + l1, which it reaches at 270 and 90 deg."""
    press = pp.load("thin_wall")
    found = [each.ours for each in chen2002._existence(press, pp.cycle(press, 7.54, points=720))]
    assert found == pytest.approx([108.0 - 350.0, 630.0 - 648.0 - 220.0, 0.0, 350.0 + 108.0], abs=1e-9)


@pytest.mark.exhaustive
def test_chen_objective_is_degenerate(made):
    """f falls with l4 towards its limit, and does not know l1."""
    page = made("chen2002")
    falling = [row(page, f"f, l4 = {length} mm").ours for length in (150, 220, 400, 1000, 3000)]
    assert falling == sorted(falling, reverse=True)
    assert falling[-1] > 1.43997794
    for length in (80, 140):
        assert row(page, f"f, l4 = 220 mm, l1 = {length} mm").ours == pytest.approx(falling[1], rel=1e-9)
    assert row(page, "l4 that the search within 150 to 220 mm ends at [mm]").ours == pytest.approx(220, rel=1e-6)
