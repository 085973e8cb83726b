"""Who runs a module that another module calls: a skill may call the skills of other subsystems."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Generic, Protocol, TypeVar

from skiros_py.skills.surroundings import owner
from skiros_py.world.view import WorldView


class Offer(Protocol):
    """What one subsystem can do."""

    @property
    def agent(self) -> str:
        """Id of the subsystem."""
        ...

    def agent_of(self, skill: str) -> str | None:
        """Returns the key of the parameter that is the subsystem doing a skill; None where it is not offered."""
        ...


OfferT = TypeVar("OfferT", bound=Offer)


class Directory(Generic[OfferT]):
    """The modules of all skill managers of a cell.

    Args:
        view: Tells which subsystems belong to one robot.
    """

    def __init__(self, view: WorldView) -> None:
        self._view = view
        self._offers: dict[str, OfferT] = {}

    def enter(self, offer: OfferT) -> None:
        """Takes in what a subsystem can do, from now on."""
        self._offers[offer.agent] = offer

    def leave(self, offer: OfferT) -> None:
        """Counts on it no more; for any thread."""
        if self._offers.get(offer.agent) is offer:
            del self._offers[offer.agent]

    def who_runs(self, module: str, arguments: Mapping[str, Any], caller: OfferT) -> OfferT:
        """Returns who runs a module that somebody calls.

        That is the subsystem that the arguments name, else the caller itself, else one of the caller's robot, else the
        first by its id; the caller for what nobody offers as a skill.
        """
        able = [offer for offer in tuple(self._offers.values()) if offer.agent_of(module) is not None]
        robot = owner(self._view, caller.agent)

        def far(offer: OfferT) -> tuple[bool, bool, bool, str]:
            named = arguments.get(offer.agent_of(module) or "") == offer.agent
            return not named, offer is not caller, owner(self._view, offer.agent) != robot, offer.agent

        return min(able, key=far, default=caller)
