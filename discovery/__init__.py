"""Laws that nobody listed: what a residual follows, found among functions of measured variables, and how sure that is."""
