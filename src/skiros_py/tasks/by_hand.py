"""What a person did in the place of a robot is believed because somebody says so."""

from __future__ import annotations

from collections.abc import Iterable

from skiros_py.skills.conditions import Condition, effects_of, write_effects
from skiros_py.world.change import Writer
from skiros_py.world.world import World


def write_by_hand(world: World, conditions: Iterable[Condition], by: str, what: str = "done by hand") -> None:
    """Makes conditions true in the world model, all of them or none.

    Args:
        world: The live world model.
        conditions: What is so now.
        by: Who says so.
        what: What was done, for the record of changes.

    Raises:
        DescriptionError: Nobody can say what a condition changes ("one of these").
        WorldError: It cannot be so.
    """
    effects = [effect for condition in conditions for effect in effects_of(condition)]
    with world.transaction("operator", f"{what}, says {by}", writer=Writer.PERSON) as tx:
        write_effects(tx, world.ontology, effects)
