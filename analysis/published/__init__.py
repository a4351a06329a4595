"""Numbers printed in the paper, and tables that they allow; all of them are defined here."""
