"""The language of goals: read from text, from PDDL and from plain data, checked word by word, and written again.

Text::

    InKit(Starter, kit_1) and not (EmptyHanded(gripper_1) or LocationEmpty("left place"))
    for all c: Compartment (HasPart(kit_1, c) implies not LocationEmpty(c))
    exists p: Starter (InKit(p, kit_1))

PDDL::

    (and (in_kit starter kit_1) (forall (?c - compartment) (imply (has_part kit_1 ?c) (not (location_empty ?c)))))
"""

from skiros_py.tasks.goals.parsing import goal_as_data, goal_as_text, goal_from_data, parse_goal

__all__ = ["goal_as_data", "goal_as_text", "goal_from_data", "parse_goal"]
