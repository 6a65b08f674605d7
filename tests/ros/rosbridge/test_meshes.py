"""Meshes over HTTP: those of the robot's packages, and no other file of the server."""

import asyncio
from pathlib import Path

import pytest

from tests.ros.rosbridge.bridged import TRIANGLE, bridged
from trajopt.ros.rosbridge import RobotDescription

NOT_GIVEN = (
    "/lab_description/secret.txt",
    "/lab_description/meshes/none.stl",
    "/lab_description/../outside.stl",
    "/lab_description/..%2foutside.stl",
    "/lab_description/%2e%2e/outside.stl",
    "/lab_description/meshes/../../outside.stl",
    "/lab_description//etc/passwd",
    "/lab_description/link.stl",
    "/lab_description/meshes",
    "/lab_description/%00.stl",
    "/lab_description/" + 5000 * "a" + ".stl",
    "//etc/passwd",
    "/other/meshes/look.stl",
    "/",
)


async def got(port: int, request: bytes) -> tuple[int, bytes]:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(request)
    whole = await asyncio.wait_for(reader.read(), 30.0)
    writer.close()
    head, _, body = whole.partition(b"\r\n\r\n")
    return int(head.split()[1]) if head else 0, body


def test_meshes_and_nothing_else(tmp_path: Path) -> None:
    async def run() -> None:
        async with bridged(tmp_path) as bridge:
            (tmp_path / "lab_description" / "link.stl").symlink_to(tmp_path / "outside.stl")

            async def get(path: str, host: str = "localhost", more: str = "") -> tuple[int, bytes]:
                return await got(
                    bridge.mesh_port, f"GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n".encode()
                )

            assert await get("/lab_description/meshes/look.stl") == (200, TRIANGLE)
            assert await get("/lab_description/meshes/look.stl?x=1") == (200, TRIANGLE)
            for path in NOT_GIVEN:
                status, body = await get(path)
                assert status in (400, 404, 414), path
                assert b"vertex" not in body and b"secret" not in body
            assert (await get("/lab_description/meshes/look.stl", "evil.example"))[0] == 403
            page = "Origin: https://evil.example\r\n"
            assert (await get("/lab_description/meshes/look.stl", more=page))[0] == 403
            for twice in ("Host: localhost", "Origin: https://a.example\r\nOrigin: https://b.example"):
                assert (await get("/lab_description/meshes/look.stl", more=f"{twice}\r\n"))[0] == 400
            for request in (
                b"POST / HTTP/1.1\r\nHost: localhost\r\n\r\n",
                b"\x00\xff\r\n\r\n",
                b"GET\r\n\r\n",
            ):
                assert (await got(bridge.mesh_port, request))[0] in (0, 400, 405, 426, 500, 501)
            assert await get("/lab_description/meshes/look.stl") == (200, TRIANGLE)

    asyncio.run(asyncio.wait_for(run(), 60.0))


def test_packages_are_those_of_the_robots_meshes(tmp_path: Path) -> None:
    package = tmp_path / "arm_description"
    package.mkdir()
    (package / "arm.stl").write_bytes(TRIANGLE)
    (tmp_path / "arm.urdf").write_text(
        "<robot name='a'><link name='l'><visual><geometry>"
        "<mesh filename='package://arm_description/arm.stl'/></geometry></visual></link></robot>"
    )
    described = RobotDescription.read(tmp_path / "arm.urdf", None, [tmp_path])
    assert dict(described.packages) == {"arm_description": package}
    assert described.srdf == ""
    assert described.file("arm_description/arm.stl") == package / "arm.stl"
    assert described.file("arm_description/../arm.urdf") is None


def test_refuses_a_description_that_is_not_text(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ValueError, match="cannot be read"):
        RobotDescription.read(tmp_path / "arm.urdf")
