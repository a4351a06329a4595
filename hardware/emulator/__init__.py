"""Emulate driver boards and function generators."""
