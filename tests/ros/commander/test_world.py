"""The world that names belong to."""

import threading

import numpy as np
import pytest

import trajopt as to
from tests.ros.commander.jumping import JumpingExecutor
from trajopt.ros.commander import (
    MoveGroupCommander,
    MoveItCommanderException,
    PlanningSceneInterface,
    RobotCommander,
    World,
    roscpp_initialize,
    roscpp_shutdown,
)


def test_blocks_within_blocks(lab_arm: to.Robot) -> None:
    outer, inner = World(lab_arm), World(lab_arm)
    with outer:
        assert RobotCommander().world is outer
        with inner:
            assert RobotCommander().world is inner
            assert RobotCommander(world=outer).world is outer
        assert RobotCommander().world is outer


@pytest.mark.parametrize("kind", [RobotCommander, PlanningSceneInterface, lambda: MoveGroupCommander("arm")])
def test_without_a_world(kind: type) -> None:
    with pytest.raises(MoveItCommanderException, match="Put the script into a block `with World"):
        kind()


def test_every_group_starts_in_its_first_named_state(lab_arm: to.Robot) -> None:
    assert World(lab_arm).positions.tolist() == [0.5, -1.0, 0.2]
    assert World(lab_arm, start="straight").positions.tolist() == [0.0, 0.0, 0.0]
    assert World(lab_arm, start={"elbow": 0.3}).positions.tolist() == [0.0, 0.3, 0.0]


def test_misuse(lab_arm: to.Robot, planar_arm: to.Robot) -> None:
    with pytest.raises(MoveItCommanderException, match="no installed robot or URDF file named 'pandar'"):
        World("pandar")
    with pytest.raises(MoveItCommanderException, match="the scene is one of 'planar_arm', not of 'lab'"):
        World(lab_arm, scene=to.Scene(planar_arm))
    with pytest.raises(MoveItCommanderException, match="a start or an executor"):
        World(lab_arm, start="bent", executor=JumpingExecutor(lab_arm.positions("bent")))
    with pytest.raises(MoveItCommanderException, match=r"\(did you mean 'arm'\?\); there are: arm"):
        MoveGroupCommander("am", world=World(lab_arm))
    with pytest.raises(MoveItCommanderException) as caught:
        World(lab_arm, start="bnet")
    assert isinstance(caught.value.__cause__, to.errors.StateNotFound)


def test_edits_from_many_threads_are_all_kept(lab_arm: to.Robot) -> None:
    world = World(lab_arm)

    def add(name: str) -> None:
        world.edit(lambda scene: scene.add(name, to.Sphere(0.01), to.placement((5, 5, 5))))

    threads = [threading.Thread(target=add, args=(f"ball{count}",)) for count in range(20)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(world.scene.objects) == 20


def test_leaving_the_block_stops_the_robot(lab_arm: to.Robot) -> None:
    with World(lab_arm) as world:
        MoveGroupCommander("arm").go("straight", wait=False)
    assert not world.moving
    assert np.abs(world.positions - lab_arm.positions("bent")).max() < 0.2


def test_starting_the_middleware_does_nothing() -> None:
    roscpp_initialize(["script.py"])
    roscpp_shutdown()
