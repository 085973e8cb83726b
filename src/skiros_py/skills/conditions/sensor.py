"""What a sensor says in this cycle, compared with a constant; composed by all, any and not, a sensor expression."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from skiros_py.skills.conditions.comparison import Comparison, Constant, Operator
from skiros_py.skills.conditions.pattern import AllOf, AnyOf, Binding, Exists, Not, Pattern
from skiros_py.skills.conditions.verdict import Verdict
from skiros_py.world.view import NO_SENSORS, WorldView


@dataclass(frozen=True, slots=True)
class Sensor:
    """A device says now of a quantity what is wanted: for hold conditions and guards, as plans cannot sense.

    Attributes:
        device: Variable that is bound to the device's id.
        quantity: What is asked: "gap", "force", "still", "x", "y", "yaw", …; see :mod:`skiros_py.skills.sensing`.
        op: ``=``, ``!=``, ``<``, ``<=``, ``>``, ``>=``.
        value: A number in the quantity's unit, or true or false.

    Raises:
        DescriptionError: There is no such comparison, or not of such a value.
    """

    device: str
    quantity: str
    op: Operator
    value: Constant

    def __post_init__(self) -> None:
        Comparison(self.op, self.value)

    def evaluate(self, view: WorldView, binding: Binding) -> Verdict:
        """Reads the sensor; what is not known does not hold."""
        device = binding[self.device]
        reading = view.sensors.read(device, self.quantity)
        missing = "no sensors here" if view.sensors is NO_SENSORS else f"{device} does not say its {self.quantity}"
        return Comparison(self.op, self.value).judge(f"the {self.quantity} of {device}", reading, missing)

    def rename(self, names: Mapping[str, str]) -> Sensor:
        """Returns the same pattern with other variable names."""
        return Sensor(names.get(self.device, self.device), self.quantity, self.op, self.value)


def is_sensed(pattern: Pattern) -> bool:
    """Tells whether a pattern asks a sensor anywhere: such a one means something in the live world only."""
    match pattern:
        case Sensor():
            return True
        case AllOf(patterns) | AnyOf(patterns):
            return any(is_sensed(part) for part in patterns)
        case Exists(_, _, inner) | Not(inner):
            return is_sensed(inner)
        case _:
            return False
