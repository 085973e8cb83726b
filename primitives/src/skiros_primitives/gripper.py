"""Grippers: opens and closes them, and monitors whether they still hold a part."""

from __future__ import annotations

from typing import Any, ClassVar

from skiros_py.devices.gripper import Gripper, GripperSpec, GripperState, GripperTarget
from skiros_py.messages import Message
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.world.poses import write_pose
from skiros_py.world.vocabulary import FLOOR, GRASP_WIDTH, GRIPPER, HELD_BY, MANIPULATABLE, ON

_STILL_FOR = 0.05
"""How long fingers need to begin, and must be still then [s]; grippers wait some cycles until they say they are."""
_PATIENCE = 2.0
_FIRM = 0.5
"""Fraction of a gripper's maximum force that parts are held with: enough for its payload, but gentle."""
_AROUND = 0.04
"""How much wider than a part the fingers are open when they come down around it [m]."""


def firm_force(gripper: GripperSpec) -> float:
    """Returns the force per finger that parts are held with [N]."""
    return _FIRM * gripper.max_force


def opening(gripper: GripperSpec, width: float) -> float:
    """Returns the gap with which fingers come down around a part of a width [m]: no wider than needed beside others."""
    return min(gripper.max_gap, width + _AROUND)


def move_fingers(context: RunContext, gripper: Gripper, gap: float, force: float) -> Execution[GripperState]:
    """Moves the fingers until they have been still for a moment, and returns the gripper state.

    Args:
        context: The run.
        gripper: The gripper.
        gap: Wanted gap between the pads [m]; 0 to close on whatever is between them.
        force: Greatest force per finger [N].
    """
    gripper.command(GripperTarget(gap, force))
    started, still_since = context.now, context.now
    while context.now < started + _PATIENCE:
        yield
        if not gripper.state.still or context.now < started + _STILL_FOR:
            still_since = context.now
        if context.now - still_since >= _STILL_FOR:
            break
    return gripper.state


class GripperControl(Primitive[Any]):
    """Moves the fingers to a gap and waits until they stand."""

    name: ClassVar[str] = "gripper_control"

    gripper: str = param(GRIPPER, "The gripper.", kind=Kind.HARDWARE)
    gap: float | None = param(
        "number",
        "Wanted gap between the pads; left out: wide open.",
        kind=Kind.OPTIONAL,
        unit="m",
        limits=(0.0, 1.0),
    )
    part: str | None = param(MANIPULATABLE, "The part for which they open, where no gap is given.", kind=Kind.OPTIONAL)
    force: float | None = param(
        "number", "Greatest force per finger; left out: as parts are held.", kind=Kind.OPTIONAL, unit="N"
    )

    def execute(self) -> Execution[Outcome]:
        """Moves the fingers."""
        gripper = Gripper(self.context.board, self.gripper)
        spec = gripper.spec
        width = self.world.value(self.part, GRASP_WIDTH) if self.part is not None else None
        wide = opening(spec, width) if isinstance(width, float) else spec.max_gap
        gap = wide if self.gap is None else self.gap
        force = firm_force(spec) if self.force is None else self.force
        state = yield from move_fingers(self.context, gripper, gap, force)
        return Success(Message("gap {gap:.0f} mm", gap=state.gap * 1000.0))


_TOLERANCE = 0.008
"""Fingers that close this much further than the part's width have lost it [m]."""
_FOR = 0.05
"""How long they must be that close [s]: a single reading is not sufficient; less than moving fingers takes."""


class WatchGrasp(Primitive[Any]):
    """Never ends by itself: the arm's skill manager runs it whenever the gripper is available."""

    name: ClassVar[str] = "watch_grasp"
    watches: ClassVar[str | None] = GRIPPER

    device: str = param(GRIPPER, "The gripper to watch; it is not taken from those who move it.")

    def execute(self) -> Execution[Outcome]:
        """Reads the gap in every cycle; a lost part is assumed to be on the floor."""
        gripper = Gripper(self.context.board, self.device)
        held, version = self._held(), self.world.version
        lost_since: float | None = None
        while True:
            yield
            if version != self.world.version:
                held, version = self._held(), self.world.version
            if held is None or gripper.state.gap > held[1] - _TOLERANCE:
                lost_since = None
                continue
            lost_since = self.context.now if lost_since is None else lost_since
            if self.context.now - lost_since >= _FOR:
                self._write(held[0], gripper.state.gap)

    def _held(self) -> tuple[str, float] | None:
        for part in self.world.subjects(HELD_BY, self.device):
            width = self.world.value(part, GRASP_WIDTH)
            if isinstance(width, float):
                return part, width
        return None

    def _write(self, part: str, gap: float) -> None:
        reason = Message("the fingers closed to {gap:.0f} mm: {part} slipped out", gap=gap * 1000.0, part=part)
        with self.world.transaction(author=self.name, reason=reason) as tx:
            tx.place(part, ON, self.world.instances(FLOOR)[0])
            write_pose(tx, part, None)
