"""Draw figures from results, without computing anything."""
