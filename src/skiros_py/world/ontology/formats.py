"""Turns the text of a file into triples, in all formats that are read; refuses files that were made to do harm."""

from __future__ import annotations

import io
import itertools
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

import pyoxigraph as ox

from skiros_py.errors import FileError, MissingExtra
from skiros_py.world.literals import LONGEST_TEXT

DEEPEST = 500
"""How deep elements, brackets and parentheses may be nested."""

LONGEST_ENTITY = 256
"""Characters that an XML entity may stand for: a namespace, not a text."""

_TURTLE_TOKEN = re.compile(
    r'"""(?:[^"\\]|\\.|"(?!""))*"""' + r"|'''(?:[^'\\]|\\.|'(?!''))*'''"
    r'|"(?:[^"\\\n]|\\.)*"' + r"|'(?:[^'\\\n]|\\.)*'|<[^<>\s]*>|#[^\n]*|\\.|([\[(])|[\])]",
    re.DOTALL,
)


@dataclass(slots=True)
class XmlOutline:
    """What an XML file says of itself.

    Attributes:
        root: Its outermost element, as namespace and name together.
        base: What its relative IRIs start with, or "" where it does not say.
        prefixes: IRI by prefix; the empty prefix is its default namespace.
        entities: Text by name of entity.
        uris: File by IRI, as a catalogue of ontologies says.
    """

    root: str = ""
    base: str = ""
    prefixes: dict[str, str] = field(default_factory=dict)
    entities: dict[str, str] = field(default_factory=dict)
    uris: dict[str, str] = field(default_factory=dict)


def check_turtle(path: Path, text: str) -> None:
    """Refuses a Turtle text that is nested too deep.

    Raises:
        FileError: It is; with the line.
    """
    if text.count("[") + text.count("(") <= DEEPEST:
        return
    depth = 0
    for match in _TURTLE_TOKEN.finditer(text):
        if match.group(1):
            depth += 1
        elif match.group() in ("]", ")"):
            depth -= 1
        if depth > DEEPEST:
            raise FileError(path, _too_deep("brackets"), line=text.count("\n", 0, match.start()) + 1)


def check_json(path: Path, text: str) -> None:
    """Refuses a JSON-LD text that is nested too deep, or whose context is elsewhere.

    Raises:
        FileError: It is or does, or is no JSON; with the line where known.
    """
    try:
        contexts = list(_contexts(json.loads(text)))
    except RecursionError:
        raise FileError(path, _too_deep("lists and objects")) from None
    except ValueError as error:
        reason = f"not JSON at column {getattr(error, 'colno', 1)}: {getattr(error, 'msg', error)}"
        raise FileError(path, reason, line=getattr(error, "lineno", None)) from None
    for context in contexts:
        reason = f"its context <{context[:200]}> is elsewhere, and nothing is fetched: write its content into the file"
        raise FileError(path, reason, line=text.count("\n", 0, max(text.find(context), 0)) + 1)


def _contexts(value: object) -> Iterator[str]:
    """Yields what the contexts in a JSON value refer to.

    Raises:
        RecursionError: It is nested too deep.
    """
    waiting = [(value, 1)]
    for part, depth in waiting:
        if depth > DEEPEST:
            raise RecursionError
        if isinstance(part, dict):
            said = part.get("@context", [])
            outside = [*(said if isinstance(said, list) else [said]), part.get("@import")]
            yield from (context for context in outside if isinstance(context, str))
        if isinstance(part, dict | list):
            waiting += [(one, depth + 1) for one in (part.values() if isinstance(part, dict) else part)]


def outline_xml(path: Path, text: str) -> XmlOutline:
    """Reads the outline of an XML text, and refuses one that refers to other files, hides a bomb or is nested too deep.

    Raises:
        FileError: It does, or is no XML; with the line.
    """
    scan = _XmlScan(path)
    try:
        scan.parser.Parse(text, True)
    except expat.ExpatError as error:
        reason = f"not XML at column {error.offset + 1}: {expat.errors.messages[error.code]}"
        raise FileError(path, reason, line=error.lineno) from None
    return scan.outline


class _XmlScan:
    """The handlers of one scan."""

    def __init__(self, path: Path) -> None:
        self.outline = XmlOutline()
        self._path = path
        self._depth = 0
        self.parser = expat.ParserCreate("UTF-8", namespace_separator="")
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.StartNamespaceDeclHandler = self._namespace
        self.parser.StartDoctypeDeclHandler = self._doctype
        self.parser.EntityDeclHandler = self._entity

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        if self._depth > DEEPEST:
            raise self._fault(_too_deep("elements"))
        if self._depth == 1:
            self.outline.root = name
            base = attributes.get("http://www.w3.org/XML/1998/namespacebase") or attributes.get("ontologyIRI")
            self.outline.base = (base or "").partition("#")[0]
        elif "name" in attributes and name == "http://www.w3.org/2002/07/owl#Prefix":
            self.outline.prefixes[attributes["name"]] = attributes.get("IRI", "")
        elif "name" in attributes and name == "urn:oasis:names:tc:entity:xmlns:xml:cataloguri":
            self.outline.uris.setdefault(attributes["name"], attributes.get("uri", ""))

    def _end(self, _name: str) -> None:
        self._depth -= 1

    def _namespace(self, prefix: str | None, iri: str | None) -> None:
        self.outline.prefixes.setdefault(prefix or "", iri or "")

    def _doctype(self, _name: str, system: str | None, public: str | None, _internal: int) -> None:
        if system or public:
            raise self._fault(f"its DOCTYPE refers to another file ({system or public}): leave that out")

    def _entity(self, name: str, is_parameter: int, value: str | None, *outside: str | None) -> None:
        if value is None:
            where = next((part for part in outside[1:] if part), "somewhere")
            raise self._fault(f"entity '{name}' refers to another file ({where}): write its text here")
        if is_parameter or len(value) > LONGEST_ENTITY or "&" in value or "<" in value:
            plain = f"a plain text of at most {LONGEST_ENTITY} characters, such as a namespace"
            raise self._fault(f"entity '{name}' must stand for {plain}")
        self.outline.entities[name] = value

    def _fault(self, reason: str) -> FileError:
        return FileError(self._path, reason, line=self.parser.CurrentLineNumber)


def _too_deep(what: str) -> str:
    return f"its {what} are nested more than {DEEPEST} deep"


# ---------------------------------------------------------------- triples


_RDF_XML = "http://www.w3.org/1999/02/22-rdf-syntax-ns#RDF"
_OWL_XML = "http://www.w3.org/2002/07/owl#Ontology"
_ENCODING = re.compile(r"""(<\?xml[^>]*?)\s+encoding\s*=\s*(?:"[^"]*"|'[^']*')""")
_TOO_LONG = f"a text or a name is too long to be read: a text may have {LONGEST_TEXT} characters"
_SINGLE_QUOTED = re.compile(r"(<!ENTITY\s+[^\s'\"]+\s+)'([^'\"]*)'")


def parse_text(
    path: Path, text: str, base: str, language: ox.RdfFormat = ox.RdfFormat.TURTLE
) -> tuple[dict[str, str], tuple[ox.Triple, ...]]:
    """Returns the prefixes and the statements of a text in Turtle, RDF/XML, N-Triples or JSON-LD.

    Raises:
        FileError: It is none; with the line.
    """
    try:
        # Anonymous nodes of two files must not meet under one name.
        parser = ox.parse(text, format=language, base_iri=base, rename_blank_nodes=True)
        quads = list(parser)
    except SyntaxError as error:
        reason = re.sub(r"^Parser error at line \d+.*?: ", "", error.msg)
        where = f" at column {error.offset}" if error.lineno else ""
        raise FileError(path, f"not {language.name}{where}: {reason[:300]}", line=error.lineno) from None
    except MemoryError:
        raise FileError(path, _TOO_LONG) from None
    if language == ox.RdfFormat.JSON_LD and any(quad.graph_name != ox.DefaultGraph() for quad in quads):
        raise FileError(
            path, 'has a named graph ("@graph" of something with an "@id"): only one graph without name is read'
        )
    return dict(parser.prefixes), tuple([quad.triple for quad in quads])


def parse_xml(path: Path, text: str, base: str, outline: XmlOutline) -> tuple[ox.Triple, ...]:
    """Returns the statements of an RDF/XML or OWL/XML text, whose outline was read before.

    Raises:
        FileError: It is neither, or not well formed; with the line where it is known.
    """
    if outline.root == _OWL_XML:
        return parse_owl_xml(path, text)
    if outline.root != _RDF_XML:
        raise FileError(path, f"is neither RDF/XML nor OWL/XML: its outermost element is <{outline.root}>")
    return parse_text(path, _readable(text, outline), base, ox.RdfFormat.RDF_XML)[1]


def _readable(text: str, outline: XmlOutline) -> str:
    """The text without what the parser does not know: encodings other than UTF-8, entities in single quotes."""
    readable = _ENCODING.sub(r"\1", text, count=1) if text.startswith("<?xml") else text
    return _SINGLE_QUOTED.sub(r'\1"\2"', readable) if outline.entities else readable


# ---------------------------------------------------------------- OWL/XML


def parse_owl_xml(path: Path, text: str) -> tuple[ox.Triple, ...]:
    """Returns the statements of an OWL/XML text; keys and rules are passed over.

    Raises:
        FileError: It does not mean anything; with the line.
    """
    # Imported here: it takes a third of a second, and few ontologies need it.
    try:
        from owlready2.owlxml_2_ntriples import OwlReadyOntologyParsingError, parse
    except ModuleNotFoundError:
        raise FileError(path, str(MissingExtra("ontology", "OWL/XML"))) from None

    sink = _Sink()
    try:
        parse(io.BytesIO(text.encode()), sink.relation, sink.value, sink.new_blank)
    except OwlReadyOntologyParsingError as error:
        raise _fault(path, str(error), error.__cause__) from None
    return tuple(sink.triples)


class _Sink:
    """Takes what the converter finds, as texts, and makes triples of it."""

    def __init__(self) -> None:
        self.triples: list[ox.Triple] = []
        self._blanks: dict[str, ox.BlankNode] = {}
        self._numbers = itertools.count()

    def new_blank(self) -> str:
        name = f"_:{next(self._numbers)}"
        self._blanks[name] = ox.BlankNode()
        return name

    def relation(self, subject: str, predicate: str, object_: str) -> None:
        self.triples.append(ox.Triple(self._node(subject), ox.NamedNode(predicate), self._node(object_)))

    def value(self, subject: str, predicate: str, value: object, type_: str = "") -> None:
        text = value if isinstance(value, str) else str(value)
        if type_.startswith("@"):
            literal = ox.Literal(text, language=type_.removeprefix("@"))
        else:
            literal = ox.Literal(text, datatype=ox.NamedNode(type_)) if type_ else ox.Literal(text)
        self.triples.append(ox.Triple(self._node(subject), ox.NamedNode(predicate), literal))

    def _node(self, name: str) -> ox.NamedNode | ox.BlankNode:
        return self._blanks[name] if name in self._blanks else ox.NamedNode(name)


def _fault(path: Path, message: str, cause: BaseException | None) -> FileError:
    line = re.search(r"line (\d+)", message)
    if isinstance(cause, KeyError):
        what = f"'{cause.args[0]}' is missing here, as prefix or as attribute"
    else:
        what = str(cause or message)
    return FileError(path, f"not OWL/XML: {what[:300]}", line=int(line.group(1)) if line else None)
