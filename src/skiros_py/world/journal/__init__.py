"""The journal: a world in a data directory, from which nothing that was acknowledged is lost."""

from skiros_py.world.journal.data_directory import DataDirectory
from skiros_py.world.journal.journal import Journal
from skiros_py.world.journal.records import Entry

__all__ = ["DataDirectory", "Entry", "Journal"]
