"""What the choice of motor and flywheel shows: the best, and every motor with every gear."""

from __future__ import annotations

from ..common.outlets.described import Column, Figure, Section, Table
from .drive_choice import DriveChoice


def choice(found: DriveChoice, page: object = None) -> tuple[Section, ...]:
    """The choice of motor, gear and flywheel."""
    tried, best = found.tried, found.best
    columns = [
        Column("motor", [each.motor for each in tried]),
        Column("", [each.remark or "suffices" for each in tried]),
        Column("ratio", [float(each.ratio) for each in tried]),
        Column("flywheel", [each.flywheel for each in tried], "kg m2"),
        Column("mean speed", [each.mean_speed for each in tried], "rad/s"),
        Column("speed drop", [each.speed_drop for each in tried], "share"),
        Column("thermal", [each.thermal for each in tried], "share"),
        Column("peak", [each.peak for each in tried], "share"),
        Column("start", [each.start_time for each in tried], "s"),
        Column("heat of a start", [each.start_heat for each in tried], "J"),
    ]
    chosen, figures = "None of the motors suffices with a flywheel of this range.", []
    if best is not None and best.thermal is not None and best.peak is not None and best.speed_drop is not None:
        chosen = f"{best.motor} with a gear of {best.ratio:g} is the smallest that suffices."
        figures = [
            Figure("flywheel", best.flywheel, "kg m2", "on the motor's shaft"),
            Figure("thermal use", best.thermal, "share", "of the rated torque, by the rms torque", kind="motor"),
            Figure("peak use", best.peak, "share", "of the breakdown torque", kind="motor"),
            Figure("speed drop", best.speed_drop, "share", "of the mean speed"),
            Figure("start", best.start_time, "s", "from rest to the rated speed, with the clutch open"),
        ]
    smallest = "Each has the smallest flywheel with which it suffices, or else the largest of the range."
    table = Table("tried", "Motors tried, the smallest first", columns, most=200)
    return (Section("Motor and flywheel", figures, [table], (), f"{chosen} {smallest}", found._press, "mains"),)


SECTIONS = {DriveChoice: choice}
"""How results of this room are described."""
