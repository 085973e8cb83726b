"""What files say of one individual, before it is an element."""

from __future__ import annotations

from skiros_py.world.element import Value

__all__ = ["Individual"]


class Individual:
    """What all files together say of one individual.

    Attributes:
        types: Names of its classes.
        values: Its properties, the label among them.
        relations: Names of a relation and of the individual at its other end.
    """

    __slots__ = ("relations", "types", "values")

    def __init__(self) -> None:
        self.types: list[str] = []
        self.values: dict[str, Value] = {}
        self.relations: list[tuple[str, str]] = []
