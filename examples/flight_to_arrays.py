"""A recorded flight as arrays: the flight filter's tilt error and its own sigma against the reference in the log.

.venv/bin/python examples/flight_to_arrays.py LOG [PICTURE.png]
"""

import sys

import numpy as np
import numpy.typing as npt

from attest_mav import VelocityAided, read_log, run_readings

Array = npt.NDArray[np.float64]


def down(attitudes: Array) -> Array:
    """The direction down in the body, shape (n, 3)."""
    w, x, y, z = attitudes.T
    return np.column_stack((2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))


def main(log_name: str, picture: str | None) -> None:
    """Print the figures of the flight, and draw them."""
    log = read_log(log_name)
    if log.reference is None:
        sys.exit(f"{log_name} has no attitude to compare with")
    solution = run_readings(VelocityAided().with_vehicle_settings(log.settings), log.readings)
    # The reference at the times of the readings: components of the direction, linear between its samples.
    t, true_down = log.reference_t, down(log.reference_attitudes)
    at_readings = np.column_stack([np.interp(solution.t, t, true_down[:, k]) for k in range(3)])
    at_readings /= np.linalg.norm(at_readings, axis=1)[:, None]
    error = np.degrees(np.arccos(np.clip(np.sum(down(solution.attitudes) * at_readings, axis=1), -1.0, 1.0)))
    sigma = np.degrees(solution.tilt_sigma)
    late = solution.aligned & (solution.t > t[0]) & (solution.t < t[-1])
    print(f"{log.inertial}: {len(log.readings)} readings; reference {log.reference}")
    print(f"aligned after {solution.t[np.argmax(solution.aligned)]:.1f} s")
    print(
        f"tilt error: rms {np.sqrt(np.mean(error[late] ** 2)):.2f} degrees; median sigma {np.median(sigma[late]):.2f}"
    )
    if picture is not None:
        import matplotlib.pyplot as plt  # noqa: PLC0415 - only for a picture

        figure, axes = plt.subplots(figsize=(8, 4))
        axes.plot(solution.t[late], error[late], label=f"error against {log.reference}")
        axes.plot(solution.t[late], sigma[late], label="own sigma")
        axes.set(xlabel="time, s", ylabel="degrees", title="Tilt of velocity-aided")
        axes.legend()
        figure.savefig(picture, dpi=120)


if __name__ == "__main__":
    if len(sys.argv) not in {2, 3}:
        sys.exit("usage: flight_to_arrays.py LOG [PICTURE.png]")
    main(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else None)
