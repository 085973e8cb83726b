"""What the ontology says about types of parts: shape, how to grasp them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from skiros_py.errors import DescriptionError
from skiros_py.geometry import Solid
from skiros_py.robot.perception import PartModel
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import GRASP_HEIGHT, GRASP_WIDTH, MANIPULATABLE, SOLID

__all__ = ["Grasp", "grasp_of", "part_models"]


@dataclass(frozen=True, slots=True)
class Grasp:
    """How to take a part from above, across its y axis.

    Attributes:
        height: Height of the finger tips above the support [m].
        width: Width of the part there [m].
        yaws: Headings of the tool relative to the part that do equally well [rad].
    """

    height: float
    width: float
    yaws: tuple[float, ...]


def part_models(view: WorldView) -> tuple[PartModel, ...]:
    """Returns every part type that has a shape of its own."""
    models = []
    for class_ in sorted(view.ontology.subclasses(MANIPULATABLE)):
        text = view.ontology.class_value(class_, SOLID)
        if text is not None:
            models.append(PartModel(class_, Solid.from_json(str(text))))
    return tuple(models)


def grasp_of(view: WorldView, part: str) -> Grasp:
    """Returns how to grasp a part.

    Raises:
        DescriptionError: The ontology does not say how.
    """
    height, width = view.value(part, GRASP_HEIGHT), view.value(part, GRASP_WIDTH)
    if not isinstance(height, float) or not isinstance(width, float):
        raise DescriptionError(f"{view.element(part).type} has no sk:graspHeight and sk:graspWidth: give it both")
    solid = Solid.from_json(str(view.value(part, SOLID)))
    turns = 8 if _is_round(solid) else 2
    return Grasp(height, width, tuple(2.0 * math.pi * k / turns for k in range(turns)))


def _is_round(solid: Solid) -> bool:
    """Tells whether turning about the vertical changes nothing: upright cylinders on the axis."""
    return all(
        block.kind == "cylinder" and max(map(abs, block.pose.position[:2] + block.pose.orientation[:2])) < 1e-6
        for block in solid.primitives
    )
