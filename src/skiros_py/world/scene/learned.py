"""What robots were taught, as a file that looks like a scene's."""

from __future__ import annotations

from pathlib import Path

from skiros_py.world.change import Edit
from skiros_py.world.element import is_learned
from skiros_py.world.index import Index
from skiros_py.world.names import LEARNED, LEARNED_GRAPH
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import read_document
from skiros_py.world.scene.files import fill
from skiros_py.world.scene.reader import Reader
from skiros_py.world.scene.writer import TurtleWriter
from skiros_py.world.vocabulary import ELEMENT
from skiros_py.world.world import World

__all__ = ["learned_turtle", "read_learned"]


def learned_turtle(view: Index) -> str:
    """Returns what was learned, of a state, as the text of a Turtle file; equal states give equal texts."""
    writer = TurtleWriter(view)
    learned = [name for name in view.abstracts(ELEMENT) if is_learned(name)]
    return writer.file(LEARNED_GRAPH, writer.elements(learned))


def read_learned(ontology: Ontology, path: Path) -> list[Edit]:
    """Returns the edits that bring what a file says was learned into a world that has learned nothing yet.

    Raises:
        FileError: The file is missing, in no language that is read, or says what the ontology does not allow; with the
            line where known.
    """
    reader = Reader(ontology, LEARNED)
    reader.take(read_document(path), whole=True)
    world = World(ontology)
    fill(world, reader, "learned", f"read from {path.name}")
    return [edit for change in world.changes for edit in change.edits]
