"""The safety distance of a protective device by the formulas of ISO 13855, ANSI B11.19 and OSHA 1910.217.

Every addend is named, with its source. Nothing here is advice. No table of a standard is copied: a value of a table, such as D_DS of ISO
13855:2024, is an argument.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..common.arguments import in_unit, suitable_numbers
from ..common.errors import PinpressError, caution, shown
from ..common.results import Tabular
from ..common.tables import Columns

IN = 0.0254  # [m]
# where constants are from, next to the standards themselves
ISO_2010 = "K and C as printed by SICK 8012624, page 24, and Rockwell 450L-UM001, page 72"
ISO_2024 = "K as printed by leuze.com and gt-engineering.it; D_DS and Z as given"
ANSI = "K and Dpf as printed by IDEC FS1A, page 7-5"
FINE = 0.064  # up to which this Dpf of ANSI B11.19 holds [m]: coarser curtains let an arm through
OSHA = "K of 29 CFR 1910.217(c)(3); the stopping time is that at 90 deg after top dead centre"
EDITIONS = {  # edition -> lengths that its formula needs, and those that it takes
    "ISO 13855:2010": (("resolution",), ("resolution",)),
    "ISO 13855:2024": (("reach", "supplement"), ("reach", "supplement")),
    "ANSI B11.19": (("resolution",), ("resolution",)),
    "OSHA 1910.217": ((), ()),
}
LONG = 2.0  # no press that is loaded by hand takes longer to stop [s]
UNMONITORED = 0.2  # share of stopping and control time that ANSI B11.19 adds for a press without a brake monitor


@dataclass(frozen=True, eq=False, repr=False)
class SafetyDistance(Tabular):
    """The distance by a formula, with every addend.

    Attributes:
        edition: the standard.
        distance: S [m].
        addends: the terms of the sum: name, time [s] or None, length [m], and source.
        formula: as text, with the sources of its constants.
        failed: "half of the springs", and "without the loads" if there are any -> the distance with such a failure; None if the brake then
            does not hold the press.
    """

    edition: str
    distance: float
    addends: tuple[tuple[str, float | None, float, str], ...]
    formula: str
    failed: Mapping[str, SafetyDistance | None] = field(default_factory=dict)

    @property
    def title(self) -> str:
        return f"SafetyDistance by {self.edition}: {self.distance:.4f} m"

    def columns(self) -> Columns:
        """A row for each addend."""
        names, times, lengths, sources = zip(*self.addends, strict=True)
        return {"addend": [*names], "time [s]": [*times], "length [m]": [*lengths], "source": [*sources]}


def safety_distance(
    edition: str, times: Mapping[str, float], monitor: float | None, lengths: Mapping[str, float], two_hand: bool, acting: str
) -> SafetyDistance:
    """The distance by the formula of an edition; arguments as for `StoppingTimes.distance`, times [s] by their names, lengths [m];
    ``acting``: with what the stopping time is computed."""
    if not isinstance(edition, str) or edition not in EDITIONS:
        raise PinpressError(f"edition is {shown(edition)}: give one of {', '.join(EDITIONS)}")
    iso = edition.startswith("ISO")
    if two_hand and not iso:
        raise PinpressError(f"two_hand is no part of the formula of {edition}: leave it out")
    needed, taken = EDITIONS[edition]
    needed = () if two_hand and edition == "ISO 13855:2010" else needed
    for name in lengths:
        if name not in taken or (two_hand and name == "resolution"):
            raise PinpressError(
                f"{name} is no part of the formula of {edition}{' for two-hand controls' if two_hand else ''}: leave it out"
            )
    for name in needed:
        if name not in lengths:
            raise PinpressError(f"{edition} needs {name}: give {name}=0.014 [m]")
    if edition.startswith("ANSI") and lengths["resolution"] > FINE:
        coarse = f"resolution is {1e3 * lengths['resolution']:g} mm: Dpf = 3.4 (d - 7 mm) is for curtains of at most {1e3 * FINE:g} mm"
        raise PinpressError(f"{coarse}, because an arm reaches through coarser ones; give a finer one")
    stopping_time = times["at 90 deg" if edition.startswith("OSHA") else "stopping"]
    rows: list[tuple[str, float, str]] = [
        ("stopping time", stopping_time, f"computed with {acting}, without wear, heat and scatter"),
        ("control", times["control"], "given"),
        ("device", times["device"], "given"),
    ]
    if monitor is not None:
        rows.append(("brake monitor", monitor, "given"))
    elif edition.startswith("ANSI"):
        rows.append(
            ("brake monitor", UNMONITORED * (stopping_time + times["control"]), "20 % of stopping and control time, as no monitor is given")
        )
    total = sum(time for _, time, _ in rows)
    if total > LONG:
        caution(f"from the signal to standstill it takes {total:.3g} s: if ms are meant, write them in seconds, as 0.030")
    if iso:
        pace, more, least, formula = _iso(edition, total, lengths, two_hand)
    else:
        more = {} if edition.startswith("OSHA") else {"Dpf": max(3.4 * (lengths["resolution"] - 0.007), 0.0)}
        pace, least = 63 * IN, 0.0
        formula = f"S = 63 in/s T; {OSHA}, the longest is {times['stopping']:.4g} s"
        if more:
            formula = f"S = 63 in/s T + Dpf, Dpf = 3.4 (d - 7 mm); {ANSI}"
    addends: list[tuple[str, float | None, float, str]] = [(name, time, pace * time, source) for name, time, source in rows]
    addends += [(name, None, length, "given" if name in ("D_DS", "Z") else "formula") for name, length in more.items()]
    distance = pace * total + sum(more.values())
    if distance < least:
        addends.append((f"up to {1e3 * least:g} mm", None, least - distance, "least distance of the formula"))
    return SafetyDistance(edition, max(distance, least), tuple(addends), formula)


def _iso(edition: str, total: float, lengths: Mapping[str, float], two_hand: bool) -> tuple[float, dict[str, float], float, str]:
    """Speed K [m/s], what is added [m], the least distance [m], and the formula as text, for a total time [s]."""
    if edition.endswith("2010"):
        source, letters = ISO_2010, "K T + C"
        resolution = lengths.get("resolution", 0.0)
        if resolution > 0.070:
            raise PinpressError(f"resolution is {1e3 * resolution:g} mm: the formula is for curtains of at most 70 mm; give a finer one")
        far = two_hand or resolution > 0.040
        more = {"C": 0.25 if two_hand else 0.85 if far else max(8 * (resolution - 0.014), 0.0)}
    else:
        source, letters, far = ISO_2024, "K T + D_DS + Z", two_hand
        more = {"D_DS": lengths["reach"], "Z": lengths["supplement"]}
    near = 2.0 * total + sum(more.values())
    if far:
        return 1.6, more, 0.1, f"S = {letters}, K = 1600 mm/s; {source}"
    if near <= 0.5:
        return 2.0, more, 0.1, f"S = {letters}, K = 2000 mm/s, at least 100 mm; {source}"
    return 1.6, more, 0.5, f"S = {letters}, K = 1600 mm/s, at least 500 mm, as K = 2000 mm/s gives more than 500 mm; {source}"


def length_argument(name: str, value: object) -> float:
    length = not_negative(name, value, "m")
    if name == "resolution" and 0.0 < length < 0.005:
        caution(f"resolution is {1e3 * length:g} mm, and no curtain is as fine: give it in m, as 0.014")
    if length > 10.0:
        raise PinpressError(f"{name} is {length:g} m: give it in m, as 0.014 for 14 mm")
    return length


def not_negative(name: str, value: object, unit: str) -> float:
    wanted = f"0, or one number from 1e-9 to 1e9 [{unit}]"
    return float(suitable_numbers(name, in_unit(name, value, unit), wanted, suits=lambda each: each == 0.0 or 1e-9 <= each <= 1e9))
