"""What half and twice of every number that decides a verdict do to the rates of right and of false verdicts."""
