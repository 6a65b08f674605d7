"""Validity of a configuration: each reason is told, and only when it is true."""

import numpy as np
import pytest

import trajopt as to
from trajopt.optimise.kinematics import Validity, validity
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model

FREE = (-1.5, 0.1, 0.3, 0.0)


def test_a_free_configuration_is_valid(odd: ReducedModel) -> None:
    found = validity(odd, FREE, requirements=[to.joint_positions({"pan": -1.5})], margin=0.01)
    assert found.valid and not found.reasons and str(found) == "valid"
    assert found.as_dict()["valid"] is True


def test_every_reason_is_reported(odd: ReducedModel) -> None:
    tall = to.axis_alignment("tip", axis=(1, 0, 0), direction=(0, 0, 1), tolerance=0.1)
    found = validity(odd, (0.5, 0.1, 0.6, 4.0), requirements=[tall])
    text = str(found)
    assert not found.valid
    assert "mm inside block" in text or "block is" in text
    assert "wrist at 229.2 deg (4.0000 rad) is 57.3 deg outside [-171.9, 171.9] deg" in text
    assert "of tip" in text and "is accepted" in text
    assert found.as_dict()["reasons"] == list(found.reasons)


def test_the_margin_counts(odd: ReducedModel) -> None:
    nearest = validity(odd, FREE).examination.smallest
    assert nearest is not None and nearest.distance > 0.0
    wide = validity(odd, FREE, margin=2.0 * nearest.distance)
    assert not wide.valid and wide.too_near == nearest
    assert "the margin is" in str(wide)
    assert validity(odd, FREE, margin=0.5 * nearest.distance).valid


def test_misuse_is_named(odd: ReducedModel) -> None:
    with pytest.raises(to.TrajoptError, match="margin: is negative"):
        validity(odd, FREE, margin=-0.1)
    with pytest.raises(to.TrajoptError, match="positions: needs shape"):
        validity(odd, (0.0, 0.0))
    with pytest.raises(to.TrajoptError, match="not finite"):
        validity(odd, (0.0, 0.0, np.nan, 0.0))
    with pytest.raises(to.TrajoptError, match="no frame named 'tipp'"):
        validity(odd, FREE, requirements=[to.frame_placement("tipp", to.placement())])


def test_dynamic_obstacles_are_named_and_checked_at_one_time() -> None:
    arm = to.load("planar2")
    tip = to.Scene(arm).placement_of("tool", arm.positions())
    motion = to.Track.constant_velocity(to.placement((0.0, 1.0, 0.0)) * tip, (0.0, -1.0, 0.0))
    scene = to.Scene(arm).add("cart", to.Box(0.1, 0.1, 0.1), motion=motion)
    start = arm.positions()

    def judged(scene: to.Scene) -> Validity:
        return validity(reduce_model(scene, "arm", start), start)

    beside = judged(scene)
    assert beside.valid and beside.left_out == ("cart",) and "changes with time: cart" in str(beside)
    assert judged(scene.still_at(0.0)).valid and not judged(scene.still_at(0.0)).left_out
    there = judged(scene.still_at(1.0))
    assert not there.valid and "cart" in there.reasons[0]
