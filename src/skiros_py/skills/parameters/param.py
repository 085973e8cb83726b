"""One parameter: who specifies it, what it may be, which of several candidates is wanted."""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from skiros_py.errors import DescriptionError
from skiros_py.skills.conditions import Pattern
from skiros_py.world.view import WorldView

IT = "it"
"""Variable of a parameter's own patterns: the element that it may be."""

Cost = str | Callable[[WorldView, str], float]
"""CURIE of a property, or a function of an element's id: the lowest value is wanted first."""
Patterns = Pattern | tuple[Pattern, ...]
ValueClass = type[object]


class Kind(enum.Enum):
    """Who specifies a parameter, and when."""

    ONLINE = "online"
    """Must be specified at every call: by a person, by a plan, or (an element) by inference."""
    OFFLINE = "offline"
    """Configuration with a default, such as a speed."""
    OPTIONAL = "optional"
    """May stay unspecified."""
    HARDWARE = "hardware"
    """A device of the robot; may differ from call to call, and is inferred when left out."""
    CONFIG = "config"
    """Fixed when the module is loaded; cannot be given at a call."""
    PLANNING = "planning"
    """An element that planner or inference sets, needed for conditions, never shown to people."""

    @property
    def is_required(self) -> bool:
        """True when the module does not run before it is specified."""
        return self in (Kind.ONLINE, Kind.HARDWARE, Kind.PLANNING)

    @property
    def has_default(self) -> bool:
        """True when its parameters have a default."""
        return self in (Kind.OFFLINE, Kind.CONFIG)


class Access(enum.Enum):
    """What a module does with a device that a parameter of kind HARDWARE names."""

    EXCLUSIVE = "exclusive"
    """It is the only one that commands the device."""
    SHARED = "shared"
    """Other runs may command the device in the same cycle: the mix rule of its kind merges the commands."""
    READ = "read"
    """It only reads the device, which is not taken."""


@dataclass(frozen=True, slots=True)
class Param:
    """One parameter.

    Attributes:
        key: Its name; conditions and compositions refer to it.
        type: CURIE of an element class ("sk:Arm"); or "number", "integer", "text", "boolean", "pose", "vector",
            "class" (CURIE of a class); or a Python class that can be written as JSON: a frozen dataclass, an Enum.
        help: One sentence for people.
        kind: Who specifies it.
        default: Value where none is specified.
        unit: Unit of a number.
        length: How many values it takes: more than one are a tuple, 0 stands for a tuple of any length.
        limits: Least and greatest value of each number; None for any.
        where: What the element must be besides of its class, over the variable ``it`` and other keys: "any container
            that is empty" is ``where=Nothing("sk:in", "it")``.
        prefer: What a candidate should be where several will do, over the same variables, best first.
        cost: What a candidate costs; the cheapest is taken of those that are preferred alike.
        unique: True when it is an error that several candidates will do.
        access: What a device is taken for.
    """

    key: str
    type: str | ValueClass
    help: str
    kind: Kind = Kind.ONLINE
    default: Any = None
    unit: str = ""
    length: int = 1
    limits: tuple[float, float] | None = None
    where: Patterns = ()
    prefer: Patterns = ()
    cost: Cost | None = None
    unique: bool = False
    access: Access = Access.EXCLUSIVE

    @property
    def is_element(self) -> bool:
        """True when its value is the id of an element."""
        return isinstance(self.type, str) and ":" in self.type

    @property
    def element_class(self) -> str:
        """Class of the elements that it may be.

        Raises:
            DescriptionError: It is no element.
        """
        if isinstance(self.type, str) and ":" in self.type:
            return self.type
        raise DescriptionError(f"parameter {self.key} is {self.type_name}, not an element")

    @property
    def type_name(self) -> str:
        """Its type in words."""
        return self.type if isinstance(self.type, str) else self.type.__name__

    @property
    def described(self) -> tuple[Pattern, ...]:
        """The patterns of :attr:`where`, one or several."""
        return _each(self.where)

    @property
    def preferred(self) -> tuple[Pattern, ...]:
        """The patterns of :attr:`prefer`, one or several."""
        return _each(self.prefer)

    @property
    def is_inferred(self) -> bool:
        """True when it is inferred from the world where it is not specified."""
        return self.is_element and self.kind.is_required


@dataclass(frozen=True, slots=True)
class Output:
    """A value that a module finds out: its outcome has it under this name, and ``Out`` in a body writes it.

    Attributes:
        name: Its name.
        type: Type of its values, as of a parameter; empty where it is not declared.
        help: Its meaning, in one sentence.
        unit: Unit of a number.
        length: How many values it has: more than one are a tuple, 0 stands for a tuple of any length.
    """

    name: str
    type: str | ValueClass
    help: str
    unit: str = ""
    length: int = 1

    @property
    def param(self) -> Param:
        """The parameter that takes such values."""
        return Param(self.name, self.type, self.help, Kind.OPTIONAL, unit=self.unit, length=self.length)


def _each(patterns: Patterns) -> tuple[Pattern, ...]:
    return patterns if isinstance(patterns, tuple) else (patterns,)
