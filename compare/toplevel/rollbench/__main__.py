"""``python -m rollbench`` is ``rollbench``."""

from compare.cli import main

if __name__ == "__main__":
    main()
