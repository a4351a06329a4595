"""The driver board on a serial line: protocol, link, supervision and driver."""
