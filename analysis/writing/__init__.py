"""Building blocks of reports that are independent of tasks: pages, numbers, references, axes."""
