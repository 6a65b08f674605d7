"""Modules that were renamed in version 0.2."""

import sys
from collections.abc import Mapping, Sequence
from types import ModuleType

MOVED: Mapping[str, str] = {
    "arrays": "values.arrays",
    "benchmark": "lab.suite",
    "bundle": "files.bundle",
    "campaign": "lab.campaign",
    "cartesian": "tasks.cartesian",
    "client": "server.client",
    "commander": "ros.commander",
    "driving.gamepad": "driving.servo_input",
    "driving.random_surprise": "driving.surprises",
    "driving.recording_file": "driving.recording",
    "driving.servo_stream": "driving.servo_input",
    "errors": "values.errors",
    "execution": "driving",
    "experience": "planning.experience",
    "explanation": "why",
    "export": "files.export",
    "grasping": "tasks.grasping",
    "infeasibility": "planning.infeasibility",
    "io": "values.documents",
    "kinematics": "optimise.kinematics",
    "messages": "files.messages",
    "methods": "optimise.methods",
    "model": "robot",
    "model.clouds": "values.shapes.clouds",
    "model.curve": "values.curve",
    "model.limits": "robot.joints",
    "model.placement": "values.placement",
    "model.requirements": "problem.requirements",
    "model.scene": "scene.scene",
    "model.shapes": "values.shapes",
    "model.trajectory": "values.trajectory",
    "moveit": "files.moveit",
    "nlp": "optimise.nlp",
    "perception": "lab.perception",
    "query": "geometry",
    "report": "viewer.report",
    "retime": "timing",
    "seeds": "planning.seeds",
    "server.rosbridge": "ros.rosbridge",
    "solvers": "optimise.solvers",
    "srdf_assistant": "lab.srdf",
    "terms": "optimise.terms",
    "transcription": "optimise.transcription",
    "warehouse": "server.warehouse",
}
"""Old name -> new name, both below `trajopt`. To be removed in version 0.3."""


def new_name(old: str) -> str | None:
    """Return the new name of a renamed module `trajopt.*`; None for any other name."""
    parts = old.split(".")[1:]
    for count in range(len(parts), 0, -1):
        moved = MOVED.get(".".join(parts[:count]))
        if moved is not None:
            return ".".join(("trajopt", moved, *parts[count:]))
    return None


class _MovedFinder:
    """Last finder of Python's import system: it sees only modules that do not exist."""

    @staticmethod
    def find_spec(fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> None:
        del path, target
        new = new_name(fullname) if fullname.startswith("trajopt.") else None
        if new is not None:
            raise ModuleNotFoundError(f"{fullname} is now {new}", name=fullname)


def watch_imports() -> None:
    """Make imports of old names raise an error with the new name."""
    if _MovedFinder not in sys.meta_path:
        sys.meta_path.append(_MovedFinder)
