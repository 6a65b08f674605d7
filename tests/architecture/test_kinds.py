"""What a residual, a check or a status is stands in its kind; names are for readers."""

import ast

from tests.architecture.import_graph import modules


def literal_name(node: ast.expr) -> bool:
    """Whether an expression is a text, or the name of a class."""
    match node:
        case ast.Constant(value=str()):
            return True
        case ast.Attribute(value=ast.Name(id=owner), attr="name"):
            return owner[:1].isupper()
        case _:
            return False


def comparisons(tree: ast.Module) -> list[int]:
    """Lines in which the name of a thing is compared with a text that the program states."""
    found: list[int] = []
    for node in ast.walk(tree):
        if not isinstance(node, ast.Compare):
            continue
        sides = (node.left, *node.comparators)
        named = any(isinstance(side, ast.Attribute) and side.attr == "name" for side in sides)
        if named and any(literal_name(side) for side in sides):
            found.append(node.lineno)
    return found


def test_no_type_is_decided_by_its_name() -> None:
    found = {name: comparisons(ast.parse(path.read_text())) for name, path in modules().items()}
    assert {name: lines for name, lines in found.items() if lines} == {}


def test_the_check_finds_forbidden_comparisons() -> None:
    text = 'a.name == "clearance"\n"x" != check.name\nblock.name == Clearance.name\na.name == b.name\n'
    assert comparisons(ast.parse(text)) == [1, 2, 3]
