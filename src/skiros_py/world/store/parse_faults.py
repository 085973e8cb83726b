"""What is wrong with a query that does not parse, for people: the engine lists every sign that could have come."""

from __future__ import annotations

import re

__all__ = ["parse_fault"]

_FAULT = re.compile(r"error at (\d+):(\d+): expected (?:one of )?(.*)", re.DOTALL)
_LISTED = re.compile(r'"(?:\\.|[^"\\])*"|\[[^\]]*\]', re.DOTALL)
"""What is no phrase: signs in quotes, and sets of signs."""
_SIGN = re.compile(r'"((?:\\.|[^"\\])+)"|\[(.)[^\]]*\]')
_WORD = re.compile(r"<[^>\s]*>|[?$]?\w+|\S")
_BEFORE, _AFTER = 3, 2
"""How many words around the place are told."""
_KINDS = {
    "a variable": ("?", "$"),
    "a name": (":", "<", "_:"),
    "a value": ('\\"', "'", "+", "true"),
    "a number": ("[0",),
}
"""Kinds of what can be written, each with signs that it begins with."""
_BRACKETS = ("{", "}", "(", ")", "=", ",", ";", "*", "/", "|", "^")
_LONGEST = 60


def parse_fault(text: str, message: str) -> str:
    """Returns where a query breaks off, and what could have come; as it is where the engine says something else.

    Columns are left out: names were written out since somebody wrote the query.

    Args:
        text: The query as the engine has read it.
        message: What the engine says.
    """
    found = _FAULT.fullmatch(message)
    if found is None:
        return message
    line, column = int(found[1]), int(found[2])
    reason = _reason(found[3])
    if reason:
        return f"line {line}: {reason}"
    lines = text.split("\n")
    before = "\n".join([*lines[: line - 1], lines[line - 1][: column - 1]])
    after = "\n".join([lines[line - 1][column - 1 :], *lines[line:]])
    expected = _expected(found[3])
    ends = bool(expected) and not after.strip()
    what = "the query ends too early" if ends else f"something is wrong near {_near(before, after)}"
    return f"line {line}: {what}" + (f"; expected {expected}" if expected else "")


def _reason(signs: str) -> str:
    """Returns what the engine says in words among the signs, "Prefix not found"; empty where it only lists them."""
    said = (each.strip() for each in _LISTED.sub("", signs).split(","))
    return next((each for each in said if each[:1].isalpha() and " " in each), "")


def _near(before: str, after: str) -> str:
    """Returns some words around a place: the engine looks ahead, so it may be just before or just after it."""
    words = [*_WORD.findall(before)[-_BEFORE:], *_WORD.findall(after)[:_AFTER]]
    said = (re.split("[#/]", word.strip("<>"))[-1] if word.startswith("<") else word for word in words)
    return f"'{' '.join(said)[:_LONGEST]}'"


def _expected(signs: str) -> str:
    """Names the kinds of what could have come; keywords are left out, of which the engine names any that is near."""
    known = {match[1] or f"[{match[2]}" for match in _SIGN.finditer(signs.replace("['", "["))}
    kinds = [kind for kind, begins in _KINDS.items() if known.intersection(begins)]
    if "a value" in kinds:
        kinds = [kind for kind in kinds if kind != "a number"]
    kinds += [f"'{sign}'" for sign in _BRACKETS if sign in known]
    return " or ".join(filter(None, [", ".join(kinds[:-1]), *kinds[-1:]]))
