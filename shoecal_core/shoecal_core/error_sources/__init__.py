"""What may be wrong with robot and shoes, and what each of it does to every signal."""
