"""Speed beside peers and the limit: interleaved rounds, medians, and whether the results agree."""
