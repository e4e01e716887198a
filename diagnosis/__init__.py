"""What the simulation gets wrong: causes compared side by side, named, and measured on recordings that were not fitted."""
