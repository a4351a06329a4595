"""The plate in PsychoPy's Builder: a component for routines, a device for the device manager."""
