"""Who may drive and reach where.

The way of a base is its own until it has driven it, or until it stands again; the floor below an arm, until it goes on.
"""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import Protocol, Self

from skiros_py.geometry import Pose
from skiros_py.ports.motion import BasePath

Outline = Sequence[tuple[float, float]]
"""Points on the floor in the frame of a base [m]; what is in their convex hull belongs to the robot."""


Path = BasePath | Sequence[Pose]
"""What a base wants to drive: turns and straight legs, or poses in close succession."""


class Way(Protocol):
    """A path that a base wants to drive. Release it when the base stands again, or use it in a ``with``."""

    @property
    def free(self) -> bool:
        """True when nobody else is on it or was promised it before: the base may go."""
        ...

    @property
    def blocked(self) -> bool:
        """True when somebody who is not driving stands there, or has an arm there: waiting is no use."""
        ...

    def waits_for(self) -> tuple[str, ...]:
        """Returns the ids of the robots because of which it is not free."""
        ...

    def passed(self, legs: float) -> None:
        """Gives back what lies behind: so many legs (or poses) have been driven, 1.5 being half of the second leg."""
        ...

    def release(self) -> None:
        """Gives the rest back; while the base still rolls, it stays taken."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


class Floor(Protocol):
    """The ways of all bases of a cell."""

    def is_driving(self, robot: str) -> bool:
        """Returns True when a robot is on its way: it will not stay where it is."""
        ...

    def ask(self, robot: str, outline: Outline, start: Pose, path: Path) -> Way:
        """Asks for the way along a path; whoever asked first goes first.

        Args:
            robot: Id of the robot.
            outline: What it covers while it drives.
            start: Where its base stands.
            path: The legs of a base that turns and drives straight, or the poses of any other base in the map: between
                two of them it stays within the hull of its outline at both.
        """
        ...

    def stretch(self, arm: str, outline: Outline) -> tuple[str, ...]:
        """Takes the floor below a motion of an arm, until its next one; whoever asks for a way has to go around it.

        Args:
            arm: Id of the arm.
            outline: Above what it moves.

        Returns:
            The ids of the robots that are on their way there: nothing is taken before they have passed.
        """
        ...

    def stretched(self, arm: str) -> Outline:
        """Returns above what an arm is or moves; nothing where it has not moved yet."""
        ...


class OpenFloor:
    """A floor with nobody else on it; a :class:`Floor`."""

    def is_driving(self, robot: str) -> bool:  # noqa: ARG002 - the port's signature
        """Returns False: there is nobody else."""
        return False

    def ask(self, robot: str, outline: Outline, start: Pose, path: Path) -> Way:  # noqa: ARG002
        """Returns a way that is free."""
        return _OpenWay()

    def stretch(self, arm: str, outline: Outline) -> tuple[str, ...]:  # noqa: ARG002
        """Returns nobody: there is nobody else."""
        return ()

    def stretched(self, arm: str) -> Outline:  # noqa: ARG002
        """Returns nothing: nobody wants to know."""
        return ()


class _OpenWay:
    free = True
    blocked = False

    def waits_for(self) -> tuple[str, ...]:
        return ()

    def passed(self, legs: float) -> None:
        pass

    def release(self) -> None:
        pass

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass
