"""Task-independent building blocks of reports: pages, numbers, references and axes."""
