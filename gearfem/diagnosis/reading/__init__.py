"""Read campaigns: records, their faults and roles, and the noise in them."""
