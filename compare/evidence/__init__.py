"""What is computed for each printed number and claim, once: the gate, the report and the literature tests read it."""
