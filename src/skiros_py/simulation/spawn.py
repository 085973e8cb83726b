"""Where bodies stand at the start: as the scene says, or drawn by the seed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from skiros_py.errors import DescriptionError
from skiros_py.geometry import Pose
from skiros_py.ports.cell import BodySpec, CellSpec

_MIN_DISTANCE = 0.13  # between the middles of parts on one place [m], so that a hand fits between them
_DROP = 0.0005  # above the surface, from where a drawn part settles [m]
_TRIES = 200
_ARRANGEMENTS = 100
_NAMED = 8
"""So many bodies are named in a message."""


def start_poses(spec: CellSpec, seed: int, platforms: Mapping[str, Pose] | None = None) -> dict[str, Pose]:
    """Returns the pose in the map of every body and compartment at the start.

    A compartment without a carrier of its own is described in the same frame as the body it belongs to.

    Args:
        spec: The cell.
        seed: The run's seed.
        platforms: Pose in the map, at the start, of each platform on which bodies stand, by device; where one is left
            out, that of its robot or device counts.

    Raises:
        DescriptionError: A body has neither pose nor place, or its place has no room for it.
    """
    known = platforms or {}
    poses = {body.id: _carrier_pose(spec, body, known) @ body.pose for body in spec.bodies if body.pose is not None}
    waiting = [body for body in spec.bodies if body.pose is None]
    for place_id in dict.fromkeys(body.place for body in waiting):
        bodies = [body for body in waiting if body.place == place_id]
        place = _place(spec, poses, bodies)
        rng = np.random.default_rng([seed, *place.id.encode()])  # other places do not change what is drawn here
        there = [poses[body.id] for body in spec.bodies if body.place == place.id and body.id in poses]
        standing = [poses[place.id].inverse() @ pose for pose in there]
        for body_id, pose in _arrange(place, bodies, standing, rng).items():
            poses[body_id] = poses[place.id] @ pose
    return poses


def free_pose(body: BodySpec, standing: Sequence[tuple[BodySpec, Pose]], seed: int) -> Pose:
    """Returns a pose in the map at which a body may come into a cell where others stand.

    Args:
        body: The body; its own pose counts where it has one.
        standing: The bodies and compartments that are there, with their poses in the map.
        seed: The run's seed.

    Raises:
        DescriptionError: It has neither pose nor place, or its place has no room for it.
    """
    if body.pose is not None:
        return body.pose
    # Whatever is movable may lie there, whichever place it was meant for.
    there = [
        replace(spec, pose=pose, carrier=None, place=body.place if spec.mass > 0.0 else spec.place)
        for spec, pose in standing
    ]
    return start_poses(CellSpec((*there, body), ()), seed)[body.id]


def _carrier_pose(spec: CellSpec, body: BodySpec, platforms: Mapping[str, Pose]) -> Pose:
    carrier = body.carrier
    if carrier is None and body.compartment and body.place is not None:
        carrier = spec.body(body.place).carrier
    if carrier is None:
        return Pose()
    if carrier not in spec.devices:
        raise DescriptionError(f"'{body.id}' is carried by '{carrier}', which is no device of this cell")
    return platforms.get(carrier, spec.group_of(carrier).start)


def _place(spec: CellSpec, poses: Mapping[str, Pose], bodies: Sequence[BodySpec]) -> BodySpec:
    names = _names(bodies)
    if bodies[0].place is None:
        raise DescriptionError(f"{names}: give a pose, or a place to lie on")
    place = next((body for body in spec.bodies if body.id == bodies[0].place), None)
    if place is None or place.id not in poses or (place.support is None and not place.compartment):
        raise DescriptionError(f"{names}: '{bodies[0].place}' is no body with a pose and a surface to lie on")
    return place


def _arrange(
    place: BodySpec, bodies: Sequence[BodySpec], standing: Sequence[Pose], rng: np.random.Generator
) -> dict[str, Pose]:
    """Draws poses in the place's frame; starts over when the first ones leave no room for the last."""
    for _ in range(_ARRANGEMENTS if len(bodies) <= _most(place) else 0):
        drawn: dict[str, Pose] = {}
        for body in bodies:
            pose = _draw(place, body, [*standing, *drawn.values()], rng)
            if pose is None:
                break
            drawn[body.id] = pose
        else:
            return drawn
    names = _names(bodies)
    raise DescriptionError(f"no room on '{place.id}' for {names} with {_MIN_DISTANCE} m between their middles")


def _most(place: BodySpec) -> float:
    """Returns how many bodies a place can never have more of: discs around their middles would overlap."""
    half_x, half_y = _surface(place)
    return (2.0 * half_x + _MIN_DISTANCE) * (2.0 * half_y + _MIN_DISTANCE) / (math.pi * (_MIN_DISTANCE / 2.0) ** 2)


def _names(bodies: Sequence[BodySpec]) -> str:
    more = f" and {len(bodies) - _NAMED} more" if len(bodies) > _NAMED else ""
    return ", ".join(body.id for body in bodies[:_NAMED]) + more


def _draw(place: BodySpec, body: BodySpec, others: Sequence[Pose], rng: np.random.Generator) -> Pose | None:
    low, high = body.solid.bounds()
    reach = np.maximum(np.abs(low), np.abs(high))
    half_x, half_y = _surface(place)
    centre_x, centre_y = place.support_centre
    for _ in range(_TRIES):
        yaw = float(rng.uniform(-math.pi, math.pi))
        cos, sin = abs(math.cos(yaw)), abs(math.sin(yaw))
        free_x, free_y = half_x - cos * reach[0] - sin * reach[1], half_y - sin * reach[0] - cos * reach[1]
        if min(free_x, free_y) < 0.0:
            continue
        x, y = rng.uniform((centre_x - free_x, centre_y - free_y), (centre_x + free_x, centre_y + free_y))
        if all(math.dist((x, y), other.position[:2]) >= _MIN_DISTANCE for other in others):
            return Pose.of(x, y, place.support_height + _DROP, yaw=yaw)
    return None


def _surface(place: BodySpec) -> tuple[float, float]:
    if place.support is not None:
        return place.support
    low, high = place.solid.bounds()
    half = (high - low) / 2.0
    return float(half[0]), float(half[1])
