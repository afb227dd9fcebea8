"""The simulated PUMA 560 in its cell of bricks and a hanging rod."""
