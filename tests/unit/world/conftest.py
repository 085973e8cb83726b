"""The shipped ontologies and the shipped scene."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.world.ontology import Ontology
from skiros_py.world.scene.files import load_scene
from skiros_py.world.world import World

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def ontology() -> Ontology:
    return Ontology.load([ROOT / "ontologies"])


@pytest.fixture
def world(ontology: Ontology) -> World:
    return load_scene(ontology, ROOT / "scenes" / "kitting.ttl")
