"""Which runs are made, and making them."""
