"""Support for kinds of task that other packages declare, in full or in a short form."""
