"""Programs are kept for the next process: what has run once compiles nothing."""

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from jax._src.lru_cache import LRUCache
from tiny_scene import TINY

import lumpedcable  # noqa: F401  (its cache writes whole files)

ROOT = Path(__file__).parents[2]
COUNTED = """
import sys
from collections import Counter
from jax import monitoring
seen = Counter()
monitoring.register_event_listener(lambda name, **_: seen.update([name.rsplit("/", 1)[-1]]))
from lumpedcable.cli import main
sys.argv = ["lumpedcable", "run", "scene.toml"]
try:
    main()
except SystemExit as left:
    assert not left.code
print(*(seen[x] for x in ("compile_requests_use_cache", "cache_misses", "cache_hits")))
"""


def test_a_second_run_of_a_scene_compiles_nothing(tmp_path):
    (tmp_path / "scene.toml").write_text(TINY)
    env = {**os.environ, "PYTHONPATH": str(ROOT), "LUMPEDCABLE_CACHE": str(tmp_path / "cache")}
    counts = []
    for _ in range(2):
        ran = subprocess.run(
            [sys.executable, "-c", COUNTED], cwd=tmp_path, env=env, capture_output=True, text=True,
            check=True,
        )  # fmt: skip
        counts.append([int(word) for word in ran.stdout.split()[-3:]])
    (first, made, _), (second, again, hits) = counts
    assert first == second > 0
    # what a compiler refuses, since it does not know an option, is neither made nor found
    assert hits == made > 0
    assert again == 0


def test_who_reads_while_an_entry_is_written_finds_all_of_it_or_none(tmp_path):
    """Workers share a folder: jax writes in place, and who reads meanwhile finds half of it."""
    writer, reader = (LRUCache(str(tmp_path), max_size=-1) for _ in range(2))
    value = os.urandom(1 << 22)
    done, found = threading.Event(), set()

    def read():
        while not done.is_set():
            for i in range(40):
                found.add((got := reader.get(f"program{i}")) is None or got == value)

    reading = threading.Thread(target=read)
    reading.start()
    for i in range(40):
        writer.put(f"program{i}", value)
    done.set()
    reading.join()
    assert found == {True}
    assert [path.name for path in tmp_path.iterdir() if not path.name.endswith("-cache")] == []
    assert all(reader.get(f"program{i}") == value for i in range(40))


def test_what_could_not_be_written_is_written_the_next_time(tmp_path, monkeypatch):
    cache = LRUCache(str(tmp_path), max_size=-1)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", _half)
        with pytest.raises(OSError, match="no space"):
            cache.put("program", b"a program")
    assert list(tmp_path.iterdir()) == []
    assert cache.get("program") is None
    cache.put("program", b"a program")
    assert cache.get("program") == b"a program"


def _half(path, value):
    with path.open("wb") as file:
        file.write(value[: len(value) // 2])
    raise OSError(28, "no space left on device")
