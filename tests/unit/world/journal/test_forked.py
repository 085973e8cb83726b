"""A journal and processes that were copied from the one that opened it."""

from __future__ import annotations

import os
from pathlib import Path

from skiros_py.errors import FileError
from skiros_py.station.worlds import open_data


def test_a_forked_process_cannot_write_to_the_world_of_its_parent(tmp_path: Path) -> None:
    with open_data(tmp_path / "data", "kitting") as data:
        child = os.fork()
        if child == 0:
            try:
                with data.world.transaction("child", "writes") as tx:
                    tx.place("starter_1", "sk:in", "pallet_b")
            except FileError as error:
                os._exit(7 if "a copy of that cannot write" in str(error) else 8)
            os._exit(9)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7

        with data.world.transaction("parent", "goes on") as tx:
            tx.place("starter_1", "sk:in", "pallet_b")
        assert data.world.version == 2
