"""Robots that fly: deliveries, and batteries that fall in flight; judged by the simulator's truth.

    uv run python benchmarks/uav.py --deliveries 20 --falls 10

Each seed is a fresh scene with newly drawn part poses. A battery that falls does so at a drawn time, once the robot is
in the air; it has landed safely where it stands on its skids at a landing place and has touched nothing before.
"""

from __future__ import annotations

import math
import sys
from argparse import ArgumentParser
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from table import Figure, finish

from skiros_py.ports.simulation import FLOOR
from skiros_py.station.session import Options, Session
from skiros_py.system import default_simulation
from skiros_py.world.poses import pose_in
from skiros_uav.aerial_base import AerialState
from skiros_uav.battery import SimulatedBattery

_SCENE = "delivery_uav"
_LOW = 0.29
"""Charge to which a battery falls: below the low level of the robot, above its critical one."""
_FLOWN = (4.0, 60.0)
"""When it falls, in a delivery that takes about 65 s [s]."""
_NEAR, _LEVEL = 0.2, 0.02
"""So near to a landing place, and so low it has landed safely [m]."""
_HAND = frozenset({"palm", "finger_left", "finger_right"})
"""Links that touch what it works on."""


@dataclass
class Flight:
    """One delivery.

    Attributes:
        delivered: Whether the part is where it should be, by the simulator's truth.
        seconds: How long it took [s].
        steps: What was done.
        fell: When the battery fell in flight [s]; None where it did not.
        landed: Where and when it landed then: x, y, z [m], time [s]; None where it did not.
        away: Distance from there to the nearest landing place [m].
        touched: What its frame or arm touched in the air.
        reason: Why the goal was not reached.
    """

    delivered: bool = False
    seconds: float = 0.0
    steps: tuple[str, ...] = ()
    fell: float | None = None
    landed: tuple[float, float, float, float] | None = None
    away: float = math.inf
    touched: tuple[str, ...] = ()
    reason: str = ""

    @property
    def is_safe(self) -> bool:
        """Whether its battery fell, and it landed on its skids at a landing place, and touched nothing before."""
        return self.landed is not None and self.landed[2] < _LEVEL and self.away < _NEAR and not self.touched


def fly(seed: int, engine: str, falls: float | None = None) -> Flight:
    """Flies one delivery.

    Args:
        seed: Of the run.
        engine: Name of the engine.
        falls: From when on the battery falls low in flight [s]; None for never.
    """
    flight = Flight()
    with Session(_SCENE, Options(seed=seed, simulation=engine)) as session:
        session.cycle.observe(_observer(session, flight, falls))
        report = session.run()
        flight.delivered = report.reached and all(one.true for one in report.conditions)
        flight.seconds = report.simulated
        flight.reason = "; ".join((*report.no_plan, *(one.reason for one in report.conditions if one.reason)))
        flight.steps = tuple(step.skill for step in report.steps)
    return flight


def _observer(session: Session, flight: Flight, falls: float | None) -> Callable[[], None]:
    """Returns what notes how it flies, and lets the battery fall once in flight."""
    robot = session.simulation.scene.robots[0]
    battery = robot.devices["battery_1"]
    assert isinstance(battery, SimulatedBattery)
    poses = (pose_in(session.world, place, None) for place in session.world.instances("uav:LandingPlace"))
    places = [pose.position for pose in poses if pose is not None]

    def look() -> None:
        snapshot = session.cycle.board.snapshot
        state = snapshot.state("base_1", AerialState)
        if not state.landed:
            contacts = robot.model.engine.contacts(robot.model.name)
            touched = {one.other for one in contacts if one.force > 0.0 and one.link not in _HAND}
            touched -= {FLOOR, robot.model.name}
            flight.touched = tuple(sorted({*flight.touched, *touched}))
            if falls is not None and flight.fell is None and snapshot.time >= falls:
                battery.level, flight.fell = _LOW, snapshot.time
        elif flight.fell is not None and flight.landed is None:
            where = state.pose.position
            flight.landed = (*where, snapshot.time)
            flight.away = min(math.dist(where[:2], place[:2]) for place in places)

    return look


def main() -> int:
    """Flies all deliveries; prints the table."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--deliveries", type=int, default=20, help="deliveries with a full battery")
    parser.add_argument("--falls", type=int, default=10, help="deliveries in which the battery falls in flight")
    parser.add_argument("--simulation", default=default_simulation(), help="engine that simulates")
    arguments = parser.parse_args()
    engine, count, falls = arguments.simulation, arguments.deliveries, arguments.falls
    whens = np.random.default_rng(18).uniform(*_FLOWN, falls)
    flights = [_told(f"delivery {seed}", fly(seed, engine)) for seed in range(count)]
    fallen = [_told(f"fall {seed}", fly(100 + seed, engine, float(when))) for seed, when in enumerate(whens)]
    figures = []
    if flights:
        delivered = sum(one.delivered for one in flights)
        middle = float(np.median([one.seconds for one in flights]))
        said = f"{delivered} of {count} (median {middle:.0f} s simulated)"
        figures.append(Figure("deliveries by air", said, f"{count} of {count}", delivered == count))
        touched = sum(bool(one.touched) for one in flights)
        figures.append(Figure("deliveries in which frame or arm touched something", f"{touched}"))
    if fallen:
        safe, on = sum(one.is_safe for one in fallen), sum(one.delivered for one in fallen)
        said = f"{safe} of {falls}; {on} of them delivered after charging"
        figures.append(Figure("battery falls in flight: lands safely", said, f"{falls} of {falls}", safe == falls))
    return finish(f"uav, {engine}", figures)


def _told(name: str, flight: Flight) -> Flight:
    print(f"{name}: {flight}", flush=True)
    return flight


if __name__ == "__main__":
    sys.exit(main())
