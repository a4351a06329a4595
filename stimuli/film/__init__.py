"""Model the air film under a finger on a vibrating plate."""
