"""Numbers of a pin table as variables of a synthesis: they give pivots and inertias of the press.

The file is read once. For each design only the pins and the masses of the links are computed again, in a millisecond or two; the whole
press is built at the start and for the result. Slopes are central differences, because a table's formulas take no complex numbers.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from ..common.errors import PinpressError, UnknownNameError, cautions_collected, shown
from ..common.quantities import Array
from ..derivatives.motion import Pivots
from ..linkage.linkage import Linkage
from ..pin_table.building import DrawnPress, drawn_from
from ..pin_table.dependence import kept_by_variation, masses_of, pivots_of, refuse_changed
from ..pin_table.numbers import TableNumber, numbers_of, rewritten, with_exact_numbers, written
from ..pin_table.reading import Entry, read_table

STEP = 1e-6  # of a variable's range: the differences are exact to about 1e-10, a ten-thousandth of what an optimum's conditions ask for


@dataclass(frozen=True, eq=False)
class TableVariables:
    """Variables of a pin table.

    Attributes:
        table: its entries.
        numbers: name of each variable -> its number in the table's text.
        steps: name of each variable -> step of its central differences [as in the table].
        kept: name of a quantity that the variables must not change -> its values.
    """

    table: Entry
    numbers: Mapping[str, TableNumber]
    steps: Mapping[str, float]
    kept: Mapping[str, Array]

    @staticmethod
    def of(path: str | os.PathLike[str], variables: Mapping[str, tuple[float, float]]) -> TableVariables:
        """The variables of a file.

        Args:
            path: of the table, or the name of a shipped press.
            variables: name -> (start, range) [as in the table].

        Raises:
            PinTableError: the file is no table, or draws no press with these values.
            UnknownNameError: the table has no such number.
            PinpressError: nothing in the press depends on a variable.
        """
        table = read_table(path)
        numbers = {".".join(each.path[each.kind == "parameter" :]): each for each in numbers_of(table.file_text)}
        for name in variables:
            if name not in numbers:
                raise UnknownNameError(f"plain number in {table.file}", name, numbers)
        chosen = {name: numbers[name] for name in variables}
        found = TableVariables(table, chosen, {name: STEP * size for name, (_, size) in variables.items()}, {})
        start = {name: value for name, (value, _) in variables.items()}
        found = replace(found, kept=kept_by_variation(found.drawn(start)))
        for name in variables:
            ahead, back = (found.drawn(each) for each in found._around(start, name))
            if _same(pivots_of(ahead), pivots_of(back)) and _same(masses_of(ahead), masses_of(back)):
                raise PinpressError(f"variable {shown(name)}: no place and no mass of {table.file} depends on it; leave it out")
        return found

    def drawn(self, values: Mapping[str, float]) -> DrawnPress:
        """The press of the table with other values; raises PinTableError if these values make no press.

        Raises:
            PinpressError: a variable changes what crank angles count from, or what moves with the crank by a ratio.
        """
        with cautions_collected():  # those of the start and of the result are issued by `press`
            drawn = self._drawn(values)
        if self.kept:
            refuse_changed(self.kept, drawn, values)
        return drawn

    def press(self, values: Mapping[str, float]) -> Linkage:
        """The press of `text`, in SI units; raises as `build`."""
        return self._drawn({name: float(written(value)) for name, value in values.items()}).press()

    def text(self, values: Mapping[str, float]) -> str:
        """The table's text with other values, to 12 digits; all else, such as comments, stays."""
        by_path = {self.numbers[name].path: value for name, value in values.items()}
        return rewritten(self.table.file_text, list(self.numbers.values()), by_path)

    def pivots(self, **values: Any) -> Pivots:
        """Pivots as for `reshaped`; for one complex value their derivatives by it as imaginary parts."""
        name = next((name for name, value in values.items() if np.iscomplexobj(value)), None)
        if name is None:
            return pivots_of(self.drawn(values))
        real = {each: float(np.real(value)) for each, value in values.items()}
        ahead, back = (pivots_of(self.drawn(each)) for each in self._around(real, name))
        share = 0.5j * np.imag(values[name]) / self.steps[name]
        return {key: (ahead[key] + back[key]) / 2 + share * (ahead[key] - back[key]) for key in ahead}

    def heavier(self, press: Linkage, values: Mapping[str, float], name: str) -> tuple[Linkage, Linkage, float]:
        """A press with the masses of a variable one step ahead and one step back, and the distance between them [as in the table]."""
        ahead, back = (self.weighed(press, each) for each in self._around(values, name))
        return ahead, back, 2 * self.steps[name]

    def weighed(self, press: Linkage, values: Mapping[str, float]) -> Linkage:
        """A press whose links have the frames of the table's, with the masses of other values."""
        inertias = list(press.model.inertias)
        for joint, parameters in masses_of(self.drawn(values)).items():
            inertias[press.joints.index(joint) + 1] = pin.Inertia.FromDynamicParameters(parameters)
        return press.with_inertias(inertias)

    def _drawn(self, values: Mapping[str, float]) -> DrawnPress:
        return drawn_from(with_exact_numbers(self.table, {self.numbers[name].path: value for name, value in values.items()}))

    def _around(self, values: Mapping[str, float], name: str) -> tuple[dict[str, float], dict[str, float]]:
        step = self.steps[name]
        return {**values, name: values[name] + step}, {**values, name: values[name] - step}


def _same(one: Mapping[Any, Array], other: Mapping[Any, Array]) -> bool:
    return all(np.array_equal(one[key], other[key]) for key in one)
