"""Lin (2019), doctoral thesis on contact loads and friction of ball screws: printed numbers, reproduced."""
