"""Processes that tests start: this Python, rollbench by its command, what they wrote as text."""

import os
import subprocess
import sys

COMMAND = (sys.executable, "-P", "-m", "rollbench")


def ran(*command, **options):
    """A process that has ended, with its exit code and what it wrote; environ: variables beside those of this one."""
    env = {**os.environ, **options.pop("environ", {})}
    settings = {"capture_output": True, "text": True, "timeout": 280, "env": env} | options
    return subprocess.run([str(word) for word in command], check=False, **settings)


def python(*words, **options):
    """`ran` by this Python."""
    return ran(sys.executable, *words, **options)
