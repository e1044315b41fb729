"""Data sets of stereo pairs with ground truth, described by a spec, made on one machine or on many.

    from stereotrace import dataset

    spec = dataset.Spec.load("rooms.yaml")     # or a dict
    report = dataset.make(spec, "rooms/")      # or on Ray: dataset.make_on_ray(spec, "s3://bucket/rooms", workers=100)

A pair depends only on the spec and its number, so it can be made again anywhere. It is equal bit for bit on the same
kind of adapter. Shards are written whole or not at all, and a stopped run resumes with the missing ones. The command
line is ``python -m stereotrace.dataset spec.yaml out/``. ``python -m stereotrace.dataset.verify out/`` reads a data set
back, and ``python -m stereotrace.dataset.sheet out/ sheet.png`` shows its pairs.
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
    """Makes a data set on Ray: see ``stereotrace.dataset.on_ray.make``. Needs ``pip install stereotrace[ray]``."""
    from . import on_ray

    return on_ray.make(spec, out, **options)
