"""Ratings as a catalogue page in text, and as columns."""

from typing import TYPE_CHECKING

import numpy as np

from ..common.arrays import Array
from ..common.units import RPM

if TYPE_CHECKING:
    from .rating import Ratings

ROWS = 16  # of the table of forces, besides the heights at which another limit governs


def columns(ratings: "Ratings") -> dict[str, Array | list[str]]:
    """Columns (n,) from top to bottom dead centre."""
    return {
        "height [m]": ratings.height,
        "crank_angle [rad]": ratings.crank_angle,
        "travel_per_angle [m/rad]": ratings.travel_per_angle,
        "slide_velocity [m/s]": ratings.slide_velocity,
        "force [N]": ratings.force,
        "limited_by": list(ratings.limited_by),
        **{f"{name} [N]": force for name, force in ratings.limits.items()},
        "work [J]": ratings.work,
    }


def text(ratings: "Ratings") -> str:
    """Main data, energies, and permissible force at some heights; units beside every number."""
    rpm = abs(ratings.speed) / RPM / ratings.turns
    what = "with weights and inertia forces at this speed" if ratings.at_speed else "the process force alone, as catalogues print it"
    return "\n".join(
        [
            f"{ratings.press}, ratings at {rpm:g} strokes/min{'' if ratings.speed > 0 else ', backwards'}; forces: {what}",
            *(f"  {name:38}{value}" for name, value in _data(ratings)),
            "",
            "Permissible force",
            f"  {'height [mm]':>14}{'crank angle [deg]':>20}{'torque per force [mm]':>24}{'force [kN]':>14}{'work [kJ]':>13}  limited by",
            *(_row(ratings, k) for k in _shown(ratings)),
        ]
    )


def _data(ratings: "Ratings") -> list[tuple[str, str]]:
    given, limit = ratings.capacities, ratings.speed_limit
    rows: list[tuple[str, str | None]] = [
        ("nominal force", f"{given.nominal_force / 1e3:.6g} kN"),
        ("nominal height", None if given.nominal_height is None else f"{1e3 * given.nominal_height:.6g} mm above bottom dead centre"),
        ("torque capacity", None if ratings.torque_capacity is None else f"{ratings.torque_capacity / 1e3:.6g} kN m"),
        ("stroke", f"{1e3 * ratings.stroke:.6g} mm"),
        ("quick return ratio", f"{ratings.quick_return_ratio:.6g}"),
        ("highest speed in the working stroke", f"{np.abs(ratings.slide_velocity).max():.6g} m/s"),
        (
            "speed at contact",
            None
            if ratings.contact_speed is None or ratings.contact_height is None
            else f"{ratings.contact_speed:.6g} m/s, {1e3 * ratings.contact_height:.6g} mm above bottom dead centre",
        ),
        (
            "mechanical advantage there",
            None if ratings.contact_advantage is None else f"{ratings.contact_advantage:.6g} N for each N m on the crank",
        ),
        ("dwell", f"{1e3 * ratings.dwell_time:.6g} ms within {1e3 * ratings.dwell_tolerance:.6g} mm of bottom dead centre"),
        *((name, f"{energy / 1e3:.6g} kJ a stroke") for name, energy in ratings.energies.items()),
        (
            "highest speed, idle",
            None
            if limit is None
            else f"{limit.strokes_per_minute:.6g} strokes/min, by {limit.limited_by} at {np.degrees(limit.crank_angle):.4g} deg",
        ),
    ]
    return [(name, value) for name, value in rows if value is not None]


def _shown(ratings: "Ratings") -> list[int]:
    """Indices of the heights shown: even steps of the crank angle, the nominal height, and where another limit begins to govern."""
    even = np.linspace(0, len(ratings.height) - 1, ROWS).round().astype(int)
    marks = [*ratings.changes, *([] if ratings.capacities.nominal_height is None else [ratings.capacities.nominal_height])]
    return sorted({*even.tolist(), *(int(np.abs(ratings.height - mark).argmin()) for mark in marks)})


def _row(ratings: "Ratings", k: int) -> str:
    angle = np.degrees(ratings.crank_angle[k]) % (360 * ratings.turns)
    return (
        f"  {1e3 * ratings.height[k]:14.3f}{angle:20.2f}{1e3 * abs(ratings.travel_per_angle[k]):24.4f}"
        f"{ratings.force[k] / 1e3:14.2f}{ratings.work[k] / 1e3:13.4f}  {ratings.limited_by[k]}"
    )
