"""The effect of one parameter: the gradient-descent filter's speed of correction on a recorded flight.

    .venv/bin/python examples/tuning.py LOG [PICTURE.png]

A fast correction follows the specific force, which in a turn is not gravity; a slow one leaves the gyro's bias. The
command `attest-mav tune` searches several parameters on many logs.
"""

import sys
from typing import Final

from attest_mav import GradientDescent, replay_log

BETAS: Final = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)
"""rad/s."""


def main(log_name: str, picture: str | None) -> None:
    """Print the tilt error for each value, and draw it."""
    errors = []
    for beta in BETAS:
        tilt = replay_log(log_name, [GradientDescent(beta=beta)], skip_s=5.0)["filters"][0]["tilt_deg"]
        if tilt is None:
            sys.exit(f"{log_name} has no attitude to compare with")
        errors.append(tilt["rms"])
        print(f"beta {beta:<6g} tilt error: rms {tilt['rms']:6.2f} degrees")
    if picture is not None:
        import matplotlib.pyplot as plt  # noqa: PLC0415 - only for a picture

        figure, axes = plt.subplots(figsize=(6, 4))
        axes.semilogx(BETAS, errors, marker="o")
        axes.set(xlabel="beta, rad/s", ylabel="tilt error, rms, degrees", title="gradient-descent")
        figure.savefig(picture, dpi=120)


if __name__ == "__main__":
    if len(sys.argv) not in {2, 3}:
        sys.exit("usage: tuning.py LOG [PICTURE.png]")
    main(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else None)
