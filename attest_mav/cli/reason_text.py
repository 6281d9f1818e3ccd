"""The reasons of verdicts in words; docs/verdict.md explains them at length."""

from typing import Final

REASON_WORDS: Final = {
    ("disagree", "tilt"): "the tilt differs",
    ("disagree", "heading"): "the tilt agrees, the heading differs",
    ("disagree", "frozen"): "the autopilot repeats one attitude while the vehicle turns",
    ("disagree", "settling"): "the difference has gone, but not for long enough",
    ("undecided", "doubted"): "receiver or magnetic field contradict our own attitude",
    ("undecided", "settling"): "a difference is there, but not for long enough",
    ("undecided", "disputed"): "our own attitudes differ on the autopilot's",
    ("undecided", "offset"): "a steady offset, as of an unknown trim",
    ("undecided", "heading-uncertain"): "the heading differs by no more than our own sigma explains",
    ("undecided", "low-confidence"): "our own tilt sigma is too large",
    ("undecided", "low-rate"): "our own tilt sigma is too large: inertial samples come too seldom",
    ("undecided", "no-estimate"): "we have no attitude: the filter aligns, or samples have stopped",
    ("undecided", "no-reference"): "the autopilot's attitudes have stopped",
    ("undecided", "unknown-frame"): "the frame of the autopilot's attitudes is not known",
    ("undecided", "two-senders"): "two vehicles send under one id",
}
"""By agreement and reason; AGREE needs none."""
