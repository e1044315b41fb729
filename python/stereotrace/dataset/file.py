"""Reads spec files: YAML 1.2 with its core schema, or JSON. Duplicate keys and deep nesting are refused."""

from __future__ import annotations

import json
import re
import reprlib
from pathlib import Path
from typing import Any

from .._needs import needs

MOST_LEVELS = 32
"""Maximum nesting of a spec's lists and mappings."""
MOST_BYTES = 2**25
"""Maximum size of a spec's file."""


class SpecError(ValueError):
    """An invalid spec. The text names the key."""


_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxother, _SHORT.maxlong = 3, 80, 80, 40


def shown(value: Any) -> str:
    """Returns a value as messages show it. A large value is cut before it is formatted."""
    try:
        text = _SHORT.repr(value)
    except ValueError:  # Python refuses to format a number of thousands of digits
        text = "a number with too many digits"
    return text if len(text) <= 80 else text[:79] + "…"


def read(path: Path) -> Any:
    """Reads a spec's file: JSON if its name ends in ``.json``, else YAML.

    Raises ``SpecError``, which names the line, for invalid content, and ``OSError`` if the file can't be read."""
    if not path.is_file() and path.exists():
        raise SpecError("it is not a regular file")
    with path.open("rb") as file:
        data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise SpecError(f"it is larger than {MOST_BYTES >> 20} MiB")
    is_json = path.suffix.lower() == ".json"
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SpecError(f"invalid {'JSON' if is_json else 'YAML'}: {error}") from error
    return _json(text) if is_json else _yaml(text)


def _json(text: str) -> Any:
    def mapping(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            keys = [key for key, _ in pairs]
            twice = next(key for key in keys if keys.count(key) > 1)
            raise SpecError(f"the key {shown(twice)} occurs twice in one mapping")
        return found

    try:
        return json.loads(text, object_pairs_hook=mapping)
    except SpecError:
        raise
    except ValueError as error:  # also raised for a number of thousands of digits
        raise SpecError(f"invalid JSON: {error}") from error
    except RecursionError:
        raise SpecError(f"its lists and mappings are nested more than {MOST_LEVELS} levels deep") from None


def _yaml(text: str) -> Any:
    yaml = needs("yaml", "dataset")
    try:
        return yaml.load(text, Loader=_loader(yaml))
    except yaml.YAMLError as error:
        raise SpecError(f"invalid YAML: {error}") from error


def _loader(yaml: Any) -> Any:
    """Returns a YAML loader for the core schema of YAML 1.2: ``1:30`` and ``no`` are strings, ``010`` is ten."""

    class Loader(yaml.SafeLoader):  # type: ignore[misc]
        yaml_implicit_resolvers: dict[str, list[tuple[str, re.Pattern[str]]]] = {}
        level = 0

        def compose_node(self, parent: Any, index: Any) -> Any:
            self.level += 1
            if self.level > MOST_LEVELS + 1:  # values in the deepest list are one level deeper
                line = self.peek_event().start_mark.line + 1
                raise SpecError(f"line {line}: lists and mappings are nested more than {MOST_LEVELS} levels deep")
            try:
                return super().compose_node(parent, index)
            finally:
                self.level -= 1

        def compose_mapping_node(self, anchor: Any) -> Any:
            node = super().compose_mapping_node(anchor)
            seen = set()
            for key, _ in node.value:
                # Keys may replace values of merged mappings.
                if not isinstance(key, yaml.ScalarNode) or key.tag == "tag:yaml.org,2002:merge":
                    continue
                if (key.tag, key.value) in seen:
                    line = key.start_mark.line + 1
                    raise SpecError(f"line {line}: the key {shown(key.value)} occurs twice in one mapping")
                seen.add((key.tag, key.value))
            return node

        def whole(self, node: Any) -> int:
            value = self.construct_scalar(node).replace("_", "")
            try:
                return int(value, 0) if re.match("[-+]?0[xo]", value) else int(value)
            except ValueError as error:
                raise SpecError(f"line {node.start_mark.line + 1}: {shown(value)}: {error}") from None

    for tag, pattern, first in (
        ("bool", "true|True|TRUE|false|False|FALSE", "tTfF"),
        ("int", "[-+]?[0-9][0-9_]*|0o[0-7]+|0x[0-9a-fA-F]+", "-+0123456789"),
        (
            "float",
            r"[-+]?(?:\.[0-9]+|[0-9][0-9_]*(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)",
            "-+.0123456789",
        ),
        ("merge", "<<", "<"),
        ("null", "~|null|Null|NULL|", ["~", "n", "N", ""]),
    ):
        Loader.add_implicit_resolver(f"tag:yaml.org,2002:{tag}", re.compile(f"^(?:{pattern})$"), list(first))
    Loader.add_constructor("tag:yaml.org,2002:int", Loader.whole)
    return Loader
