"""Task-independent building blocks for reports: HTML, numbers, references and axes."""
