"""The search for parameters of a filter: some logs choose them, others check them."""
