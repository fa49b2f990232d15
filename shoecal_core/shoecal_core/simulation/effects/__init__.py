"""Effects that a reality lists: one module a family, each effect a small class of its own."""
