"""BROAD: filters over hand-held motion under optical motion capture, by the metric of the data set's authors."""
