"""``python -m rollbench.comparison`` is ``rollbench``."""

from rollbench.comparison.cli import main

if __name__ == "__main__":
    main()
