"""What is looked at by `export.check`, one question a file."""
