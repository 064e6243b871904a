"""Makes tests/ importable, so that tests of several packages share their helpers."""

import os
from pathlib import Path

# one cache of compiled programs for all tests, and for the next time they run
CACHE = Path(__file__).parent.parent / ".pytest_cache" / "xla"
os.environ.setdefault("LUMPEDCABLE_CACHE", str(CACHE))
