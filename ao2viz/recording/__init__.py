"""What happened: episodes with the decision behind every step, growth, and returns."""
