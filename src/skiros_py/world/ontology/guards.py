"""Looks at a file before it is parsed, and refuses what was made to harm rather than to be read.

Parsers resolve entities and follow nesting as deep as it goes; here both have limits that no honest file reaches.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from skiros_py.errors import FileError

__all__ = ["DEEPEST", "LONGEST_ENTITY", "XmlOutline", "check_turtle", "outline_xml", "read_text"]

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
    """

    root: str = ""
    base: str = ""
    prefixes: dict[str, str] = field(default_factory=dict)
    entities: dict[str, str] = field(default_factory=dict)


def read_text(path: Path) -> str:
    """Reads a file as UTF-8 text, with or without a byte-order mark.

    Raises:
        FileError: It is missing, unreadable or not such a text.
    """
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise FileError(path, "there is no such file") from None
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror or error}") from None
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise FileError(path, "is UTF-16 text: save it as UTF-8")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise FileError(path, f"cannot be read as UTF-8 text: {error.reason}", line=line) from None
    if "\0" in text:
        raise FileError(path, "is no text: it has a zero byte", line=text.count("\n", 0, text.index("\0")) + 1)
    return text


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
