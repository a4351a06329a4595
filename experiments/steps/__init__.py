"""The vocabulary of a protocol: the steps that it yields, and the replies that it receives."""
