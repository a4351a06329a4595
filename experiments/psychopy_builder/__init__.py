"""The plate in PsychoPy Builder: a component for routines and a device for the device manager."""
