"""Turns the text of a file into triples: Turtle, RDF/XML and OWL/XML."""

from __future__ import annotations

import re
from pathlib import Path

import pyoxigraph as ox

from skiros_py.errors import FileError
from skiros_py.world.datatype import LONGEST_TEXT
from skiros_py.world.ontology.guards import XmlOutline
from skiros_py.world.ontology.owlxml import parse_owl_xml

__all__ = ["parse_turtle", "parse_xml"]

_RDF_XML = "http://www.w3.org/1999/02/22-rdf-syntax-ns#RDF"
_OWL_XML = "http://www.w3.org/2002/07/owl#Ontology"
_ENCODING = re.compile(r"""(<\?xml[^>]*?)\s+encoding\s*=\s*(?:"[^"]*"|'[^']*')""")
_TOO_LONG = f"a text or a name is too long to be read: a text may have {LONGEST_TEXT} characters"
_SINGLE_QUOTED = re.compile(r"(<!ENTITY\s+[^\s'\"]+\s+)'([^'\"]*)'")


def parse_turtle(path: Path, text: str, base: str) -> tuple[dict[str, str], tuple[ox.Triple, ...]]:
    """Returns the prefixes and the statements of a Turtle text.

    Raises:
        FileError: It is none; with the line.
    """
    # Anonymous nodes of two files must not meet under one name.
    parser = ox.parse(text, format=ox.RdfFormat.TURTLE, base_iri=base, rename_blank_nodes=True)
    try:
        triples = tuple([quad.triple for quad in parser])
    except SyntaxError as error:
        reason = re.sub(r"^Parser error at line \d+.*?: ", "", error.msg)
        raise FileError(path, f"not Turtle at column {error.offset}: {reason[:300]}", line=error.lineno) from None
    except MemoryError:
        raise FileError(path, _TOO_LONG) from None
    return dict(parser.prefixes), triples


def parse_xml(path: Path, text: str, base: str, outline: XmlOutline) -> tuple[ox.Triple, ...]:
    """Returns the statements of an RDF/XML or OWL/XML text, whose outline was read before.

    Raises:
        FileError: It is neither, or not well formed; with the line where it is known.
    """
    if outline.root == _OWL_XML:
        return parse_owl_xml(path, text)
    if outline.root != _RDF_XML:
        raise FileError(path, f"is neither RDF/XML nor OWL/XML: its outermost element is <{outline.root}>")
    parser = ox.parse(_readable(text, outline), format=ox.RdfFormat.RDF_XML, base_iri=base, rename_blank_nodes=True)
    try:
        return tuple([quad.triple for quad in parser])
    except SyntaxError as error:
        raise FileError(path, f"not RDF/XML: {error.msg[:300]}") from None
    except MemoryError:
        raise FileError(path, _TOO_LONG) from None


def _readable(text: str, outline: XmlOutline) -> str:
    """The text without what the parser does not know: encodings other than UTF-8, entities in single quotes."""
    readable = _ENCODING.sub(r"\1", text, count=1) if text.startswith("<?xml") else text
    return _SINGLE_QUOTED.sub(r'\1"\2"', readable) if outline.entities else readable
