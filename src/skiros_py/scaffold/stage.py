"""A small scene for a trial: a world with a robot, to which elements of the requested classes and facts are added."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import count
from pathlib import Path

from skiros_py.config import ontology_paths
from skiros_py.errors import FileError, UnknownName, UsageError, WorldError
from skiros_py.geometry import Pose
from skiros_py.scaffold.declared import snake_case, words_of
from skiros_py.scaffold.draft import render
from skiros_py.scaffold.ontology import declaring, prefix_of, prefix_table
from skiros_py.scaffold.project import Knowledge
from skiros_py.scaffold.robot import robot_iris
from skiros_py.skills.conditions import AllOf, AnyOf, Compare, Computed, Condition, Exists, Has, Pattern, Related
from skiros_py.skills.parameters.values import sample_of_range
from skiros_py.world.change import PropertyEdit, RelationEdit
from skiros_py.world.element import Placement, Value
from skiros_py.world.reasoners.registry import load_reasoners
from skiros_py.world.scene.files import diff, load_scene
from skiros_py.world.scene.writer import TurtleWriter
from skiros_py.world.terms import Family
from skiros_py.world.transaction import Transaction
from skiros_py.world.vocabulary import DRIVING_POSE, ELEMENT, GRASP_WIDTH, GRASPABLE_BY, HAS_A, POSE
from skiros_py.world.world import World


class Stage:
    """A scene under construction.

    Args:
        known: The available words.
        name: Name of the scene.
        robot: Name of its robot; empty for none.

    Attributes:
        world: Its current state.
        goals: Its goals.
        left_to_robot: Required places of the robot, as (robot, relation, place): it drives there itself.

    Raises:
        UnknownName: There is no such robot.
    """

    def __init__(self, known: Knowledge, name: str, robot: str = "") -> None:
        robots = robot_iris(known.ontology)
        if robot and robot not in robots:
            raise UnknownName("robot", robot, robots)
        self._ontology = known.ontology
        self._name = name
        self._robot = [robots[robot]] if robot else []
        self._row = count()
        self.goals: list[str] = []
        self.left_to_robot: list[tuple[str, str, str]] = []
        self.world = self._loaded()
        self._given = self.world.snapshot()
        self._pieces = [id_ for id_ in self._given.instances(ELEMENT) if id_ not in ("floor", "unknown_location")]

    def _loaded(self) -> World:
        reasoners, _ = load_reasoners(self._ontology)
        with tempfile.TemporaryDirectory(prefix="skiros-new-") as folder:
            file = Path(folder) / "scene.ttl"
            file.write_text(self._rendered(""), encoding="utf-8")
            try:
                return load_scene(self._ontology, file, ontology_paths(), reasoners=reasoners)
            except FileError as error:
                raise UsageError(f"scene '{self._name}': {error.reason}") from error

    @contextmanager
    def _edit(self) -> Iterator[Transaction]:
        try:
            with self.world.transaction("skiros new", "sets the stage") as tx:
                yield tx
        except WorldError as error:
            raise UsageError(f"scene '{self._name}': {error}") from error

    def cast(self, class_: str, role: str) -> str:
        """Returns an individual of a class: one of the robot where it has one, else a new one named after a role."""
        for root, id_ in (("sk:Floor", "floor"), ("sk:UnknownLocation", "unknown_location")):
            if self._ontology.is_a(class_, root):
                return id_
        return next(iter(self._given.instances_among(class_, self._pieces)), None) or self.add(class_, role)

    def add(self, class_: str, role: str) -> str:
        """Adds an individual of a class, standing on the floor where it can stand anywhere, and returns its id."""
        stem = snake_case(role)
        number = next(n for n in count(1) if not self.world.has(f"{stem}_{n}"))
        id_ = f"{stem}_{number}"
        is_a = self._ontology.is_a
        properties: dict[str, Value] = {}
        placement = Placement("sk:at", "unknown_location") if is_a(class_, "sk:Robot") else None
        is_device = is_a(class_, "sk:Device")
        if not placement and not is_device and is_a(class_, "sk:SpatialThing") and not is_a(class_, "sk:Root"):
            placement = Placement("sk:on", "floor")
            properties[POSE] = Pose((2.0 + next(self._row), 0.0, 0.0))
            if is_a(class_, "sk:Location") and not self._ontology.class_value(class_, DRIVING_POSE):
                properties[DRIVING_POSE] = Pose((-0.8, 0.0, 0.0))
        with self._edit() as tx:
            tx.add(class_, f"{words_of(role)} {number}", id_, properties, placement)
            if is_device and self._robot:
                tx.relate(self._piece("sk:Arm"), HAS_A, id_)
        return id_

    def _piece(self, class_: str) -> str:
        for id_ in self._given.instances_among(class_, self._pieces):
            return id_
        raise UsageError(f"robot <{self._robot[0]}> has no {class_}")

    # ------------------------------------------------------------------ facts

    def suppose(self, pattern: Pattern, binding: Mapping[str, str]) -> tuple[str, ...]:
        """States facts that make a pattern true, as far as a scene can state them.

        The location of a robot is omitted, because it drives there.

        Returns:
            The parts that cannot be stated.
        """
        match pattern:
            case Related(relation, subject, object_):
                self._relate(binding[subject], relation, binding[object_])
            case Compare(property_, "=", subject, value):
                self._set(binding[subject], property_, value)
            case Has(property_, subject):
                if self.world.value(binding[subject], property_) is None:
                    sample = sample_of_range(self._ontology.properties[property_].range)
                    if sample is None:
                        return (f"there is no example of {property_}",)
                    self._set(binding[subject], property_, sample)
            case Exists(variable, class_, inner):
                return self.suppose(inner, {**binding, variable: self.cast(class_, class_.partition(":")[2])})
            case AllOf(patterns):
                return tuple(left for part in patterns for left in self.suppose(part, binding))
            case AnyOf(patterns):
                return self.suppose(patterns[0], binding)
            case Computed(relation, subject, _) if relation == GRASPABLE_BY:
                self._set(binding[subject], GRASP_WIDTH, 0.04)
            case Computed(relation):
                return (f"{relation} is computed",)
            case _:
                pass  # a negation needs no fact
        return ()

    def _set(self, element: str, property_: str, value: Value) -> None:
        with self._edit() as tx:
            tx.set(element, property_, value)

    def _relate(self, subject: str, relation: str, object_: str) -> None:
        """States that a relation holds; a placement moves what it places."""
        family = self._ontology.family(relation)
        moved = ""
        if family is Family.PLACEMENT:
            moved, placement = self._ontology.placed(subject, relation, object_)
            if moved in self._pieces:
                self.left_to_robot.append((moved, placement.relation, placement.place))
                return
        with self._edit() as tx:
            if family is Family.STRUCTURE:
                for owner in set(self.world.subjects(relation, object_)) - {subject}:
                    tx.unrelate(owner, relation, object_)
            elif moved and placement.place != "floor":
                tx.set(moved, POSE, None)
            tx.relate(subject, relation, object_)

    # ------------------------------------------------------------------ as Turtle

    def turtle(self, help_: str) -> str:
        """Returns the scene as a Turtle file.

        Args:
            help_: Its purpose, in a sentence.
        """
        state = self.world.snapshot()
        new = [id_ for id_ in state.instances(ELEMENT) if not self._given.has(id_)]
        writer = TurtleWriter(state)
        used = {state.element(id_).type for id_ in new} | {p for id_ in new for p in state.element(id_).properties}
        used |= {relation for id_ in new for _, relation, _ in state.statements_about(id_)}
        paragraphs = []
        for edit in diff(self._given, state):
            match edit:
                case PropertyEdit(id_, property_, _, value) if self._given.has(id_) and value is not None:
                    paragraphs.append(f"scene:{id_} {property_} {writer.literal(property_, value)} .\n")
                    used.add(property_)
                case RelationEdit(subject, relation, object_, _, True) if self._given.has(subject):
                    paragraphs.append(f"scene:{subject} {relation} scene:{object_} .\n")
                    used.add(relation)
        paragraphs += writer.elements(new)
        base = self._piece("sk:Base") if self._robot else ""
        return self._rendered(help_, {prefix_of(word) for word in used}, paragraphs, base)

    def _rendered(
        self, help_: str, prefixes: Collection[str] = (), paragraphs: Sequence[str] = (), base: str = ""
    ) -> str:
        return render(
            "scene.ttl",
            name=self._name,
            help=help_,
            label=words_of(self._name),
            prefixes=prefix_table(self._ontology, prefixes),
            imports=declaring(self._ontology, prefixes) + self._robot,
            goals=[json.dumps(goal) for goal in self.goals],
            base=base,
            paragraphs=paragraphs,
        )


def open_questions(stage: Stage, conditions: Sequence[Condition], cast: Mapping[str, str]) -> Iterator[str]:
    """Yields the required facts that do not hold in a scene, with reasons, except where its robot drives itself."""
    for condition in conditions:
        about = {cast[argument] for argument in condition.arguments}
        by_itself = any({robot, place} <= about for robot, _, place in stage.left_to_robot)
        verdict = condition.evaluate(stage.world, cast)
        if not verdict.holds and not by_itself:
            yield f"{condition} ({verdict.lines()[-1].strip()})"
