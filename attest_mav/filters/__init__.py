"""The attitude filters: values with a pure step."""
