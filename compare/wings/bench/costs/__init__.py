"""What solves cost: benches against targets, cold and warm times in processes of their own."""
