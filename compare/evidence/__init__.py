"""What the models give for the printed numbers of a chapter: computed once, for report, gate and tests."""
