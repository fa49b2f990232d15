"""Recordings of others, bags and CSV files, made into sessions by a mapping."""
