"""One page of a replayed flight: its series over log time, and its figures."""
