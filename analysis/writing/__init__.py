"""Building blocks of reports that know no kind of task: pages, numbers, references, axes."""
