"""Values taught to robots about classes of things; they take precedence over the values of the class itself.

A taught pose is an element of the learned concepts (or of an ontology) that has the value and names its class by
``sk:appliesTo``. So teaching changes no element and no class, persists beyond the scene, and can be deleted.
"""

from __future__ import annotations

from skiros_py.world.element import Element, Value
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import (
    APPLIES_TO,
    DRIVING_POSE,
    GRASP_POSE,
    GRASP_WIDTH,
    PLACING_POSE,
    TAUGHT_POSE,
)

TEACHABLE = frozenset({DRIVING_POSE, GRASP_POSE, GRASP_WIDTH, PLACING_POSE})
"""Properties whose values can be taught."""


def class_value(view: WorldView, class_: str, property_: str) -> Value | None:
    """Returns the default value for things of a class: as taught, else from the class.

    The value taught for the most specific class counts; of several, the last.

    Raises:
        UnknownName: It is not a class.
    """
    lesson = lesson_about(view, class_, property_)
    return view.ontology.class_value(class_, property_) if lesson is None else lesson.properties[property_]


def lesson_about(view: WorldView, class_: str, property_: str) -> Element | None:
    """Returns the element with the taught value for things of a class, or None if nothing was taught.

    Raises:
        UnknownName: It is not a class.
    """
    if property_ not in TEACHABLE:
        return None
    about: dict[str, Element] = {}
    for lesson in lessons(view):
        if property_ in lesson.properties and APPLIES_TO in lesson.properties:
            about[str(lesson.properties[APPLIES_TO])] = lesson
    return next((about[above] for above in view.ontology.ancestors(class_) if above in about), None)


def lessons(view: WorldView) -> tuple[Element, ...]:
    """Returns everything that was taught about classes, in the order in which it was taught."""
    if TAUGHT_POSE not in view.ontology.classes:
        return ()
    return tuple(view.element(name) for name in sorted(view.abstracts(TAUGHT_POSE), key=_age))


def _age(element: str) -> tuple[int, str]:
    """Ids of one class are numbered and never used again: the greatest number is the last ("…_10" after "…_9")."""
    return len(element), element
