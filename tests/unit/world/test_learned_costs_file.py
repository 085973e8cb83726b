"""Learned costs are written to ``learned.ttl`` beside the thread that learns, and survive a restart."""

from __future__ import annotations

from pathlib import Path

from skiros_py.planning.experience import observe, records
from skiros_py.testing.tiny import DRIVE, tiny_ontology, tiny_scene
from skiros_py.world.journal.data_directory import DataDirectory


def test_what_was_learned_survives_a_restart_and_is_in_the_file(tmp_path: Path) -> None:
    scene = tiny_scene(tmp_path)
    with DataDirectory.open(tmp_path / "data", tiny_ontology(), scene=scene) as data:
        for _ in range(20):
            observe(data.world, DRIVE, "base_1", {"Base": "base_1", "Location": "box_a"}, 4.0, is_success=False)
        kept = [element.properties for element in records(data.world)]

    assert "sk:failedTimes" in (tmp_path / "data" / "learned.ttl").read_text()
    with DataDirectory.open(tmp_path / "data", tiny_ontology()) as data:
        assert [element.properties for element in records(data.world)] == kept
    assert not list((tmp_path / "data").glob("learned.ttl.kept-*"))
