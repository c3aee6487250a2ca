"""The cabinet task: open a drawer by its handle."""
