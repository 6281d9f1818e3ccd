"""The witness: which of several attitudes are not refuted, and which sensor or receiver is at fault."""
