"""A published table: its columns, as printed and as read, and what of it contradicts itself."""
