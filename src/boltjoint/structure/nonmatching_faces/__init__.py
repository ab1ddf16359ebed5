"""Contact of two surfaces whose faces need not match: segments, and weighted points on them."""
