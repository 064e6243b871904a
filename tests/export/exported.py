"""Which run of the file of `conftest.py` is exported, and where it goes wrong in the other."""

import synthetic_result

RUN = 3
HALF = len(synthetic_result.TIMES) // 2
