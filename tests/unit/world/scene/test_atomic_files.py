"""A file is written whole, or stays as it was."""

from __future__ import annotations

import resource
import subprocess
import sys
from pathlib import Path

import pytest

from skiros_py.errors import FileError
from skiros_py.world.scene.files import write_atomically

ON_A_SMALL_DISK = """
import resource, signal, sys
from pathlib import Path
from skiros_py.errors import FileError
from skiros_py.world.scene.files import write_atomically
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
try:
    write_atomically(Path(sys.argv[1]), "x" * 5000)
except FileError as error:
    print(error)
"""


def test_writing_a_file_leaves_no_other_file(tmp_path: Path) -> None:
    write_atomically(tmp_path / "new.ttl", "ä\u2028\r\n")

    assert (tmp_path / "new.ttl").read_bytes() == "ä\u2028\r\n".encode()
    assert [file.name for file in tmp_path.iterdir()] == ["new.ttl"]


def test_on_a_full_disk_the_old_file_is_kept_and_no_temporary_file_remains(tmp_path: Path) -> None:
    (tmp_path / "old.ttl").write_text("old", encoding="utf-8")

    told = subprocess.run(
        [sys.executable, "-c", ON_A_SMALL_DISK, str(tmp_path / "old.ttl")], capture_output=True, text=True, check=True
    )

    assert "old.ttl: cannot be written (File too large); nothing was changed" in told.stdout
    assert (tmp_path / "old.ttl").read_text(encoding="utf-8") == "old"
    assert [file.name for file in tmp_path.iterdir()] == ["old.ttl"]
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] != 1000


@pytest.mark.parametrize("mode", [0o644, 0o664, 0o600])
def test_the_permissions_of_the_old_file_are_kept(tmp_path: Path, mode: int) -> None:
    file = tmp_path / "old.ttl"
    file.touch()
    file.chmod(mode)

    write_atomically(file, "new")

    assert file.stat().st_mode & 0o777 == mode


def test_a_new_file_has_default_permissions(tmp_path: Path) -> None:
    (tmp_path / "other").touch()

    write_atomically(tmp_path / "new.ttl", "new")

    assert (tmp_path / "new.ttl").stat().st_mode == (tmp_path / "other").stat().st_mode


def test_writing_through_a_symbolic_link_keeps_the_link(tmp_path: Path) -> None:
    (tmp_path / "real.ttl").write_text("old", encoding="utf-8")
    (tmp_path / "link.ttl").symlink_to("real.ttl")

    write_atomically(tmp_path / "link.ttl", "new")

    assert (tmp_path / "link.ttl").is_symlink()
    assert (tmp_path / "real.ttl").read_text(encoding="utf-8") == "new"


@pytest.mark.parametrize("name", ["nowhere/new.ttl", "file/new.ttl", "folder", "x" * 300 + ".ttl", "nul\0.ttl"])
def test_a_failed_write_raises_a_file_error_and_leaves_no_temporary_file(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()

    with pytest.raises(FileError, match="cannot be written"):
        write_atomically(tmp_path / name, "new")

    assert sorted(file.name for file in tmp_path.iterdir()) == ["file", "folder"]
