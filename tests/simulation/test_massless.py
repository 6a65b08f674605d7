"""Robots without inertias are played without dynamics."""

import numpy as np

import trajopt as to


def moved(scene: to.Scene) -> to.Result:
    return to.plan(to.Problem(scene=scene, group="arm", start=(0.0, 0.0), goal=(0.4, 0.3)))


def test_plays_a_plan_without_dynamics(planar_arm: to.Robot) -> None:
    plan = moved(to.Scene(robot=planar_arm)).require()
    rollout = to.simulate(plan)
    assert not rollout.dynamic
    assert any("moves no mass" in note for note in rollout.notes)
    assert "without dynamics" in rollout.summary()
    np.testing.assert_allclose(
        rollout.positions, plan.trajectory(np.minimum(rollout.times, plan.trajectory.duration)), atol=1e-12
    )
    np.testing.assert_allclose(rollout.torques, 0.0)
    assert rollout.contacts == ()


def test_finds_contacts_without_dynamics(planar_arm: to.Robot) -> None:
    plan = moved(to.Scene(robot=planar_arm)).require()
    elbow = plan.problem.scene.placement_of("fore", plan)
    blocked = to.Scene(robot=planar_arm).add("ball", to.Sphere(0.1), elbow)
    rollout = to.simulate(
        to.Problem(scene=blocked, group="arm", start=(0.0, 0.0), goal=(0.4, 0.3)).reduced, plan.trajectory
    )
    assert any("ball" in contact.pair for contact in rollout.contacts)


def test_a_robot_with_masses_is_moved_by_its_motors() -> None:
    assert to.simulate(moved(to.Scene(robot=to.load("planar2")))).dynamic
