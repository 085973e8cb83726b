"""A world's present state as the text of a scene file."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pyoxigraph as ox

from skiros_py.errors import FileError
from skiros_py.world.names import SCENE, STANDARD_PREFIXES
from skiros_py.world.store.triples import Triples
from skiros_py.world.vocabulary import ELEMENT
from skiros_py.world.world import World

__all__ = ["scene_turtle", "write_atomically"]

_OWL, _RDF = STANDARD_PREFIXES["owl"], STANDARD_PREFIXES["rdf"]


def scene_turtle(world: World) -> str:
    """Returns the Turtle text, in an order that depends on the content alone."""
    used = {name: iri for name, iri in sorted(world.ontology.names.prefixes.items()) if name != "xsd"}
    text = ox.serialize(list(_triples(world)), format=ox.RdfFormat.TURTLE, prefixes=used)
    assert text is not None  # it is, where no output file is given
    lines = text.decode().splitlines()
    # The engine writes prefixes in any order, and individuals without a blank line between them.
    head = sorted(line for line in lines if line.startswith("@prefix"))
    body = [line if line.startswith("\t") else f"\n{line}" for line in lines if not line.startswith("@prefix")]
    return "\n".join([*head, *body]).replace("\t", "    ") + "\n"


def write_atomically(path: Path, text: str) -> None:
    """Writes a file so that it is there whole or as it was before.

    Raises:
        FileError: It cannot be written.
    """
    try:
        with tempfile.NamedTemporaryFile("w", encoding="utf-8", dir=path.parent, delete=False) as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        Path(file.name).replace(path)
    except OSError as error:
        raise FileError(path, f"cannot be written: {error}") from error


def _triples(world: World) -> Iterator[ox.Triple]:
    yield from _header(world)
    triples = Triples(world.ontology)
    yield from triples.goals(world.goals)
    index = world.snapshot()
    relations: dict[str, list[ox.Triple]] = {}
    for subject, relation, object_ in index.statements():
        relations.setdefault(subject, []).append(triples.relation(subject, relation, object_))
    for element_id in index.instances(ELEMENT):
        yield from triples.element(index.element(element_id))
        yield from relations.get(element_id, ())


def _header(world: World) -> Iterator[ox.Triple]:
    """The file as an ontology that imports those which declare terms; robots' individuals are in the scene already."""
    scene = ox.NamedNode(SCENE.removesuffix("#"))
    yield ox.Triple(scene, ox.NamedNode(_RDF + "type"), ox.NamedNode(_OWL + "Ontology"))
    for file in world.ontology.sources:
        if not any(isinstance(t.subject, ox.NamedNode) and t.subject.value.startswith(SCENE) for t in file.triples):
            yield ox.Triple(scene, ox.NamedNode(_OWL + "imports"), ox.NamedNode(file.iri))
