"""The finger on the plate: its position and the contact forces."""
