"""compas_fab as it is installed from PyPI: a client made for ROS, run unchanged."""

import asyncio
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.ros.rosbridge.bridged import bridged
from trajopt.ros.rosbridge import Distro

pytest.importorskip("compas_fab")


def told(folder: Path, *words: str, distro: Distro = Distro.JAZZY) -> dict[str, Any]:
    """Return what the script of compas_fab got."""

    async def run() -> bytes:
        async with bridged(folder, distro=distro) as bridge:
            script = await asyncio.create_subprocess_exec(
                sys.executable,
                *(
                    "-m",
                    "tests.ros.rosbridge.compas_script",
                    str(bridge.port),
                    str(bridge.mesh_port),
                    *words,
                ),
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.PIPE,
            )
            out, err = await asyncio.wait_for(script.communicate(), 250.0)
            assert script.returncode == 0, err.decode()
            return out.splitlines()[-1]

    return json.loads(asyncio.run(run()))


@pytest.mark.parametrize("distro", Distro, ids=lambda distro: distro.title)
def test_it_loads_the_robot_and_plans(tmp_path: Path, distro: Distro) -> None:
    got = told(tmp_path, distro=distro)["basics"]
    assert (got["distro"], got["name"], got["group"]) == (distro.title, "lab", "arm")
    reach = 0.5 * np.exp(0.5j) + 0.5 * np.exp(1.5j)
    assert np.allclose(got["hand"], (reach.real, reach.imag, 0.1), atol=1e-6)
    assert np.allclose(got["end"], (1.0, 0.5, 0.0), atol=0.011) and got["duration"] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("distro", Distro, ids=lambda distro: distro.title)
def test_all_that_its_planner_and_its_client_do(tmp_path: Path, distro: Distro) -> None:
    got = told(tmp_path, "all", distro=distro)
    more, executed = got["more"], got["executed"]
    assert np.allclose(more["ik"], (0.5, 1.0, 0.2), atol=0.02)
    assert more["fraction"] == pytest.approx(1.0)
    assert 0.0 < more["partly"] < 1.0
    assert ["box", "hand"] in more["pairs"]
    assert more["blocked"]
    assert more["left"] == []
    assert executed["heard"] == ["MONITOR"]
    assert np.allclose(executed["where"], (1.0, 0.5, 0.0), atol=0.01)
    if distro is Distro.NOETIC:
        assert "done" in executed["result"]
