"""What xneck's parts do beside their peers, measured side by side in one run and told as ratios."""
