"""Claims: a module takes all of its devices at once or none, in the order of asking.

A device is claimed exclusively, or shared with other claims that share it. Modules in modules are levels: the claim of
a skill is the parent of the claims of its parts, which divide among each other what the skill has, and nothing else.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from itertools import takewhile
from typing import Any

from skiros_py.errors import DescriptionError, UsageError
from skiros_py.ports.board import DeviceBoard
from skiros_py.skills.parameters import Access, Kind, Param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import owner
from skiros_py.world.view import WorldView, pieces
from skiros_py.world.vocabulary import DEVICE, LOCATION


class Claim(AbstractContextManager["Claim"]):
    """The devices that a run of a module asks for. Release it on every end, or use it in a ``with``.

    Attributes:
        owner: The module, for messages.
        devices: Their ids.
        shared: Those of them that may be commanded by other runs at the same time.
        parent: The claim it is a part of; None for that of a module that stands alone.
        granted: True when it has them all.
        released: True when it was given back.
    """

    def __init__(
        self, owner: str, devices: frozenset[str], shared: frozenset[str], parent: Claim | None, level: Claims
    ) -> None:
        self.owner = owner
        self.devices = devices
        self.shared = shared
        self.parent = parent
        self.granted = False
        self.released = False
        self.within = Claims()
        self._level = level
        level.add(self)

    def release(self) -> None:
        """Gives all devices back, with those of its parts; may be called twice."""
        if self.released:
            return
        self.released, self.granted = True, False
        self.within.release_all()
        self._level.remove(self)

    def waits_for(self) -> tuple[str, ...]:
        """Returns why it is not granted yet: "arm_1 (pick)" for each device that an earlier claim excludes it from."""
        if self.granted or self.released:
            return ()
        before = ((device, self._level.before(device, self)) for device in sorted(self.devices))
        return tuple(f"{device} ({other.owner})" for device, other in before if other is not None)

    def __exit__(self, *_: object) -> None:
        self.release()


class Claims:
    """Claims that may exclude each other: for each device a queue, in the order of asking. For the control thread only.

    A claim is granted when no earlier claim in its queues excludes it. The oldest claim is never excluded, so nothing
    can deadlock.
    """

    def __init__(self) -> None:
        self._claims: dict[Claim, None] = {}
        self._queues: dict[str, deque[Claim]] = {}

    def request(
        self, owner: str, devices: Iterable[str], *, shared: Iterable[str] = (), within: Claim | None = None
    ) -> Claim:
        """Asks for devices: all or none.

        It is granted, at once or later, when no earlier claim excludes it from one of them. A shared device is open to
        all that share it; a claim that wants it exclusively waits until they are released, and later ones wait for it.

        Args:
            owner: The module, for messages.
            devices: Their ids.
            shared: Those of them that others may command at the same time.
            within: The claim of the module that the owner is a part of.

        Raises:
            DescriptionError: The module that the owner is a part of has not declared one of the devices, or shares one
                that the owner wants exclusively.
            UsageError: That module has not got its own devices, or has given them back.
        """
        wanted, open_ = frozenset(devices), frozenset(shared)
        if within is None:
            return Claim(owner, wanted, open_, None, self)
        if not within.granted:
            state = "given its devices back" if within.released else f"to wait for {', '.join(within.waits_for())}"
            raise UsageError(f"{owner}: {within.owner} itself has {state}")
        missing = sorted(wanted - within.devices)
        if missing:
            has = ", ".join(sorted(within.devices)) or "none"
            raise DescriptionError(
                f"{owner} needs {', '.join(missing)}, but {within.owner} has {has}: declare what is missing as a "
                f"hardware parameter of {within.owner}"
            )
        alone = sorted((wanted - open_) & within.shared)
        if alone:
            raise DescriptionError(f"{owner} takes {', '.join(alone)} exclusively, but {within.owner} shares it")
        return Claim(owner, wanted, open_, within, within.within)

    def add(self, claim: Claim) -> None:
        """Appends a claim to the queues of its devices."""
        self._claims[claim] = None
        for device in claim.devices:
            self._queues.setdefault(device, deque()).append(claim)
        self._grant(claim)

    def remove(self, claim: Claim) -> None:
        """Removes a claim, and grants those that it excluded."""
        del self._claims[claim]
        for device in claim.devices:
            self._queues[device].remove(claim)
            if not self._queues[device]:
                del self._queues[device]
        for device in sorted(claim.devices & self._queues.keys()):
            for other in self._queues[device]:
                if not other.granted:
                    self._grant(other)
                if device not in other.shared:
                    break

    def before(self, device: str, claim: Claim) -> Claim | None:
        """Returns the first earlier claim that keeps another one from a device; None where none does."""
        alone = device not in claim.shared
        earlier = takewhile(lambda other: other is not claim, self._queues[device])
        return next((other for other in earlier if alone or device not in other.shared), None)

    def wanted(self, device: str) -> bool:
        """Returns whether a run has a device, or waits for it."""
        return device in self._queues

    def release_all(self) -> None:
        """Gives all devices back."""
        for claim in reversed(tuple(self._claims)):  # the youngest first, so that none is granted in between
            claim.release()

    def _grant(self, claim: Claim) -> None:
        claim.granted = all(self.before(device, claim) is None for device in claim.devices)


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
    """Fills in devices and robots that were not specified: the only one of its class that is near the subsystem.

    Near means: the subsystem itself, else what it is built of, else its robot, else what that is built of.
    """
    filled = dict(values)
    for param in params:
        if param.is_element and param.kind in (Kind.HARDWARE, Kind.PLANNING) and filled.get(param.key) is None:
            found = _nearest(view, param.element_class, agent)
            if found is not None:
                filled[param.key] = found
    return filled


def standstill(board: DeviceBoard, claim: Claim) -> Execution[None]:
    """Waits until the devices of an ended run stand, for the braking time at most; shared ones may go on moving."""
    end, devices = board.now + board.braking_time, claim.devices - claim.shared
    while board.now < end and not board.stand(devices):
        yield


def _nearest(view: WorldView, class_: str, agent: str) -> str | None:
    robot = owner(view, agent)
    circles = [(agent,), pieces(view, agent), *([(robot,), pieces(view, robot)] if robot else ())]
    for circle in circles:
        fitting = [element for element in circle if view.ontology.is_a(view.element(element).type, class_)]
        if fitting:
            return fitting[0] if len(fitting) == 1 else None
    return None
