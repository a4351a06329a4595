"""The parts of protocols: interface, registry, simulated answers, orders, adaptive methods."""
