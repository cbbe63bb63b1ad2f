"""What the wing of rolling contact in 3D adds."""

from rollbench.compare.registration import Registration

REGISTRATION = Registration(
    folders=("hifi/rolling",),
    needs=("friction",),
    functions={
        "rolling study": "wings.rolling.commands:run_rolling_study",
        "rolling compare": "wings.rolling.commands:run_rolling_compare",
        "gate": "wings.rolling.rows:rolling_rows",
        "bench": "wings.rolling.bench:jobs",
    },
)
