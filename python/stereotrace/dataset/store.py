"""The store of a data set: a folder, or any location that fsspec supports. Files are written whole or not at all."""

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
"""Part of the names of unfinished files."""


READERS = 32
"""Number of files that are read in parallel."""
READ_AHEAD = 256
"""Maximum number of files in memory while many are read."""


class Written(io.RawIOBase):
    """A file that counts and hashes its bytes as they are written."""

    def __init__(self, file: Any) -> None:
        self._file = file
        self._hash = hashlib.sha256()
        self.bytes = 0

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        view = memoryview(data).cast("B")
        # Writers of tar and Parquet files write an end even after an error. The file is closed by then.
        if self._file is not None:
            self._hash.update(view)
            self._file.write(view)
            self.bytes += len(view)
        return len(view)

    def tell(self) -> int:
        return self.bytes

    def abandon(self) -> None:
        """Drops all further writes."""
        self._file = None

    def sha256(self) -> str:
        """Returns the hash of all bytes written."""
        return self._hash.hexdigest()


class Store:
    """A folder of files."""

    def __init__(self, url: str, options: dict[str, Any] | None = None) -> None:
        """``url`` is a path, or a URL like ``s3://bucket/folder``. ``options`` are those of its fsspec file system."""
        fsspec = needs("fsspec", "dataset")
        self.url = url
        self.options = options or {}
        # fsspec would interpret colons in a path as a chain of file systems.
        self.is_local = "://" not in url
        if self.is_local:
            self._files, root = fsspec.filesystem("file", **self.options), os.path.abspath(url)
        else:
            self._files, root = fsspec.core.url_to_fs(url, **self.options)
        # A cached listing would not show files of other workers.
        self._files.use_listings_cache = False
        self._root = str(root).rstrip("/")

    def place(self, name: str) -> str:
        """Returns the full name of a file, for messages."""
        return self._files.unstrip_protocol(self._path(name)) if not self.is_local else self._path(name)

    def _path(self, name: str) -> str:
        return posixpath.join(self._root, name)

    def names(self, folder: str = "") -> set[str]:
        """Returns the names in a folder. A missing folder has none."""
        self._files.invalidate_cache()
        try:
            found = self._files.ls(self._path(folder).rstrip("/"), detail=False)
        except FileNotFoundError:
            return set()
        return {posixpath.basename(str(name).rstrip("/")) for name in found}

    def stamps(self) -> dict[str, str]:
        """Returns the names in the folder with stamps that change if the file does: size, time or the storage's tag."""
        self._files.invalidate_cache()
        try:
            found = self._files.ls(self._path("").rstrip("/"), detail=True)
        except FileNotFoundError:
            return {}
        tags = ("size", "mtime", "LastModified", "ETag", "etag", "updated", "last_modified", "created")
        return {
            posixpath.basename(str(one["name"]).rstrip("/")): " ".join(str(one.get(tag)) for tag in tags)
            for one in found
        }

    def exists(self, name: str) -> bool:
        self._files.invalidate_cache()
        return bool(self._files.exists(self._path(name)))

    def read(self, name: str) -> bytes:
        return bytes(self._files.cat_file(self._path(name)))

    def read_all(self, names: Sequence[str]) -> Iterator[bytes | None]:
        """Reads many files in parallel. Yields ``None`` for a missing one."""

        def read(name: str) -> bytes | None:
            try:
                return self.read(name)
            except FileNotFoundError:
                return None

        with ThreadPoolExecutor(READERS) as readers:
            for begin in range(0, len(names), READ_AHEAD):
                yield from readers.map(read, names[begin : begin + READ_AHEAD])

    def lines(self, name: str) -> Iterator[bytes]:
        """Yields the lines of a file. A missing file has none."""
        try:
            with self._files.open(self._path(name), "rb") as file:
                yield from file
        except FileNotFoundError:
            return

    def make_folder(self) -> None:
        self._files.makedirs(self._root, exist_ok=True)

    def remove(self, name: str) -> None:
        """Removes a file or a folder, if it exists."""
        if self.exists(name):
            self._files.rm(self._path(name), recursive=True)

    def remove_parts(self, names: Iterable[str]) -> None:
        """Removes unfinished files of these names, with any ending, which killed processes left."""
        wanted = set(names)
        for part in self.names():
            if PART in part and part.partition(".")[0] in wanted:
                self.remove(part)

    def write(self, name: str, data: bytes) -> None:
        """Writes a file, whole or not at all."""
        with self.writing(name) as file:
            file.write(data)

    def mark(self, name: str) -> None:
        """Writes an empty file, and makes its folder."""
        path = self._path(name)
        self._files.makedirs(posixpath.dirname(path), exist_ok=True)
        self._files.pipe_file(path, b"")

    @contextmanager
    def writing(self, name: str) -> Iterator[Written]:
        """Opens a file for writing. It gets its name once it is complete, and is removed if anything fails."""
        part = self._path(f"{name}{PART}{uuid.uuid4().hex}")
        written = None
        try:
            with self._files.open(part, "wb") as file:
                written = Written(file)
                yield written
            # This may replace the file of another run, which has the same bytes.
            self._files.mv(part, self._path(name))
        except BaseException:
            if written is not None:
                written.abandon()
            self._discard(part)
            raise

    def put_folder(self, folder: Path, name: str) -> int:
        """Copies a local folder to a folder of this name. Returns its size in bytes."""
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
        """Copies all files of a local folder to the same relative paths, each whole or not at all.

        Unfinished files carry ``name``, so that ``remove_parts`` finds them. Returns the size in bytes."""
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
            self.put_files(folder)  # object stores write objects whole
        return sum(file.stat().st_size for file in files)

    def put_files(self, folder: Path) -> None:
        """Copies all files of a local folder to the same relative paths."""
        self._files.put(f"{folder}/", self._root, recursive=True)

    def _discard(self, path: str) -> None:
        try:
            if self._files.exists(path):
                self._files.rm(path, recursive=True)
        except Exception:  # the error that led here is the one to raise
            pass
