"""Which devices a module takes, and which one is meant where nobody says."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from skiros_py.ports.board import DeviceBoard
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import owner
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import DEVICE, HAS_A, LOCATION


def devices_of(view: WorldView, params: Iterable[Param], takes: Sequence[str], values: Mapping[str, Any]) -> set[str]:
    """Returns what a call takes: its hardware, and of what it takes as a whole all devices, and any place itself."""
    devices = {values[p.key] for p in params if p.kind is Kind.HARDWARE and isinstance(values.get(p.key), str)}
    for key in takes:
        if isinstance(values.get(key), str):
            devices |= {e for e in pieces(view, values[key]) if view.ontology.is_a(view.element(e).type, DEVICE)}
            devices |= {values[key]} if view.ontology.is_a(view.element(values[key]).type, LOCATION) else set()
    return devices


def complete(view: WorldView, params: Iterable[Param], values: Mapping[str, Any], agent: str) -> dict[str, Any]:
    """Fills in devices and robots that nobody specified: the only one of its class that is near the subsystem.

    Near means: the subsystem itself, else what it is built of, else its robot, else what that is built of.
    """
    filled = dict(values)
    for param in params:
        if param.is_element and param.kind in (Kind.HARDWARE, Kind.PLANNING) and filled.get(param.key) is None:
            found = _nearest(view, param.element_class, agent)
            if found is not None:
                filled[param.key] = found
    return filled


def pieces(view: WorldView, whole: str) -> Iterator[str]:
    """Yields an element and everything it is built of, from the top."""
    yield whole
    for piece in view.objects(whole, HAS_A):
        yield from pieces(view, piece)


def standstill(board: DeviceBoard, devices: Iterable[str]) -> Execution[None]:
    """Waits until devices stand that nobody commands any more, for the braking time at most."""
    end = board.now + board.braking_time
    while board.now < end and not board.stand(devices):
        yield


def _nearest(view: WorldView, class_: str, agent: str) -> str | None:
    robot = owner(view, agent)
    circles = [[agent], list(pieces(view, agent)), [robot] if robot else [], list(pieces(view, robot)) if robot else []]
    for circle in circles:
        fitting = [element for element in circle if view.ontology.is_a(view.element(element).type, class_)]
        if fitting:
            return fitting[0] if len(fitting) == 1 else None
    return None
