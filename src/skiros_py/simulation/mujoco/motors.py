"""Joint motors: MuJoCo has springs, the port has motors that reach a velocity within one step where they can.

They are controllers of the velocity, with the masses that they move known. What stands in the way is pushed harder
with every step, up to the greatest effort.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Array

_ENOUGH = 1.25
"""Share of the greatest effort that may be asked for: more than all of it, or a motor that pushes would tremble."""
_LEARNING = 0.5
"""Share of what a step lacked of its velocity that the next one adds to what it asks for."""


class Motors:
    """The motors of all joints in the world, by number.

    Args:
        period: Length of one step of the engine [s].
        substeps: Number of MuJoCo's steps in it.

    Attributes:
        names: Joint names in the model, by number.
        efforts: What they applied on average in the last step of the engine.
    """

    def __init__(self, period: float, substeps: int) -> None:
        self._period = period
        self._substep = period / substeps
        self.names: list[str] = []
        self._positions = np.zeros(0, np.intp)  # where their values are in MuJoCo's state
        self._velocities = np.zeros(0, np.intp)
        self._inertias = np.zeros(0)  # what each moves, in the position in which the model begins
        # Rows: target position, velocity there, share of the error, greatest speed, greatest effort, one-step effort,
        # the velocity that the last step was to reach, the share of what it lacked of that to be asked for later, which
        # end of its efforts it was at (-1, 0, 1), and what is asked for because earlier steps did not reach theirs; a
        # column for each motor.
        self._values: Array = np.zeros((10, 0))
        self._on: NDArray[np.bool_] = np.zeros(0, np.bool_)
        self.efforts: Array = np.zeros(0)

    def add(self, names: Sequence[str]) -> None:
        """Adds motors that are switched off."""
        self.names.extend(names)
        first = len(self._on)
        self._values = np.pad(self._values, ((0, 0), (0, len(names))))
        self._on = np.pad(self._on, (0, len(names)))
        self.efforts = np.pad(self.efforts, (0, len(names)))
        self._forget(range(first, len(self._on)))

    def look_up(self, model: Any) -> None:
        """Finds the joints in a model that has been compiled again."""
        joints = [model.joint(name) for name in self.names]
        self._positions = np.array([joint.qposadr[0] for joint in joints], np.intp)
        self._velocities = np.array([joint.dofadr[0] for joint in joints], np.intp)
        self._inertias = model.dof_M0[self._velocities]

    def state(self, data: Any, numbers: Sequence[int]) -> tuple[Array, Array, Array]:
        """Returns positions, velocities and efforts of some joints."""
        return data.qpos[self._positions[numbers]], data.qvel[self._velocities[numbers]], self.efforts[numbers]

    def reset(self, data: Any, numbers: Sequence[int], positions: Sequence[float]) -> None:
        """Puts joints to positions, at rest."""
        data.qpos[self._positions[numbers]], data.qvel[self._velocities[numbers]] = positions, 0.0
        self._forget(numbers)

    def control(
        self,
        numbers: Sequence[int],
        *,
        positions: Any = 0.0,
        velocities: Any,
        gain: float = 0.0,
        most: float | None = None,
        effort: Any,
    ) -> None:
        """Lets motors keep velocities, and correct a share of the distance to positions in each step."""
        for row, value in enumerate((positions, velocities, gain, np.inf if most is None else most, effort)):
            self._values[row, numbers] = value
        self._on[numbers] = True

    def push(self, numbers: Sequence[int], efforts: Sequence[float]) -> None:
        """Switches motors off and applies efforts in the next step."""
        self._on[numbers] = False
        self._values[5, numbers] = efforts
        self._forget(numbers)

    def _forget(self, numbers: Sequence[int]) -> None:
        self._values[7:, numbers] = 0.0

    def drive(self, model: Any, data: Any, substep: int) -> None:
        """Sets the efforts of one of MuJoCo's steps."""
        if not self.names:
            return
        target, velocity, gain, most, effort, pushed, expected, learnt, end, beyond = self._values
        position, speed = data.qpos[self._positions], data.qvel[self._velocities]
        lacking = expected - speed
        beyond += learnt * lacking * (end * lacking <= 0.0)
        away = target + velocity * (substep * self._substep) - position
        wanted = np.minimum(np.maximum(velocity + gain * away / self._period, -most), most)
        change, needed = np.zeros(model.nv), np.zeros(model.nv)
        change[self._velocities] = self._on * (wanted - speed + beyond) / self._substep
        mujoco.mj_mulM(model, data, needed, change)
        force = needed[self._velocities] + data.qfrc_bias[self._velocities]
        limited = np.minimum(np.maximum(force, -effort), effort)
        expected[:], learnt[:], end[:] = wanted, _LEARNING * self._on, np.sign(force - limited)
        # Little more is asked for than the effort suffices for: it would push on when it shall go back.
        surplus = (np.abs(force) - _ENOUGH * effort) * self._substep / self._inertias
        beyond -= np.sign(beyond) * (force * beyond > 0.0) * np.minimum(np.maximum(surplus, 0.0), np.abs(beyond))
        applied = np.where(self._on, limited, pushed)
        data.qfrc_applied[self._velocities] = applied
        self.efforts = (self.efforts if substep else 0.0) + applied * (self._substep / self._period)

    def end_step(self, data: Any) -> None:
        """Ends what was asked for one step."""
        self._values[5] = 0.0
        data.qfrc_applied[self._velocities] = 0.0

    def save(self) -> tuple[Array, ...]:
        """Returns all that the next steps depend on."""
        return self._values.copy(), self._on.astype(float), self.efforts.copy()

    def restore(self, saved: tuple[Array, ...]) -> None:
        """Goes back to what was saved."""
        values, on, efforts = saved
        self._values, self._on, self.efforts = values.copy(), on.astype(np.bool_), efforts.copy()
