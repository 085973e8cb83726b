"""Use cases: goals. They are parsed and checked here; a job or a task pursues them."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

from skiros_py.api import goals as api
from skiros_py.errors import StaleVersion, UsageError
from skiros_py.messages import Message
from skiros_py.planning.problem.stock import believed
from skiros_py.planning.problem.task import Capability
from skiros_py.skills.conditions import ClassRelated, Compare, Computed, Condition, ConditionType, Has, Nothing, Related
from skiros_py.skills.conditions.effects import Assign, Relate, brought_about
from skiros_py.skills.conditions.pattern import NumberChange, Pattern, leaves
from skiros_py.skills.conditions.watch import ReadingView
from skiros_py.skills.skill import SkillDescription
from skiros_py.station.jobs.orders import texts_of
from skiros_py.station.jobs.template_document import goal_texts
from skiros_py.station.requests import ANY_VERSION, LIBRARY, Author, Seen, Service, require_seen
from skiros_py.tasks.goals import goal_as_data, goal_as_text, parse_goal
from skiros_py.world.change import Writer
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView


def _checked(condition: Condition, view: WorldView) -> api.CheckedCondition:
    verdict = believed(condition, view)
    (data,) = goal_as_data((condition,))
    text = goal_as_text((condition,))
    return api.CheckedCondition.view_of(verdict, text=text, data=data, lines=tuple(verdict.lines()))


# ------------------------------------------------------------------ words

_Change = tuple[str, str]
"""An effect of a skill: a relation or property, and the class of the element that it moves or changes."""


def condition_words(
    conditions: Mapping[str, ConditionType], capabilities: Sequence[Capability], ontology: Ontology
) -> Iterator[api.ConditionWord]:
    """Yields the words of the goal language, with the skills that can make them hold.

    A skill counts if it changes a relation or property on which the condition depends; whether it does so for the
    elements of a goal is found by planning.
    """
    brought = {c.skill.name: frozenset(_brought(c.skill, ontology)) for c in capabilities}
    for name, type_ in sorted(conditions.items()):
        wanted = tuple(_wanted(type_.pattern, ontology))
        skills = [skill for skill, changes in brought.items() if any(one(c) for one in wanted for c in changes)]
        roles = tuple(_roles(type_, [c.skill for c in capabilities if c.skill.name in skills], ontology))
        yield api.ConditionWord.view_of(type_, name=name, roles=roles, skills=tuple(sorted(skills)))


def _roles(type_: ConditionType, skills: Sequence[SkillDescription], ontology: Ontology) -> Iterator[api.Role]:
    """Yields the arguments of a condition, each with the class for which those skills make it hold."""
    made = [
        [skill.param(argument).element_class for argument in post.arguments]
        for skill in skills
        for post in skill.post
        if post.type.name == type_.name and not post.negated
    ]
    for number, role in enumerate(type_.roles):
        reached = _widest([classes[number] for classes in made], ontology)
        narrower = reached is not None and ontology.is_a(reached, role.class_)
        yield api.Role.model_validate(
            {"name": role.name, "class": role.class_, "reached": reached if narrower else role.class_}
        )


def _widest(classes: Sequence[str], ontology: Ontology) -> str | None:
    """Returns the one of these classes that includes all others; None if there is none."""
    return next((wide for wide in classes if all(ontology.is_a(one, wide) for one in classes)), None)


def _brought(skill: SkillDescription, ontology: Ontology) -> Iterator[_Change]:
    """Yields the effects of a skill."""
    for condition in skill.post:
        for effect in brought_about(condition):
            if isinstance(effect, Assign | NumberChange):
                yield effect.property, skill.param(effect.subject).element_class
            elif isinstance(effect, Relate):
                ends = (effect.subject, effect.relation, effect.object)
                moved = ontology.placed(*ends)[0] if ontology.is_placement(effect.relation) else effect.subject
                yield effect.relation, skill.param(moved).element_class


def _wanted(pattern: Pattern, ontology: Ontology) -> Iterator[Callable[[_Change], bool]]:
    """Yields, for each part of a pattern, a predicate that returns whether a change may make it hold."""
    for leaf, _ in leaves(pattern):
        match leaf:
            case Nothing(relation=emptied):
                yield partial(_takes_away, emptied, ontology)
            case Related(relation=relation) | Computed(relation=relation) | ClassRelated(relation=relation):
                yield partial(_is_among, frozenset(ontology.sub_relations(relation)))
            case Has(property=property_) | Compare(property=property_):
                yield partial(_is_among, frozenset({property_}))


def _is_among(names: frozenset[str], change: _Change) -> bool:
    return change[0] in names


def _takes_away(relation: str, ontology: Ontology, change: _Change) -> bool:
    """Returns whether a change moves the element that may have the relation, which then no longer holds."""
    other, class_ = change
    if not (other in ontology.relations and ontology.is_placement(other) and ontology.is_placement(relation)):
        return False
    known = ontology.relation(relation)
    thing = known.domain if known.place_end == "object" else known.range
    return thing is None or ontology.is_a(class_, thing) or ontology.is_a(thing, class_)


class GoalService(Service):
    """Checks goals, and stores those of the scene."""

    def check(self, order: api.GoalOrder) -> api.CheckedGoal:
        """Returns the goal as parsed, and for each condition whether it holds now, or why not.

        Raises:
            UsageError: It cannot be parsed.
        """
        session = self._station.session
        state = session.world.snapshot()
        view = ReadingView(state, session.world.sensors)  # one state of the world, with the current readings of devices
        goal = parse_goal(texts_of(order, self._station.document_store), view, session.catalogue.conditions)
        each = tuple(_checked(condition, view) for condition in goal)
        holds = all(one.holds for one in each)
        return api.CheckedGoal(text=goal_as_text(goal), conditions=each, holds=holds, world=state.version)

    def get(self) -> api.SceneGoals:
        """Returns the goals of the scene."""
        session = self._station.session
        goals = session.world.goals
        try:
            session.parse(goals)
        except UsageError as error:
            return api.SceneGoals(goals=goals, fault=str(error))
        return api.SceneGoals(goals=goals)

    def put(self, body: api.GoalTexts, seen: Seen | None = ANY_VERSION, author: Author = LIBRARY) -> api.SceneGoals:
        """Replaces the goals of the scene.

        Raises:
            UsageError: One of them cannot be parsed.
            StaleVersion: They were changed since the author has seen them.
        """
        world = self._station.session.world
        before = world.goals
        require_seen(seen, goals_version(before))
        texts = goal_texts(body.goals)
        self._station.session.parse(texts)
        reason = Message("the goals of the scene")
        with world.transaction(author.name, reason, writer=Writer.PERSON, holder=author.holder) as tx:
            if world.goals != before:
                raise StaleVersion(Message("the goals of the scene were changed meanwhile: look again"))
            tx.set_goals(texts)
        return self.get()

    def words(self, *, every: bool = False) -> api.ConditionWords:
        """Lists the words of goals, with the classes of their arguments.

        Args:
            every: True to include those that no present robot can fulfil.
        """
        session = self._station.session
        capabilities = self._station.control.call(lambda now: now.tasks.capabilities)
        words = condition_words(session.catalogue.conditions, capabilities, session.world.ontology)
        return api.ConditionWords(items=tuple(word for word in words if every or word.skills))


def goals_version(goals: tuple[str, ...]) -> int:
    """Returns a version number of the texts; the version of the world would change with every other edit."""
    return int.from_bytes(hashlib.sha256(repr(goals).encode()).digest()[:6])
