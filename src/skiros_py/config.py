"""Where ontologies and scenes are found."""

from __future__ import annotations

import errno
import os
import re
import stat
from collections.abc import Iterator
from pathlib import Path

from skiros_py.errors import FileError, UnknownName, UsageError
from skiros_py.files import RDF_TYPES
from skiros_py.plugins.installation import has_bare_name, installation
from skiros_py.plugins.loading import files_of
from skiros_py.plugins.plugin import Entry, PluginFault, qualified

SCENE_SUFFIXES = tuple(RDF_TYPES)
"""How the names of scene files end; of two files of one name the first kind counts."""

_PACKAGE = Path(__file__).parent
SCENE_NAME = r"(?:[a-z0-9-]{1,64}\.)?[A-Za-z0-9][A-Za-z0-9_-]{0,63}"
"""The form of the name of a scene: its own, perhaps qualified by its distribution."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")
_LONGEST_SHOWN = 80
_NO_FILES = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


ONTOLOGIES = "SKIROS_ONTOLOGIES"
"""Environment variable with more folders of :func:`ontology_paths`, separated by ':'."""
IMPORTS = "SKIROS_IMPORTS"
"""Environment variable with the folders of :func:`import_paths`, separated by ':'."""


def ontology_paths() -> tuple[Path, ...]:
    """Returns the folders whose files make the ontology; ``SKIROS_ONTOLOGIES`` adds more, separated by ':'.

    Plug-ins bring more: :func:`~skiros_py.world.ontology.load_installed` adds them.
    """
    return (_folder("ontologies"), *_from_environment(ONTOLOGIES))


def import_paths() -> tuple[Path, ...]:
    """Returns the folders in which imported ontologies are looked up: of ``SKIROS_IMPORTS``, and that of the package.

    A file in them counts only where it is imported.
    """
    return (*_from_environment(IMPORTS), _folder("ontologies"))


def scene_paths() -> tuple[Path, ...]:
    """Returns the folders with scenes; ``SKIROS_SCENES`` adds more, separated by ':'.

    Plug-ins bring more: entry points of the group ``skiros.scenes`` name packages with scenes, or a file.
    """
    return (*_from_environment("SKIROS_SCENES"), _folder("scenes"))


def scene_names() -> tuple[str, ...]:
    """Returns the names of all scenes; no plug-in is loaded for it."""
    return tuple(sorted({file.stem for folder in scene_paths() for file in _scenes_in(folder)} | set(plugin_scenes())))


def _scenes_in(folder: Path) -> Iterator[Path]:
    files = (file for suffix in SCENE_SUFFIXES for file in folder.glob(f"*{suffix}"))
    yield from (file for file in files if _NAME.fullmatch(file.stem) and _is_file(file) and _is_within(file))


def find_scene(scene: str) -> Path:
    """Returns the file of a scene, given by name or by path: what ends in one of :data:`SCENE_SUFFIXES` is a path.

    Raises:
        UnknownName: There is no scene of that name.
        UsageError: It can be neither a name nor a path.
        FileError: There is no such file.
    """
    return _scene_file(scene) if scene.endswith(SCENE_SUFFIXES) else named_scene(scene)


def named_scene(name: str) -> Path:
    """Returns the file of a scene given by name: one in the scene folders or of a plug-in, never one elsewhere.

    Raises:
        UnknownName: There is no scene of that name.
        UsageError: It cannot be a name; or the plug-in that it is from is broken.
        FileError: Its file is a symbolic link out of the scene folders.
    """
    if not re.fullmatch(SCENE_NAME, name) or name.endswith(SCENE_SUFFIXES):
        raise UsageError(
            f"{_shown(name)} is no name of a scene: a name is made of letters, digits, '_' and '-' (64 at most, the"
            f" first a letter or digit); the path of a file must end in {' or '.join(SCENE_SUFFIXES)}"
        )
    for folder in scene_paths():
        for file in (folder / f"{name}{suffix}" for suffix in SCENE_SUFFIXES):
            if _is_file(file):
                if not _is_within(file):
                    raise FileError(file, f"is a symbolic link out of {folder}; give the path of the file it leads to")
                return file
    return _plugin_scene(name)


def _plugin_scene(name: str) -> Path:
    entry = plugin_scenes().get(name)
    if entry is None:
        raise UnknownName("scene", name, scene_names())
    places, own_name = files_of(entry), name.rpartition(".")[2]
    if isinstance(places, PluginFault):
        raise UsageError(str(places))
    candidates = (p if _is_file(p) else p / f"{own_name}{suffix}" for p in places for suffix in SCENE_SUFFIXES)
    for file in candidates:
        if file.suffix in SCENE_SUFFIXES and _is_file(file):
            return file
    raise UsageError(f"scene '{name}' of {entry}: there is no scene file {places[0]}")


def plugin_scenes() -> dict[str, Entry]:
    """Returns who brings each scene: an entry point for an object one of its own name, one for a package all in it.

    A name that is also that of another distribution's, or of a file in the scene folders, is qualified.
    """
    claims: dict[str, list[Entry]] = {}
    for entry in installation().of("skiros.scenes"):
        for name in [entry.own_name] if entry.attribute else _names_in_package(entry):
            claims.setdefault(name, []).append(entry)
    taken = {file.stem for folder in scene_paths() for file in _scenes_in(folder)}
    found: dict[str, Entry] = {}
    for name, entries in claims.items():
        for entry in entries:
            source, holders = str(entry.distribution), {str(one.distribution) for one in entries}
            alone = name not in taken and has_bare_name(source, holders)
            found.setdefault(name if alone else qualified(name, source), entry)
    return found


def _names_in_package(entry: Entry) -> set[str]:
    places = files_of(entry)
    return set() if isinstance(places, PluginFault) else {file.stem for p in places for file in _scenes_in(p)}


def _scene_file(path: str) -> Path:
    if not path.isprintable():
        raise UsageError(f"{_shown(path)} is no path of a scene: it has characters that cannot be printed")
    file = Path(path)
    if _is_file(file):
        return file
    known = ", ".join(scene_names())
    raise FileError(Path(path[-_LONGEST_SHOWN:]), f"the scene file {_what_it_is(file)}; scenes known by name: {known}")


def _what_it_is(path: Path) -> str:
    """Says of what is no file why it is none."""
    try:
        mode = path.stat().st_mode
    except OSError as error:
        if error.errno == errno.ELOOP:
            return "is a link that leads round in circles"
        if error.errno == errno.EACCES:
            return "cannot be reached: permission denied"
        return "is a link to a file that does not exist" if os.path.islink(path) else "does not exist"  # noqa: PTH114
    kind = next((name for is_one, name in _NO_FILES if is_one(mode)), "something else")
    return f"is {kind}, not a file"


def _is_file(path: Path) -> bool:
    return os.path.isfile(path)  # noqa: PTH113  Path.is_file() raises for long names


def _is_within(file: Path) -> bool:
    real = Path(os.path.realpath(file))  # Path.resolve() raises where links lead round in circles
    return real.is_relative_to(os.path.realpath(file.parent))


def _shown(text: str) -> str:
    return repr(text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}…")


def _folder(name: str) -> Path:
    """Returns a data folder: inside the installed package, or beside ``src`` in a checkout."""
    installed = _PACKAGE / "data" / name
    return installed if installed.is_dir() else _PACKAGE.parents[1] / name


def _from_environment(variable: str) -> tuple[Path, ...]:
    return tuple(Path(part) for part in os.environ.get(variable, "").split(":") if part)
