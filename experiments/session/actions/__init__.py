"""How a session carries out the steps that take several actions."""
