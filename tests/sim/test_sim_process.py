"""``attest-mav sim`` as a process on free ports, heard by pymavlink."""

import signal
import socket
import subprocess
import time

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

TIMEOUT_S = 20.0


@pytest.fixture
def start(command):
    """start(*arguments): the simulator as a process; ended at the latest with the test."""
    processes = []

    def begin(*arguments):
        process = subprocess.Popen([*command, "sim", *arguments], stderr=subprocess.PIPE, text=True)
        processes.append(process)
        return process

    yield begin
    for process in processes:
        process.kill()
        process.communicate()


@pytest.fixture
def listener():
    """A bound UDP socket and its port."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        sock.settimeout(TIMEOUT_S)
        yield sock, sock.getsockname()[1]


def gather(sock, enough):
    """Messages by type, until ``enough`` of them is true."""
    parser = mavlink.MAVLink(None)
    messages = {}
    until = time.monotonic() + TIMEOUT_S
    while not enough(messages):
        assert time.monotonic() < until, f"only { ({k: len(v) for k, v in messages.items()}) }"
        for message in parser.parse_buffer(sock.recv(65536)) or []:
            messages.setdefault(message.get_type(), []).append(message)
    return messages


def test_it_flies_for_its_duration_and_ends_with_zero(start, listener):
    sock, port = listener
    link = f"udpout:127.0.0.1:{port}"
    process = start("--link", link, "--duration", "1.5", "--rate", "100", "--scenario", "square", "--seed", "3")
    messages = gather(sock, lambda m: len(m.get("RAW_IMU", [])) == 150)
    _, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0
    assert errors == (
        f"attest-mav sim: ardupilot vehicle, scenario square, RAW_IMU at 100 Hz, seed 3, on {link} for 1.5 s\n"
    )
    times = [m.time_usec for m in messages["RAW_IMU"]]
    assert times == [10_000 * (k + 1) for k in range(150)]
    assert len(messages["SIM_STATE"]) in {149, 150}  # sent after the last RAW_IMU


def test_a_fault_is_flown_and_told_at_the_start(start, listener):
    sock, port = listener
    faults = ["--fault", "gyro2-stuck=10@0.5", "--fault", "receiver-off@0"]
    process = start("--link", f"udpout:127.0.0.1:{port}", "--duration", "1", *faults)
    messages = gather(sock, lambda m: len(m.get("SCALED_IMU2", [])) == 50)
    _, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0
    assert ", seed 0, faults gyro2-stuck=10@0.5 receiver-off@0, on udpout:" in errors
    stuck = [m.time_boot_ms for m in messages["SCALED_IMU2"] if (m.xgyro, m.ygyro, m.zgyro) == (174, 174, 174)]
    assert stuck == list(range(500, 1001, 20))
    assert {m.xgyro for m in messages["RAW_IMU"]} != {174}


def test_it_keeps_real_time(start, listener):
    sock, port = listener
    start("--link", f"udpout:127.0.0.1:{port}", "--rate", "50")
    gather(sock, lambda m: len(m.get("RAW_IMU", [])) == 5)
    began = time.monotonic()
    gather(sock, lambda m: len(m.get("RAW_IMU", [])) == 100)
    assert time.monotonic() - began > 1.7  # 95 periods of 20 ms, and not faster; slower is the machine's affair


def test_speed_makes_time_go_faster(start, listener):
    sock, port = listener
    began = time.monotonic()
    process = start("--link", f"udpout:127.0.0.1:{port}", "--duration", "20", "--speed", "20", "--scenario", "still")
    # Datagrams may be lost at this speed, so their number proves nothing; the time that they carry does.
    gather(sock, lambda m: "RAW_IMU" in m and m["RAW_IMU"][-1].time_usec > 15_000_000)
    assert time.monotonic() - began < 15.0  # what it would take at speed 1
    assert process.wait(TIMEOUT_S) == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_end_it_with_zero(start, listener, number):
    sock, port = listener
    process = start("--link", f"udpout:127.0.0.1:{port}", "--personality", "px4")
    gather(sock, lambda m: "HIGHRES_IMU" in m)
    process.send_signal(number)
    _, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 0
    assert len(errors.splitlines()) == 1


def test_it_takes_commands_over_tcp(start):
    process = start("--link", "tcpin:127.0.0.1:0", "--scenario", "still")
    port = int(process.stderr.readline().partition("tcpin:127.0.0.1:")[2].split()[0])
    companion = mavlink.MAVLink(None, srcSystem=1, srcComponent=193)
    ask = mavlink.MAVLink_command_long_message(
        1, 1, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 0, mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION, 10_000, 0, 0, 0, 0, 0
    )
    with socket.create_connection(("127.0.0.1", port), TIMEOUT_S) as sock:
        gather(sock, lambda m: "HEARTBEAT" in m)
        sock.sendall(ask.pack(companion))
        messages = gather(sock, lambda m: len(m.get("ATTITUDE_QUATERNION", [])) == 50)
    assert messages["COMMAND_ACK"][0].result == mavlink.MAV_RESULT_ACCEPTED
    times = [m.time_boot_ms for m in messages["ATTITUDE_QUATERNION"]]
    assert times[-1] - times[0] == 490


def test_a_new_tcp_peer_is_heard_though_the_last_one_left_in_mid_frame(start):
    process = start("--link", "tcpin:127.0.0.1:0", "--scenario", "still")
    port = int(process.stderr.readline().partition("tcpin:127.0.0.1:")[2].split()[0])
    companion = mavlink.MAVLink(None, srcSystem=1, srcComponent=193)
    ask = mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0).pack(companion)
    with socket.create_connection(("127.0.0.1", port), TIMEOUT_S) as sock:
        sock.sendall(ask[:20])
        gather(sock, lambda m: "HEARTBEAT" in m)
    with socket.create_connection(("127.0.0.1", port), TIMEOUT_S) as sock:
        sock.sendall(ask)
        assert gather(sock, lambda m: "COMMAND_ACK" in m)["COMMAND_ACK"][0].command == 400


def test_a_busy_port_is_one_line_and_69(start):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        process = start("--link", f"tcpin:127.0.0.1:{port}")
        _, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 69
    assert len(errors.splitlines()) == 1
    assert errors.startswith(f"attest-mav: error: cannot listen on tcpin:127.0.0.1:{port}")


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--scenario", "loop"], "'loop': expected one of still, hover, coordinated-turns, square, rover, tumbling"),
        (["--personality", "inav"], "'inav': expected one of ardupilot, px4"),
        (["--rate", "0"], "rate 0 Hz is out of range: expected 1 to 1000"),
        (["--rate", "nan"], "rate nan Hz is out of range"),
        (["--speed", "0"], "--speed 0 is out of range: expected 0.01 to 100"),
        (["--duration", "-1"], "--duration -1 is out of range"),
        (
            ["--fault", "gyro-bais-x=5@20"],
            "fault 'gyro-bais-x=5@20': unknown fault 'gyro-bais-x'; did you mean gyro-bias?",
        ),
        (
            ["--fault", "receiver-off@1", "--fault", "trim=999@3"],
            "trim in deg 999 is out of range: expected -180 to 180",
        ),
        (["--link", "sim:"], "needs a real link"),
        (["--link", "carrier-pigeon:"], "carrier-pigeon"),
    ],
)
def test_arguments_that_make_no_sense_are_one_line_and_2(start, arguments, text):
    process = start(*arguments)
    _, errors = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 2
    assert len(errors.splitlines()) == 1
    assert errors.startswith("attest-mav: error: ")
    assert text in errors
