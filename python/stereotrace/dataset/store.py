"""Where a data set lies: a folder, or any place that fsspec knows. Files are there whole or not at all."""

from __future__ import annotations

import hashlib
import io
import os
import posixpath
import uuid
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .._needs import needs

PART = ".part-"
"""In the names of what is not whole yet."""


READERS = 32
"""Files that are read at once."""
READ_AHEAD = 256
"""Files that are held at once while many are read."""


class Written(io.RawIOBase):
    """A file that counts its bytes and hashes them while they are written."""

    def __init__(self, file: Any) -> None:
        self._file = file
        self._hash = hashlib.sha256()
        self.bytes = 0

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        view = memoryview(data).cast("B")
        # What writes files of several parts ends them even after a part could not be written.
        if self._file is not None:
            self._hash.update(view)
            self._file.write(view)
            self.bytes += len(view)
        return len(view)

    def tell(self) -> int:
        return self.bytes

    def abandon(self) -> None:
        """What is still written goes nowhere."""
        self._file = None

    def sha256(self) -> str:
        """Of all that was written."""
        return self._hash.hexdigest()


class Store:
    """A folder of files."""

    def __init__(self, url: str, options: dict[str, Any] | None = None) -> None:
        """``url`` is a path, or a place like ``s3://bucket/folder``; ``options`` are those of its fsspec file system."""
        fsspec = needs("fsspec", "dataset")
        self.url = url
        self.options = options or {}
        # A path is one, whatever is in it; fsspec would take its colons for a chain of file systems.
        self.is_local = "://" not in url
        if self.is_local:
            self._files, root = fsspec.filesystem("file", **self.options), os.path.abspath(url)
        else:
            self._files, root = fsspec.core.url_to_fs(url, **self.options)
        # A listing that is kept would not show what other workers wrote.
        self._files.use_listings_cache = False
        self._root = str(root).rstrip("/")

    def place(self, name: str) -> str:
        """The whole name of a file, for messages."""
        return self._files.unstrip_protocol(self._path(name)) if not self.is_local else self._path(name)

    def _path(self, name: str) -> str:
        return posixpath.join(self._root, name)

    def names(self, folder: str = "") -> set[str]:
        """What lies in a folder; nothing where it is not there."""
        self._files.invalidate_cache()
        try:
            found = self._files.ls(self._path(folder).rstrip("/"), detail=False)
        except FileNotFoundError:
            return set()
        return {posixpath.basename(str(name).rstrip("/")) for name in found}

    def stamps(self) -> dict[str, str]:
        """What lies in the folder, with what tells a file from another of its name: size, time, or the storage's own
        tag."""
        self._files.invalidate_cache()
        try:
            found = self._files.ls(self._path("").rstrip("/"), detail=True)
        except FileNotFoundError:
            return {}
        tags = ("size", "mtime", "LastModified", "ETag", "etag", "updated", "last_modified", "created")
        return {posixpath.basename(str(one["name"]).rstrip("/")): " ".join(str(one.get(tag)) for tag in tags) for one in found}

    def exists(self, name: str) -> bool:
        self._files.invalidate_cache()
        return bool(self._files.exists(self._path(name)))

    def read(self, name: str) -> bytes:
        return bytes(self._files.cat_file(self._path(name)))

    def read_all(self, names: Sequence[str]) -> Iterator[bytes | None]:
        """Reads many files, several at once; ``None`` of one that is not there."""

        def read(name: str) -> bytes | None:
            try:
                return self.read(name)
            except FileNotFoundError:
                return None

        with ThreadPoolExecutor(READERS) as readers:
            for begin in range(0, len(names), READ_AHEAD):
                yield from readers.map(read, names[begin : begin + READ_AHEAD])

    def lines(self, name: str) -> Iterator[bytes]:
        """The lines of a file; none where it is not there."""
        try:
            with self._files.open(self._path(name), "rb") as file:
                yield from file
        except FileNotFoundError:
            return

    def make_folder(self) -> None:
        self._files.makedirs(self._root, exist_ok=True)

    def remove(self, name: str) -> None:
        """A file or a folder; nothing where there is none."""
        if self.exists(name):
            self._files.rm(self._path(name), recursive=True)

    def remove_parts(self, names: Iterable[str]) -> None:
        """What processes that were killed left of files of these names, whatever their endings."""
        wanted = set(names)
        for part in self.names():
            if PART in part and part.partition(".")[0] in wanted:
                self.remove(part)

    def write(self, name: str, data: bytes) -> None:
        """A file, whole or not at all."""
        with self.writing(name) as file:
            file.write(data)

    def mark(self, name: str) -> None:
        """An empty file, in a folder that is made."""
        path = self._path(name)
        self._files.makedirs(posixpath.dirname(path), exist_ok=True)
        self._files.pipe_file(path, b"")

    @contextmanager
    def writing(self, name: str) -> Iterator[Written]:
        """A file that has its name only when all of it is written, and is not there if anything fails."""
        part = self._path(f"{name}{PART}{uuid.uuid4().hex}")
        written = None
        try:
            with self._files.open(part, "wb") as file:
                written = Written(file)
                yield written
            # Of another run, or of a process that did not end after all: it has the same bytes.
            self._files.mv(part, self._path(name))
        except BaseException:
            if written is not None:
                written.abandon()
            self._discard(part)
            raise

    def put_folder(self, folder: Path, name: str) -> int:
        """A folder of this machine, as a folder of this name; returns its bytes."""
        part = self._path(f"{name}{PART}{uuid.uuid4().hex}")
        try:
            self._files.put(f"{folder}/", part, recursive=True)
            if self.exists(name):
                self.remove(name)
            self._files.mv(part, self._path(name), recursive=True)
        except BaseException:
            self._discard(part)
            raise
        return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())

    def put_into_root(self, folder: Path, name: str) -> int:
        """All files of a folder of this machine, where they lie in it, each of them whole or not at all; returns their
        bytes. ``name`` says whose they are, for what a process that is killed leaves."""
        files = sorted(file for file in folder.rglob("*") if file.is_file())
        if self.is_local:
            part = self._path(f"{name}{PART}{uuid.uuid4().hex}")
            try:
                self._files.put(f"{folder}/", part, recursive=True)
                for file in files:
                    place = file.relative_to(folder).as_posix()
                    os.makedirs(posixpath.dirname(self._path(place)), exist_ok=True)
                    os.replace(posixpath.join(part, place), self._path(place))
            finally:
                self._discard(part)
        else:
            self.put_files(folder)  # an object is whole when it is there
        return sum(file.stat().st_size for file in files)

    def put_files(self, folder: Path) -> None:
        """All files of a folder of this machine, where they lie in it."""
        self._files.put(f"{folder}/", self._root, recursive=True)

    def _discard(self, path: str) -> None:
        try:
            if self._files.exists(path):
                self._files.rm(path, recursive=True)
        except Exception:  # the error that led here is the one to tell
            pass
