"""The gate: verdicts on users' scenes and on the shipped ones, for continuous integration."""
