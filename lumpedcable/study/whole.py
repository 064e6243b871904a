"""Compiled programs are kept in whole files: neither a kill nor two processes leave half of one."""

from pathlib import Path
from typing import Any

__all__ = ["keep_whole", "write_whole"]


def write_whole(target: Path, value: bytes) -> None:
    """Write a file that is there whole or not at all."""
    from lumpedcable.results.target import drafted  # loads h5py, for what is compiled alone

    with drafted(target) as draft:
        draft.write_bytes(value)


def keep_whole() -> bool:
    """Let jax write what it keeps under a passing name first, which then becomes its own in one step.

    jax writes an entry of its cache in place, once for all: who reads meanwhile, as workers of a study
    that share a folder do, is told of an error and compiles anew, and of what a kill or a full disk cuts
    off every later process is told. It has no setting for that, so its method is replaced; a cache that
    is kept to a size has a lock, and is left alone, as is one in no folder of this computer. False where
    this jax has another cache.
    """
    try:
        from jax._src import lru_cache

        plain, ending = lru_cache.LRUCache.put, lru_cache._CACHE_SUFFIX
    except (ImportError, AttributeError):
        return False

    def put(self: Any, key: str, value: bytes) -> None:
        if self.eviction_enabled or not key or "://" in str(self.path):
            plain(self, key, value)
            return
        target = Path(self.path) / f"{key}{ending}"
        if not target.exists():
            write_whole(target, value)

    lru_cache.LRUCache.put = put
    return True
