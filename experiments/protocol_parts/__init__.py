"""What protocols are made of: interface, registry, simulated answers, orders, adaptive methods."""
