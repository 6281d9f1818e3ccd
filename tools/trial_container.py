"""A Debian that is booted by systemd as PID 1, in a container without a network: for tools/systemd_trial."""

import os
import shutil
import subprocess
import time
from pathlib import Path
from typing import Self

PACKAGES = "systemd,systemd-sysv,udev,dbus,python3,python3-venv,procps"
BOOT_S = 60.0


def obstacle() -> str:
    """Why no container can be booted here, "" where one can."""
    if os.geteuid() != 0:
        return "only root can boot a container"
    missing = [name for name in ("mmdebstrap", "systemd-nspawn", "nsenter") if shutil.which(name) is None]
    if missing:
        return f"{', '.join(missing)} not found; apt-get install mmdebstrap systemd-container util-linux"
    return ""


def make_root(folder: Path, suite: str, base: Path | None) -> None:
    """Fill a folder with a small Debian that has systemd and Python, from a mirror or a tar file of one."""
    command = ["mmdebstrap", "--quiet", "--variant=minbase", f"--include={PACKAGES}", suite, str(folder)]
    if base is not None:
        folder.mkdir()
        command = ["tar", "--extract", "--numeric-owner", f"--file={base}", f"--directory={folder}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise TrialError(f"{command[0]} failed: {done.stderr.strip()[-500:]}")
    # Nobody logs in, and a second booted system on this kernel has no business with its devices.
    for unit in ("getty.target", "console-getty.service", "systemd-networkd.service", "apt-daily.timer"):
        (folder / "etc/systemd/system" / unit).symlink_to("/dev/null")


class TrialError(Exception):
    """A step that did not go as it must."""


class Container:
    """The booted system below ``root``; a context."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self._process: subprocess.Popen[bytes] | None = None
        self._leader = 0

    def __enter__(self) -> Self:
        self._process = subprocess.Popen(
            [
                shutil.which("systemd-nspawn") or "systemd-nspawn",
                "--quiet",
                "--boot",
                "--register=no",
                "--keep-unit",
                "--private-network",
                "--machine=attest-mav-trial",
                f"--directory={self._root}",
            ],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            self._await_boot()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        if self._process is None:
            return
        if self._leader:
            os.kill(self._leader, 37)  # SIGRTMIN+3: systemd's word for "halt"
        else:
            self._process.terminate()
        try:
            self._process.wait(30.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process, self._leader = None, 0

    def run(self, *command: str, check: bool = True, timeout_s: float = 120.0) -> str:
        """What a command in the container writes; TrialError where it fails and must not."""
        code, text = self.attempt(*command, timeout_s=timeout_s)
        if check and code != 0:
            raise TrialError(f"{' '.join(command)}: exit code {code}: {text[-600:]}")
        return text

    def attempt(self, *command: str, timeout_s: float = 120.0) -> tuple[int, str]:
        """Exit code and what was written, stdout and stderr together."""
        enter = ["nsenter", "--target", str(self._leader), "--mount", "--uts", "--ipc", "--net", "--pid", "--cgroup"]
        environment = {"PATH": "/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin", "LANG": "C.UTF-8", "HOME": "/root"}
        try:
            done = subprocess.run(
                [*enter, "--", *command],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                env=environment,
                timeout=timeout_s,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise TrialError(f"{' '.join(command)}: did not return within {timeout_s:g} s") from None
        return done.returncode, done.stdout.strip()

    def _await_boot(self) -> None:
        """Wait for PID 1 of the container and for the end of its boot."""
        deadline = time.monotonic() + BOOT_S
        while not self._leader:
            self._leader = self._find_leader()
            if self._process is None or self._process.poll() is not None or time.monotonic() > deadline:
                raise TrialError("systemd-nspawn did not boot the container")
            time.sleep(0.05)
        while time.monotonic() < deadline:
            _, state = self.attempt("systemctl", "is-system-running", "--wait")
            if state.split("\n")[-1] in {"running", "degraded"}:
                return
            time.sleep(0.1)
        raise TrialError(f"the boot did not end within {BOOT_S:g} s")

    def _find_leader(self) -> int:
        """The PID on the host of the container's PID 1, 0 before there is one."""
        assert self._process is not None  # noqa: S101  (for type checkers)
        children = Path(f"/proc/{self._process.pid}/task/{self._process.pid}/children")
        try:
            found = [int(word) for word in children.read_text().split()]
        except OSError:
            return 0
        for pid in found:
            try:
                names = Path(f"/proc/{pid}/status").read_text()
            except OSError:
                continue
            if "\nNSpid:" in names and names.split("\nNSpid:")[1].split("\n")[0].split()[-1] == "1":
                comm = Path(f"/proc/{pid}/comm").read_text().strip()
                return pid if comm == "systemd" else 0
        return 0
