"""From samples to estimates and judgements: time base, alignment, lanes, pipeline, verdict."""
