"""The library of effects; each is a small plug-in, see `base`, and `known` for all of them."""
