"""The page on planned motions."""
