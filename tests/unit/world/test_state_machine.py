"""Random writes to a world, against a naive model: sets of triples, with the rules spelt out plainly.

The model knows what a transaction must do and whether it must be refused; after each step every reading method of the
world has to say what the model says.
"""

from __future__ import annotations

import copy
import math
import tempfile
from collections.abc import Iterator
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from skiros_py.config import ontology_paths
from skiros_py.errors import Locked, StaleVersion, WorldError
from skiros_py.geometry import Pose
from skiros_py.testing import TINY_ONTOLOGY
from skiros_py.world.branches import children, parent
from skiros_py.world.change import Change, Writer
from skiros_py.world.element import Placement
from skiros_py.world.index import Index
from skiros_py.world.locks import Locks
from skiros_py.world.lookup import resolve
from skiros_py.world.ontology import Ontology
from skiros_py.world.transaction import Transaction
from skiros_py.world.undo import undo
from skiros_py.world.world import World

COUNTED = """
@prefix t: <https://w3id.org/skiros-py/testing/counted#> .
@prefix tiny: <https://w3id.org/skiros-py/testing/tiny#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix xsd: <http://www.w3.org/2001/XMLSchema#> .
<https://w3id.org/skiros-py/testing/counted> a owl:Ontology ;
    owl:imports <https://w3id.org/skiros-py/core> , <https://w3id.org/skiros-py/testing/tiny> .
t:Tray a owl:Class ; rdfs:label "tray" ; rdfs:comment "Has at most two slots." ; rdfs:subClassOf sk:Container ,
    [ a owl:Restriction ; owl:onProperty sk:hasA ; owl:maxCardinality "2"^^xsd:nonNegativeInteger ] .
t:Cart a owl:Class ; rdfs:label "cart" ; rdfs:comment "Carries at most one ball." ; rdfs:subClassOf sk:Robot ,
    [ a owl:Restriction ; owl:onProperty tiny:carries ; owl:maxCardinality "1"^^xsd:nonNegativeInteger ] .
t:Weight a owl:Class ; rdfs:label "weight" ; rdfs:comment "Has a mass." ; rdfs:subClassOf tiny:Ball ,
    [ a owl:Restriction ; owl:onProperty sk:mass ; owl:minCardinality "1"^^xsd:nonNegativeInteger ] .
t:owns a owl:ObjectProperty , owl:InverseFunctionalProperty ; rdfs:label "owns" ; rdfs:comment "Alone." ;
    rdfs:domain sk:Robot ; rdfs:range sk:Location .
"""

# ---------------------------------------------------------------- what the ontology says, once more and by hand

ABOVE = {
    "tiny:Ball": "sk:Manipulatable sk:Object sk:SpatialThing sk:Element",
    "tiny:RedBall": "tiny:Ball sk:Manipulatable sk:Object sk:SpatialThing sk:Element",
    "t:Weight": "tiny:Ball sk:Manipulatable sk:Object sk:SpatialThing sk:Element",
    "tiny:Box": "sk:Container sk:Location sk:SpatialThing sk:Element",
    "t:Tray": "sk:Container sk:Location sk:SpatialThing sk:Element",
    "tiny:Slot": "sk:Container sk:Location sk:SpatialThing sk:Element",
    "sk:Floor": "sk:Root sk:Location sk:SpatialThing sk:Element",
    "t:Cart": "sk:Robot sk:SpatialThing sk:Element",
    "sk:Gripper": "sk:Device sk:SpatialThing sk:Element",
    "sk:Skill": "sk:Element",
}
CLASSES = sorted(ABOVE)
PLACEMENTS = {  # domain, range, whether the object is the place
    "sk:at": ("sk:Robot", "sk:Location", True),
    "sk:heldBy": ("sk:Manipulatable", "sk:Gripper", True),
    "sk:in": ("sk:SpatialThing", "sk:Location", True),
    "sk:on": ("sk:SpatialThing", "sk:Location", True),
    "tiny:carries": ("sk:Robot", "sk:Manipulatable", False),
}
OTHERS = {  # domain, range
    "sk:hasA": ("sk:Element", "sk:Element"),
    "sk:poseFrame": ("sk:SpatialThing", "sk:SpatialThing"),
    "sk:startLocation": ("sk:Robot", "sk:Location"),
    "tiny:knows": ("sk:Robot", "sk:Location"),
    "t:owns": ("sk:Robot", "sk:Location"),
}
FUNCTIONAL = {"sk:poseFrame", "sk:startLocation"}
NARROWER = {"sk:placement": tuple(PLACEMENTS), "sk:structure": ("sk:hasA",)}
MOST = {("t:Tray", "sk:hasA"): 2, ("t:Cart", "tiny:carries"): 1}
FLAG, COUNT, MASS, POSE, SIZE, GAP = "sk:missing", "sk:missedLooks", "sk:mass", "sk:pose", "sk:size", "sk:maxGap"
BEARERS = {
    FLAG: "sk:SpatialThing",
    COUNT: "sk:Manipulatable",
    MASS: "sk:SpatialThing",
    POSE: "sk:SpatialThing",
    SIZE: "sk:SpatialThing",
    GAP: "sk:Gripper",
    "rdfs:label": "sk:Element",
}
TURN = (0.0, 0.0, 1.0, 0.0)
VALUES: dict[str, list[tuple[Any, Any]]] = {  # what is written, and as what it is kept
    FLAG: [(True, True), (False, False)],
    COUNT: [(3, 3), (-(2**63), -(2**63))],
    MASS: [(0.5, 0.5), (3, 3.0)],
    POSE: [(Pose((1, 2, 3)), Pose((1.0, 2.0, 3.0))), (Pose((0.0, 0.0, 1.0), TURN), Pose((0.0, 0.0, 1.0), TURN))],
    SIZE: [([1, 2.5], (1.0, 2.5)), ((), ())],
    GAP: [(0.1, 0.1)],
    "rdfs:label": [
        ("box", "box"),
        ('"} DROP ALL; #', '"} DROP ALL; #'),
        ("\N{GRINNING FACE}\0", "\N{GRINNING FACE}\0"),
    ],
}
BAD: dict[str, list[Any]] = {
    FLAG: [1, "true", 0.0],
    COUNT: [True, 1.0, 2**63, 10**50, "1"],
    MASS: [math.nan, math.inf, True, "1", 10**400],
    POSE: [Pose((math.nan, 0.0, 0.0)), Pose((0.0, 0.0)), Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 2.0)), "0 0 0 0 0 0"],  # type: ignore[arg-type]
    SIZE: [(1.0, math.nan), "1 2", (True,)],
    GAP: [None.__class__],
    "rdfs:label": ["", "\ud800", None, 5],
}

Fact = tuple[str, str, str]


def is_a(class_: str, ancestor: str) -> bool:
    return class_ == ancestor or ancestor in ABOVE[class_].split()


def ends_of(relation: str) -> tuple[str, str]:
    return PLACEMENTS[relation][:2] if relation in PLACEMENTS else OTHERS[relation]


def below(relation: str) -> tuple[str, ...]:
    return (relation, *NARROWER.get(relation, ()))


def learned(name: str) -> bool:
    return name.startswith("learned:")


class Refused(Exception):
    pass


class Model:
    """What is: classes, values (labels among them) and facts; and what may be done with them."""

    def __init__(self) -> None:
        self.types: dict[str, str] = {}
        self.values: dict[tuple[str, str], Any] = {}
        self.facts: set[Fact] = set()
        self.goals: tuple[str, ...] = ()
        self.used: set[str] = set()

    # -------------------------------------------------------- reading

    def place_of(self, name: str) -> Placement | None:
        for s, r, o in self.facts:
            if r in PLACEMENTS:
                thing, place = (s, o) if PLACEMENTS[r][2] else (o, s)
                if thing == name:
                    return Placement(r, place)
        return None

    def placed_in(self, name: str) -> list[str]:
        return sorted(n for n in self.types if (at := self.place_of(n)) is not None and at.place == name)

    def owners(self, name: str) -> list[str]:
        return sorted(s for s, r, o in self.facts if r == "sk:hasA" and o == name)

    def pieces(self, name: str) -> set[str]:
        found = {name}
        while more := {o for s, r, o in self.facts if r == "sk:hasA" and s in found} - found:
            found |= more
        return found

    # -------------------------------------------------------- writing

    def need(self, *names: str) -> None:
        if not all(name in self.types for name in names):
            raise Refused

    def fits(self, subject: str, relation: str, object_: str) -> bool:
        domain, range_ = ends_of(relation)
        return (
            is_a(self.types[subject], domain)
            and is_a(self.types[object_], range_)
            and learned(subject) == learned(object_)
        )

    def next_id(self, class_: str, *, is_learned: bool) -> str:
        bare = "".join("_" + c.lower() if c.isupper() else c for c in class_.split(":")[1]).strip("_")
        stem = ("learned:" if is_learned else "") + bare
        tails = [name[len(stem) + 1 :] for name in self.used if name.startswith(stem + "_")]
        return f"{stem}_{max([0, *(int(tail) for tail in tails if tail.isdigit())]) + 1}"

    def add(self, class_: str, name: str | None, values: dict[str, Any], *, is_learned: bool) -> str:
        if class_ not in ABOVE or name in self.used:
            raise Refused
        name = name or self.next_id(class_, is_learned=is_learned)
        self.used.add(name)
        self.types[name] = class_
        self.values[name, "rdfs:label"] = class_.split(":")[1]
        for property_, value in values.items():
            self.set(name, property_, value)
        return name

    def place(self, name: str, relation: str, place: str) -> None:
        self.need(name, place)
        if relation not in PLACEMENTS:
            raise Refused
        fact = (name, relation, place) if PLACEMENTS[relation][2] else (place, relation, name)
        if not self.fits(*fact):
            raise Refused
        self.displace(name)
        self.facts.add(fact)

    def displace(self, name: str) -> None:
        at = self.place_of(name)
        if at is not None:
            self.facts -= {(name, at.relation, at.place), (at.place, at.relation, name)}

    def relate(self, subject: str, relation: str, object_: str) -> None:
        self.need(subject, object_)
        if relation in PLACEMENTS:
            to = (subject, object_) if PLACEMENTS[relation][2] else (object_, subject)
            self.place(to[0], relation, to[1])
            return
        if relation not in OTHERS or not self.fits(subject, relation, object_):
            raise Refused
        if relation in FUNCTIONAL:
            self.facts -= {fact for fact in self.facts if fact[:2] == (subject, relation)}
        self.facts.add((subject, relation, object_))

    def unrelate(self, subject: str, relation: str, object_: str) -> None:
        if (subject, relation, object_) not in self.facts or (relation in PLACEMENTS and not learned(subject)):
            raise Refused
        self.facts.remove((subject, relation, object_))

    def set(self, name: str, property_: str, value: Any) -> None:
        self.need(name)
        if value is None and property_ != "rdfs:label":
            self.values.pop((name, property_), None)
            return
        if not is_a(self.types[name], BEARERS[property_]):
            raise Refused
        kept = [kept for written, kept in VALUES[property_] if written is value]
        if not kept:
            raise Refused
        self.values[name, property_] = kept[0]

    def remove(self, name: str) -> None:
        self.need(name)
        doomed = self.pieces(name)
        if any((at := self.place_of(n)) is not None and at.relation == "sk:heldBy" for n in doomed):
            raise Refused
        refuge, owner = self.place_of(name), name
        while refuge is None and self.owners(owner):
            owner = self.owners(owner)[0]
            refuge = self.place_of(owner)
        guests = sorted({guest for n in doomed for guest in self.placed_in(n)} - doomed)
        for guest in guests:
            self._move_out(guest, refuge)
        for s, r, o in sorted(self.facts):
            if r == "sk:poseFrame" and o in doomed:
                self.values.pop((s, POSE), None)
        for n in doomed:
            self._forget(n)

    def _move_out(self, guest: str, refuge: Placement | None) -> None:
        old = self.place_of(guest)
        assert old is not None
        self.displace(guest)
        if learned(guest):
            return
        for relation in (refuge.relation, old.relation, *sorted(PLACEMENTS)) if refuge else ():
            fact = (guest, relation, refuge.place) if PLACEMENTS[relation][2] else (refuge.place, relation, guest)
            if self.fits(*fact):
                self.facts.add(fact)
                return
        raise Refused

    def _forget(self, name: str) -> None:
        del self.types[name]
        self.facts = {fact for fact in self.facts if name not in (fact[0], fact[2])}
        self.values = {key: value for key, value in self.values.items() if key[0] != name}

    # -------------------------------------------------------- what a state must be

    def check(self) -> None:
        if any(s not in self.types or o not in self.types for s, _, o in self.facts):
            raise Refused
        for name, class_ in self.types.items():
            owners, at = self.owners(name), self.place_of(name)
            must_be = is_a(class_, "sk:SpatialThing") and not is_a(class_, "sk:Root") and not learned(name)
            if len(owners) > 1 or (owners and at) or (must_be and not owners and not at):
                raise Refused
            if class_ == "t:Weight" and not learned(name) and (name, MASS) not in self.values:
                raise Refused
            if len([1 for _, r, o in self.facts if (r, o) == ("t:owns", name)]) > 1:
                raise Refused
            for (counted, relation), most in MOST.items():
                if class_ == counted and len([1 for s, r, _ in self.facts if (s, r) == (name, relation)]) > most:
                    raise Refused
            self._check_ways_up(name)

    def _check_ways_up(self, name: str) -> None:
        for relations in (set(PLACEMENTS) | {"sk:hasA"}, {"sk:poseFrame"}):
            above, new = set[str](), {name}
            while new:
                new = {up for lower, up in self._up(relations) if lower in new} - above
                above |= new
            if name in above:
                raise Refused

    def _up(self, relations: set[str]) -> Iterator[tuple[str, str]]:
        for s, r, o in self.facts & {fact for fact in self.facts if fact[1] in relations}:
            yield (s, o) if r == "sk:poseFrame" or PLACEMENTS.get(r, (0, 0, False))[2] else (o, s)

    # -------------------------------------------------------- differences

    def content(self, name: str) -> Any:
        return self.types.get(name), sorted((k[1], repr(v)) for k, v in self.values.items() if k[0] == name)

    def marks(self, before: Model) -> set[str]:
        """The elements whose values, place or relations differ."""
        names = {n for n in {*self.types, *before.types} if self.content(n) != before.content(n)}
        for s, r, o in self.facts ^ before.facts:
            names |= {s, o} if r not in PLACEMENTS else {s if PLACEMENTS[r][2] else o}
        return names

    def concerns(self, before: Model) -> set[str]:
        """What differs, where that is or was, and all that they are or were pieces of."""
        found = self.marks(before) | {end for s, _, o in self.facts ^ before.facts for end in (s, o)}
        owns = {(s, o) for s, r, o in self.facts | before.facts if r == "sk:hasA"}
        while more := {s for s, o in owns if o in found} - found:
            found |= more
        return found

    def same(self, other: Model) -> bool:
        return not self.marks(other) and self.goals == other.goals


@cache
def ontology() -> Ontology:
    with tempfile.TemporaryDirectory() as folder:
        counted = Path(folder) / "counted.ttl"
        counted.write_text(COUNTED)
        return Ontology.load((ontology_paths()[0] / "core.ttl", TINY_ONTOLOGY, counted))


# ---------------------------------------------------------------- random writes

AUTHORS = ("ann", "bob")
NO_RELATIONS = ("sk:placement", "sk:structure", "tiny:fitsIn", "rdfs:subClassOf", "sk:onn")
NO_ONE = ("nobody_1", "kitting:Kit", "sk:on", "", "learned:nothing_1", "x" * 3000)


FURNITURE: list[tuple[Any, ...]] = [
    ("add", "sk:Floor", "floor", {}, False),
    *(("add", class_, None, {}, False) for class_ in ("tiny:Box", "tiny:Box", "t:Tray", "tiny:Slot", "tiny:Slot")),
    *(("add", class_, None, {}, False) for class_ in ("t:Cart", "t:Cart", "sk:Gripper", *4 * ["tiny:Ball"])),
    *(("add", class_, None, {}, True) for class_ in ("tiny:Box", "tiny:Ball")),
    *(("place", name, "sk:on", "floor") for name in ("box_1", "tray_1", "cart_1", "cart_2", "ball_1")),
    ("place", "box_2", "sk:in", "box_1"),
    ("place", "ball_2", "sk:in", "slot_1"),
    ("place", "ball_3", "tiny:carries", "cart_1"),
    ("place", "learned:ball_1", "sk:in", "learned:box_1"),
    ("relate", "tray_1", "sk:hasA", "slot_1"),
    ("relate", "tray_1", "sk:hasA", "slot_2"),
    ("relate", "cart_1", "sk:hasA", "gripper_1"),
    ("place", "ball_4", "sk:heldBy", "gripper_1"),
    ("relate", "cart_1", "t:owns", "slot_1"),
    ("relate", "slot_1", "sk:poseFrame", "tray_1"),
    ("relate", "ball_2", "sk:poseFrame", "box_2"),
    *(("set", name, POSE, VALUES[POSE][0][0]) for name in ("slot_1", "ball_2")),
    ("goals", ("a", "b")),
]


class WorldMachine(RuleBasedStateMachine):
    """Does the same to a world and to the model."""

    @initialize()
    def begin(self) -> None:
        self.now = 0.0
        self.world = World(ontology(), clock=lambda: self.now)
        self.world.locks = Locks(lambda: self.now)
        self.model = Model()
        self.locked: dict[str, tuple[str, float]] = {}
        self.stamps: dict[str, tuple[int, float]] = {}
        self.history: list[tuple[Change, Model, Model]] = []
        self.gone: set[str] = set()
        self.told: list[Change] = []
        self.again = self.world.snapshot().copy()
        self.old = self.world.snapshot(), self.model
        self.world.subscribe(self.told.append)
        self._write("ann", Writer.SYSTEM, FURNITURE, None)
        self._write("ann", Writer.PERSON, [("place", "ball_1", "sk:in", "box_1")], None)

    # -------------------------------------------------------- rules

    @rule(data=st.data(), author=st.sampled_from(AUTHORS), writer=st.sampled_from(Writer))
    def write(self, data: st.DataObject, author: str, writer: Writer) -> None:
        """Does a few things in one transaction, that may have been written by somebody who looked long ago."""
        steps = [self._step(data, "right") for _ in range(data.draw(st.integers(1, 3)))]
        if any(step[0] == "add" and step[2] is None and not step[4] for step in steps):
            steps.append(("place", "NEW", "sk:on", "floor"))
        expects = data.draw(st.sampled_from([None, None, "right", "wrong", "gone"]))
        self._write(author, writer, steps, self._expected(data, expects))

    @rule(data=st.data(), author=st.sampled_from(AUTHORS))
    def edit(self, data: st.DataObject, author: str) -> None:
        """A person does one thing, which can be undone."""
        self._write(author, Writer.PERSON, [self._step(data, "right")], None)

    @rule(data=st.data(), what=st.sampled_from(["add", "relate", "unrelate", "remove", "goals"]))
    def go_wrong(self, data: st.DataObject, what: str) -> None:
        """Names that are likely wrong, and nothing else, so that nothing else can be the reason."""
        self._write("pick", Writer.SKILL, [self._step(data, "wrong", what)], None)

    @rule(data=st.data(), wrong=st.sampled_from([(name, value) for name, values in BAD.items() for value in values]))
    def set_wrongly(self, data: st.DataObject, wrong: tuple[str, Any]) -> None:
        """A value that the property cannot have, of something that could bear it."""
        bearers = [n for n in self._names() if is_a(self.model.types[n], BEARERS[wrong[0]])]
        self._write("pick", Writer.SKILL, [("set", data.draw(st.sampled_from(bearers or ["floor"])), *wrong)], None)

    @rule(data=st.data(), property_=st.sampled_from(sorted(BEARERS)))
    def set_on_any(self, data: st.DataObject, property_: str) -> None:
        """A value that the property can have, of something that may not bear it, or is not there."""
        name = data.draw(st.sampled_from([*self._names(), *sorted(self.gone), *NO_ONE]))
        self._write("pick", Writer.SKILL, [("set", name, property_, VALUES[property_][0][0])], None)

    @rule(data=st.data(), relation=st.sampled_from([*PLACEMENTS, *OTHERS]))
    def relate_any(self, data: st.DataObject, relation: str) -> None:
        """Two things that are there, of whatever class."""
        names = st.sampled_from([*self._names(), "NEW"])
        self._write("pick", Writer.SKILL, [("relate", data.draw(names), relation, data.draw(names))], None)

    @rule(
        data=st.data(),
        relation=st.sampled_from([*OTHERS, "tiny:carries", "sk:heldBy"]),
        author=st.sampled_from(AUTHORS),
    )
    def relate_well(self, data: st.DataObject, relation: str, author: str) -> None:
        """Two things of the right classes; numbers, cycles and locks may still forbid it."""
        self._write(author, Writer.PERSON, [("relate", *self._ends(data.draw, relation))], None)

    @rule(data=st.data(), class_=st.sampled_from(["t:Weight", "t:Weight", *CLASSES]), mass=st.booleans())
    def add_one(self, data: st.DataObject, class_: str, mass: bool) -> None:
        """Something new, on the floor; it may have to have a mass."""
        values = {MASS: VALUES[MASS][0][0]} if mass else {}
        steps = [("add", class_, None, values, False), ("place", "NEW", "sk:on", "floor")]
        self._write("ann", Writer.PERSON, steps[: data.draw(st.sampled_from([2, 2, 1]))], None)

    @rule(data=st.data(), deep=st.booleans())
    def put_a_place_into_what_is_there(self, data: st.DataObject, deep: bool) -> None:
        """Or into what is in what is there."""
        inside = [(name, at.place) for name in self._names() if (at := self.model.place_of(name)) is not None]
        if deep:
            inside = [(name, above) for name, place in inside for lower, above in inside if lower == place]
        fitting = [(place, "sk:in", name) for name, place in inside if self.model.fits(place, "sk:in", name)]
        if fitting:
            self._write("ann", Writer.PERSON, [("place", *data.draw(st.sampled_from(sorted(fitting))))], None)

    @rule(data=st.data(), writer=st.sampled_from(Writer))
    def remove_one(self, data: st.DataObject, writer: Writer) -> None:
        """Something, with its pieces; what was in it moves out, and poses in its frame are lost."""
        self._write("bob", writer, [self._step(data, "right", "remove")], None)

    @rule(data=st.data(), author=st.sampled_from(AUTHORS), writer=st.sampled_from(Writer))
    def touch_what_is_locked(self, data: st.DataObject, author: str, writer: Writer) -> None:
        """It, a piece of it, or what holds a piece of it."""
        locked = {name for name in self.locked if self._locker(name) and name in self.model.types}
        names = sorted({piece for name in locked for piece in self.model.pieces(name)})
        if names:
            self._write(
                author, writer, [("set", data.draw(st.sampled_from(names)), FLAG, data.draw(st.booleans()))], None
            )

    @rule(author=st.sampled_from(AUTHORS))
    def undo_last(self, author: str) -> None:
        before, model = self.world.snapshot(), copy.deepcopy(self.model)
        undone = {change.undoes for change, _, _ in self.history}
        mine = [h for h in self.history if h[0].writer is Writer.PERSON and h[0].undoes is None]
        last = next((h for h in reversed(mine) if h[0].number not in undone), None)
        try:
            if last is None or self._is_built_on(last, undone):
                raise Refused
            self._take_back(model, last[2], last[1])
            self._check_locks(author, Writer.PERSON, model)
        except Refused:
            with pytest.raises(WorldError):
                undo(self.world, author)
            assert self.world.snapshot() is before
            return
        change = undo(self.world, author)
        assert (change.undoes, change.writer, change.author) == (last[0].number, Writer.PERSON, author)
        self._take_over(model)

    @rule(data=st.data(), owner=st.sampled_from(AUTHORS), seconds=st.sampled_from([1.0, 5.0]))
    def lock(self, data: st.DataObject, owner: str, seconds: float) -> None:
        names = data.draw(st.sets(st.sampled_from(sorted(self.model.types)), min_size=1, max_size=3))
        if any(self._locker(name) not in (None, owner) for name in names):
            with pytest.raises(Locked):
                self.world.locks.acquire(names, owner, seconds)
        else:
            self.world.locks.acquire(names, owner, seconds)
            self.locked.update((name, (owner, self.now + seconds)) for name in names)

    @rule(owner=st.sampled_from(AUTHORS))
    def unlock(self, owner: str) -> None:
        self.world.locks.release(owner)
        self.locked = {name: lock for name, lock in self.locked.items() if lock[0] != owner}

    @rule(seconds=st.sampled_from([0.5, 1.0, 5.0]))
    def wait(self, seconds: float) -> None:
        self.now += seconds

    @rule()
    def look_at_an_old_snapshot(self) -> None:
        self._compare(*self.old)
        self.old = self.world.snapshot(), copy.deepcopy(self.model)

    def teardown(self) -> None:
        if hasattr(self, "old"):
            self._compare(*self.old)

    # -------------------------------------------------------- both do the same

    def _step(self, data: st.DataObject, how: str, what: str | None = None) -> tuple[Any, ...]:
        """Draws one thing to do: likely right, or with a name, class, relation or value that likely is not."""
        done = what or data.draw(st.sampled_from(["relate", "place", "set", "unrelate", "add", "remove", "goals"]))
        return tuple(getattr(self, f"_{how}_{done}")(data.draw))

    def _names(self) -> list[str]:
        return sorted(self.model.types)

    def _right_add(self, draw: Any) -> Iterator[Any]:
        class_ = draw(st.sampled_from(CLASSES))
        mass = {MASS: VALUES[MASS][0][0]} if class_ == "t:Weight" else {}
        given = draw(st.none() | st.sampled_from(["box_9", "learned:box_8", "ball_7"]))
        yield from ("add", class_, given, mass, draw(st.booleans()) if given is None else False)

    def _wrong_add(self, draw: Any) -> Iterator[Any]:
        class_ = draw(st.sampled_from([*CLASSES, "sk:Scene", "owl:Class", "sk:Bal"]))
        yield from ("add", class_, draw(st.sampled_from([*self._names(), *sorted(self.gone)])), {}, False)

    def _ends(self, draw: Any, relation: str) -> tuple[str, str, str]:
        names = self._names()
        pairs = [(s, o) for s in names for o in names if s != o and self.model.fits(s, relation, o)]
        s, o = draw(st.sampled_from(pairs)) if pairs else ("floor", "floor")
        return s, relation, o

    def _right_place(self, draw: Any) -> Iterator[str]:
        s, relation, o = self._ends(draw, draw(st.sampled_from(sorted(PLACEMENTS))))
        yield from ("place", s, relation, o) if PLACEMENTS[relation][2] else ("place", o, relation, s)

    def _right_relate(self, draw: Any) -> Iterator[str]:
        yield from ("relate", *self._ends(draw, draw(st.sampled_from(sorted(OTHERS)))))

    def _wrong_relate(self, draw: Any) -> Iterator[str]:
        name = st.sampled_from([*self._names(), *sorted(self.gone), *NO_ONE, "NEW"])
        relation = draw(st.sampled_from([*PLACEMENTS, *OTHERS, *NO_RELATIONS]))
        yield from (draw(st.sampled_from(["relate", "unrelate", "place"])), draw(name), relation, draw(name))

    def _right_unrelate(self, draw: Any) -> Iterator[str]:
        may_go = sorted(f for f in self.model.facts if f[1] in OTHERS or learned(f[0]))
        s, r, o = draw(st.sampled_from(may_go)) if may_go else ("floor", "sk:hasA", "floor")
        yield from ("unrelate", s, r, o)

    def _wrong_unrelate(self, draw: Any) -> Iterator[str]:
        may_stay = sorted(f for f in self.model.facts if f[1] in PLACEMENTS and not learned(f[0]))
        yield from ("unrelate", *(draw(st.sampled_from(may_stay)) if may_stay else ("floor", "sk:in", "floor")))

    def _right_set(self, draw: Any) -> Iterator[Any]:
        property_ = draw(st.sampled_from(sorted(VALUES)))
        names = [n for n, class_ in sorted(self.model.types.items()) if is_a(class_, BEARERS[property_])]
        none = [None] if property_ != "rdfs:label" else []
        value = draw(st.sampled_from([*(written for written, _ in VALUES[property_]), *none]))
        yield from ("set", draw(st.sampled_from(names or ["floor"])), property_, value)

    def _right_remove(self, draw: Any) -> Iterator[str]:
        yield from ("remove", draw(st.sampled_from([n for n in self._names() if n != "floor"] or ["nobody_1"])))

    def _wrong_remove(self, draw: Any) -> Iterator[str]:
        yield from ("remove", draw(st.sampled_from([*sorted(self.gone), *NO_ONE, "NEW"])))

    def _right_goals(self, draw: Any) -> Iterator[Any]:
        yield from ("goals", draw(st.sampled_from([(), ("a",), ("b", "a", "a")])))

    def _wrong_goals(self, draw: Any) -> Iterator[Any]:
        yield from ("goals", draw(st.sampled_from([(" ",), (5,)])))

    def _write(self, author: str, writer: Writer, steps: list[tuple[Any, ...]], expects: dict[str, int] | None) -> None:
        model = copy.deepcopy(self.model)
        before, version, number = self.world.snapshot(), self.world.version, len(self.told)
        fault = self._predict(author, writer, model, steps, expects or {})
        refused = None
        try:
            with self.world.transaction(author, "random", writer=writer, expects=expects) as tx:
                self._do(tx, steps)
        except WorldError as error:
            refused = error
        if fault is None:
            assert refused is None, "refused for no reason"
            self._take_over(model)
        else:
            assert isinstance(refused, fault), "should have been refused"
            assert len(str(refused)) < 20_000
            assert (self.world.snapshot(), self.world.version, len(self.told)) == (before, version, number)

    def _predict(
        self, author: str, writer: Writer, model: Model, steps: list[tuple[Any, ...]], expects: dict[str, int]
    ) -> type[Exception] | None:
        for name, version in expects.items():
            if version != (self.world.version if name == "" else self.stamps.get(name, (-1, 0.0))[0]):
                return StaleVersion
        try:
            new = "NEW"
            for what, *arguments in steps:
                names = [new if isinstance(a, str) and a == "NEW" else a for a in arguments]
                if what == "add":
                    new = model.add(names[0], names[1], names[2], is_learned=names[3])
                elif what == "goals":
                    if not all(isinstance(goal, str) and goal.strip() for goal in names[0]):
                        raise Refused
                    model.goals = tuple(sorted(set(names[0])))
                else:
                    getattr(model, what)(*names)
            model.check()
        except Refused:
            return WorldError
        try:
            self._check_locks(author, writer, model)
        except Refused:
            return Locked
        return None

    @staticmethod
    def _do(tx: Transaction, steps: list[tuple[Any, ...]]) -> None:
        new = "NEW"
        for what, *arguments in steps:
            names = [new if isinstance(a, str) and a == "NEW" else a for a in arguments]
            if what == "add":
                new = tx.add(names[0], None, names[1], names[2], learned=names[3])
            else:
                getattr(tx, {"goals": "set_goals"}.get(what, what))(*names)

    def _take_over(self, model: Model) -> None:
        """The world did it: the model is what is now, and there is a change if anything changed."""
        before, self.model = self.model, model
        model.used = before.used | model.types.keys()  # what came and went in one transaction was never seen
        self.gone = model.used - model.types.keys()
        if model.same(before):
            assert len(self.told) == self.world.version == len(self.history)
            return
        change = self.world.changes[-1]
        assert change.number == len(self.history) + 1
        assert change.marks() == model.marks(before)
        self.history.append((change, before, copy.deepcopy(model)))
        for name in model.marks(before):
            self.stamps[name] = (change.number, self.now)
        self.stamps = {name: stamp for name, stamp in self.stamps.items() if name in model.types}
        for edit in change.edits:
            self.again.apply(edit)

    def _expected(self, data: st.DataObject, which: str | None) -> dict[str, int] | None:
        if which is None:
            return None
        if which == "gone":
            return {data.draw(st.sampled_from(sorted(self.gone))): 1} if self.gone else {"": self.world.version}
        name = data.draw(st.sampled_from(["", *sorted(self.stamps)]))
        now = self.world.version if name == "" else self.stamps[name][0]
        return {name: now if which == "right" else now - 1}

    # -------------------------------------------------------- locks and undo, plainly

    def _locker(self, name: str) -> str | None:
        owner, until = self.locked.get(name, ("", -1.0))
        return owner if until > self.now else None

    def _check_locks(self, author: str, writer: Writer, model: Model) -> None:
        kept_out = any(self._locker(name) not in (None, author) for name in model.concerns(self.model))
        if kept_out and writer in (Writer.PERSON, Writer.JOB):
            raise Refused

    def _is_built_on(self, last: tuple[Change, Model, Model], undone: set[int | None]) -> bool:
        def about(entry: tuple[Change, Model, Model]) -> set[str]:
            goals = {"the goals"} if entry[1].goals != entry[2].goals else set()
            return entry[2].marks(entry[1]) | goals

        later = [h for h in self.history if h[0].number > last[0].number]
        standing = [h for h in later if h[0].undoes is None and h[0].number not in undone]
        return any(about(entry) & about(last) for entry in standing)

    def _take_back(self, model: Model, after: Model, before: Model) -> None:
        model.facts = (model.facts - (after.facts - before.facts)) | (before.facts - after.facts)
        for name in after.marks(before):
            model.types.pop(name, None)
            model.values = {key: value for key, value in model.values.items() if key[0] != name}
            if name in before.types:
                model.types[name] = before.types[name]
                model.values.update((key, value) for key, value in before.values.items() if key[0] == name)
        if after.goals != before.goals:
            model.goals = before.goals
        model.check()

    # -------------------------------------------------------- after each step

    @invariant()
    def every_reading_method_says_what_the_model_says(self) -> None:
        self._compare(self.world.snapshot(), self.model)
        for name in self.model.types:
            assert (self.world.stamp(name).change, self.world.stamp(name).time) == self.stamps[name]
        assert self.world.goals == self.model.goals

    @invariant()
    def changes_done_again_lead_to_the_same_state(self) -> None:
        now = self.world.snapshot()
        assert list(self.again.statements()) == list(now.statements())
        assert {name: self.again.element(name) for name in self.again.ids()} == {n: now.element(n) for n in now.ids()}
        assert self.again.goals == now.goals

    @invariant()
    def subscribers_were_told_every_change_in_order(self) -> None:
        assert self.told == list(self.world.changes) == [change for change, _, _ in self.history]
        assert self.world.version == len(self.told)

    @invariant()
    def locks_are_those_that_run(self) -> None:
        running = sorted(name for name in self.locked if self._locker(name))
        assert [(lock.element, lock.owner) for lock in self.world.locks.held()] == [
            (name, self._locker(name)) for name in running
        ]

    @staticmethod
    def _compare(view: Index, model: Model) -> None:
        assert set(view.ids()) == set(model.types)
        assert set(view.statements()) == model.facts
        for class_ in ("sk:Element", "sk:Container", *CLASSES):
            of_class = sorted(n for n, type_ in model.types.items() if is_a(type_, class_))
            assert view.instances(class_) == tuple(n for n in of_class if not learned(n))
            assert view.abstracts(class_) == tuple(n for n in of_class if learned(n))
        places = {name: model.place_of(name) for name in model.types}
        for class_, relation in product(("sk:Element", "sk:Container", *CLASSES), PLACEMENTS):
            placed = [at for n, at in places.items() if is_a(model.types[n], class_) and not learned(n)]
            assert view.any_placed(class_, relation) is any(at and at.relation == relation for at in placed)
        values: dict[str, dict[str, Any]] = {name: {} for name in model.types}
        for (name, property_), value in model.values.items():
            values[name][property_] = value
        for name, class_ in model.types.items():
            element, own = view.element(name), values[name]
            assert {"rdfs:label": element.label, **element.properties} == own
            assert repr(sorted(element.properties.items())) == repr(sorted((k, own[k]) for k in element.properties))
            assert (element.id, element.type, view.has(name)) == (name, class_, True)
            at, owners = places[name], model.owners(name)
            guests = tuple(
                sorted(guest for guest, place in places.items() if place is not None and place.place == name)
            )
            assert view.placement(name) == at
            assert view.contents(name) == guests == children(view, name, "sk:placement")
            assert view.owners(name) == tuple(owners)
            assert parent(view, name) == (at.place if at else owners[0] if owners else None)
            assert view.value(name, MASS) == own.get(MASS)
        for relation in (*PLACEMENTS, *OTHERS, *NARROWER):
            narrower = set(below(relation))
            held = {(s, o) for s, r, o in model.facts if r in narrower}
            ends: dict[str, tuple[set[str], set[str]]] = {name: (set(), set()) for name in model.types}
            for s, o in held:
                ends[s][1].add(o)
                ends[o][0].add(s)
            for name in model.types:
                subjects = tuple(sorted(ends[name][0]))
                assert view.objects(name, relation) == tuple(sorted(ends[name][1]))
                assert view.subjects(relation, name) == subjects
                if subjects:
                    bare = tuple(s for s in subjects if not learned(s))
                    assert resolve(view, relations={relation: name}) == bare
            assert all(view.related(s, relation, o) for s, o in held)
            assert not any(view.related(o, relation, s) for s, o in held if (o, s) not in held)


WorldMachine.TestCase.settings = settings(
    max_examples=120, stateful_step_count=30, deadline=None, suppress_health_check=list(HealthCheck)
)


@pytest.mark.filterwarnings("error")
class TestRandomWrites(WorldMachine.TestCase):
    pass
