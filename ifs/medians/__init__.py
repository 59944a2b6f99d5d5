"""Sets between sets, and the clouds that they become."""
