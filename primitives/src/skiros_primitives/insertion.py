"""Insertion by feel: a part that stands on a wall, or jams, finds its way down under a light press.

The hand follows small motions sideways while it gives way to what pushes it (admittance control): upwards, so that the
press stays light, and sideways, so that nothing is pushed hard. Every motion is bounded in size and in time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from skiros_primitives.contact import PRESS, HandForce
from skiros_py.devices.arm import Arm, ArmTarget
from skiros_py.geometry import Array, rotation_matrix
from skiros_py.ports.kinematics import Kinematics
from skiros_py.skills.context import RunContext
from skiros_py.skills.primitive import Execution

REACH = 0.004
"""How far sideways a way in is searched [m]."""
_LIMIT, _BEARS = 40.0, 0.3
"""Force at which it goes no further [N], when giving way has not helped for so long [s]."""
_PITCH, _SPEED = 0.001, 0.012
"""Distance between the turns of the spiral [m], and the speed along it [m/s]."""
_DOWN, _LANDING, _UP = 0.02, 0.01, 0.02
"""Speeds down where nothing is below, and where the floor may be; greatest speed up [m/s]."""
_LONGEST = 8.0
"""How long it tries one way [s]."""
_HASTE = 0.3
"""Acceleration downwards; the hand feels it as if it were pushed [m/s²]."""
_NOTHING = 1.0
"""Force up to which nothing is below [N]."""
_GIVES, _YIELDS = 0.0005, 0.001
"""Speeds down and sideways per force that is more or less than wanted [m/(N s)]."""
_FREE = 5.0
"""Force sideways that it bears [N]; it gives way to more."""
_INSIDE, _EASY = 15.0, 1.0
"""The same between the walls, where it is pressed harder, for they rub, and bears less [N]."""
_JAMS, _PROGRESS = 0.6, 0.0005
"""It jams between walls where it has not come down by so much for so long [s, m]."""
_DEEPER = 0.003
"""A part that comes down by so much has found the way [m]."""
_SHAKES, _SHAKING = 2.0, 1.5
"""Shakes per second, and how long it shakes [s]."""
_TILT, _SWAY = math.radians(2.5), 0.0008
"""How far it turns and moves sideways when it shakes [rad, m]."""
_BEYOND = 0.006
"""How far below where it ought to be the floor may be [m]."""
_DAMPING = 1e-4


@dataclass(frozen=True, slots=True)
class Step:
    """One cycle of a motion sideways, from where it began: x and y of the base [m], and a turn about z [rad]."""

    x: float = 0.0
    y: float = 0.0
    turn: float = 0.0


def spiral(period: float, reach: float = REACH) -> Iterator[Step]:
    """Yields the steps of a spiral out from the middle.

    Args:
        period: Length of one control cycle [s].
        reach: Its radius [m].
    """
    turned = 0.0
    while (radius := _PITCH * turned / math.tau) <= reach:
        yield Step(radius * math.cos(turned), radius * math.sin(turned))
        turned += _SPEED * period / max(radius, _PITCH / 2.0)


def away(pressed: Array, period: float, reach: float = REACH) -> Iterator[Step]:
    """Yields the steps of a motion away from what presses, and back.

    Args:
        pressed: Where it presses: x and y from the middle.
        period: Length of one control cycle [s].
        reach: How far [m].
    """
    x, y = -pressed / max(1e-9, float(np.hypot(*pressed)))
    out = np.arange(1, round(reach / _SPEED / period) + 1) * _SPEED * period
    for far in (*out, *out[::-1], 0.0):
        yield Step(far * x, far * y)


def shake(period: float) -> Iterator[Step]:
    """Yields the steps of a shake: it turns back and forth, and moves around a little; at the end it is back.

    Args:
        period: Length of one control cycle [s].
    """
    for cycle in range(1, round(_SHAKING / period) + 1):
        angle = math.tau * _SHAKES * cycle * period
        swell = math.sin(math.pi * cycle * period / _SHAKING)
        x, y, turn = math.cos(1.5 * angle), math.sin(1.5 * angle), math.sin(angle)
        yield Step(swell * _SWAY * x, swell * _SWAY * y, swell * _TILT * turn)


class Insertion:
    """Lets down what a hand holds, by feel; the hand may lean.

    Args:
        context: The run.
        arm: The arm.
        force: What pushes its hand.
        floor: Height of the tip at which the part stands on the floor, in the frame of the base [m].
        landing: How far above this it stands on the floor already [m].
    """

    def __init__(self, context: RunContext, arm: Arm, force: HandForce, floor: float, landing: float) -> None:
        self._kinematics = context.port(Kinematics, arm.id)
        self._arm, self._force, self._period = arm, force, context.board.period
        self._floor, self._landing = floor, landing
        self._joints: Array = np.asarray(arm.state.positions)
        self._aside = np.zeros(2)
        self._speed = 0.0

    def lower(self) -> Execution[bool]:
        """Comes straight down until it presses; returns whether that is on the floor."""
        return (yield from self.follow(iter(())))

    def search(self) -> Execution[bool]:
        """Searches sideways: away from what it presses on, then all around; returns whether it is on the floor then."""
        return (yield from self.follow(self._sideways()))

    def _sideways(self) -> Iterator[Step]:
        yield from away(self._force.pressed_at(), self._period)
        yield from spiral(self._period)

    def shake(self) -> Execution[bool]:
        """Shakes; returns whether it is on the floor then."""
        return (yield from self.follow(shake(self._period)))

    def follow(self, steps: Iterator[Step]) -> Execution[bool]:
        """Follows steps while it presses, and comes down where nothing is below; returns whether it is on the floor.

        What has come down deeper than it began is between the walls: it is pressed harder, moves only where the walls
        push it, and jams where it does not come down further. It ends on the floor, when it jams, at the end of the
        steps while something is below, or where it is pushed too hard.
        """
        wall = lowest = self._height()
        at, waited, hard = Step(), 0.0, 0.0
        for _ in range(round(_LONGEST / self._period)):
            push, height = self._force.push(), self._height()
            low, inside = height <= self._floor + self._landing, height <= wall - _DEEPER
            if (low and push[2] >= (PRESS if inside else PRESS / 2.0)) or height <= self._floor - _BEYOND:
                yield from self._rest()
                return low
            deeper = height < lowest - _PROGRESS
            lowest, waited = (height, 0.0) if deeper else (lowest, waited + self._period)
            hard = hard + self._period if float(np.abs(push).max()) > _LIMIT else 0.0
            step = next(steps, None) if push[2] >= PRESS / 2.0 and not inside else at
            if step is None or hard > _BEARS or (inside and waited > _JAMS):
                break
            yield from self._move(push, (step.x - at.x, step.y - at.y, step.turn - at.turn), inside=inside)
            at = step
        yield from self._rest()
        return False

    def _move(self, push: Array, by: tuple[float, float, float], *, inside: bool) -> Execution[None]:
        """Moves for one cycle."""
        press, nothing, free = (_INSIDE, PRESS / 2.0, _EASY) if inside else (PRESS, _NOTHING, _FREE)
        fast = _DOWN if self._height() > self._floor + self._landing else _LANDING
        wanted = fast if push[2] < nothing else max(-_UP, _GIVES * (press - float(push[2])))
        self._speed = min(wanted, max(0.0, self._speed) + _HASTE * self._period)
        over = push[:2] - np.clip(push[:2], -free, free)
        aside = np.clip(self._aside + _YIELDS * over * self._period, -REACH, REACH)
        x, y = aside - self._aside
        self._aside = aside
        twist = np.array([by[0] + x, by[1] + y, -self._speed * self._period, 0.0, 0.0, by[2]])
        moved = self._jacobian_inverse() @ twist
        self._joints = self._joints + moved
        self._arm.command(ArmTarget(tuple(self._joints.tolist()), tuple((moved / self._period).tolist())))
        yield

    def _rest(self) -> Execution[None]:
        """Gives way to what pushes it up harder than wanted, and stands still."""
        for _ in range(_RESTS):
            push = self._force.push()
            if push[2] <= PRESS:
                break
            yield from self._move(push, (0.0, 0.0, 0.0), inside=False)
        self._speed = 0.0
        self._arm.command(ArmTarget(tuple(self._joints.tolist()), (0.0,) * len(self._joints)))
        yield

    def _height(self) -> float:
        return self._kinematics.pose(self._arm.spec.tip, self._positions(self._arm.state.positions)).position[2]

    def _jacobian_inverse(self) -> Array:
        spec, positions = self._arm.spec, self._positions(self._joints.tolist())
        turn = rotation_matrix(self._kinematics.pose(spec.tip, positions).orientation)
        local = self._kinematics.jacobian(spec.tip, positions, spec.joints)
        whole = np.vstack([turn @ local[:3], turn @ local[3:]])
        return np.asarray(whole.T @ np.linalg.inv(whole @ whole.T + _DAMPING * np.eye(6)))

    def _positions(self, joints: tuple[float, ...] | list[float]) -> dict[str, float]:
        return dict(zip(self._arm.spec.joints, joints, strict=True))


_RESTS = 40
"""Greatest number of cycles in which it gives way at its end."""
