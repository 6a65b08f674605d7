"""Tags a Linux wheel with the oldest C library that its extension modules run on.

python packaging/glibc_tag.py WHEEL

The tag follows from the versions of the symbols that the modules take from libc and libstdc++. The libraries
of pin and coal are not copied in: pip installs them as wheels, and the modules find them by their RUNPATH.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path
from zipfile import ZipFile

GLIBCXX = {19: 17, 24: 28, 28: 31, 29: 34, 30: 35, 32: 38, 33: 39}
"""y by x: systems of manylinux_2_y have symbols up to GLIBCXX_3.4.x, by auditwheel's policies."""
OURS = ("libpinocchio", "libcoal", "libboost_")
"""Beginnings of the libraries that come with the wheels of pin and coal."""
EVERYWHERE = ("libstdc++", "libm.", "libgcc_s", "libc.", "ld-linux", "libpthread", "libdl", "librt")
"""Beginnings of the libraries that every manylinux system has."""
CORES = Path(__file__).parents[1] / "trajopt" / "native" / "CMakeLists.txt"
"""States the extension modules that a wheel must hold."""


def needs(module: Path) -> tuple[int, set[str]]:
    """Return y of the oldest manylinux_2_y that runs an extension module, and the libraries that it loads."""
    listed = subprocess.run(["objdump", "-p", str(module)], capture_output=True, text=True, check=True).stdout
    glibc = [int(minor) for minor in re.findall(r"GLIBC_2\.(\d+)", listed)]
    glibcxx = max((int(minor) for minor in re.findall(r"GLIBCXX_3\.4\.(\d+)", listed)), default=0)
    by_cxx = [minor for newest, minor in GLIBCXX.items() if newest >= glibcxx]
    if not by_cxx:
        raise SystemExit(f"{module.name} needs GLIBCXX_3.4.{glibcxx}, which is newer than this table")
    if "$ORIGIN/../../cmeel.prefix/lib" not in listed and any(name in listed for name in OURS):
        raise SystemExit(f"{module.name} would not find the libraries of pin and coal")
    return max(*glibc, min(by_cxx), 17), set(re.findall(r"NEEDED\s+(\S+)", listed))


def stated() -> set[str]:
    """Return the names of the native cores that are built."""
    return set(re.findall(r"^native_core\((\w+)", CORES.read_text(), re.MULTILINE))


def main(wheel: Path) -> None:
    """Tag a wheel in place."""
    if not wheel.name.endswith(("linux_x86_64.whl", "linux_aarch64.whl")):
        print(f"{wheel.name} is not for Linux: its tag stays")
        return
    minor, libraries = 17, set[str]()
    with tempfile.TemporaryDirectory() as folder, ZipFile(wheel) as archive:
        modules = [name for name in archive.namelist() if name.endswith(".so")]
        for name in modules:
            needed, loaded = needs(Path(archive.extract(name, folder)))
            minor, libraries = max(minor, needed), libraries | loaded
    foreign = [name for name in sorted(libraries) if not name.startswith((*OURS, *EVERYWHERE))]
    lacks = sorted(stated() - {Path(name).name.split(".")[0] for name in modules})
    if lacks or foreign:
        raise SystemExit(f"native cores that it lacks: {lacks}; unexpected libraries: {foreign}")
    machine = wheel.stem.split("linux_")[-1]
    tag = f"manylinux_2_{minor}_{machine}"
    subprocess.run(
        [sys.executable, "-m", "wheel", "tags", "--remove", "--platform-tag", tag, str(wheel)], check=True
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
