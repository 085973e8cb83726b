"""Which events somebody wants."""

from __future__ import annotations

from dataclasses import dataclass

from skiros_py.station.events.event import Event, Kind


@dataclass(frozen=True, slots=True)
class Choice:
    """Which events somebody wants: those that fit all of this.

    Attributes:
        kinds: Kinds of events.
        types: What happened, in one word; empty for anything.
        job: Id of the job that they belong to; empty for any.
        element: Id of the element of the world that they touch; empty for any.
    """

    kinds: frozenset[Kind] = frozenset(Kind)
    types: frozenset[str] = frozenset()
    job: str = ""
    element: str = ""

    def takes(self, event: Event) -> bool:
        """Returns whether an event is among them."""
        return (
            event.kind in self.kinds
            and (not self.types or event.type in self.types)
            and (not self.job or event.job == self.job)
            and (not self.element or event.touches(self.element))
        )


EVERYTHING = Choice()
