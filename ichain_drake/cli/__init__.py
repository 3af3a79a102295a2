"""The `ichain` command."""
