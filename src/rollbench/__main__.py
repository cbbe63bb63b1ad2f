"""Entry point of ``python -m rollbench``, which is the same as the command ``rollbench``."""

from rollbench.compare.cli import main

if __name__ == "__main__":
    main()
