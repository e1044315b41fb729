"""Checks dependencies by deny.toml: their licences and sources, and crates of which there must be one version.

    python3 scripts/check_dependencies.py

It covers every feature and target, and needs only cargo and Python 3.11. `cargo deny check` reads advisories too.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
REGISTRY = "registry+https://github.com/rust-lang/crates.io-index"


def is_allowed(expression: str, allowed: set[str]) -> bool:
    """Whether an SPDX expression can be fulfilled by allowed licences alone."""
    tokens = re.findall(r"\(|\)|[^()\s]+(?: WITH [^()\s]+)?", expression.replace("/", " OR "))
    words = {"OR": "or", "AND": "and", "(": "(", ")": ")"}
    return bool(eval(" ".join(words.get(token, str(token in allowed)) for token in tokens)))  # noqa: S307


def main() -> int:
    command = ["cargo", "metadata", "--format-version", "1", "--all-features", "--locked"]
    packages = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)["packages"]
    rules = tomllib.loads((ROOT / "deny.toml").read_text())
    allowed = set(rules["licenses"]["allow"])
    faults = []
    versions = defaultdict(set)
    for package in packages:
        name = f"{package['name']} {package['version']}"
        versions[package["name"]].add(package["version"])
        if not package["license"] or not is_allowed(package["license"], allowed):
            faults.append(f"{name}: licence {package['license'] or 'not stated'}")
        if package["source"] not in (None, REGISTRY):
            faults.append(f"{name}: source {package['source']}")
    for rule in rules["bans"]["deny"]:
        if rule.get("deny-multiple-versions") and len(versions[rule["crate"]]) > 1:
            faults.append(f"{rule['crate']}: versions {', '.join(sorted(versions[rule['crate']]))}")
    twice = sorted(f"{name} {', '.join(sorted(found))}" for name, found in versions.items() if len(found) > 1)
    print(f"{len(packages)} packages; {len(twice)} of several versions: {'; '.join(twice)}")
    print("\n".join(f"error: {fault}" for fault in faults), file=sys.stderr, end="\n" if faults else "")
    return 1 if faults else 0


if __name__ == "__main__":
    assert is_allowed("MIT/Apache-2.0", {"MIT"}) and not is_allowed("(MIT OR Zlib) AND ISC", {"MIT"})
    sys.exit(main())
