"""The page on a diagnosis."""
