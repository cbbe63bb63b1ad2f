"""Speed: what solves cost, against the source's formulation."""
