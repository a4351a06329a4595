"""Presentation orders of surfaces: rules, designs and random numbers."""
