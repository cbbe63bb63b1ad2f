"""Ball screws with random errors of balls and grooves under axial load (Liu et al. 2025): one chain, and many of them."""
