"""Common parts of the teaching primitives: the class a lesson applies to, and storing it."""

from __future__ import annotations

from collections.abc import Mapping

from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.world.element import Value
from skiros_py.world.names import ClassName, local_name
from skiros_py.world.vocabulary import APPLIES_TO
from skiros_py.world.world import World


def other_class(world: World, element: str, type_: str | None) -> Failure | None:
    """Returns why an element cannot serve as an example for a class: it must be of that class."""
    line = world.ontology.ancestors(world.element(element).type)
    if type_ is None or type_ in line:
        return None
    return Failure(f"type: {element} is no {type_}; teach it for one of {', '.join(line)}")


def keep(
    world: World, lesson: ClassName, element: str, type_: str | None, values: Mapping[str, Value], *, author: str
) -> Outcome:
    """Stores data shown on one element for all things of its class.

    Args:
        world: The world.
        lesson: Class of the learned data.
        element: The example element.
        type_: The class it applies to; by default, that of the element.
        values: The shown values, by property.
        author: Who was taught.
    """
    class_ = type_ or world.element(element).type
    label = f"{world.ontology.classes[lesson].label.removeprefix('taught ')} for {local_name(class_)}"
    with world.transaction(author=author, reason=f"shown on {element}") as tx:
        learned = tx.add(lesson, label, properties={APPLIES_TO: class_, **values}, learned=True)
    return Success(f"learned as {learned}: {label}")
