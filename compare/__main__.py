"""``python -m rollbench.compare`` is ``rollbench``."""

from rollbench.compare.cli import main

if __name__ == "__main__":
    main()
