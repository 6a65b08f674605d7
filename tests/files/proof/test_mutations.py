"""Statements with changed numbers: those that the checker accepts are true at all sampled times."""

import copy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.files.proof.conftest import Checker, Proof
from tests.files.proof.dense import refuted

Place = tuple[Any, Any]


def numbers(value: Any) -> Iterator[Place]:
    """Yield the container and the key of every number."""
    for key, part in value.items() if isinstance(value, dict) else enumerate(value):
        if isinstance(part, dict | list):
            yield from numbers(part)
        elif isinstance(part, int | float) and not isinstance(part, bool):
            yield value, key


def mutate(proof: Proof, rng: np.random.Generator) -> Proof:
    statement = copy.deepcopy(proof.statement)
    sections = ("motion", "drives", "joints", "ends", "parts", "changes", "pairs", "requirements")
    sections = [name for name in sections if statement[name]]
    where = list(numbers(statement[sections[rng.integers(len(sections))]]))
    for _ in range(int(rng.integers(1, 3))):
        container, key = where[rng.integers(len(where))]
        if isinstance(container[key], int) and not isinstance(container[key], float):
            container[key] = max(0, container[key] + int(rng.integers(-1, 2)))
        else:
            size = 10.0 ** rng.uniform(-9.0, 0.5)
            container[key] = float(container[key] + size * rng.standard_normal())
    return Proof(statement, proof.witness)


def accepted_and_refuted(
    checker: Checker, proof: Proof, path: Path, *, count: int, seed: int
) -> tuple[int, list[str]]:
    rng = np.random.default_rng(seed)
    accepted, false = 0, list[str]()
    for _ in range(count):
        mutated = mutate(proof, rng)
        try:
            proven = not checker.fault(mutated.write(path))
        except checker.malformed:
            proven = False
        if proven:
            accepted += 1
            false += list(refuted(mutated.statement))
    return accepted, false


def test_the_dense_check_refutes_what_is_false(planar: Proof) -> None:
    assert list(refuted(planar.statement)) == []
    statement = copy.deepcopy(planar.statement)
    for pair in statement["pairs"]:
        pair[2] = 0.01
    assert any("post" in fault for fault in refuted(statement))


@pytest.mark.parametrize("name", ["planar", "moving"])
def test_accepted_mutations_are_true(
    name: str, tmp_path: Path, checker: Checker, request: pytest.FixtureRequest
) -> None:
    proof = request.getfixturevalue(name)
    accepted, false = accepted_and_refuted(checker, proof, tmp_path / "x.proof", count=40, seed=1)
    assert 0 < accepted < 40
    assert false == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 105))
@pytest.mark.parametrize("name", ["planar", "moving"])
@pytest.mark.timeout(0)
def test_many_accepted_mutations_are_true(
    seed: int, name: str, tmp_path: Path, checker: Checker, request: pytest.FixtureRequest
) -> None:
    proof = request.getfixturevalue(name)
    accepted, false = accepted_and_refuted(checker, proof, tmp_path / "x.proof", count=1000, seed=seed)
    assert accepted > 0
    assert false == []
