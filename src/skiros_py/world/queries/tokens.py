"""SPARQL text cut into tokens, so that keywords, names and parameters are told from texts, IRIs and comments."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from skiros_py.errors import UsageError

__all__ = ["Token", "decoded_iri", "decoded_local", "decoded_text", "tokens"]

_UCHAR = r"\\u[0-9A-Fa-f]{4}|\\U[0-9A-Fa-f]{8}"
_LETTER = r"[^\W\d_]"
_ESCAPED = r"\\[-_~.!$&'()*+,;=/?#@%]"
_LOCAL = rf"(?:(?:\w|[:·-]|%[0-9A-Fa-f]{{2}}|{_ESCAPED}|\.+(?=\w|[:·%\\-]))*)"

_LONGEST_PREFIX = 100  # so that looking for one in a long text takes no long time

_TOKEN = re.compile(
    rf"""
    (?P<blank>[ \t\r\n]+)
  | (?P<comment>\#[^\r\n]*)
  | (?P<iri><(?:[^<>"{{}}|^`\\\x00-\x20]|{_UCHAR})*>)
  | (?P<text>\"\"\"(?:(?:\"|\"\")?(?:[^"\\]|\\.))*\"\"\" | '''(?:(?:'|'')?(?:[^'\\]|\\.))*'''
            | "(?:[^"\\\r\n]|\\.)*" | '(?:[^'\\\r\n]|\\.)*')
  | (?P<parameter>\$\w+)
  | (?P<variable>\?\w+)
  | (?P<name>(?:{_LETTER}(?:[\w.·-]{{0,{_LONGEST_PREFIX}}}[\w·-])?|_)?:{_LOCAL})
  | (?P<number>(?:\d+(?:\.\d*)?|\.\d+)[eE][+-]?\d+|\d*\.\d+|\d+)
  | (?P<word>{_LETTER}\w*)
  | (?P<language>@[A-Za-z]+(?:-[A-Za-z0-9]+)*)
  | (?P<open>[({{\[])
  | (?P<close>[)}}\]])
  | (?P<sign>\^\^|&&|\|\||!=|<=|>=|[<>=!|/^+*?.,;&-])
    """,
    re.VERBOSE | re.DOTALL,
)
_UCHARS = re.compile(_UCHAR)
_ESCAPE = re.compile(rf"{_UCHAR}|\\.", re.DOTALL)
_SAFE_IN_TEXT = {'"': '\\"', "'": "\\'", "\\": "\\\\", "\n": "\\n", "\r": "\\r"}
_NOT_IN_IRI = re.compile(r"""[<>"{}|^`\\\x00-\x20]""")


@dataclass(frozen=True, slots=True)
class Token:
    """One piece of a query.

    Attributes:
        kind: "blank", "comment", "iri", "text", "parameter", "variable", "name" (with a prefix), "number", "word"
            (keywords and functions), "language", "open", "close" or "sign".
        text: As written.
        at: Where it begins, counted in characters from 0.
    """

    kind: str
    text: str
    at: int


def tokens(sparql: str) -> Iterator[Token]:
    """Yields all tokens of a query, blanks and comments too.

    Raises:
        UsageError: Something is no token: a text that is not closed, a character that SPARQL does not have.
    """
    at = 0
    while at < len(sparql):
        match = _TOKEN.match(sparql, at)
        if match is None:
            raise UsageError(
                f"the query does not parse: line {sparql.count(chr(10), 0, at) + 1}: {_problem(sparql, at)}"
            )
        assert match.lastgroup is not None
        yield Token(match.lastgroup, match[0], at)
        at = match.end()


def decoded_text(literal: str) -> str:
    r"""Returns a text in quotes without any ``\u``: engines differ on whether those may close it."""
    return _ESCAPE.sub(_text_escape, literal) if "\\" in literal else literal


def decoded_iri(iri: str) -> str:
    r"""Returns an IRI, given in angles, without them and without any ``\u``.

    Raises:
        UsageError: A character in it must not be there.
    """
    bare = _UCHARS.sub(_character, iri[1:-1])
    if _NOT_IN_IRI.search(bare):
        raise UsageError(f"the query does not parse: {iri} is no IRI")
    return bare


def decoded_local(local: str) -> str:
    """Returns the part of a name after the prefix, without backslashes."""
    return re.sub(r"\\(.)", r"\1", local)


def _character(match: re.Match[str]) -> str:
    digits = match[0][2:]
    code = int(digits, 16)
    if code > 0x10FFFF or 0xD800 <= code <= 0xDFFF:
        raise UsageError(f"the query does not parse: there is no character {match[0]}")
    return chr(code)


def _text_escape(match: re.Match[str]) -> str:
    if match[0][1] not in "uU":
        return match[0]
    if len(match[0]) == 2:
        raise UsageError("the query does not parse: \\u needs four hexadecimal digits after it, and \\U eight")
    character = _character(match)
    return _SAFE_IN_TEXT.get(character, character)


def _problem(sparql: str, at: int) -> str:
    character = sparql[at]
    if character in "\"'":
        return "a text is not closed"
    if character == "$":
        return "$ begins a parameter, and a name must follow"
    return f"{character!r} means nothing here"
