"""What left of, above, near, inside … mean for boxes; ``core.ttl`` says the same in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from skiros_py.geometry import Array
from skiros_py.world.reasoners.boxes import Bools, Boxes
from skiros_py.world.reasoners.contacts import (
    depth,
    distance,
    gap_seen_from_above,
    is_closer,
    offset_along,
    reach_along,
)
from skiros_py.world.vocabulary import (
    ABOVE,
    BEHIND,
    BELOW,
    IN_FRONT_OF,
    INSIDE,
    LEFT_OF,
    NEAR,
    OVERLAPS,
    RESTS_ON,
    RIGHT_OF,
)

ACCURACY = 0.003
"""Poses are not sensed more exactly: what differs less is taken for the same [m]."""
NEARBY = 0.5
"""Things are near where there is at most this much between them: about as far as an arm reaches from a spot [m]."""
RESTING = 0.005
"""A thing rests where its lowest point is this close to the surface [m]."""

_ANYWHERE = float("inf")


@dataclass(frozen=True, slots=True)
class SpatialRelation:
    """One relation between boxes, pair by pair of one root.

    Attributes:
        holds: Between which pairs it holds.
        value: What that was decided by [m].
        says: A sentence about two elements, given whether it holds and the value.
        within: How far apart along the root's x, y, z the boxes may be for it to hold at all [m].
        needs_map: True where up and down matter, so that the pose in the map must be known.
        needs_size: True if a point has no answer.
    """

    holds: Callable[[Boxes, Boxes], Bools]
    value: Callable[[Boxes, Boxes], Array]
    says: Callable[[str, str, bool, float], str]
    within: tuple[float, float, float]
    needs_map: bool = False
    needs_size: bool = False


# ---------------------------------------------------------------- left, right, in front, behind


def _beside(axis: int, side: float, words: str, further: str) -> SpatialRelation:
    """Wholly beyond one of the object's sides."""

    def value(a: Boxes, b: Boxes) -> Array:
        return side * offset_along(a, b, axis) - reach_along(a, b, axis) - b.halves[:, axis]

    def holds(a: Boxes, b: Boxes) -> Bools:
        return (value(a, b) >= -ACCURACY) & (side * offset_along(a, b, axis) > ACCURACY)

    def says(a: str, b: str, yes: bool, gap: float) -> str:
        if yes:
            return f"{a} is {words} {b}, with {max(gap, 0.0):.3f} m between them"
        return f"{a} is not {words} {b}: it would have to be {max(-gap, ACCURACY):.3f} m further {further}"

    return SpatialRelation(holds, value, says, (_ANYWHERE, _ANYWHERE, _ANYWHERE))


# ---------------------------------------------------------------- above, below, rests on


def _height_over(a: Boxes, b: Boxes) -> Array:
    return np.asarray(_lowest(a) - _highest(b))


def _is_above(a: Boxes, b: Boxes) -> Bools:
    higher = (_height_over(a, b) >= -ACCURACY) & (a.centres[:, 2] - b.centres[:, 2] > ACCURACY)
    apart = np.linalg.norm(a.centres[:, :2] - b.centres[:, :2], axis=1)
    return np.asarray(higher & ((gap_seen_from_above(a, b) < -ACCURACY) | (apart <= ACCURACY)))


def _says_over(word: str, further: str) -> Callable[[str, str, bool, float], str]:
    def says(a: str, b: str, yes: bool, gap: float) -> str:
        if yes:
            return f"{a} is {word} {b}, with {max(gap, 0.0):.3f} m between them"
        if gap >= -ACCURACY:
            return f"{a} is not {word} {b}: it is beside it"
        return f"{a} is not {word} {b}: it would have to be {-gap:.3f} m {further}"

    return says


def _height_on(a: Boxes, b: Boxes) -> Array:
    return np.asarray(_lowest(a) - np.where(b.hollow, _lowest(b), _highest(b)))


def _rests(a: Boxes, b: Boxes) -> Bools:
    middle = replace(a, halves=np.zeros_like(a.halves))
    return np.asarray((np.abs(_height_on(a, b)) <= RESTING) & (gap_seen_from_above(middle, b) <= 0.0))


def _says_rests(a: str, b: str, yes: bool, height: float) -> str:
    if yes:
        return f"{a} rests on {b}"
    if abs(height) <= RESTING:
        return f"{a} does not rest on {b}: its middle is not over it"
    return f"{a} does not rest on {b}: it is {abs(height):.3f} m {'above' if height > 0.0 else 'below'} its surface"


def _lowest(boxes: Boxes) -> Array:
    return np.asarray(boxes.centres[:, 2] - boxes.reach()[:, 2])


def _highest(boxes: Boxes) -> Array:
    return np.asarray(boxes.centres[:, 2] + boxes.reach()[:, 2])


# ---------------------------------------------------------------- near, overlaps, inside


def _is_near(a: Boxes, b: Boxes) -> Bools:
    return is_closer(a, b, NEARBY)


def _says_near(a: str, b: str, yes: bool, apart: float) -> str:
    far = "" if yes else f", more than {NEARBY} m"
    return f"{a} is {'' if yes else 'not '}near {b}: there are {apart:.3f} m between them{far}"


def _shared(a: Boxes, b: Boxes) -> Array:
    return np.maximum(depth(a, b), 0.0)


def _overlaps(a: Boxes, b: Boxes) -> Bools:
    thinnest = np.minimum(a.halves.min(axis=1), b.halves.min(axis=1))
    return np.asarray(depth(a, b) > np.clip(thinnest, 1e-6, ACCURACY))


def _says_overlaps(a: str, b: str, yes: bool, deep: float) -> str:
    if yes:
        return f"{a} and {b} overlap by {deep:.3f} m"
    return f"{a} and {b} do not overlap{', but touch' if deep > 0.0 else ''}"


def _clearance(a: Boxes, b: Boxes) -> Array:
    """The least room left at the sides and below; negative by how far it sticks out there."""
    x, y = (b.halves[:, k] - np.abs(offset_along(a, b, k)) - reach_along(a, b, k) for k in (0, 1))
    below = b.halves[:, 2] + offset_along(a, b, 2) - reach_along(a, b, 2)
    return np.asarray(np.minimum.reduce([x, y, below]))


def _is_inside(a: Boxes, b: Boxes) -> Bools:
    return np.asarray((_clearance(a, b) >= -ACCURACY) & _overlaps(a, b))


def _says_inside(a: str, b: str, yes: bool, clear: float) -> str:
    if yes:
        return f"{a} is inside {b}, with {max(clear, 0.0):.3f} m to its sides"
    if clear >= -ACCURACY:
        return f"{a} is not inside {b}: it is over it"
    return f"{a} is not inside {b}: it sticks out by {-clear:.3f} m"


SPATIAL_RELATIONS: Mapping[str, SpatialRelation] = MappingProxyType(
    {
        IN_FRONT_OF: _beside(0, 1.0, "in front of", "ahead"),
        BEHIND: _beside(0, -1.0, "behind", "back"),
        LEFT_OF: _beside(1, 1.0, "left of", "to the left"),
        RIGHT_OF: _beside(1, -1.0, "right of", "to the right"),
        ABOVE: SpatialRelation(
            _is_above, _height_over, _says_over("above", "higher"), (0.01, 0.01, _ANYWHERE), needs_map=True
        ),
        BELOW: SpatialRelation(
            lambda a, b: _is_above(b, a),
            lambda a, b: _height_over(b, a),
            _says_over("below", "lower"),
            (0.01, 0.01, _ANYWHERE),
            needs_map=True,
        ),
        RESTS_ON: SpatialRelation(
            _rests, _height_on, _says_rests, (0.01, 0.01, 2.0 * RESTING), needs_map=True, needs_size=True
        ),
        NEAR: SpatialRelation(_is_near, distance, _says_near, (NEARBY, NEARBY, NEARBY)),
        OVERLAPS: SpatialRelation(_overlaps, _shared, _says_overlaps, (0.0, 0.0, 0.0), needs_size=True),
        INSIDE: SpatialRelation(_is_inside, _clearance, _says_inside, (0.0, 0.0, 0.0), needs_size=True),
    }
)
"""Every spatial relation by its CURIE."""
