"""Common base of the primitives that drive a differential-drive base."""

from __future__ import annotations

import math
from typing import Any

from skiros_py.devices.base import Base, BaseTwist
from skiros_py.geometry import wrap_angle
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.world.vocabulary import AT, FLOOR, POSE_FRAME

_ALIGNED = math.radians(0.3)


class DrivingPrimitive(Primitive[Any]):
    """Base of the primitives that drive; their parameters have fields ``base`` and ``robot``."""

    def rides(self, element: str) -> bool:
        """Returns True when an element moves with the base."""
        frames = self.world.objects(element, POSE_FRAME)
        return any(frame == self.params.base or self.rides(frame) for frame in frames)

    def leave(self, reason: str) -> None:
        """Places the robot on the floor: it is at no location while it drives."""
        floors = self.world.instances(FLOOR)
        placement = self.world.placement(self.params.robot)
        if floors and (placement is None or placement.place != floors[0]):
            with self.world.transaction(author=self.name, reason=reason) as tx:
                tx.place(self.params.robot, AT, floors[0])

    def turn(self, base: Base, heading: float, *, fastest: float, patience: float) -> Execution[bool]:
        """Turns on the spot.

        Args:
            base: The base.
            heading: Heading in the map at the end [rad].
            fastest: Greatest turning speed [rad/s].
            patience: Longest time [s].

        Returns:
            Whether it reached the heading.
        """
        limit, deadline = base.spec.max_angular_acceleration, self.context.now + patience
        while self.context.now < deadline:
            error = wrap_angle(heading - base.state.pose.yaw)
            if abs(error) < _ALIGNED:
                return True
            speed = min(fastest, math.sqrt(1.6 * limit * abs(error)), 4.0 * abs(error))
            base.command(BaseTwist(0.0, math.copysign(speed, error)))
            yield
        return False

    def stand(self, base: Base) -> Execution[None]:
        """Brakes, and waits for localisation to settle."""
        deadline = self.context.now + 5.0
        yield
        while not base.state.still and self.context.now < deadline:
            yield
        settled = self.context.now + 0.1
        while self.context.now < settled:
            yield
