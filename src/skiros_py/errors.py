"""The one tree of faults.

::

    SkirosError
    ├── UsageError            a request for something that does not exist or does not parse
    │   ├── UnknownName       ... with the names that do exist
    │   │   └── NotFound      ... which the request is addressed to
    │   ├── GoalSyntaxError   ... at this column of the goal
    │   ├── MissingExtra      ... that needs an extra of the distribution, which is not installed
    │   ├── DocumentError     ... at these places of a document
    │   ├── KeyReused         ... with the key of an earlier, different request
    │   └── WrongState        ... that cannot be done now, in the state things are in
    │       └── Removed       ... since its result was removed
    ├── Refused               a use case cannot be done now, with a code for programs: no plan, no simulation, ...
    ├── FileError             a file cannot be read or understood: path, line, reason
    │   └── DiskFault         ... or cannot be read or written now: the disk is full, read-only or failing
    ├── WorldError            a write to the world model was refused
    │   ├── StaleVersion      ... because the author had not seen the latest change
    │   └── Locked            ... because another user has locked an element
    ├── DescriptionError      a skill, primitive or robot is described wrongly (its author must fix it)
    ├── ModuleError           a skill or primitive raised while it ran, or was stopped with everything else
    ├── PlanningError         a planner broke (not: "there is no plan", which is an answer)
    ├── DeviceError           a device or the simulation broke
    ├── Busy                  overload: the same request may succeed later
    │   └── Overloaded        ... as soon as the caller sends less of them
    └── MissingSystemLibrary  a library that pip cannot install is absent

Interruption is not part of the tree: the platform raises it to cancel a run; only the platform catches it.

Expected outcomes ("no plan", "part not found", "condition does not hold") are values, never exceptions.
"""

from __future__ import annotations

import difflib
import string
from bisect import bisect_left
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from pathlib import Path

from skiros_py.messages import Message, cut, joined, with_values


def escaped(text: str) -> str:
    r"""Returns a line in which everything that cannot be printed is written out, as in ``\x1b`` or ``\n``.

    Labels, authors and reasons come from anywhere; what they say must not steer the terminal or look like more lines.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


class SkirosError(Exception):
    """Base of every error that this platform raises on purpose.

    Args:
        text: The text, meant for the user; with values the template of a :class:`~skiros_py.messages.Message`.
        values: The values of its fields.
    """

    def __init__(self, text: object = "", /, **values: object) -> None:
        super().__init__(with_values(text, values))

    def __reduce__(self) -> tuple[Callable[..., SkirosError], tuple[object, ...]]:
        # Faults travel from worker processes; their constructors take other arguments than the text in ``args``.
        return _restored, (type(self), self.args, dict(self.__dict__))


def _restored(kind: type[SkirosError], args: tuple[object, ...], fields: dict[str, object]) -> SkirosError:
    error = kind.__new__(kind, *args)
    error.__dict__.update(fields)
    return error


class UsageError(SkirosError):
    """A request for something that does not exist or does not parse."""


class UnknownName(UsageError):
    """An unknown name.

    Attributes:
        kind: The kind of name, in the user's words ("scene", "condition", ...).
        name: The name given.
        known: The names that exist, sorted; of very many, those similar to the given one.
        nearest: The known name most like the given one, or None.
    """

    def __init__(self, kind: str, name: str, known: Iterable[str], *, where: str = "") -> None:
        self.kind = kind
        self.name = name
        given = str(name)[:_LONGEST_SHOWN]
        names = known if isinstance(known, Mapping | AbstractSet) else sorted(known)
        many = len(names) > _MANY
        self.known = tuple(sorted(_alike(given, names) if many else names))
        self.nearest = _nearest(given, self.known)
        said = {"kind": kind, "name": given if len(str(name)) <= len(given) else f"{given}…"}
        text = Message("unknown {kind} '{name}'.", **said)
        if where:
            text = Message("unknown {kind} '{name}' {where}.", where=cut(where, _LONGEST_SHOWN), **said)
        hint = [Message("Did you mean '{name}'?", name=self.nearest)] if self.nearest else []
        shown = ", ".join(self.known[:20]) + (", …" if many or len(self.known) > 20 else "")
        there_is = Message("Known: {names}.", names=shown)
        if not self.known:
            there_is = Message("None of {count} is like it.", count=len(names)) if many else Message("There is none.")
        super().__init__(joined(" ", [text, *hint, there_is]))


class NotFound(UnknownName):
    """The object that a request addresses does not exist.

    Attributes:
        code: The kind of object, for programs.
    """

    code = "NotFound"

    @classmethod
    def of(cls, error: UnknownName, code: str) -> NotFound:
        """Converts an unknown name."""
        found = cls.__new__(cls, *error.args)
        found.__dict__.update(error.__dict__, code=code)
        return found


_MANY = 1000
"""Maximum number of names compared with the given one: that takes 10 ms, all of them would take seconds."""
_TOO_MANY = 20_000
"""Maximum number of names that are iterated: that takes 10 ms."""
_LONGEST_SHOWN = 100


def _nearest(name: str, known: Iterable[str]) -> str | None:
    folded = {candidate.casefold(): candidate for candidate in known}
    qualified = (own for own in folded if own.endswith(f".{name.casefold()}"))  # the same name, of a distribution
    close = [*qualified] or difflib.get_close_matches(name.casefold(), list(folded), n=1, cutoff=0.6)
    return folded[close[0]] if close else None


def _alike(name: str, known: Collection[str]) -> Iterable[str]:
    if len(known) > _TOO_MANY and isinstance(known, Mapping | AbstractSet):
        return {spelling for spelling in _misspelt(name) if spelling in known}
    return _around(name, sorted(known))


def _misspelt(name: str) -> Iterator[str]:
    """Yields the names that differ from the given one by one typing error, or by capitals."""
    for text in {name, name.casefold()}:
        yield text
        for at in range(len(text) + 1):
            before, after = text[:at], text[at:]
            yield before + after[1:]
            yield before + after[1:2] + after[:1] + after[2:]
            for letter in _LETTERS:
                yield before + letter + after
                yield before + letter + after[1:]


_LETTERS = string.ascii_letters + string.digits + "_:"


def _around(name: str, names: list[str]) -> list[str]:
    """Returns the names next to the given one in sorted order: they have similar beginnings."""
    places = {bisect_left(names, spelling) for spelling in (name, name.casefold(), name[:-1])}
    reach = _MANY // (2 * len(places))
    return sorted({other for at in places for other in names[max(0, at - reach) : at + reach]})


class GoalSyntaxError(UsageError):
    """A goal text that the grammar does not accept.

    Attributes:
        text: The whole goal text.
        column: 1-based column of the first character that does not fit.
    """

    def __init__(self, text: str, column: int, reason: str) -> None:
        self.text = text
        self.column = column
        start = max(0, column - 60)  # a window, should the goal be very long
        shown = text[start : start + 100]
        pointer = f"{' ' * (column - 1 - start)}^"
        text = Message("goal, column {column}: {reason}", column=column, reason=reason)
        super().__init__(joined("\n  ", (text, shown, pointer)))


@dataclass(frozen=True, slots=True)
class DocumentFault:
    """Something that is wrong with a document.

    Attributes:
        place: Where in the document ("children[1].module"); empty for the whole.
        text: What is wrong, in a sentence.
        line: 1-based line of an imported text; 0 if unknown.
        column: 1-based column in that line; 0 if unknown.
    """

    place: str
    text: str
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        line = Message("line {line}, column {column}", line=self.line, column=self.column) if self.line else ""
        where = [part for part in (line, self.place) if part]
        return joined(": ", (joined(", ", where), self.text)) if where else self.text


class DocumentError(UsageError):
    """A document that is not accepted; nothing of it was stored.

    Attributes:
        faults: What is wrong, each with its place.
    """

    def __init__(self, faults: Sequence[DocumentFault], document: str = "") -> None:
        self.faults = tuple(faults)
        said = joined("; ", map(str, self.faults[:_MOST_FAULTS_SHOWN]))
        super().__init__(joined(": ", (document, said)) if document else said)


_MOST_FAULTS_SHOWN = 20


class KeyReused(UsageError):
    """A request has the key of an earlier, different one."""


class WrongState(UsageError):
    """A request that is invalid in the current state: a finished job cannot be paused."""


class Removed(WrongState):
    """A repeated request whose result was removed; it is not created again."""


class Refused(SkirosError):
    """A use case cannot be done in the current state.

    Attributes:
        code: Why, for programs.
        data: Further data, for programs.
    """

    def __init__(self, code: str, text: str, **data: object) -> None:
        self.code = code
        self.data = data
        super().__init__(text)


class FileError(SkirosError):
    """A file that cannot be read or understood; nothing was started.

    Attributes:
        path: The file.
        line: 1-based line, or None if unknown.
        reason: The fault and how to fix it.
    """

    def __init__(self, path: Path, reason: str, *, line: int | None = None) -> None:
        self.path = path
        self.line = line
        self.reason = reason
        where = f"{path}:{line}" if line else f"{path}"
        super().__init__(joined(": ", (where, reason)))


class DiskFault(FileError):
    """A file cannot be read or written now; the same may succeed later."""


class WorldError(SkirosError):
    """A write to the world model was refused; the text says what would be allowed."""


class StaleVersion(WorldError):
    """An edit was based on an outdated state; read the current one, then decide.

    Attributes:
        present: The current version, if known.
    """

    def __init__(self, text: str, *, present: int | None = None) -> None:
        self.present = present
        super().__init__(text)


class Locked(WorldError):
    """Another user has locked an element of an edit.

    Attributes:
        locks: Element, owner and remaining time [s] of each lock that prevents it.
    """

    def __init__(self, text: str, locks: tuple[tuple[str, str, float], ...] = ()) -> None:
        self.locks = locks
        super().__init__(text)


class DescriptionError(SkirosError):
    """A skill, primitive, condition, robot or document is described wrongly; its author must fix it.

    Attributes:
        text: What is wrong.
        place: Where in a document ("children[1].seconds"); empty for the whole, or where there is no document.
    """

    def __init__(self, text: str, place: str = "") -> None:
        self.text = text
        self.place = place
        super().__init__(joined(": ", (place, text)) if place else text)


class ModuleError(SkirosError):
    """A skill or primitive raised, exited or blocked the control cycle while it ran, or was halted."""


class PlanningError(SkirosError):
    """A planner program broke, or returned something that is not a plan."""


class DeviceError(SkirosError):
    """A device, the simulation or a worker process broke."""


class Busy(SkirosError):
    """Overload: the request was not accepted; it may succeed later.

    Attributes:
        retry_after: Recommended time before the next attempt [s].
    """

    def __init__(self, text: str, *, retry_after: float = 1.0) -> None:
        self.retry_after = retry_after
        super().__init__(text)


class Overloaded(Busy):
    """More requests arrive than can be carried out; this one had no effect."""


def without_wheels(extra: str) -> tuple[str, ...]:
    """Returns the packages of an extra that do not exist for this Python and machine.

    Another extra that it has where such a marker holds is none of it elsewhere.
    """
    from importlib.metadata import requires

    from packaging.requirements import Requirement

    found: list[str] = []
    for wanted in (Requirement(text) for text in requires("skiros-py") or ()):
        if wanted.marker is None or f'extra == "{extra}"' not in str(wanted.marker):
            continue
        here = wanted.marker.evaluate({"extra": extra})
        if wanted.name == "skiros-py":
            found.extend(name for part in sorted(wanted.extras if here else ()) for name in without_wheels(part))
        elif not here:
            found.append(wanted.name)
    return tuple(found)


class MissingExtra(UsageError):
    """A required extra of the distribution is not installed.

    Attributes:
        extra: Its name.
    """

    def __init__(self, extra: str, needed_for: str) -> None:
        self.extra = extra
        todo = f"python3 -m pip install 'skiros-py[{extra}]'"
        missing = without_wheels(extra)
        if missing:
            todo = f"use Python 3.11 on x86-64 Linux, since {', '.join(missing)} cannot be installed here"
        super().__init__(f"{needed_for} needs the extra '{extra}': {todo}")


class MissingSystemLibrary(SkirosError):
    """A system library that pip cannot install is missing.

    Attributes:
        package: The Debian package that contains it.
    """

    def __init__(self, needed_by: str, library: str, package: str) -> None:
        self.package = package
        super().__init__(f"{needed_by} needs {library}: install it with 'apt-get install {package}'")
