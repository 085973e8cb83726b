"""The installed entry points, from the metadata of all distributions, or from a package's own folder.

The metadata of an installed package contain the entry points at the time of its installation; during development they
are outdated.
"""

from __future__ import annotations

import importlib
import os
import re
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from email.message import Message
from email.parser import HeaderParser
from functools import lru_cache
from importlib import metadata
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from skiros_py.errors import UnknownName
from skiros_py.plugins.plugin import Distribution, Entry, PluginFault, canonical, qualified

_KINDS = (
    "skills", "primitives", "behaviours", "documents", "conditions", "reasoners", "planners", "devices", "adapters",
    "drivers", "engines", "signals", "ontologies", "robots", "scenes", "pages", "topics",
)  # fmt: skip
GROUPS = tuple(f"skiros.{kind}" for kind in _KINDS)
"""The entry-point groups of this platform."""

WITHOUT = "SKIROS_WITHOUT"
"""Environment variable with the distributions that are left out, separated by blanks; child processes get it, too."""
_PREFIX = "skiros."
_METADATA = (".dist-info", ".egg-info")

_Sight = tuple[tuple[str, tuple[str, ...]], ...]


@dataclass(frozen=True, slots=True)
class Installation:
    """The plug-in distributions that Python finds, in the order of its path.

    Attributes:
        distributions: Those that have entry points for this platform.
        entries: These entry points, by the names under which they are offered; in a group each name stands once.
        faults: Metadata that cannot be understood, and entry points of one distribution with one name.
        left_out: Entry points of distributions that are left out: names stay qualified where these have them, too.
    """

    distributions: tuple[Distribution, ...]
    entries: tuple[Entry, ...]
    faults: tuple[PluginFault, ...]
    left_out: tuple[Entry, ...] = ()

    def of(self, group: str) -> tuple[Entry, ...]:
        """Returns the entry points of a group."""
        return tuple(entry for entry in self.entries if entry.group == group)


def installation() -> Installation:
    """Returns what is installed now, without what ``SKIROS_WITHOUT`` names; read again only if either changes."""
    return _scanned(_sight(), frozenset(map(canonical, os.environ.get(WITHOUT, "").split())))


def _sight() -> _Sight:
    """The folders of metadata on the path, which identify an installation."""
    return tuple((folder, _metadata_in(folder)) for folder in sys.path)


def _metadata_in(folder: str) -> tuple[str, ...]:
    try:
        return tuple(sorted(name for name in os.listdir(folder or ".") if name.endswith(_METADATA)))  # noqa: PTH208
    except OSError:
        return ()


@lru_cache(maxsize=1)
def _scanned(_sight: _Sight, without: frozenset[str]) -> Installation:
    found: dict[str, tuple[Distribution, tuple[Entry, ...]]] = {}
    faults: list[PluginFault] = []
    for source in metadata.distributions():
        if _speaks_of_skiros(source):
            distribution = _described(source)
            try:
                entries = tuple(_entries(source.entry_points, distribution))
            except Exception as error:  # noqa: BLE001 - whatever the parser makes of somebody's file
                reason = f"its entry_points.txt cannot be understood: {type(error).__name__}: {error}"
                if canonical(distribution.name) not in without:
                    faults.append(PluginFault("skiros", "-", str(distribution), reason, "", distribution.folder))
            else:
                # As for imports, the first of a name on the path counts.
                found.setdefault(canonical(distribution.name), (distribution, entries))
    named: dict[tuple[str, str], list[Entry]] = {}
    for entry in _named_apart([entry for _, own in found.values() for entry in own]):
        if canonical(entry.distribution.name) not in without:
            named.setdefault((entry.group, entry.name), []).append(entry)
    for twins in (own for own in named.values() if len(own) > 1):
        reason = f"the name '{twins[0].name}' stands twice: {' and '.join(map(str, twins))}; neither counts, rename one"
        faults += [PluginFault(one.group, one.name, str(one.distribution), reason, "") for one in twins]
    entries = tuple(sorted((own[0] for own in named.values() if len(own) == 1), key=_order))
    left_out = tuple(entry for name in without if name in found for entry in found.pop(name)[1])
    return Installation(tuple(distribution for distribution, _ in found.values()), entries, tuple(faults), left_out)


def _named_apart(entries: Sequence[Entry]) -> Iterator[Entry]:
    claims = [(entry.group, entry.name, str(entry.distribution)) for entry in entries]
    for entry, (group, name, distribution) in zip(entries, claims, strict=True):
        holders = {other for *key, other in claims if key == [group, name]}
        yield entry if has_bare_name(distribution, holders) else entry.offered(qualified(name, distribution))


def has_bare_name(distribution: str, holders: Iterable[str]) -> bool:
    """Tells whether one of the distributions that use a name has it unqualified: the only one, or the built-in one.

    Args:
        distribution: The distribution ("skiros-skills 0.1.0").
        holders: All that use the name.
    """
    built_in = [one for one in holders if canonical(one.partition(" ")[0]) in _built_in()]
    return {distribution} == set(built_in or holders)


@lru_cache(maxsize=1)
def _built_in() -> frozenset[str]:
    """The names of this distribution and of those that its own metadata name, as its extras do."""
    named = (_NAME.fullmatch(text) for text in metadata.requires(OWN_NAME) or ())
    return frozenset({OWN_NAME, *(canonical(match[1]) for match in named if match)})


def _order(entry: Entry) -> tuple[str, ...]:
    return entry.group, entry.name, canonical(entry.distribution.name), entry.value


def _speaks_of_skiros(source: metadata.Distribution) -> bool:
    try:
        return _PREFIX in (source.read_text("entry_points.txt") or "")
    except (OSError, ValueError):
        return False


def _entries(points: Iterable[metadata.EntryPoint], distribution: Distribution) -> Iterator[Entry]:
    """Yields the entry points for this platform, each once."""
    own = [Entry(p.group, p.name, p.value, distribution) for p in points if p.group.startswith(_PREFIX)]
    yield from dict.fromkeys(own)


def _described(source: metadata.Distribution) -> Distribution:
    folder = Path(str(getattr(source, "_path", "")))
    said = _headers(source)
    requires = tuple(said.get_all("Requires-Dist") or ())
    name = said["Name"] or folder.name.partition("-")[0] or "an unknown distribution"
    return Distribution(name, said["Version"] or "", requires, str(folder))


def _headers(source: metadata.Distribution) -> Message:
    """Reads the headers of the metadata; a partly removed distribution may have none."""
    try:
        text = source.read_text("METADATA") or source.read_text("PKG-INFO") or ""
    except (OSError, ValueError):
        text = ""
    return HeaderParser().parsestr(text)


# ---------------------------------------------------------------- fitting versions


OWN_NAME = "skiros-py"
"""Name of this distribution."""
_NAME = re.compile(r"\s*([A-Za-z0-9][A-Za-z0-9._-]*)(.*)", re.DOTALL)


class Misfit(NamedTuple):
    """Why a distribution does not fit this skiros-py, and the remedy."""

    problem: str
    todo: str

    def __str__(self) -> str:
        return f"{self.problem}; {self.todo}"


@lru_cache(maxsize=1024)  # called for each entry point of a distribution
def misfit(distribution: Distribution, own_version: str | None = None) -> Misfit | None:
    """Returns why a distribution does not fit this skiros-py; None if it does, or has no requirement.

    Args:
        distribution: Its metadata may contain ``Requires-Dist: skiros-py>=0.1,<0.2``.
        own_version: Version to compare with; by default, that of the installed skiros-py.
    """
    for text in distribution.requires:
        match = _NAME.fullmatch(text)
        # Most say nothing but the name; the library that reads the rest takes a while to import.
        if match and canonical(match[1]) == OWN_NAME and match[2].strip():
            problem = _problem(text, own_version or version(OWN_NAME))
            if problem:
                return Misfit(problem, f"install a release of {distribution.name} that fits, or such a {OWN_NAME}")
    return None


def _problem(text: str, own_version: str) -> str | None:
    from packaging.requirements import InvalidRequirement, Requirement

    try:
        requirement = Requirement(text)
    except InvalidRequirement:
        return f"its metadata require '{text}', which is no requirement (such as '{OWN_NAME}>=0.1,<0.2')"
    if requirement.marker is not None and not requirement.marker.evaluate({"extra": ""}):
        return None
    if requirement.specifier.contains(own_version, prereleases=True):
        return None
    return f"it is made for {OWN_NAME}{requirement.specifier}, and this is {OWN_NAME} {own_version}"


@contextmanager
def leaving_out(names: Iterable[str]) -> Iterator[None]:
    """Leaves out all plug-ins of some distributions, in this process and in those that it starts.

    Args:
        names: Names of the distributions.

    Raises:
        UnknownName: There is none of a name.
    """
    known = {canonical(distribution.name) for distribution in installation().distributions} - {OWN_NAME}
    for name in names:
        if canonical(name) not in known:
            raise UnknownName("distribution with plug-ins", name, known)
    before = os.environ.get(WITHOUT, "")
    os.environ[WITHOUT] = " ".join((before, *names))
    try:
        yield
    finally:
        os.environ[WITHOUT] = before


@contextmanager
def as_if_installed(project: Mapping[str, Any], source: Path) -> Iterator[None]:
    """Registers a package in this process, whether it is installed or not.

    Its modules that are imported meanwhile are unloaded at the end: they may have changed the next time.

    Args:
        project: The table ``[project]`` of its ``pyproject.toml``.
        source: The folder that its Python package is in.
    """
    before, loaded = list(sys.path), set(sys.modules)
    with tempfile.TemporaryDirectory(prefix="skiros-installed-") as site:
        _write_metadata(Path(site), project)
        sys.path[:0] = [site, str(source)]
        importlib.invalidate_caches()
        try:
            yield
        finally:
            sys.path[:] = before
            own = {path.stem for path in source.iterdir()}
            for name in [name for name in sys.modules if name.partition(".")[0] in own and name not in loaded]:
                del sys.modules[name]
            importlib.invalidate_caches()


def _write_metadata(site: Path, project: Mapping[str, Any]) -> None:
    """Writes the metadata of an installed package; they precede others of the same name."""
    name, version = str(project["name"]), str(project.get("version", "0"))
    info = site / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir()
    needs = "".join(f"Requires-Dist: {requirement}\n" for requirement in project.get("dependencies", ()))
    head = f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n"
    (info / "METADATA").write_text(head + needs, encoding="utf-8")
    groups = project.get("entry-points", {}).items()
    lines = (line for group, own in groups for line in (f"[{group}]", *(f"{k} = {v}" for k, v in own.items())))
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
