"""Colours of bodies in pictures; no decision depends on them."""

from __future__ import annotations

from skiros_py.ports.cell import BodySpec
from skiros_py.ports.simulation import Colour

_FURNITURE: Colour = (0.80, 0.67, 0.49, 1.0)
_KIT: Colour = (0.25, 0.45, 0.60, 1.0)
_PARTS: tuple[Colour, ...] = (
    (0.86, 0.32, 0.22, 1.0),
    (0.24, 0.60, 0.34, 1.0),
    (0.95, 0.72, 0.18, 1.0),
    (0.45, 0.33, 0.66, 1.0),
    (0.16, 0.62, 0.66, 1.0),
    (0.85, 0.45, 0.65, 1.0),
)


class Palette:
    """Gives furniture wood, what stands on something a kit's blue, and each type of part a colour of its own."""

    def __init__(self) -> None:
        self._types: dict[str, Colour] = {}

    def colour(self, body: BodySpec) -> Colour:
        """Returns a body's colour; bodies of one type have one colour."""
        if body.mass > 0.0 and body.carrier is None and not body.compartment:
            return self._types.setdefault(body.type, _PARTS[len(self._types) % len(_PARTS)])
        return _KIT if body.place is not None or body.carrier is not None else _FURNITURE
