"""What a rehearsal is asked for: present beliefs as a scene, the goal, and how to play it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from skiros_py.errors import UsageError
from skiros_py.geometry import Pose
from skiros_py.messages import Message, listed
from skiros_py.planning.requests import RuledOut
from skiros_py.skills.restart import last_place
from skiros_py.skills.surroundings import is_held, solid_of
from skiros_py.station.scenes.scenes import scene_only
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Placement
from skiros_py.world.index import with_value
from skiros_py.world.scene.learned import learned_names, learned_turtle
from skiros_py.world.scene.writer import scene_turtle
from skiros_py.world.view import WorldView
from skiros_py.world.workspace import Workspace
from skiros_py.world.world import World

if TYPE_CHECKING:
    from skiros_py.station.session import Options, Session


MARK = "SKIROS_REHEARSAL"
"""Environment variable that marks the programs started by a rehearsal."""


@dataclass(frozen=True, slots=True)
class RehearsalOrder:
    """A rehearsal to be played; plain data.

    Attributes:
        name: Name of the scene.
        scene: The beliefs, as a scene file.
        learned: The learned concepts, as a file; empty for none.
        goal: The goal texts; empty for the goal of the scene.
        options: How to open the second world.
        assumptions: What no belief says, and is assumed.
        draws: How often what no belief says is drawn, each time for a world of its own.
        rounds: How many plans are tried at most.
        limit: Simulated time after which a plan has failed [s].
        pictures: Folder for pictures of failures; None for none.
        ruled_out: Attempts that are not planned in the first place.
    """

    name: str
    scene: str
    learned: str
    goal: tuple[str, ...]
    options: Options
    assumptions: tuple[str, ...] = ()
    draws: int = 1
    rounds: int = 5
    limit: float = 1800.0
    pictures: Path | None = None
    ruled_out: tuple[RuledOut, ...] = ()

    def __post_init__(self) -> None:
        if self.draws < 1 or self.rounds < 1:
            raise UsageError(Message("a rehearsal takes at least one draw and one round"))


def order_from(world: World, options: Options, goal: Sequence[str] = (), **how: object) -> RehearsalOrder:
    """Returns the order for a world whose robots stand where it says.

    Args:
        world: The beliefs.
        options: Those of the session that would do it; the second one simulates as fast as it can.
        goal: The goal texts; none for the goal of the scene.
        **how: Further attributes of the order.
    """
    return _order(world, {}, options, goal, how)


def order_of(session: Session, goal: Sequence[str], **how: object) -> RehearsalOrder:
    """Returns the order for what a session believes now; bases stand where they are localised."""
    board = session.cycle.board
    robots = [robot for robot in session.spec.robots if robot.carrier is not None]
    poses = {robot.carrier.id: robot.pose(board.snapshot, board.guard) for robot in robots if robot.carrier}
    return _order(session.world, poses, session.options, goal, how)


def _order(
    world: World, poses: Mapping[str, Pose], options: Options, goal: Sequence[str], how: Mapping[str, object]
) -> RehearsalOrder:
    work = Workspace(scene_only(world.snapshot()))
    for device, pose in poses.items():
        work.put(with_value(work.view.element(device), v.POSE, pose))
    assumptions = (*_put_back(world, work), *_unknown_poses(work.view))
    there = replace(options, goal=(), fake=False, driver=None, gui=False, pace=None, data=None)
    view = work.view
    learned = learned_turtle(view) if learned_names(view) else ""
    name = view.source.name or "scene"
    return RehearsalOrder(name, scene_turtle(view), learned, tuple(goal), there, assumptions, **how)  # type: ignore[arg-type]


def _put_back(world: World, work: Workspace) -> Iterator[str]:
    """Puts held parts back where they were taken from: no simulation starts with something between fingers."""
    for part in [one for one in work.view.instances(v.MANIPULATABLE) if is_held(work.view, one)]:
        before = last_place(world, part)
        place = before or Placement(v.ON, work.view.instances(v.UNKNOWN_LOCATION)[0])
        work.place(part, place)
        work.put(with_value(work.view.element(part), v.POSE, None))
        if before is None:
            work.put(with_value(work.view.element(part), v.MISSING, True))
        yield Message("{part} is held: rehearsed as if it were still in {place}", part=part, place=place.place)


def _unknown_poses(view: WorldView) -> Iterator[str]:
    """Yields for each place the things that lie there and were never seen."""
    unknown: dict[str, list[str]] = {}
    for thing in (*view.instances(v.MANIPULATABLE), *view.instances(v.STOCK)):
        at = view.placement(thing)
        if view.value(thing, v.POSE) is not None or at is None or at.relation not in (v.IN, v.MAY_BE_IN):
            continue
        if solid_of(view, at.place) is not None:
            unknown.setdefault(at.place, []).append(thing)
    for place, things in sorted(unknown.items()):
        yield Message("where in {place} {things} lie was never seen: drawn", place=place, things=listed(sorted(things)))
