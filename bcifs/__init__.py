"""bcifs."""
