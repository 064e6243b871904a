"""Programs are kept for the next process: what has run once compiles nothing."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
TINY = """
[materials.hooke]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "hooke"
length = "10 m"
segments = 8
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = { held = { pretension = "50 kN", direction = [1, 0, 0] } }
[events.break]
breaks = "rope.end"
time = "40 ms"
[solver]
waves = "plain"
[output]
duration = "4 ms"
every = "2 ms"
quantities = ["position"]
"""
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
