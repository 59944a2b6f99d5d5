"""Where in a TOML text a key or a value stands."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tree_sitter import Node

Path = tuple[str | int, ...]


def locate(text: str, path: Path) -> tuple[int, int]:
    """Line and column, both from 1, of the value at a path of keys; of the nearest parent that is there.

    >>> locate('[cells.edge]\\npoints = 3\\n', ("cells", "edge", "points"))
    (2, 10)
    """
    places = _places(text)
    while path not in places and path:
        path = path[:-1]
    line, column = places.get(path, (1, 1))
    before = text.encode().split(b"\n")[line - 1][: column - 1]
    return line, len(before.decode()) + 1


def _places(text: str) -> dict[Path, tuple[int, int]]:
    """The place of every value of a document, by its path; columns count bytes."""
    import tree_sitter_toml
    from tree_sitter import Language, Parser

    tree = Parser(Language(tree_sitter_toml.language())).parse(text.encode())
    places: dict[Path, tuple[int, int]] = {(): (1, 1)}
    elements: dict[Path, int] = {}
    for node in tree.root_node.named_children:
        if node.type == "pair":
            _pair(node, (), places)
        elif node.type in ("table", "table_array_element"):
            key, *pairs = node.named_children
            prefix = _in_arrays(_key(key), elements)
            if node.type == "table_array_element":
                number = elements.get(prefix, -1) + 1
                elements[prefix] = number
                prefix = (*prefix, number)
            for end in range(1, len(prefix) + 1):
                places.setdefault(prefix[:end], _place(key))
            for pair in pairs:
                if pair.type == "pair":
                    _pair(pair, prefix, places)
    return places


def _in_arrays(path: Path, elements: dict[Path, int]) -> Path:
    """A table's path, with the last element's number after each parent that is an array of tables."""
    result: Path = ()
    for position, key in enumerate(path):
        result = (*result, key)
        if result in elements and position < len(path) - 1:
            result = (*result, elements[result])
    return result


def _pair(pair: "Node", prefix: Path, places: dict[Path, tuple[int, int]]) -> None:
    key, value = [child for child in pair.named_children if child.type != "comment"][:2]
    keys = _key(key)
    for end in range(1, len(keys)):
        places.setdefault(prefix + keys[:end], _place(key))
    _value(value, prefix + keys, places)


def _value(value: "Node", path: Path, places: dict[Path, tuple[int, int]]) -> None:
    places[path] = _place(value)
    children = [child for child in value.named_children if child.type != "comment"]
    if value.type == "array":
        for number, child in enumerate(children):
            _value(child, (*path, number), places)
    elif value.type == "inline_table":
        for child in children:
            _pair(child, path, places)


def _key(node: "Node") -> Path:
    if node.type == "dotted_key":
        return tuple(part for child in node.named_children for part in _key(child))
    text = (node.text or b"").decode()
    return (text[1:-1] if node.type == "quoted_key" else text,)


def _place(node: "Node") -> tuple[int, int]:
    row, column = node.start_point
    return row + 1, column + 1
