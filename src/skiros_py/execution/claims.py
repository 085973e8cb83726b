"""Who may use which device: a module takes all of its devices at once or none, in the order of asking.

Modules in modules are levels: a skill's claim is the parent of the claims of what it is composed of. Those share out
among each other what the skill has, and nothing else.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from types import TracebackType
from typing import Self

from skiros_py.errors import DescriptionError, UsageError


class Claim:
    """A module's wish for devices. Release it on every end, or use it in a ``with``.

    Attributes:
        owner: Who wants them, for messages.
        devices: Their ids.
        parent: The claim it is a part of; None for that of a module that stands alone.
        granted: True when it has them all.
        released: True when it was given back.
    """

    def __init__(self, owner: str, devices: frozenset[str], parent: Claim | None, level: _Level) -> None:
        self.owner = owner
        self.devices = devices
        self.parent = parent
        self.granted = False
        self.released = False
        self.within = _Level()
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
        """Returns why it is not granted yet: "arm_1 (pick)" for each device that is in use or wanted before."""
        if self.granted or self.released:
            return ()
        firsts = ((device, self._level.first(device)) for device in sorted(self.devices))
        return tuple(f"{device} ({first.owner})" for device, first in firsts if first is not self)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()


class Claims:
    """All claims of a control cycle; used in its thread only."""

    def __init__(self) -> None:
        self._level = _Level()

    def request(self, owner: str, devices: Iterable[str], *, within: Claim | None = None) -> Claim:
        """Asks for devices: all or none.

        It is granted, at once or later, when all of them are free and nobody who asked before waits for one of them.

        Args:
            owner: Who wants them, for messages.
            devices: Their ids.
            within: The claim of the module that the owner is a part of.

        Raises:
            DescriptionError: The module that the owner is a part of has not declared one of the devices.
            UsageError: That module has not got its own devices, or has given them back.
        """
        wanted = frozenset(devices)
        if within is None:
            return Claim(owner, wanted, None, self._level)
        if not within.granted:
            raise UsageError(f"{owner}: {within.owner} itself has {_state(within)}")
        missing = sorted(wanted - within.devices)
        if missing:
            has = ", ".join(sorted(within.devices)) or "none"
            raise DescriptionError(
                f"{owner} needs {', '.join(missing)}, but {within.owner} has {has}: declare what is missing as a "
                f"hardware parameter of {within.owner}"
            )
        return Claim(owner, wanted, within, within.within)


class _Level:
    """Claims that exclude each other: for each device a queue, in the order of asking.

    Who is first in all its queues has its devices. The oldest is first in all of its own, so somebody always has.
    """

    def __init__(self) -> None:
        self._claims: dict[Claim, None] = {}
        self._queues: dict[str, deque[Claim]] = {}

    def add(self, claim: Claim) -> None:
        self._claims[claim] = None
        for device in claim.devices:
            self._queues.setdefault(device, deque()).append(claim)
        self._grant(claim)

    def remove(self, claim: Claim) -> None:
        del self._claims[claim]
        for device in claim.devices:
            self._queues[device].remove(claim)
            if not self._queues[device]:
                del self._queues[device]
        for device in sorted(claim.devices & self._queues.keys()):
            self._grant(self._queues[device][0])

    def first(self, device: str) -> Claim:
        return self._queues[device][0]

    def release_all(self) -> None:
        for claim in reversed(tuple(self._claims)):  # the youngest first: nobody is granted anything on the way
            claim.release()

    def _grant(self, claim: Claim) -> None:
        claim.granted = all(self._queues[device][0] is claim for device in claim.devices)


def _state(claim: Claim) -> str:
    if claim.released:
        return "given its devices back"
    return f"to wait for {', '.join(claim.waits_for())}"
