"""Part types from the ontology: shape, grasps, and poses of tools and parts."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product

from skiros_py.errors import DescriptionError
from skiros_py.geometry import Pose, Solid
from skiros_py.messages import Message
from skiros_py.ports.perception import PartModel
from skiros_py.skills.surroundings import solid_of
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import GRASP_HEIGHT, GRASP_POSE, GRASP_WIDTH, MANIPULATABLE, SOLID


def downward(x: float, y: float, z: float, yaw: float) -> Pose:
    """Returns a tool pose that points straight down; the tool's x axis has the given heading [m, rad]."""
    return Pose.of(x, y, z, roll=math.pi, yaw=yaw)


def level(pose: Pose) -> Pose:
    """Returns a pose without its tilt: things are assumed to stand upright, regardless of the measured tilt."""
    return Pose.of(*pose.position, yaw=pose.yaw)


_LEANING = math.radians(30.0)
"""How far a hand leans where the arm cannot hold it straight above."""


def leaning(tools: Iterable[Pose]) -> tuple[Pose, ...]:
    """Returns poses of a tool that leans to both sides, about the axis along which its fingers close.

    They hold a part at the same places, and what is grasped or put down so stands upright.
    """
    turns = [Pose.of(0.0, 0.0, 0.0, pitch=side * _LEANING) for side in (1.0, -1.0)]
    return tuple(tool @ turn for tool, turn in product(tools, turns))


_ROUND_TURNS = 8
"""How many grasp directions are tried for a round part."""


@dataclass(frozen=True, slots=True)
class Grasp:
    """How to grasp a part.

    Attributes:
        poses: Equivalent tool poses in the part's frame.
        width: Finger gap there when the part is held [m].
    """

    poses: tuple[Pose, ...]
    width: float


def part_models(view: WorldView) -> tuple[PartModel, ...]:
    """Returns every part type that has its own shape."""
    models = []
    for class_ in sorted(view.ontology.subclasses(MANIPULATABLE)):
        text = view.ontology.class_value(class_, SOLID)
        if text is not None:
            models.append(PartModel(class_, Solid.from_json(str(text))))
    return tuple(models)


def grasp_of(view: WorldView, part: str) -> Grasp:
    """Returns how to grasp a part: from the part itself, else as taught for its class, else from its class.

    Raises:
        DescriptionError: No grasp is known.
    """
    pose, height, width = (view.value(part, name) for name in (GRASP_POSE, GRASP_HEIGHT, GRASP_WIDTH))
    own = view.element(part).properties
    if not isinstance(pose, Pose) or (GRASP_HEIGHT in own and GRASP_POSE not in own):
        pose = downward(0.0, 0.0, height, 0.0) if isinstance(height, float) else None
    if pose is None or not isinstance(width, float):
        missing = Message("{kind} has no sk:graspHeight and sk:graspWidth", kind=view.element(part).type)
        raise DescriptionError(f"{missing}: give it both, or teach a grasp")
    return Grasp(_alike(pose, solid_of(view, part)), width)


def _alike(pose: Pose, solid: Solid | None) -> tuple[Pose, ...]:
    """The grasp itself and with the fingers swapped; for round parts, from all sides."""
    if solid is not None and _is_round(solid):
        turns = (Pose.of(0.0, 0.0, 0.0, yaw=2.0 * math.pi * k / _ROUND_TURNS) for k in range(_ROUND_TURNS))
        return tuple(turn @ pose for turn in turns)
    return (pose, pose @ Pose.of(0.0, 0.0, 0.0, yaw=math.pi))


def _is_round(solid: Solid) -> bool:
    """Returns whether turning about the vertical changes nothing: upright cylinders on the axis."""
    return all(
        block.kind == "cylinder" and max(map(abs, block.pose.position[:2] + block.pose.orientation[:2])) < 1e-6
        for block in solid.primitives
    )
