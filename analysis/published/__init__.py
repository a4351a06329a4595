"""Numbers printed in the paper, and tables consistent with them; defined only here."""
