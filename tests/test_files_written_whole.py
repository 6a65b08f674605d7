"""A file that is written is there as a whole: also where two write it at once, or one fails in the midst."""

import os
import zipfile
from pathlib import Path
from typing import Any

import pytest

from trajopt.files.bundle.containers import Archive, write_archive
from trajopt.values.documents.document import write_text
from trajopt.values.errors import FileFormatError


def test_two_concurrent_writers_leave_one_whole_bundle(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target, begun, written = tmp_path / "x.trajopt", list[str](), zipfile.ZipFile.writestr

    def in_the_midst(file: zipfile.ZipFile, item: zipfile.ZipInfo, data: bytes) -> Any:
        done = written(file, item, data)
        if not begun:
            begun.append("the other")
            write_archive(target, {"a": b"2" * 1000, "b": b"2" * 10})
        return done

    monkeypatch.setattr(zipfile.ZipFile, "writestr", in_the_midst)
    write_archive(target, {"a": b"1" * 1000, "b": b"1" * 10})
    found = Archive(target)
    assert (found.read("a"), found.read("b")) == (b"1" * 1000, b"1" * 10)
    assert [each.name for each in tmp_path.iterdir()] == [target.name]


def test_two_concurrent_writers_leave_one_whole_text(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target, begun, written = tmp_path / "x.json", list[str](), Path.write_text

    def in_the_midst(path: Path, text: str, **options: Any) -> int:
        done = written(path, text, **options)
        if not begun:
            begun.append("the other")
            write_text(target, "second")
        return done

    monkeypatch.setattr(Path, "write_text", in_the_midst)
    write_text(target, "first")
    assert target.read_text() == "first"
    assert [each.name for each in tmp_path.iterdir()] == [target.name]


@pytest.mark.parametrize("name", ["x" * 250, "x\0y", "folder/\0", "/"])
def test_a_name_that_no_file_can_have_is_refused_and_a_long_one_is_written(tmp_path: Path, name: str) -> None:
    if name.startswith("x" * 250):
        write_text(tmp_path / name, "long")
        assert (tmp_path / name).read_text() == "long"
        return
    with pytest.raises(FileFormatError, match="cannot be written"):
        write_text(tmp_path / name, "text")


def test_an_interrupted_write_keeps_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "x.trajopt"
    write_archive(target, {"a": b"old"})

    def fails(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(zipfile.ZipFile, "writestr", fails)
    with pytest.raises(MemoryError):
        write_archive(target, {"a": b"new"})
    assert Archive(target).read("a") == b"old"
    assert [each.name for each in tmp_path.iterdir()] == [target.name]


def test_a_device_and_a_folder_are_refused_and_a_link_is_followed(tmp_path: Path) -> None:
    pipe, folder, link = (tmp_path / name for name in ("pipe", "folder", "link"))
    os.mkfifo(pipe)
    folder.mkdir()
    for each in pipe, folder:
        with pytest.raises(FileFormatError, match="cannot be written: it is a folder or a device"):
            write_text(each, "text")
    link.symlink_to("target")
    write_text(link, "text")
    assert link.is_symlink() and (tmp_path / "target").read_text() == "text" and pipe.is_fifo()
