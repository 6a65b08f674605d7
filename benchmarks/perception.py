"""Depth images to scenes: cost, accuracy of MuJoCo's depths, and unknown shelves.

python -m benchmarks.perception DATA [--shelves N] [--images N] [--json FILE] [--page FILE]

DATA is a folder of MotionBenchMaker with panda/<set>/, for the still plans that the images are compared with.
"""

import argparse
import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import process_time

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from benchmarks.shelves import EYE, Shelf, looks, random_shelf
from trajopt.lab.perception import Camera, Cloud, DepthImage, Sensing, perceive, with_unseen
from trajopt.lab.suite.instance import find_instances
from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.scene.camera import Singles
from trajopt.simulation import DepthCamera, Flaws

FLAWS = Flaws(beyond=3.0, lost=0.01, edge=0.05, grazing=float(np.deg2rad(80.0)))
"""Noise within three standard deviations; pixels are lost anywhere, at edges and in grazing view."""
UNSEEN = 0.04
"""Edge of the cubes of unseen space [m]."""
CLEARANCE = 0.01
"""Asked for besides, as one would for errors of the camera's placement [m]."""


@dataclass(frozen=True)
class Reached:
    """One shelf, planned for with its seen part.

    Attributes:
        status: How planning ended.
        milliseconds: CPU time of planning [ms].
        balls: Of the clouds that it was planned among.
        clearance: From everything that is really there, proven along the motion [m]; None without a motion.
        contact: Whether the motion touches what is really there; None without a motion.
    """

    status: str
    milliseconds: float
    balls: int
    clearance: float | None
    contact: bool | None


def timed(
    images: Sequence[tuple[to.Scene, DepthImage, Sensing]], plans: Sequence[to.Problem]
) -> dict[str, list[float]]:
    """Return CPU times of images to scenes, and of still plans, taken in turn [ms]."""
    found: dict[str, list[float]] = {"image": [], "plan": []}
    for each in (*images[:2],):
        perceive(*each)
    to.plan(plans[0])
    for count in range(max(len(images), len(plans))):
        scene, image, sensing = images[count % len(images)]
        fresh = DepthImage(image.camera, np.array(image.depth), image.positions)
        begin = process_time()
        perceive(scene, fresh, sensing)
        found["image"].append(1e3 * (process_time() - begin))
        begin = process_time()
        to.plan(plans[count % len(plans)])
        found["plan"].append(1e3 * (process_time() - begin))
    return found


def exactness(scene: to.Scene, camera: Camera, positions: np.ndarray) -> tuple[float, float, float]:
    """Return how far drawn depths are off rays: median, 99th percentile [m], and the share beyond 1 mm."""
    with DepthCamera(scene, "panda_arm", camera) as eye:
        drawn = eye.exact(positions).ravel()
        assert eye._drawn is not None
        model, data = eye._drawn.model, eye._drawn.data
        where = camera.at(scene, positions)
        across, down = np.broadcast_arrays(*camera.intrinsics.slopes)
        rays = np.stack((across, down, np.ones_like(across)), axis=-1).reshape(-1, 3).astype(np.float64)
        count = len(rays)
        geoms, depth = np.empty(count, np.int32), np.empty(count)
        groups = np.array((0, 1, 1, 0, 0, 0), np.uint8)
        mujoco.mj_multiRay(
            model, data, where.translation, (rays @ where.rotation.T).ravel(), groups, True, -1, geoms, depth,
            None, count, 1e10,
        )  # fmt: skip
    both = np.isfinite(drawn) & (geoms >= 0)
    off = np.abs(drawn[both] - depth[both])
    return float(np.median(off)), float(np.percentile(off, 99)), float((off > 1e-3).mean())


def reach(
    shelf: Shelf, images: Sequence[DepthImage], positions: np.ndarray, *, unseen: bool, cell: float
) -> Reached:
    """Plan in the seen scene, and judge the motion in the true scene."""
    sensing = Sensing(workspace=shelf.workspace, cell=cell)
    seen = perceive(shelf.empty, list(images), sensing)
    scene = seen.scene.with_clearance(world=CLEARANCE)
    if unseen:
        scene = with_unseen(scene, list(images), sensing, cell=UNSEEN)
    problem = to.Problem(scene=scene, group="panda_arm", start=positions, goal=shelf.goal)
    begin = process_time()
    result = to.plan(problem)
    spent = 1e3 * (process_time() - begin)
    balls = sum(len(shape.points) if isinstance(shape, to.Points) else len(shape.keys)
                for item in scene.objects.values() for shape, _ in item.parts)  # fmt: skip
    if not result.verified:
        return Reached(result.status.name, spent, balls, None, None)
    truth = replace(problem, scene=shelf.truth)
    certificate = to.judge(truth, result.require().trajectory)
    clearance = float(certificate.clearance)
    return Reached(result.status.name, spent, balls, clearance, clearance <= 0.0)


def taken(shelf: Shelf, stands: Sequence[np.ndarray], rng: np.random.Generator) -> list[DepthImage]:
    """Return the depth images of a shelf by the camera on the hand, from several configurations."""
    with DepthCamera(shelf.truth, "panda_arm", EYE) as eye:
        return [DepthImage(EYE, as_measured(eye.measure(at, rng, FLAWS)), at) for at in stands]


def as_measured(depth: Singles) -> np.ndarray:
    """Return depths as a camera sends them: whole millimetres, 0 where nothing was measured."""
    return np.where(np.isfinite(depth), np.rint(1e3 * depth), 0.0).astype(np.uint16)


def main() -> None:
    """Measure, and write the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--shelves", type=int, default=50)
    parser.add_argument("--images", type=int, default=60)
    parser.add_argument(
        "--every", type=int, default=5, help="shelves from one with unseen space solid to the next"
    )
    parser.add_argument("--cell", type=float, default=0.02, help="of the clouds that are planned among [m]")
    parser.add_argument("--json", type=Path, default=Path("benchmarks/results/perception.json"))
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    robot = to.load("panda")
    stands = looks(robot)
    shelves = [random_shelf(robot, np.random.default_rng((21, count))) for count in range(given.shelves)]
    images = [taken(each, stands, np.random.default_rng((22, count))) for count, each in enumerate(shelves)]
    print("images are taken", flush=True)
    instances = find_instances(given.data / "panda", robot, limit=max(1, -(-given.images // 7)))
    plans = [each.make() for each in instances]
    single = [
        (shelf.empty, each, Sensing(workspace=shelf.workspace))
        for shelf, own in zip(shelves, images, strict=True)
        for each in own
    ]
    times = timed(single[: given.images], plans[: given.images])
    clouds = [perceive(*each).cloud for each in single[:10]]
    exact = exactness(shelves[0].truth, EYE, stands[0])
    found: dict[str, list[Reached]] = {"free": [], "solid": []}
    for count, (shelf, own) in enumerate(zip(shelves, images, strict=True)):
        for name, several in found.items():
            if name == "free" or count % given.every == 0:
                several.append(reach(shelf, own, stands[-1], unseen=name == "solid", cell=given.cell))
                print(name, several[-1], flush=True)
    plain = {
        "runs": times,
        "exact": exact,
        "shelves": {name: [asdict(each) for each in several] for name, several in found.items()},
    }
    given.json.parent.mkdir(parents=True, exist_ok=True)
    given.json.write_text(json.dumps(plain, indent=1) + "\n")
    text = section(times, clouds, exact, found)
    print(text)
    if given.page is not None:
        write_section(given.page, "perception", text)


def section(
    times: dict[str, list[float]],
    clouds: Sequence[Cloud],
    exact: tuple[float, float, float],
    found: dict[str, list[Reached]],
) -> str:
    """Return the tables in Markdown."""
    image, plan = (float(np.median(times[name])) for name in ("image", "plan"))
    costs = table(
        ("CPU", "median ms", "p90 ms", "runs"),
        [
            (
                words,
                f"{np.median(times[name]):.1f}",
                f"{np.percentile(times[name], 90):.1f}",
                f"{len(times[name])}",
            )
            for name, words in (
                ("image", "640x480 depth image to a scene, 5 mm cells"),
                ("plan", "static `plan()`, Panda sets"),
            )
        ],
    )
    points = float(np.median([len(each) for each in clouds]))
    rows: list[tuple[str, ...]] = []
    for name, several in found.items():
        ends = Counter(each.status for each in several)
        driven = [each for each in several if each.contact is not None]
        ends_words = ", ".join(f"{count} {status}" for status, count in ends.most_common())
        least = min((each.clearance for each in driven if each.clearance is not None), default=float("nan"))
        rows.append(
            (
                name, f"{len(several)}", ends_words, f"{sum(bool(each.contact) for each in driven)}",
                f"{1e3 * least:.1f}" if driven else "-",
                f"{np.median([each.milliseconds for each in several]):.0f}",
                f"{np.median([each.balls for each in several]):.0f}",
            )
        )  # fmt: skip
    head = (
        "unseen space",
        "shelves",
        "outcomes",
        "contacts",
        "least clearance mm",
        "plan, median ms",
        "balls and cubes",
    )
    return "\n\n".join(
        (
            costs,
            f"An image takes {image / plan:.2f} of a static plan (medians) and "
            f"leaves about {points:.0f} balls.",
            f"MuJoCo's depths differ from ray casts by {1e6 * exact[0]:.1f} um "
            f"(median) and {1e6 * exact[1]:.0f} um (99 in 100); {1e2 * exact[2]:.2f} % of the pixels, on "
            "edges, by more than 1 mm.",
            table(head, rows),
        )
    )


if __name__ == "__main__":
    main()
