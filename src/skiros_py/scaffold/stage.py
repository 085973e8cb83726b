"""A small scene for a trial: individuals of the requested classes, facts about them; and its test."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

from skiros_py.config import ontology_paths
from skiros_py.errors import FileError, UsageError
from skiros_py.scaffold.declared import snake_case, words_of
from skiros_py.scaffold.draft import render
from skiros_py.scaffold.ontology import declaring, prefix_of, prefix_table
from skiros_py.scaffold.project import Knowledge
from skiros_py.scaffold.robot import RobotFile
from skiros_py.skills.conditions import AllOf, AnyOf, Compare, Computed, Condition, Exists, Has, Pattern, Related
from skiros_py.tasks.goals import parse_goal
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import load_reasoners
from skiros_py.world.scene import load_scene
from skiros_py.world.terms import Family
from skiros_py.world.world import World

_SAMPLES = {
    "xsd:boolean": "true",
    "xsd:integer": "1",
    "xsd:decimal": "1.0",
    "xsd:double": "1.0e0",
    "xsd:string": '"text"',
    "sk:poseLiteral": '"0 0 0 0 0 0"^^sk:poseLiteral',
    "sk:vectorLiteral": '"1 1"^^sk:vectorLiteral',
    "sk:className": '"sk:Object"^^sk:className',
    "rdf:JSON": '"[]"^^rdf:JSON',
}
"""An example value of each data type, as Turtle."""


@dataclass(slots=True)
class _Individual:
    """One individual: its Turtle statements, by predicate."""

    id: str
    class_: str
    label: str
    facts: dict[str, list[str]] = field(default_factory=dict)


class Stage:
    """A scene under construction.

    Args:
        ontology: The available words.
        name: Name of the scene.
        robot: Its robot; None for none.

    Attributes:
        goals: Its goals.
        left_to_robot: Required places of the robot, as (robot, relation, place): it drives there itself.
    """

    def __init__(self, ontology: Ontology, name: str, robot: RobotFile | None = None) -> None:
        self._ontology = ontology
        self._name = name
        self._robot = robot
        self._own: dict[str, _Individual] = {}
        self._of_robot: dict[str, _Individual] = {}
        self._row = count()
        self.goals: list[str] = []
        self.left_to_robot: list[tuple[str, str, str]] = []

    def cast(self, class_: str, role: str) -> str:
        """Returns an individual of a class: one of the robot where it has one, else a new one named after a role."""
        for root in ("sk:Floor", "sk:UnknownLocation"):
            if self._ontology.is_a(class_, root):
                return snake_case(root.partition(":")[2])
        for id_, own in (self._robot.individuals if self._robot else {}).items():
            if self._ontology.is_a(own, class_):
                return id_
        return self.add(class_, role)

    def add(self, class_: str, role: str) -> str:
        """Adds an individual of a class, standing on the floor where it can stand anywhere, and returns its id."""
        stem = snake_case(role)
        id_ = next(name for n in count(1) if not self._knows(name := f"{stem}_{n}"))
        person = _Individual(id_, class_, f"{words_of(role)} {id_.rpartition('_')[2]}")
        self._own[id_] = person
        self._settle(person)
        return id_

    def _knows(self, id_: str) -> bool:
        return id_ in self._own or (self._robot is not None and id_ in self._robot.individuals)

    def _settle(self, person: _Individual) -> None:
        is_a = self._ontology.is_a
        if is_a(person.class_, "sk:Robot"):
            person.facts["sk:at"] = ["scene:unknown_location"]
        elif is_a(person.class_, "sk:Device"):
            if self._robot is not None:
                self._say(self._robot.first("sk:Arm", self._ontology), "sk:hasA", f"scene:{person.id}")
        elif is_a(person.class_, "sk:SpatialThing") and not is_a(person.class_, "sk:Root"):
            person.facts["sk:on"] = ["scene:floor"]
            person.facts["sk:pose"] = [f'"{2.0 + next(self._row):.1f} 0 0 0 0 0"^^sk:poseLiteral']
            if is_a(person.class_, "sk:Location") and not self._ontology.class_value(person.class_, "sk:drivingPose"):
                person.facts["sk:drivingPose"] = ['"-0.8 0 0 0 0 0"^^sk:poseLiteral']

    # ------------------------------------------------------------------ facts

    def suppose(self, pattern: Pattern, binding: Mapping[str, str]) -> tuple[str, ...]:
        """States facts that make a pattern true, as far as a scene can state them.

        The location of a robot is omitted, because it drives there.

        Returns:
            The parts that cannot be stated.
        """
        match pattern:
            case Related(relation, subject, object_):
                self.relate(binding[subject], relation, binding[object_])
            case Compare(property_, "=", subject, value):
                self._say(binding[subject], property_, _turtle(value), instead=True)
            case Has(property_, subject):
                if not self._value(binding[subject], property_):
                    self._say(binding[subject], property_, self._sample(property_), instead=True)
            case Exists(variable, class_, inner):
                return self.suppose(inner, {**binding, variable: self.cast(class_, class_.partition(":")[2])})
            case AllOf(patterns):
                return tuple(left for part in patterns for left in self.suppose(part, binding))
            case AnyOf(patterns):
                return self.suppose(patterns[0], binding)
            case Computed("sk:graspableBy", subject, _):
                self._say(binding[subject], "sk:graspWidth", "0.04", instead=True)
            case Computed(relation):
                return (f"{relation} is computed",)
            case _:
                pass  # a negation needs no fact
        return ()

    def relate(self, subject: str, relation: str, object_: str) -> None:
        """States that a relation holds; a placement moves what it places."""
        family = self._ontology.family(relation)
        if family is Family.PLACEMENT:
            moved, placement = self._ontology.placed(subject, relation, object_)
            if self._robot and moved in self._robot.individuals:
                self.left_to_robot.append((moved, placement.relation, placement.place))
                return
            self._unplace(moved, keep_pose=placement.place == "floor")
        if family is Family.STRUCTURE:
            if self._robot and (subject, object_) in self._robot.pieces:
                return
            for owner in (*self._own.values(), *self._of_robot.values()):
                owner.facts["sk:hasA"] = [o for o in owner.facts.get("sk:hasA", []) if o != f"scene:{object_}"]
        self._say(subject, relation, f"scene:{object_}")

    def _unplace(self, moved: str, *, keep_pose: bool) -> None:
        for person in self._own.values():
            for relation in [r for r in person.facts if self._places(r)]:
                person.facts[relation] = [
                    o for o in person.facts[relation] if self._ontology.placed(person.id, relation, o[6:])[0] != moved
                ]
        if not keep_pose and moved in self._own:
            self._own[moved].facts.pop("sk:pose", None)

    def _places(self, relation: str) -> bool:
        return relation in self._ontology.relations and self._ontology.is_placement(relation)

    def _value(self, id_: str, property_: str) -> bool:
        person = self._own.get(id_) or self._of_robot.get(id_)
        if person is None:
            return False
        return property_ in person.facts or self._ontology.class_value(person.class_, property_) is not None

    def _sample(self, property_: str) -> str:
        return _SAMPLES[self._ontology.properties[property_].range]

    def _say(self, subject: str, predicate: str, value: str, *, instead: bool = False) -> None:
        person = self._own.get(subject)
        if person is None:
            class_ = self._robot.individuals.get(subject, "") if self._robot else ""
            person = self._of_robot.setdefault(subject, _Individual(subject, class_, ""))
        values = person.facts.setdefault(predicate, [])
        if instead:
            values.clear()
        if value not in values:
            values.append(value)

    # ------------------------------------------------------------------ as Turtle

    def turtle(self, help_: str) -> str:
        """Returns the scene as a Turtle file.

        Args:
            help_: Its purpose, in a sentence.
        """
        people = [*self._of_robot.values(), *self._own.values()]
        used = {prefix_of(p.class_) for p in self._own.values()} | {prefix_of(f) for p in people for f in p.facts}
        robot = [self._robot.iri] if self._robot else []
        return render(
            "scene.ttl",
            name=self._name,
            help=help_,
            label=words_of(self._name),
            prefixes=prefix_table(self._ontology, used),
            imports=declaring(self._ontology, used) + robot,
            goals=[json.dumps(goal) for goal in self.goals],
            base=self._robot.first("sk:Base", self._ontology) if self._robot else "",
            people=[(p, _statements(p)) for p in people if p.class_ and _statements(p)],
        )


def _statements(person: _Individual) -> list[str]:
    head = [] if not person.label else [f"rdfs:label {json.dumps(person.label)}"]
    return head + [f"{predicate} {' , '.join(values)}" for predicate, values in person.facts.items() if values]


def _turtle(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return json.dumps(value, ensure_ascii=False)


def tried(known: Knowledge, text: str, what: str) -> World:
    """Loads a scene from its text.

    Raises:
        UsageError: It cannot be loaded, or its goal refers to missing elements.
    """
    reasoners, _ = load_reasoners(known.ontology)
    with tempfile.TemporaryDirectory(prefix="skiros-new-") as folder:
        file = Path(folder) / "scene.ttl"
        file.write_text(text, encoding="utf-8")
        try:
            world = load_scene(known.ontology, file, ontology_paths(), reasoners=reasoners)
            parse_goal(world.goals, world, known.catalogue.conditions)
        except FileError as error:
            raise UsageError(f"{what}: {error.reason}") from error
    return world


def open_questions(
    world: World, stage: Stage, conditions: Mapping[str, Condition], cast: Mapping[str, str]
) -> Iterator[str]:
    """Yields the required facts that do not hold in a scene, with reasons, except where its robot drives itself."""
    for said, condition in conditions.items():
        about = {cast[argument] for argument in condition.arguments}
        by_itself = any({robot, place} <= about for robot, _, place in stage.left_to_robot)
        verdict = condition.evaluate(world, cast)
        if not verdict.holds and not by_itself:
            yield f"{said} ({verdict.lines()[-1].strip()})"
