"""Machine code kept on disk: a convenience, without which everything works as well, but compiles anew.

A file for each function, signature, processor, version of Numba and state of the kernel's sources, which appears whole
and holds its own checksum: processes that compile at the same time share it, and what is damaged counts as missing.
Numba's own cache has an index for each function, by which one process can be led to the code of another signature.
"""

import hashlib
import logging
import os
import pickle
import time
import uuid
from contextlib import suppress
from pathlib import Path
from typing import Any

import numba.core.caching
import numba.core.serialize

compiler: Any = numba
core: Any = numba.core  # private, and without types
LOG = logging.getLogger("legspring")
LONGEST_WRITE = 600.0
"""Seconds after which a file that is not whole will never be."""
DIGEST = hashlib.sha256().digest_size


class CodeFiles:
    """The files of one function, as Numba asks for them.

    Parameters
    ----------
    directory, name
        Where they are, and how their names begin.
    stamp
        What the code depends on beside its key; files of another stamp are removed when one is saved.
    """

    def __init__(self, directory: str, name: str, stamp: str) -> None:
        version = hashlib.sha256(f"{compiler.__version__} {stamp}".encode()).hexdigest()
        self.directory, self.name, self.version = Path(directory), name, version[:12]

    def path(self, key: Any) -> Path:
        """Return the file for a signature and a processor."""
        digest = hashlib.sha256(repr(key).encode()).hexdigest()
        return self.directory / f"{self.name}.{self.version}.{digest[:16]}.nbc"

    def load(self, key: Any) -> Any:
        """Return what is stored, or None."""
        data = self.path(key).read_bytes()
        body = data[DIGEST:]
        return pickle.loads(body) if data[:DIGEST] == hashlib.sha256(body).digest() else None

    def save(self, key: Any, value: Any) -> None:
        """Store machine code; remove that of other versions."""
        body = core.serialize.dumps(value)
        path = self.path(key)
        temporary = path.with_name(f"{path.name}.{uuid.uuid4().hex[:8]}.tmp")
        try:
            temporary.write_bytes(hashlib.sha256(body).digest() + body)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
        self._tidy()

    def _tidy(self) -> None:
        """Remove files of other versions, and what a process that was killed did not finish."""
        for other in self.directory.glob(f"{self.name}.*"):
            with suppress(OSError):
                current = other.name.startswith(f"{self.name}.{self.version}.") and other.suffix == ".nbc"
                growing = other.suffix == ".tmp" and time.time() - other.stat().st_mtime < LONGEST_WRITE
                if not current and not growing:
                    other.unlink()

    def flush(self) -> None:
        """Forget everything."""
        for path in self.directory.glob(f"{self.name}.{self.version}.*.nbc"):
            path.unlink(missing_ok=True)


class CodeCache(core.caching.FunctionCache):  # type: ignore[misc]
    """Numba's cache for one function, which never fails, and says when there is something to compile."""

    def __init__(self, function: Any, stamp: str) -> None:
        super().__init__(function)
        self._cache_file = CodeFiles(self._cache_path, self._impl.filename_base, stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the code for a signature, or None."""
        found = None
        with suppress(Exception):
            found = super().load_overload(sig, target_context)
        if found is None:
            LOG.info("compiling (about half a minute, once) ...")
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store the code for a signature, if that can be done."""
        with suppress(Exception):
            super().save_overload(sig, data)


class NoCache(core.caching.NullCache):  # type: ignore[misc]
    """What stands in where there is no place for files: it says so, once there is something to compile."""

    def load_overload(self, sig: Any, target_context: Any) -> None:
        """Find nothing."""
        LOG.info("compiling (about half a minute; to keep the result, let NUMBA_CACHE_DIR be a writable folder) ...")


def keep(compiled: Any, stamp: str) -> None:
    """Keep the machine code of a compiled function on disk, if there is a place for it."""
    # All of this is Numba's own business, which another version may do in another way: then nothing is kept.
    try:
        compiled._cache = CodeCache(compiled.py_func, stamp)
    except Exception:
        compiled._cache = NoCache()


def check_compiler() -> None:
    """Raise ValueError where Numba is told not to compile."""
    if compiler.config.DISABLE_JIT:
        value = os.environ.get("NUMBA_DISABLE_JIT", "1")
        raise ValueError(f"NUMBA_DISABLE_JIT = {value!r}: must be 0, or left out; the model has to be compiled")
