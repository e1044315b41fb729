"""Imports of optional dependencies, which extras of the package install."""

from __future__ import annotations

import importlib
from typing import Any


def needs(module: str, extra: str) -> Any:
    """Imports a module of another package. Raises ``ImportError`` that says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        name = module.partition(".")[0]
        raise ImportError(
            f"{name} can't be imported ({error}); install it with: pip install 'stereotrace[{extra}]'"
        ) from error
