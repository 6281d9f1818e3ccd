"""The behaviour of a companion component: discovery, ports, streams, commands, encoder."""
