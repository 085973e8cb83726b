"""Parameters of skills and primitives: typed, with a help text, and of one of the paper's kinds (§5.2)."""

from __future__ import annotations

import dataclasses
import enum
from dataclasses import dataclass
from typing import Any

from skiros_py.errors import DescriptionError

__all__ = ["Kind", "Param", "param", "params_of"]


class Kind(enum.Enum):
    """Who specifies a parameter, and when."""

    ONLINE = "online"
    """Must be specified at every call."""
    OFFLINE = "offline"
    """Configuration with a default, such as a speed."""
    OPTIONAL = "optional"
    """May stay unspecified."""
    HARDWARE = "hardware"
    """A device of the robot; may differ from call to call."""
    PLANNING = "planning"
    """Set by the planner, needed for conditions, never shown to people."""


@dataclass(frozen=True, slots=True)
class Param:
    """One parameter.

    Attributes:
        key: Its name; conditions and compositions refer to it.
        type: CURIE of an element class ("sk:Arm"), or "number", "text", "boolean".
        help: One sentence for people.
        kind: Who specifies it.
        default: Value where nobody specifies one.
        unit: Unit of a number.
    """

    key: str
    type: str
    help: str
    kind: Kind = Kind.ONLINE
    default: Any = None
    unit: str = ""

    @property
    def is_element(self) -> bool:
        """True when its value is the id of an element."""
        return ":" in self.type


def param(
    type_: str, help_: str, *, kind: Kind = Kind.ONLINE, default: Any = dataclasses.MISSING, unit: str = ""
) -> Any:
    """Declares one field of a primitive's ``Params`` dataclass; see :class:`Param`."""
    metadata = {"type": type_, "help": help_, "kind": kind, "unit": unit}
    return dataclasses.field(default=default, metadata=metadata)


def params_of(dataclass_type: type) -> tuple[Param, ...]:
    """Reads the parameters that a ``Params`` dataclass declares.

    Raises:
        DescriptionError: A field was not declared with :func:`param`.
    """
    return tuple(_read(dataclass_type, field) for field in dataclasses.fields(dataclass_type))


def _read(owner: type, field: dataclasses.Field[Any]) -> Param:
    if "help" not in field.metadata:
        raise DescriptionError(f"{owner.__qualname__}.{field.name}: declare it with param(type, help, …)")
    default = None if field.default is dataclasses.MISSING else field.default
    kind = field.metadata["kind"]
    return Param(field.name, field.metadata["type"], field.metadata["help"], kind, default, field.metadata["unit"])
