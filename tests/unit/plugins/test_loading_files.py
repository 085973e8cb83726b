"""Entry points for ontologies, robots and scenes name a package or a Path; for a package no code is run."""

from __future__ import annotations

import zipfile
from typing import Any

import pytest

from skiros_py.plugins.installation import installation
from skiros_py.plugins.loading import files_of
from skiros_py.plugins.plugin import PluginFault

BREAKS = "raise SystemExit"


def named(group: str = "robots") -> Any:
    (entry,) = (entry for entry in installation().of(f"skiros.{group}") if entry.name == "own")
    return files_of(entry)


@pytest.mark.parametrize(
    ("value", "files", "folder"),
    [
        ("sk_fa", {"sk_fa/__init__.py": BREAKS, "sk_fa/robots/r.ttl": ""}, "sk_fa/robots"),
        ("sk_fb", {"sk_fb/__init__.py": BREAKS, "sk_fb/r.ttl": ""}, "sk_fb"),
        ("sk_fc", {"sk_fc/r.ttl": ""}, "sk_fc"),
        ("sk_fd.data", {"sk_fd/__init__.py": BREAKS, "sk_fd/data.py": BREAKS, "sk_fd/r.ttl": ""}, "sk_fd"),
        ("sk_fe.deep", {"sk_fe/__init__.py": BREAKS, "sk_fe/deep/r.ttl": ""}, "sk_fe/deep"),
        ("sk_ff:HERE", {"sk_ff.py": "import pathlib\nHERE = pathlib.Path(__file__).parent / 'x'"}, "x"),
        (
            "sk_fg:HERE",
            {"sk_fg/__init__.py": "from importlib.resources import files\nHERE = files(__name__) / 'y'"},
            "sk_fg/y",
        ),
        (
            "sk_fh:HERE",
            {"sk_fh.py": "from importlib.resources import files\nHERE = files('sk_fi')", "sk_fi/r.ttl": ""},
            "sk_fi",
        ),
    ],
)
def test_an_entry_point_gives_the_folder_of_its_files(
    site: Any, value: str, files: dict[str, str], folder: str
) -> None:
    site.install("sk-files", {"robots": {"own": value}}, files)

    assert named() == (site.folder / folder,)


@pytest.mark.parametrize(
    ("value", "files", "says"),
    [
        ("sk_fj", {"sk_fj.py": ""}, "sk_fj is a module by itself and has no folder: name a package, or a Path"),
        ("sk_fk:X", {"sk_fk.py": "X = 'a/b.ttl'"}, "it is a str, nothing for robots: name a package, or a Path"),
        ("sk_fl:X", {"sk_fl.py": BREAKS}, "SystemExit: "),
        ("sk_fm", {}, "there is no package 'sk_fm': the entry point is stale; install sk-files again, or uninstall it"),
        ("sk_fn.deep", {"sk_fn/__init__.py": ""}, "there is no package 'sk_fn.deep': the entry point is stale"),
    ],
)
def test_an_entry_point_without_files_is_reported(site: Any, value: str, files: dict[str, str], says: str) -> None:
    site.install("sk-files", {"robots": {"own": value}}, files)

    fault = named()

    assert isinstance(fault, PluginFault)
    assert fault.reason.startswith(says)
    assert (fault.group, fault.name, fault.distribution) == ("skiros.robots", "own", "sk-files 0.3")


def test_files_in_an_archive_are_refused(site: Any) -> None:
    with zipfile.ZipFile(site.folder / "packed.zip", "w") as archive:
        archive.writestr("robots/r.ttl", "")
    code = "import zipfile, pathlib\nX = zipfile.Path(pathlib.Path(__file__).parent / 'packed.zip')"
    site.install("sk-files", {"robots": {"own": "sk_fo:X"}}, {"sk_fo.py": code})

    fault = named()

    assert isinstance(fault, PluginFault)
    assert fault.reason.endswith("lies in an archive: it must be files")
