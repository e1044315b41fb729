"""Data sets of stereo pairs with ground truth, described by a spec: of any number of pairs, on this machine or on many.

    from stereotrace import dataset

    spec = dataset.Spec.load("rooms.yaml")     # or a dict
    report = dataset.make(spec, "rooms/")      # or on Ray: dataset.make_on_ray(spec, "s3://bucket/rooms", workers=100)

Each pair follows from the spec and its number alone, so that any of them can be made again anywhere: bit for bit on the same kind of adapter. Shards are written whole
or not at all, and a run that was stopped goes on with those that are missing. At the terminal: ``python -m stereotrace.dataset spec.yaml out/``.
"""

from __future__ import annotations

from typing import Any

from .file import SpecError
from .run import DataSet, OtherDataSet, Report, make
from .spec import Spec
from .store import Store
from .worker import Worker

__all__ = ["DataSet", "OtherDataSet", "Report", "Spec", "SpecError", "Store", "Worker", "make", "make_on_ray"]


def make_on_ray(spec: Spec, out: str, **options: Any) -> Report:
    """``stereotrace.dataset.on_ray.make``, which needs ``pip install stereotrace[ray]``."""
    from . import on_ray

    return on_ray.make(spec, out, **options)
