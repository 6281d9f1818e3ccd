"""The site of the daemon on its event loop; imported only where it is switched on."""
