"""The pages of docs/reference, made from the code: what a page says is what the code does."""
