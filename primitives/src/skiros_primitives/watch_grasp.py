"""Monitors in the background whether the gripper still holds the part it is believed to hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_py.devices.gripper import Gripper
from skiros_py.skills.outcome import Outcome
from skiros_py.skills.parameters import param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.surroundings import set_pose
from skiros_py.world.vocabulary import FLOOR, GRASP_WIDTH, GRIPPER, HELD_BY, ON

_TOLERANCE = 0.008
"""Fingers that close this much further than the part's width have lost it [m]."""
_FOR = 0.1
"""How long they must be that close [s]: a single reading is not sufficient."""


class WatchGrasp(Primitive["WatchGrasp.Params"]):
    """Never ends by itself: the arm's skill manager runs it whenever the gripper is available."""

    name: ClassVar[str] = "watch_grasp"
    watches: ClassVar[str | None] = GRIPPER

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        device: str = param(GRIPPER, "The gripper to watch; it is not taken from those who move it.")

    def execute(self) -> Execution[Outcome]:
        """Reads the gap in every cycle; a lost part is assumed to be on the floor."""
        gripper = Gripper(self.context.board, self.params.device)
        lost_since: float | None = None
        while True:
            yield
            held = self._held()
            if held is None or gripper.state.gap > held[1] - _TOLERANCE:
                lost_since = None
                continue
            lost_since = self.context.now if lost_since is None else lost_since
            if self.context.now - lost_since >= _FOR:
                self._write(held[0], gripper.state.gap)

    def _held(self) -> tuple[str, float] | None:
        for part in self.world.subjects(HELD_BY, self.params.device):
            width = self.world.value(part, GRASP_WIDTH)
            if isinstance(width, float):
                return part, width
        return None

    def _write(self, part: str, gap: float) -> None:
        reason = f"the fingers closed to {gap * 1e3:.0f} mm: {part} slipped out"
        with self.world.transaction(author=self.name, reason=reason) as tx:
            tx.place(part, ON, self.world.instances(FLOOR)[0])
            set_pose(tx, self.world, part, None)
