"""Entry points are found by one look at the metadata, however broken these are; no code of a plug-in runs."""

from __future__ import annotations

import shutil
import sys
from importlib.metadata import entry_points
from typing import Any

import pytest

from skiros_py.plugins.installation import GROUPS, installation


@pytest.mark.parametrize("group", GROUPS)
def test_the_found_entry_points_match_those_of_the_standard_library(group: str) -> None:
    found = {(entry.name, entry.value) for entry in installation().of(group)}

    assert found == {(point.name, point.value) for point in entry_points(group=group)}


def test_finding_plug_ins_executes_no_code(site: Any) -> None:
    site.install("sk-explosive", {"skills": {"boom": "sk_explosive:X"}}, {"sk_explosive.py": "raise SystemExit"})

    (entry,) = (e for e in installation().of("skiros.skills") if e.name == "boom")

    assert str(entry) == "sk-explosive 0.3 (sk_explosive:X)"
    assert (entry.module, entry.attribute) == ("sk_explosive", "X")
    assert "sk_explosive" not in sys.modules


def test_distributions_installed_or_removed_at_run_time_are_noticed(site: Any) -> None:
    before = installation()
    info = site.install("sk-late", {"skills": {"late": "sk_late:X"}})

    assert {entry.name for entry in installation().entries} - {entry.name for entry in before.entries} == {"late"}

    shutil.rmtree(info)

    assert installation() == before


def test_partly_removed_metadata_does_not_hide_other_distributions(site: Any) -> None:
    (site.install("sk-half", {"skills": {"half": "sk_half:X"}}) / "METADATA").unlink()
    (site.install("sk-garbled", {"skills": {"x": "y"}}) / "entry_points.txt").write_bytes(b"[skiros.skills]\n\xff\xfe")
    (site.install("sk-empty", {"skills": {"x": "y"}}) / "entry_points.txt").unlink()
    site.install("sk-whole", {"skills": {"whole": "sk_whole:X"}})

    found = {entry.name: str(entry.distribution) for entry in installation().of("skiros.skills")}

    assert found["whole"] == "sk-whole 0.3"
    assert found["half"] == "sk_half (no version)"
    assert "x" not in found


def test_unreadable_entry_points_are_reported_with_their_origin(site: Any) -> None:
    info = site.install("sk-odd", {"skills": {"x": "y"}})
    (info / "entry_points.txt").write_text("[skiros.skills]\nno equals sign\n", encoding="utf-8")

    faults = installation().faults

    assert [(f.distribution, f.origin) for f in faults] == [("sk-odd 0.3", str(info))]
    assert "its entry_points.txt cannot be understood" in faults[0].reason


def test_the_first_distribution_with_a_name_on_the_path_is_used(
    site: Any, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    site.install("sk-twice", {"skills": {"new": "sk_twice:NEW"}}, version="2.0")
    older = type(site)(tmp_path_factory.mktemp("older"))
    older.install("sk_twice", {"skills": {"old": "sk_twice:OLD"}}, version="1.0")
    monkeypatch.setattr(sys, "path", [*sys.path, str(older.folder)])

    names = {entry.name for entry in installation().of("skiros.skills")}

    assert "new" in names
    assert "old" not in names
