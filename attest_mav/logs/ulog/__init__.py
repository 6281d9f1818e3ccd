"""ULog, which PX4 records on board: messages, topics, and the source made of them."""
