"""The wire: framing, decoding into SI samples, encoding, and the manners of a component."""
