"""The reasoner of sizes: what fits into what, what a gripper can grasp, which things are of like size (paper §7.1)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from skiros_py.geometry import Array
from skiros_py.messages import Message
from skiros_py.world.change import PlacementEdit, Writer
from skiros_py.world.element import Value
from skiros_py.world.reasoners.boxes import extents
from skiros_py.world.reasoners.registry import Answer, Proposal, Reasoner
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import CONTAINER, FITS_IN, GRASP_WIDTH, GRASPABLE_BY, IN, MAX_GAP, SOLID

CLEARANCE = 0.005
"""A thing fits when it leaves this much room both ways, half of it on each side [m]."""
_SPREAD = 0.1
"""Standard deviation of measured lengths, as a part of the length: cameras see some sides from afar or not at all."""


def dimensions(solid: Value | None) -> tuple[float, float, float] | None:
    """Returns the lengths x, y, z of the box around a shape given as ``sk:solid`` [m], or None if there is none."""
    box = extents(solid)
    return None if box is None else (2.0 * box[3], 2.0 * box[4], 2.0 * box[5])


def similarity(view: WorldView, a: str, b: str) -> float | None:
    """Returns how alike two elements are in size, from 0 to 1, or None if a size is not known.

    It is the room that their boxes share when laid into each other, longest side along longest, as a part of the room
    that both take.

    Raises:
        UnknownName: There is no such element.
    """
    sizes = [dimensions(view.value(element, SOLID)) for element in (a, b)]
    if sizes[0] is None or sizes[1] is None:
        return None
    one, other = sorted(sizes[0]), sorted(sizes[1])
    shared = math.prod(map(min, one, other))
    return shared / (math.prod(one) + math.prod(other) - shared)


class SizeReasoner(Reasoner):
    """Compares sizes: of outlines (does it fit?), of grasps (is it narrow enough?), of shapes (what may it be?)."""

    name = "sizes"
    relations = frozenset({FITS_IN, GRASPABLE_BY})
    functions = MappingProxyType({"sk:similarity": similarity})
    keys = frozenset({"dimensions"})

    def answer(self, view: WorldView, subject: str, relation: str, object_: str) -> Answer:
        """Returns whether one thing fits into another, or a gripper can grasp it; the value is the clearance [m]."""
        return _fits(view, subject, object_) if relation == FITS_IN else _graspable(view, subject, object_)

    def pairs(
        self, view: WorldView, relation: str, subjects: Iterable[str], objects: Sequence[str]
    ) -> Iterator[tuple[str, str]]:
        """Yields the pairs between which a relation holds, in the order given."""
        needs, offers, spare = _COMPARED[relation]
        first, wanted = _known(view, subjects, needs)
        second, room = _known(view, objects, offers)
        for subject, size in zip(first, wanted, strict=True):
            good = ((room - size).min(axis=1) >= spare) if second else ()
            yield from ((subject, object_) for object_, fits in zip(second, good, strict=True) if fits)

    def data(self, view: WorldView, element: str, key: str) -> Value | None:
        """Reads "dimensions": the lengths x, y, z of the box around an element, in its own frame [m].

        Raises:
            UsageError: It has no such key.
            UnknownName: There is no such element.
        """
        return dimensions(view.value(element, SOLID)) if key == "dimensions" else super().data(view, element, key)

    def classify(self, view: WorldView, element: str, classes: Sequence[str]) -> tuple[tuple[str, float], ...]:
        """Returns how likely the size that was measured of an element makes each class, likeliest first.

        Measured is what the element itself has as ``sk:solid``; the classes are those whose own ``sk:solid`` is known.
        The likelihoods sum to 1; how the thing lay does not matter.

        Raises:
            UnknownName: There is no such element or class.
        """
        measured = dimensions(view.element(element).properties.get(SOLID))
        known = {name: dimensions(view.ontology.class_value(name, SOLID)) for name in classes}
        usual = {name: size for name, size in known.items() if size is not None}
        if measured is None or not usual:
            return ()
        off = np.log(np.sort(measured)) - np.log(np.sort(np.array(list(usual.values())), axis=1))
        fit = -0.5 * ((off / _SPREAD) ** 2).sum(axis=1)
        weights = np.exp(fit - fit.max())  # the best fits with weight 1, so that never all are 0
        likely = zip(usual, (weights / weights.sum()).tolist(), strict=True)
        return tuple(sorted(likely, key=lambda found: (-found[1], found[0])))

    def veto(self, proposal: Proposal) -> str | None:
        """Refuses placements by people and jobs where a thing does not fit; sensed placements are accepted."""
        if proposal.writer not in (Writer.PERSON, Writer.JOB):
            return None
        objections = (_objection(proposal.after, edit) for edit in proposal.edits if isinstance(edit, PlacementEdit))
        return "; ".join(text for text in objections if text) or None


def _objection(view: WorldView, edit: PlacementEdit) -> str | None:
    """Returns why a thing cannot be where an edit puts it; None also if a size is unknown."""
    new, ontology = edit.new, view.ontology
    if new is None or new.relation not in ontology.sub_relations(IN):
        return None
    if not ontology.is_a(view.element(new.place).type, CONTAINER):
        return None
    answer = _fits(view, edit.element, new.place)
    return None if answer.holds or answer.value is None else answer.reason


# ---------------------------------------------------------------- fits in, graspable by


def _fits(view: WorldView, thing: str, container: str) -> Answer:
    wanted, room = _outline(view, thing), _outline(view, container)
    unknown = [name for name, size in ((thing, wanted), (container, room)) if size is None]
    if wanted is None or room is None:
        return Answer(False, Message("the size of {things} is not known", things=unknown[0]))
    left = min(have - need for need, have in zip(wanted, room, strict=True))
    sizes = {"width": wanted[0], "length": wanted[1], "wide": room[0], "long": room[1]}
    into = Message("{width:.3f} x {length:.3f} m into {wide:.3f} x {long:.3f} m", **sizes)
    said = {"thing": thing, "container": container, "sizes": into}
    if left >= CLEARANCE:
        return Answer(True, Message("{thing} fits into {container}: {sizes}", **said), left)
    return Answer(
        False,
        Message(
            "{thing} does not fit into {container}: {sizes}, with {clearance} m to spare", clearance=CLEARANCE, **said
        ),
        left,
    )


def _graspable(view: WorldView, thing: str, gripper: str) -> Answer:
    read_width, read_gap, _ = _COMPARED[GRASPABLE_BY]
    width, gap = read_width(view, thing), read_gap(view, gripper)
    if width is None or gap is None:
        return Answer(
            False,
            Message(
                "{thing} has no {property}, or {other} no {need}",
                thing=thing,
                property=GRASP_WIDTH,
                other=gripper,
                need=MAX_GAP,
            ),
        )
    said = {"thing": thing, "width": width[0], "gripper": gripper, "gap": gap[0]}
    text = Message("{thing} is {width:.3f} m wide, {gripper} opens {gap:.3f} m", **said)
    return Answer(width[0] < gap[0], text, gap[0] - width[0])


def _outline(view: WorldView, element: str) -> tuple[float, ...] | None:
    """The shorter and the longer side of what an element covers of the ground, as it stands [m]."""
    size = dimensions(view.value(element, SOLID))
    return None if size is None else tuple(sorted(size[:2]))


_Read = Callable[["WorldView", str], tuple[float, ...] | None]


def _number(property_: str) -> _Read:
    """Reads a property whose value is one number."""

    def read(view: WorldView, element: str) -> tuple[float, ...] | None:
        value = view.value(element, property_)
        return (float(value),) if isinstance(value, int | float) else None

    return read


_COMPARED: Mapping[str, tuple[_Read, _Read, float]] = MappingProxyType(
    {
        FITS_IN: (_outline, _outline, CLEARANCE),
        GRASPABLE_BY: (_number(GRASP_WIDTH), _number(MAX_GAP), math.ulp(0.0)),  # more than nothing at all
    }
)
"""By relation: the sizes of subject and object, and the required clearance [m]."""


def _known(view: WorldView, elements: Iterable[str], read: _Read) -> tuple[list[str], Array]:
    """The elements with a known size, and the sizes, row by row [m]."""
    found = [(element, size) for element in elements if (size := read(view, element)) is not None]
    return [element for element, _ in found], np.array([size for _, size in found])
