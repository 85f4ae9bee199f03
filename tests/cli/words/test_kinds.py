"""What acts on a press in Python acts on it on the command line."""

import inspect
from types import ModuleType

import pytest

import pinpress as pp
from pinpress.cli.words import part_specs


def classes_with(room: ModuleType, method: str) -> set[str]:
    return {name for name in dir(room) if inspect.isclass(each := getattr(room, name)) and hasattr(each, method)}


@pytest.mark.parametrize(
    ("room", "method", "kinds", "without"),
    [
        (pp.loads, "intervals", part_specs.LOADS, {"ProcessLoad"}),  # the protocol
        (pp.drives, "torque", part_specs.MOTORS, {"Drive", "SpeedTorqueDrive", "Geared"}),  # protocols; keys of any motor
    ],
    ids=["loads", "motors"],
)
def test_every_load_and_motor_has_a_kind(room: ModuleType, method: str, kinds: dict[str, part_specs.Kind], without: set[str]) -> None:
    assert classes_with(room, method) - {kind.made.__name__ for kind in kinds.values()} == without
