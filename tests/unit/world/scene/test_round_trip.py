"""A scene saved is the scene loaded, whatever is in it."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings

from skiros_py.world.scene import diff, learned_turtle, load_scene, read_learned, save_scene
from skiros_py.world.scene.writer import scene_turtle
from skiros_py.world.world import World

from .worlds import ONTOLOGY, same, worlds
