"""Axioms: groups of statements that a reasoner treats as one, each with its anonymous nodes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import pyoxigraph as ox

from skiros_py.errors import FileError
from skiros_py.world.ontology.check.material import ANNOTATIONS, HEADER, Material
from skiros_py.world.ontology.statements import Node, Statement, is_standard
from skiros_py.world.terms import DECLARES, Kind, reached

_ONLY_DECLARE = frozenset({"owl:Class", "owl:ObjectProperty", "owl:DatatypeProperty", "owl:NamedIndividual"}) | {
    type_ for type_, kind in DECLARES.items() if kind in (Kind.ANNOTATION, Kind.DATATYPE)
}


@dataclass(frozen=True, slots=True)
class Axiom:
    """One axiom of a file.

    Attributes:
        head: The statement that starts it.
        body: The statements about its anonymous nodes: lists, restrictions, class expressions.
        is_assertion: True when it is about individuals, False when about classes, relations and properties.
    """

    head: Statement
    body: tuple[Statement, ...]
    is_assertion: bool

    def names(self) -> frozenset[str]:
        """Returns the names of all terms and individuals in it."""
        names = {name for s in (self.head, *self.body) for name in (s.subject, s.predicate, s.object)}
        return frozenset(name for name in names if name is not None and not is_standard(name))


@dataclass(frozen=True, slots=True)
class Axioms:
    """The input of a reasoner.

    Attributes:
        declarations: Declarations of classes, relations, properties and data types; always included.
        said: All other axioms, in file order.
    """

    declarations: tuple[ox.Triple, ...]
    said: tuple[Axiom, ...]


def axioms_of(material: Material) -> Axioms:
    """Groups the statements of all files into axioms, without labels, comments and class-level values.

    Class-level values are defaults that subclasses may override, which OWL does not support.
    """
    logical = [statement for statement in material.all if _is_logical(material, statement)]
    declarations = dict.fromkeys(statement.triple for statement in logical if _declares(statement))
    return Axioms(tuple(declarations), tuple(_grouped(material, [s for s in logical if not _declares(s)])))


def triples_of(axioms: Iterable[Axiom]) -> list[ox.Triple]:
    """Returns the triples of several axioms."""
    return [statement.triple for axiom in axioms for statement in (axiom.head, *axiom.body)]


def _grouped(material: Material, statements: list[Statement]) -> Iterator[Axiom]:
    referred = {statement.triple.object for statement in statements}
    described: set[Node] = set()
    for statement in statements:
        subject = statement.triple.subject
        if statement.subject is not None:
            yield Axiom(statement, _body(material, statement.triple.object), _asserts(statement))
        elif subject not in referred and subject not in described:  # disjointness of many, a negative assertion
            described.add(subject)
            own = _hanging(material, subject)
            head = next((s for s in own if s.predicate == "rdf:type"), own[0])
            rest = [s for s in own if s is not head]
            yield Axiom(head, (*rest, *(t for s in rest for t in _body(material, s.triple.object))), _asserts(head))


def _body(material: Material, node: Node) -> tuple[Statement, ...]:
    nodes = reached([node], lambda node: (statement.triple.object for statement in _hanging(material, node)))
    return tuple(statement for node in nodes for statement in _hanging(material, node))


def _hanging(material: Material, node: Node) -> list[Statement]:
    """The logical statements about an anonymous node, which no other file shares."""
    about = material.about(material.key(node)).values() if isinstance(node, ox.BlankNode) else ()
    return [statement for group in about for statement in group if _is_logical(material, statement)]


def _is_logical(material: Material, statement: Statement) -> bool:
    word, subject = statement.predicate, statement.subject
    if word in ANNOTATIONS or word in HEADER or statement.object == "owl:Ontology":
        return False
    if word in material.declared[Kind.ANNOTATION] or not (is_standard(word) or material.kinds(word)):
        return False
    return is_standard(word) or subject is None or not material.kinds(subject)


def _declares(statement: Statement) -> bool:
    return statement.predicate == "rdf:type" and statement.object in _ONLY_DECLARE and statement.subject is not None


def _asserts(head: Statement) -> bool:
    word = head.predicate
    if word == "rdf:type" and head.object is not None:
        return not is_standard(head.object) or head.object in _ABOUT_INDIVIDUALS
    return word == "rdf:type" or not is_standard(word) or word in _ABOUT_INDIVIDUALS


_ABOUT_INDIVIDUALS = frozenset(
    f"owl:{word}"
    for word in ("sameAs", "differentFrom", "AllDifferent", "NegativePropertyAssertion", "Thing", "Nothing")
)


# ---------------------------------------------------------------- axioms as sentences


_SENTENCES: Mapping[str, str] = {
    "rdfs:subClassOf": "every {s} is {o}",
    "owl:equivalentClass": "{s} means the same as {o}",
    "owl:disjointWith": "nothing is both {s} and {o}",
    "owl:complementOf": "{s} is all that is not {o}",
    "owl:disjointUnionOf": "{s} is exactly one of {o}",
    "owl:unionOf": "{s} is any of {o}",
    "owl:intersectionOf": "{s} is all of {o} at once",
    "owl:oneOf": "{s} is one of {o}",
    "owl:hasKey": "{s} is identified by {o}",
    "rdfs:domain": "whatever has {s} is {o}",
    "rdfs:range": "whatever {s} leads to is {o}",
    "rdfs:subPropertyOf": "{s} implies {o}",
    "owl:equivalentProperty": "{s} means the same as {o}",
    "owl:inverseOf": "{s} is {o} read backwards",
    "owl:propertyDisjointWith": "{s} and {o} never hold between the same two",
    "owl:propertyChainAxiom": "{o} one after the other imply {s}",
    "owl:sameAs": "{s} is the same thing as {o}",
    "owl:differentFrom": "{s} is another thing than {o}",
    "rdf:type": "{s} is {o}",
}
_TYPES: Mapping[str, str] = {
    "owl:FunctionalProperty": "{s} leads to one thing at most",
    "owl:InverseFunctionalProperty": "one thing at most has {s} to the same",
    "owl:TransitiveProperty": "{s} is transitive",
    "owl:SymmetricProperty": "{s} holds both ways",
    "owl:AsymmetricProperty": "{s} never holds both ways",
    "owl:ReflexiveProperty": "everything has {s} to itself",
    "owl:IrreflexiveProperty": "nothing has {s} to itself",
}
_MANY: Mapping[str, str] = {
    "owl:AllDisjointClasses": "nothing is two of {o}",
    "owl:AllDisjointProperties": "no two of {o} hold between the same two",
    "owl:AllDifferent": "{o} are all different things",
}
_RESTRICTIONS: Mapping[str, str] = {
    "owl:someValuesFrom": "some {o}",
    "owl:allValuesFrom": "nothing but {o}",
    "owl:hasSelf": "itself",
    **{f"owl:{w}": "at least {o}" for w in ("minCardinality", "minQualifiedCardinality")},
    **{f"owl:{w}": "at most {o}" for w in ("maxCardinality", "maxQualifiedCardinality")},
    **{f"owl:{w}": "exactly {o}" for w in ("cardinality", "qualifiedCardinality")},
}
_JOINED: Mapping[str, str] = {"owl:unionOf": " or ", "owl:intersectionOf": " and ", "owl:oneOf": " or "}
_DEEP = 6
"""Maximum depth of class expressions that are written out."""


def in_words(axiom: Axiom, material: Material) -> str:
    """Returns an axiom as a sentence, with its location: "every kitting:Kit is sk:Container (kitting.ttl:51)"."""
    fault = place_of(axiom, material)
    where = f"{fault.path}:{fault.line}" if fault.line else f"{fault.path}"
    return f"{_Words(material).sentence(axiom.head)} ({where})"


def place_of(axiom: Axiom, material: Material) -> FileError:
    """Returns a fault at the place of an axiom."""
    return material.fault_in(axiom.head, "", axiom.head.object)


class _Words:
    def __init__(self, material: Material) -> None:
        self._material = material

    def sentence(self, head: Statement) -> str:
        subject, word, object_ = head.triple.subject, head.predicate, head.triple.object
        type_ = (head.object or "") if word == "rdf:type" else ""
        if type_ in _MANY:
            about = self._about(subject)
            return _MANY[type_].format(o=self._list(about.get("owl:members") or about["owl:distinctMembers"], ", "))
        if type_ == "owl:NegativePropertyAssertion":
            return self._negative(self._about(subject))
        pattern = _TYPES.get(type_) or _SENTENCES.get(word, "{s} " + word + " {o}")
        return pattern.format(s=self._node(subject), o=self._node(object_))

    def _about(self, node: Node) -> Mapping[str, Node]:
        about = self._material.about(self._material.key(node))
        return {predicate: statements[0].triple.object for predicate, statements in about.items()}

    def _negative(self, about: Mapping[str, Node]) -> str:
        target = about.get("owl:targetIndividual", about.get("owl:targetValue"))
        said = (about.get("owl:sourceIndividual"), about.get("owl:assertionProperty"), target)
        return f"it is not true that {' '.join(map(self._node, said))}"

    def _node(self, node: Node | None, depth: int = 0) -> str:
        if isinstance(node, ox.NamedNode):
            return self._material.key(node)
        if isinstance(node, ox.Literal):
            return node.value if len(node.value) <= 40 else f"{node.value[:40]}…"
        if depth > _DEEP:
            return "…"
        return "something unnamed" if node is None else self._expression(self._about(node), node, depth + 1)

    def _expression(self, about: Mapping[str, Node], node: Node, depth: int) -> str:
        if "rdf:first" in about:
            return self._list(node, ", ", depth)
        for word, joint in _JOINED.items():
            if word in about:
                return f"({self._list(about[word], joint, depth)})"
        if "owl:complementOf" in about:
            return f"not {self._node(about['owl:complementOf'], depth)}"
        if "owl:inverseOf" in about:
            return f"{self._node(about['owl:inverseOf'], depth)} read backwards"
        return self._restriction(about, depth)

    def _restriction(self, about: Mapping[str, Node], depth: int) -> str:
        property_ = self._node(about.get("owl:onProperty"), depth)
        if "owl:hasValue" in about:
            return f"something with {property_} {self._node(about['owl:hasValue'], depth)}"
        for word, pattern in _RESTRICTIONS.items():
            if word in about:
                of = about.get("owl:onClass", about.get("owl:onDataRange"))
                what = f" {self._node(of, depth)}" if of is not None else ""
                return f"something with {property_} to {pattern.format(o=self._node(about[word], depth))}{what}"
        return "something unnamed"

    def _list(self, node: Node, joint: str, depth: int = 0) -> str:
        return joint.join(self._node(member, depth) for member in self._material.members(node))
