"""The only package that waits, reads clocks and opens files and sockets."""
