"""The configuration: TOML text to frozen, checked records."""
