import os
from contextlib import suppress

import pytest

from attest_mav.config.records import LinkConfig
from attest_mav.errors import ConfigError
from attest_mav.runtime.keys import read_key, read_keys

KEY = bytes(range(1, 33))


def made(tmp_path, content, mode=0o600):
    path = tmp_path / "link.key"
    path.write_bytes(content)
    path.chmod(mode)
    return str(path)


@pytest.mark.parametrize(
    "content",
    [KEY, KEY.hex().encode(), KEY.hex().upper().encode() + b"\n", KEY.hex().encode() + b"\r\n"],
    ids=["bytes", "digits", "a line", "another line"],
)
@pytest.mark.parametrize("mode", [0o600, 0o400])
def test_a_key_is_bytes_or_digits(tmp_path, content, mode):
    assert read_key(made(tmp_path, content, mode)) == KEY


@pytest.mark.parametrize("mode", [0o644, 0o640, 0o604, 0o620, 0o666])
def test_a_key_that_others_may_read_is_refused_with_the_remedy(tmp_path, mode):
    path = made(tmp_path, KEY, mode)
    with pytest.raises(ConfigError) as caught:
        read_key(path)
    assert f"others may read or change it (mode {mode:04o}): chmod 600 {path}" in str(caught.value)
    assert caught.value.exit_code == 78


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "expected 32 bytes, or 64 hexadecimal digits"),
        (KEY[:-1], "expected 32 bytes"),
        (KEY + b"\n", "expected 32 bytes"),
        (b"x" * 64, "expected 32 bytes"),
        (KEY.hex().encode() * 2, "expected 32 bytes"),
        (b"\xff" * 64, "expected 32 bytes"),
        (bytes(32), "all bytes are zero"),
        (b"0" * 64, "all bytes are zero"),
    ],
)
def test_what_is_no_key_is_refused_and_not_shown(tmp_path, content, said):
    path = made(tmp_path, content)
    with pytest.raises(ConfigError) as caught:
        read_key(path)
    assert said in str(caught.value)
    assert path in str(caught.value)
    assert not content or repr(content)[2:-1] not in str(caught.value)


@pytest.mark.parametrize("make", [lambda _path: None, os.mkdir, os.mkfifo], ids=["missing", "directory", "pipe"])
def test_what_is_no_file_is_refused(tmp_path, make):
    path = str(tmp_path / "k")
    make(path)
    with suppress(FileNotFoundError):
        os.chmod(path, 0o700 if os.path.isdir(path) else 0o600)  # noqa: PTH101, PTH112
    with pytest.raises(ConfigError, match=r"key_file .*/k: "):
        read_key(path)


def test_keys_are_read_for_links_that_sign_alone(tmp_path):
    path = made(tmp_path, KEY)
    signing = LinkConfig(url="sim:", signing="sign", key_file=path)
    silent = LinkConfig(url="sim:", key_file="/nowhere")
    assert read_keys([signing, silent]) == {path: KEY}
