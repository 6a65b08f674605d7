"""Uncertain: whose place is known too badly to go on."""

from trajopt.driving.guard import Seen


def grow_uncertain(world: Seen) -> bool:
    """Say whether the place of something is known worse and worse."""
    timings = (world.scene.objects[name].timing for name in world.scene.changing)
    return any(timing.motion is not None and any(timing.motion.error[1:]) for timing in timings)


def too_uncertain(world: Seen, time: float) -> str:
    """Say how well it is known where things are at a time on the executor's clock [s], the worst first.

    Args:
        world: What is known of the world.
        time: When the robot would go on [s].
    """
    since, objects = time - world.stamp, world.scene.objects
    errors = {
        name: motion.error_at(since)
        for name in world.scene.changing
        if (motion := objects[name].timing.motion) is not None and any(motion.error[1:])
    }
    worst = sorted(errors, key=lambda name: -errors[name])
    said = [f"{name} to within {1e3 * errors[name]:.0f} mm" for name in worst]
    seen = f"what was seen {since:.2f} s before is known too badly to go on"
    return f"{seen}: {', '.join(said)}" if said else "what comes next is not proven yet"
