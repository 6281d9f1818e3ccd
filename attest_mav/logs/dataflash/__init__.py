"""DataFlash logs, which ArduPilot records on board: records, readers, and the source made of them."""
