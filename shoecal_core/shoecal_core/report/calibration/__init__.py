"""Pages on calibrations, from recordings and with known weights."""
