"""The report's sections: each takes the analysis and returns headings, tables, figures."""
