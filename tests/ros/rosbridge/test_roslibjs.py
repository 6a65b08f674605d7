"""roslibjs as it is installed from npm: a client made for ROS, in JavaScript, run unchanged."""

import asyncio
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.ros.rosbridge.bridged import bridged

SCRIPT = Path(__file__).with_name("roslib_script.mjs")
ROSLIB = "roslib@2.1.0"


@pytest.mark.slow
def test_it_plans_and_drives(tmp_path: Path) -> None:
    npm = shutil.which("npm")
    if npm is None or shutil.which("node") is None:
        pytest.skip("node and npm are not installed")
    words = (npm, "install", "--no-audit", "--no-fund", "--prefix", tmp_path, ROSLIB)
    installed = subprocess.run(words, capture_output=True, text=True, check=False, timeout=200.0)
    if installed.returncode:
        pytest.skip(f"{ROSLIB} cannot be installed: {installed.stderr[-200:]}")
    script = tmp_path / SCRIPT.name
    script.write_text(SCRIPT.read_text())

    async def run() -> bytes:
        async with bridged(tmp_path / "robot") as bridge:
            pipes = {"stdout": asyncio.subprocess.PIPE, "stderr": asyncio.subprocess.PIPE}
            node = await asyncio.create_subprocess_exec("node", script, str(bridge.port), **pipes)
            out, err = await asyncio.wait_for(node.communicate(), 100.0)
            assert node.returncode == 0, err.decode()
            return out

    told = json.loads(asyncio.run(run()))
    assert told["urdf"] == "<robot" and told["joints"] == ["shoulder", "elbow", "wrist"]
    assert "/joint_states" in told["topics"]
    assert told["code"] == 1 and np.allclose(told["end"], (1.0, 0.5, 0.0), atol=0.011)
    assert "has no field 'fk_link_name'" in told["refused"]
    assert told["executed"]["error_code"]["val"] == 1 and told["feedback"] == ["MONITOR"]
