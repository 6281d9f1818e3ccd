"""The papers' scenarios and figures. ``scenarios`` lists them by id."""
