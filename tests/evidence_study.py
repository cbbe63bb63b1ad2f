"""One study for all tests of what is computed for printed numbers: literature tests, gate and sections of the report.

They form one group, so that one worker computes every entry, and computes it once. What a test changes it tries on a study
of its own.
"""

from rollbench.compare.models.study import SceneResultCache

GROUP = "evidence"
#: Sixty randomly drawn screws decide the claims on random errors as two hundred do.
STUDY = SceneResultCache(random_draw_count=60)
