"""Checks the text of a query, and expands its prefixes.

Names with prefixes become full IRIs, so that the engine reads exactly what was checked here: it needs no blank between
a keyword and a name, and would read ``SERVICE:x`` as both.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import pyoxigraph as ox

from skiros_py.errors import UnknownName, UsageError
from skiros_py.world.names import Names

DEEPEST = 100
"""Maximum nesting of brackets in a query: recursive parsers crash on thousands."""

_FORMS = ("SELECT", "ASK", "CONSTRUCT")
_UPDATES = ("INSERT", "DELETE", "LOAD", "CLEAR", "DROP", "CREATE", "ADD", "MOVE", "COPY", "WITH")
_REFUSED = {
    "SERVICE": "the query asks another server (SERVICE); only this world can be asked",
    "FROM": "the query names its graphs (FROM); leave that out: all graphs are asked as one, GRAPH <…> {…} asks one",
    "LOAD": "the query fetches a file (LOAD); only what is in this world can be asked",
}
_BAD_STARTS = {
    **{
        word: f"{word} changes triples, and a query cannot: the world changes by transactions only" for word in _UPDATES
    },
    "DESCRIBE": "DESCRIBE does not say what it answers: write CONSTRUCT",
    "BASE": "the query shortens IRIs by BASE: use prefixes, or write them in full",
    "PREFIX": "the query does not parse: PREFIX needs a name and an IRI, as in PREFIX ex: <http://…#>",
}

_UCHAR = r"\\u[0-9A-Fa-f]{4}|\\U[0-9A-Fa-f]{8}"
_LETTER = r"[^\W\d_]"
_LOCAL = r"(?:(?:\w|[:·-]|%[0-9A-Fa-f]{2}|\\[-_~.!$&'()*+,;=/?#@%]|\.+(?=\w|[:·%\\-]))*)"
_PREFIX = rf"(?:{_LETTER}(?:[\w.·-]{{0,100}}[\w·-])?)?"  # limited, so that no long text is searched again and again
_IRI = rf"<(?:[^<>\"{{}}|^`\\\x00-\x20]|{_UCHAR})*>"
_GAP = r"(?:[ \t\r\n]|\#[^\r\n]*)"

_TOKEN = re.compile(
    rf"""
    (?P<blank>[ \t\r\n]+)
  | (?P<comment>\#[^\r\n]*)
  | (?P<declaration>(?i:PREFIX){_GAP}+{_PREFIX}:{_GAP}*{_IRI})
  | (?P<iri>{_IRI})
  | (?P<text>\"\"\"(?:(?:\"|\"\")?(?:[^"\\]|\\.))*\"\"\" | '''(?:(?:'|'')?(?:[^'\\]|\\.))*'''
            | "(?:[^"\\\r\n]|\\.)*" | '(?:[^'\\\r\n]|\\.)*')
  | (?P<parameter>\$\w+)
  | (?P<name>(?:{_PREFIX}|_):{_LOCAL})
  | (?P<word>{_LETTER}\w*)
  | (?P<open>[({{\[])
  | (?P<close>[)}}\]])
  | (?P<other>\?\w+ | @[A-Za-z]+(?:-[A-Za-z0-9]+)* | \d+ | \^\^|&&|\|\||!=|<=|>=|[<>=!|/^+*?.,;&-])
    """,
    re.VERBOSE | re.DOTALL,
)
_DECLARATION = re.compile(rf"(?i:PREFIX){_GAP}+(?P<prefix>{_PREFIX}):{_GAP}*(?P<iri>{_IRI})")
_UCHARS = re.compile(_UCHAR)
_ESCAPE = re.compile(rf"{_UCHAR}|\\.", re.DOTALL)
_SAFE_IN_TEXT = {'"': '\\"', "'": "\\'", "\\": "\\\\", "\n": "\\n", "\r": "\\r"}
_NOT_IN_IRI = re.compile(r"""[<>"{}|^`\\\x00-\x20]""")


@dataclass(frozen=True, slots=True)
class QueryText:
    """A checked query; see :func:`parsed`.

    Attributes:
        form: "SELECT", "ASK" or "CONSTRUCT".
        pieces: The text with full IRIs; every second piece is the name of a parameter.
        iris: The IRIs in it.
        parameters: The names of its parameters.
    """

    form: str
    pieces: tuple[str, ...]
    iris: frozenset[str]
    parameters: frozenset[str]

    def filled(self, terms: Mapping[str, ox.NamedNode | ox.Literal]) -> str:
        """Returns the query with terms for its parameters.

        Raises:
            UsageError: A parameter has no term, or a term has no parameter.
        """
        unbound = sorted(self.parameters.difference(terms))
        if unbound:
            bound = ", ".join(sorted(terms)) or "nothing"
            raise UsageError(
                f"nothing is bound to ${', $'.join(unbound)}; bound: {bound} (variables are written ?name)"
            )
        unused = sorted(set(terms) - self.parameters)
        if unused:
            raise UsageError(f"the query has no parameter ${', $'.join(unused)}")
        # A term writes itself escaped, so that no value can become query text.
        return "".join(str(terms[piece]) if at % 2 else piece for at, piece in enumerate(self.pieces))


@lru_cache(maxsize=512)
def parsed(sparql: str, names: Names) -> QueryText:
    """Parses and checks a query without running it.

    Raises:
        UsageError: It is no query, is an update, asks another server, or is nested too deep.
        UnknownName: It uses an undeclared prefix.
    """
    return _Reader(names).read(sparql)


class _Reader:
    def __init__(self, names: Names) -> None:
        self._prefixes = dict(names.prefixes)
        self._form: str | None = None
        self._pieces = [""]
        self._iris: set[str] = set()
        self._depth = 0
        self._signs = 0

    def read(self, sparql: str) -> QueryText:
        at = 0
        while at < len(sparql):
            match = _TOKEN.match(sparql, at)
            if match is None:
                line = sparql.count("\n", 0, at) + 1
                raise UsageError(f"the query does not parse: line {line}: {_problem(sparql[at])}")
            assert match.lastgroup is not None
            self._check_depth(match.lastgroup, match[0])
            self._take(match.lastgroup, match[0])
            at = match.end()
        if self._form is None:
            raise UsageError("the query is empty: it needs SELECT, ASK or CONSTRUCT")
        parameters = frozenset(self._pieces[1::2])
        return QueryText(self._form, tuple(self._pieces), frozenset(self._iris), parameters)

    def _check_depth(self, kind: str, text: str) -> None:
        """Counts open brackets, and signs in a row: ``!!!!x``, ``- - -x``, ``^^^^x`` nest like brackets."""
        self._depth += (kind == "open") - (kind == "close")
        if text in ("!", "+", "-", "^", "^^"):
            self._signs += len(text)
        elif kind not in ("blank", "comment"):
            self._signs = 0
        if max(self._depth, self._signs) > DEEPEST:
            raise UsageError(
                f"the query is nested too deep: {DEEPEST} brackets within each other or signs in a row are the most"
            )

    def _take(self, kind: str, text: str) -> None:
        if kind == "declaration" and self._form is None:
            self._declare(text)
        elif kind == "word":
            self._word(text)
        elif kind == "name":
            self._name(text)
        elif kind == "iri":
            self._iri(_decoded_iri(text))
        elif kind == "parameter":
            self._pieces += [text[1:], ""]
        elif kind == "comment":
            self._write(" ")
        else:
            self._write(_ESCAPE.sub(_text_escape, text) if kind == "text" else text)

    def _declare(self, text: str) -> None:
        found = _DECLARATION.fullmatch(text)
        assert found is not None, "the token is a declaration"
        self._prefixes[found["prefix"]] = _decoded_iri(found["iri"])
        self._write("\n" * text.count("\n"))  # so that the engine counts lines as the author does

    def _word(self, text: str) -> None:
        word = text.upper()
        for refused, why in _REFUSED.items():
            if refused in word:  # the engine needs no blank between two keywords
                raise UsageError(why)
        if self._form is None:
            if word not in _FORMS:
                begins = f"the query begins with '{word[:40]}', and must with SELECT, ASK or CONSTRUCT"
                raise UsageError(_BAD_STARTS.get(word, begins))
            self._form = word
        self._write(text)

    def _name(self, text: str) -> None:
        prefix, _, local = text.partition(":")
        if prefix == "_":
            self._write(f" {text} ")
        elif prefix not in self._prefixes:
            raise UnknownName("prefix", prefix, self._prefixes, where=f"in '{text}'")
        else:
            self._iri(self._prefixes[prefix] + re.sub(r"\\(.)", r"\1", local))

    def _iri(self, iri: str) -> None:
        self._iris.add(iri)
        self._write(f"<{iri}>")

    def _write(self, text: str) -> None:
        self._pieces[-1] += text


def _decoded_iri(iri: str) -> str:
    r"""Returns an IRI, given in angles, without them and without any ``\u``."""
    bare = _UCHARS.sub(_character, iri[1:-1])
    if _NOT_IN_IRI.search(bare):
        raise UsageError(f"the query does not parse: {iri} is no IRI")
    return bare


def _character(match: re.Match[str]) -> str:
    digits = match[0][2:]
    code = int(digits, 16)
    if code > 0x10FFFF or 0xD800 <= code <= 0xDFFF:
        raise UsageError(f"the query does not parse: there is no character {match[0]}")
    return chr(code)


def _text_escape(match: re.Match[str]) -> str:
    r"""Replaces ``\u`` in a text in quotes: engines differ on whether the character may close the text."""
    if match[0][1] not in "uU":
        return match[0]
    if len(match[0]) == 2:
        raise UsageError("the query does not parse: \\u needs four hexadecimal digits after it, and \\U eight")
    character = _character(match)
    return _SAFE_IN_TEXT.get(character, character)


def _problem(character: str) -> str:
    if character in "\"'":
        return "a text is not closed"
    if character == "$":
        return "$ begins a parameter, and a name must follow"
    return f"{character!r} means nothing here"
