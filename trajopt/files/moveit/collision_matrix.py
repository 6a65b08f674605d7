"""Allowed-collision matrix of a planning scene message."""

from dataclasses import replace
from itertools import combinations

from trajopt.scene.clearances import AllowedCollisions
from trajopt.scene.scene import Scene
from trajopt.values.documents.document import Node

MATRIX_FIELDS = ("entry_names", "entry_values", "default_entry_names", "default_entry_values")


def apply_matrix(node: Node, scene: Scene, notes: list[str]) -> Scene:
    """Return the scene with the message's allowed-collision matrix in place of the robot's.

    The matrix replaces the description's entries for pairs of links that it both names; other links keep the
    description's entries. A matrix without pairs only adds its defaults. If two defaults apply to a pair,
    both must allow contact, as in MoveIt.

    Args:
        node: The matrix; its rows are lists, or mappings with `enabled`.
        scene: The scene with everything that the matrix may name.
        notes: Receives notes on omissions.

    Raises:
        FileFormatError: If its parts are inconsistent.
    """
    node.only(MATRIX_FIELDS)
    names = [name.text() for name in node["entry_names"].elements()]
    defaults = _defaults(node)
    if len(set(names)) != len(names):
        raise node["entry_names"].error("a name comes twice")
    if not names and not defaults:
        return scene
    rows = _rows(node, len(names))
    known = frozenset((*scene.robot.links, *scene.objects))
    strangers = sorted({*names, *defaults} - known)
    if strangers:
        notes.append(f"{node.place}: left out, being neither link nor object: {', '.join(strangers)}")
    kept = {name: allowed for name, allowed in defaults.items() if name in known}
    described = (pair for pair in scene.robot.disabled_pairs if not pair <= set(names))
    entries = dict.fromkeys(described, True) if names else dict(scene.allowed.entries)
    conflicts = (pair for pair in combinations(kept, 2) if kept[pair[0]] != kept[pair[1]])
    entries = dict.fromkeys(map(frozenset, conflicts), False) | entries
    for (i, a), (j, b) in combinations(enumerate(names), 2):
        if rows[i][j] != rows[j][i]:
            notes.append(f"{node.place}: {a} and {b} differ by order; the row of {a} counts")
        if a in known and b in known:
            _set(entries, frozenset((a, b)), rows[i][j], kept)
    if names:
        _note_unnamed(node, names, scene, notes)
    if not entries and not kept:
        # A scene without any entry would fall back to the robot's own matrix.
        a, b = (*scene.robot.links, *scene.robot.links)[:2]
        entries[frozenset((a, b))] = False
    return replace(scene, allowed=AllowedCollisions(entries, kept))


def _set(
    entries: dict[frozenset[str], bool], pair: frozenset[str], allowed: bool, defaults: dict[str, bool]
) -> None:
    """Enter a pair if it differs from the defaults, so that the defaults can still be changed."""
    entries.pop(pair, None)
    if allowed != any(defaults.get(name, False) for name in pair):
        entries[pair] = allowed


def _defaults(node: Node) -> dict[str, bool]:
    names = node["default_entry_names"].elements()
    values = node["default_entry_values"].elements()
    if len(names) != len(values):
        raise node["default_entry_names"].error(f"{len(names)} names, but {len(values)} values")
    return {name.text(): value.flag() for name, value in zip(names, values, strict=True)}


def _rows(node: Node, count: int) -> list[list[bool]]:
    rows: list[list[bool]] = []
    for row in node["entry_values"].elements():
        cells = row if isinstance(row.value, list) else row.only(("enabled",))["enabled"]
        rows.append([cell.flag() for cell in cells.elements()])
        if len(rows[-1]) != count:
            raise row.error(f"{len(rows[-1])} values for {count} names")
    if len(rows) != count:
        raise node["entry_values"].error(f"{len(rows)} rows for {count} names")
    return rows


def _note_unnamed(node: Node, names: list[str], scene: Scene, notes: list[str]) -> None:
    owners = dict.fromkeys(body.owner for body in scene.robot.bodies)
    unnamed = [owner for owner in owners if owner not in names]
    if unnamed:
        notes.append(
            f"{node.place}: does not name {', '.join(unnamed)}: "
            "what the robot's description allows of them stays allowed"
        )
