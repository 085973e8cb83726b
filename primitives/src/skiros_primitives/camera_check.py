"""Whether a camera is where it is believed to be: what two pictures say of the same thing.

Where a camera is off by the same on its carrier in both, it sees a thing off in its own frame, so in two places when it
is turned in between. From one side only, another camera tells; which of the two is off, a third one, or one of them
that agrees with itself from two sides.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping

import numpy as np

from skiros_primitives.cameras import localised_within
from skiros_py.geometry import Array, Pose
from skiros_py.messages import Message, joined
from skiros_py.skills.context import RunContext
from skiros_py.skills.pictures import Sighting
from skiros_py.world import vocabulary as v

_EVERY = 600.0
"""Time after which a camera is compared again [s]."""
_TURNED = math.radians(80.0)
"""Least angle between two pictures that are compared."""
_MOST = 0.007
"""A camera may see things off by so much [m]: half of it is the error of telling where a part lies."""
_MOST_APART = 0.010
"""Two cameras may see one thing so far apart [m], besides what localisers are off by."""
_SIGMAS = 3.0
_SOON = 120.0
"""Within this time two cameras have to see one thing [s]: it may be moved later."""
_KEPT = 16
"""So many comparisons of two cameras on different carriers are averaged: each time the robot is localised again."""
_SAME = 0.04
"""What is seen farther apart is not the same thing [m]."""
_STOOD, _STOOD_TURN = 0.02, math.radians(1.0)
"""A robot that is localised no farther off has not moved between two pictures [m, rad]."""


def error_between(first: Sighting, second: Sighting) -> float | None:
    """Returns by how much a camera sees things off, across its axis, by two sightings [m]; None where nothing tells.

    Args:
        first: Where something was seen.
        second: Where the same thing was seen from elsewhere.
    """
    moved = first.robot.inverse() @ second.robot
    if math.hypot(*moved.position) > _STOOD or abs(moved.yaw) > _STOOD_TURN:
        return None
    apart = np.subtract(first.pose.position, second.pose.position)
    turns = first.camera.matrix()[:3, :3] - second.camera.matrix()[:3, :3]
    left, sizes, right = np.linalg.svd(turns)
    seen = sizes >= 2.0 * math.sin(_TURNED / 2.0)
    if seen.sum() < 2 or np.linalg.norm(apart) > _SAME:
        return None
    # along the axis about which the camera turned nothing tells: there the error is taken to be none
    return float(np.linalg.norm(right[seen].T @ ((left.T @ apart)[seen] / sizes[seen])))


def apart(context: RunContext, first: Sighting, second: Sighting) -> tuple[Array, float] | None:
    """Returns how far apart two cameras saw one thing, and the standard deviation of that by localisers [m].

    Two cameras on one robot have its error in common; those on different carriers do not. None where nothing tells.

    Args:
        context: The run.
        first: Where one of them saw it.
        second: Where the other one saw it.
    """
    if first.carrier == second.carrier:
        moved = first.robot.inverse() @ second.robot
        if math.hypot(*moved.position) > _STOOD or abs(moved.yaw) > _STOOD_TURN:
            return None
        between, noise = np.subtract(second.pose.position, first.pose.position), 0.0
    else:
        places = [(one.robot @ one.pose).position for one in (first, second)]
        groups = {group.id: group for group in context.cell.groups}
        robots = [(groups[one.carrier], one.robot) for one in (first, second) if one.carrier in groups]
        noise = math.hypot(*(localised_within(group, places[0], at.position) for group, at in robots))
        between = np.subtract(places[1], places[0])
    return (between, noise) if np.linalg.norm(between) <= _SAME else None


def note_sighting(context: RunContext, camera: str, thing: str, seen: Sighting, author: str) -> dict[str, float]:
    """Keeps where a camera has seen something, and compares it with where others saw it just before.

    Args:
        context: The run.
        camera: Id of the camera.
        thing: Id of what it has seen.
        seen: Where.
        author: Who looks.

    Returns:
        By how much it sees things apart from others, by their ids, where that is too much [m].
    """
    pictures, differ = context.pictures, dict[str, float]()
    for (other, what), before in pictures.sightings.items():
        found = None
        if what == thing and other != camera and seen.time - before.time < _SOON:
            found = apart(context, before, seen)
        if found is None:
            continue
        between, noise = found
        first, second = sorted((camera, other))
        kept = pictures.apart.setdefault((first, second), deque(maxlen=_KEPT))
        if kept and (seen.carrier == before.carrier or kept[-1][0].distance(seen.robot) < _STOOD):
            kept.pop()  # it has the same error as that from now
        kept.append((seen.robot, between if first == other else -between))
        error = float(np.linalg.norm(np.mean([one for _, one in kept], axis=0)))
        pictures.agree[first, second] = error <= _MOST_APART
        if error > _MOST_APART + _SIGMAS * noise / math.sqrt(len(kept)):
            differ[other] = error
        elif error <= _MOST_APART:
            for one, confirmed in ((camera, other), (other, camera)):
                if confirmed in pictures.compared and context.world.value(confirmed, v.SIGHT_ERROR) is None:
                    _clear(context, one, author)
    pictures.sightings[camera, thing] = seen
    return differ


def _clear(context: RunContext, camera: str, author: str) -> None:
    """Writes that nothing is wrong with a camera, where something was."""
    if context.world.value(camera, v.SIGHT_ERROR) is not None:
        with context.world.transaction(author=author, reason=Message("{camera} sees well again", camera=camera)) as tx:
            tx.set(camera, v.SIGHT_ERROR, None)


def blame(context: RunContext, camera: str, differ: Mapping[str, float], author: str) -> Message | None:
    """Tells which of some cameras are off, where they see one thing apart; writes and announces that.

    Args:
        context: The run.
        camera: Id of a camera.
        differ: By how much it sees things apart from others, by their ids [m].
        author: Who looks.

    Returns:
        What to tell a person; None where nothing is wrong.
    """
    told: list[Message] = []
    for other, error in differ.items():
        pair = (camera, other)
        off = [one for one in pair if context.world.value(one, v.SIGHT_ERROR) is not None]
        doubted = off or [one for one in pair if not _is_confirmed(context, one)] or list(pair)
        if len(doubted) == 1:
            (wrong,) = doubted
            (right,) = {*pair} - {wrong}
            text = Message(
                "{camera} sees things {error:.0f} mm from where {other} does: it has to be calibrated",
                camera=wrong,
                other=right,
                error=1e3 * error,
            )
        else:
            text = Message(
                "{camera} and {other} see things {error:.0f} mm apart: one of them has to be calibrated",
                camera=camera,
                other=other,
                error=1e3 * error,
            )
        told.append(text)
        for one in doubted:
            if one not in off:
                _announce(context, one, error, text, author)
    return joined("; ", told) if told else None


def _is_confirmed(context: RunContext, camera: str) -> bool:
    """Returns whether a camera agrees with itself from two sides, or with another camera."""
    pictures = context.pictures
    return camera in pictures.compared or any(agree and camera in pair for pair, agree in pictures.agree.items())


def _announce(context: RunContext, camera: str, error: float, reason: Message, author: str) -> None:
    with context.world.transaction(author=author, reason=reason) as tx:
        tx.set(camera, v.SIGHT_ERROR, round(error, 4))
    context.emit("camera_off", {"camera": camera, "error": error, "text": str(reason)})


def is_due(context: RunContext, camera: str, every: float = _EVERY) -> bool:
    """Returns whether pictures of a camera were not compared for some time [s]."""
    last = context.pictures.compared.get(camera)
    return last is None or context.board.snapshot.time - last > every


def is_turned(first: Sighting, camera: Pose) -> bool:
    """Returns whether a camera would be turned enough against a sighting.

    Args:
        first: The sighting.
        camera: Where the camera would be in the map.
    """
    between = (first.robot @ first.camera).inverse() @ camera
    return 2.0 * math.acos(min(1.0, abs(between.orientation[3]))) > _TURNED


def compare(context: RunContext, camera: str, first: Sighting, second: Sighting, author: str) -> Message | None:
    """Compares two sightings of one thing; writes by how much the camera is off, and announces it where that is much.

    Args:
        context: The run.
        camera: Id of the camera.
        first: Where something was seen.
        second: Where the same thing was seen from elsewhere.
        author: Who looks.

    Returns:
        What to tell a person; None where nothing is wrong, or nothing tells.
    """
    error = error_between(first, second)
    if error is None:
        return None
    context.pictures.compared[camera] = context.board.snapshot.time
    known = {"camera": camera, "error": 1e3 * error}
    if error <= _MOST:
        _clear(context, camera, author)
        return None
    reason = Message("{camera} sees things {error:.0f} mm off: it has to be calibrated", **known)
    _announce(context, camera, error, reason, author)
    return reason
