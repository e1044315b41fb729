"""Shares one renderer between tests, on the adapter that STEREOTRACE_ADAPTER names, or on the software adapter."""

from __future__ import annotations

import os

os.environ.setdefault("STEREOTRACE_ADAPTER", "software")

import pytest

import stereotrace


@pytest.fixture(scope="session")
def renderer() -> stereotrace.Renderer:
    return stereotrace.Renderer()


@pytest.fixture(scope="session")
def hall() -> stereotrace.Scene:
    return stereotrace.Scene.builtin("hall")
