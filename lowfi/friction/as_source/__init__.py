"""Lin's formulations of friction, as printed in his thesis (2019), for comparison with those of rollbench."""
