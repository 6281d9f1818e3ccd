"""What the daemon shows over HTTP, without I/O: requests, answers, and the documents made of a snapshot."""
