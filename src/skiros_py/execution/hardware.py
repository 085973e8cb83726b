"""Which devices a module takes, and which device is meant where none is named."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from skiros_py.execution.claims import Claim
from skiros_py.ports.board import DeviceBoard
from skiros_py.skills.parameters import Access, Kind, Param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import owner
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import DEVICE, HAS_A, LOCATION


def devices_of(
    view: WorldView, params: Iterable[Param], takes: Sequence[str], values: Mapping[str, Any]
) -> dict[str, Access]:
    """Returns what a call takes: its hardware, and of what it takes as a whole all devices, and any place itself.

    Devices that it only reads are left out. A device that is named twice is taken exclusively if one of the two asks
    for that.
    """
    named = [p for p in params if p.kind is Kind.HARDWARE and isinstance(values.get(p.key), str)]
    devices = {values[p.key]: Access.SHARED for p in named if p.access is Access.SHARED}
    devices |= {values[p.key]: Access.EXCLUSIVE for p in named if p.access is Access.EXCLUSIVE}
    for key in takes:
        if isinstance(values.get(key), str):
            whole = [e for e in pieces(view, values[key]) if view.ontology.is_a(view.element(e).type, DEVICE)]
            whole += [values[key]] if view.ontology.is_a(view.element(values[key]).type, LOCATION) else []
            devices |= dict.fromkeys(whole, Access.EXCLUSIVE)
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


def standstill(board: DeviceBoard, claim: Claim) -> Execution[None]:
    """Waits until the devices of an ended run stand, for the braking time at most; shared ones may go on moving."""
    end, devices = board.now + board.braking_time, claim.devices - claim.shared
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
