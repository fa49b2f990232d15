"""The library of effects; each is a small plug-in, see `base`, and `library` for all of them."""
