import stat
import sys

import imageio.v3 as iio
import numpy as np
import pytest

from vr_envs.render import write_animation
from vr_envs.render.style import RED


def picture(k):
    frame = np.full((40, 64, 3), (250, 249, 245), np.uint8)
    frame[10:30, 4 * k : 4 * k + 12] = (47, 111, 163)
    return frame


# a GIF's colours are looked up to 5 bits in 256; a film compresses
@pytest.mark.parametrize(("name", "off"), [("a.gif", 8.0), ("a.mp4", 12.0)])
def test_an_animation_reads_back(name, off, tmp_path):
    frames = [picture(k) for k in range(6)]
    write_animation(tmp_path / name, iter(frames), 20.0)
    back = np.stack([f[..., :3] for f in iio.imiter(tmp_path / name)])
    assert back.shape == (6, 40, 64, 3)
    # the middle of each block keeps its colour, and so does the paper
    for k in range(6):
        assert np.abs(back[k, 20, 4 * k + 6].astype(float) - frames[k][20, 4 * k + 6]).max() <= off
        assert np.abs(back[k, 2, 50].astype(float) - frames[k][2, 50]).max() <= off
    assert list(tmp_path.iterdir()) == [tmp_path / name]


@pytest.mark.parametrize(("fps", "milliseconds"), [(15.0, 70), (1000.0, 20)])
def test_a_gif_counts_hundredths_of_a_second(fps, milliseconds, tmp_path):
    write_animation(tmp_path / "a.gif", [picture(0), picture(1)], fps)
    assert iio.immeta(tmp_path / "a.gif")["duration"] == milliseconds


def test_film_pace(tmp_path):
    write_animation(str(tmp_path / "a.mp4"), [picture(k) for k in range(5)], 12.5)
    assert iio.immeta(tmp_path / "a.mp4")["fps"] == pytest.approx(12.5)


def test_a_still_is_the_last_picture(tmp_path):
    write_animation(tmp_path / "a.png", (picture(k) for k in range(4)), 10.0)
    assert (iio.imread(tmp_path / "a.png") == picture(3)).all()


def test_a_single_picture_is_an_animation_too(tmp_path):
    write_animation(tmp_path / "a.gif", [picture(2)], 10.0)
    assert np.abs(iio.imread(tmp_path / "a.gif", index=0)[..., :3].astype(float) - picture(2)).max() <= 8.0


def test_a_colour_that_comes_late_is_kept_in_a_gif(tmp_path):
    late = picture(3)
    late[2:8, 2:8] = RED
    write_animation(tmp_path / "a.gif", [picture(0), picture(1), late], 10.0)
    last = list(iio.imiter(tmp_path / "a.gif"))[-1]
    assert np.abs(last[5, 5, :3].astype(float) - RED).max() <= 8.0


@pytest.mark.parametrize("name", ["a.avi", "a", "a.jpg"])
def test_another_extension_is_refused(name, tmp_path):
    with pytest.raises(ValueError, match=r"\.gif, \.mp4, \.png"):
        write_animation(tmp_path / name, [picture(0)], 10.0)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("fps", [0.0, -1.0, float("nan"), float("inf")])
def test_an_impossible_pace_is_refused(fps, tmp_path):
    with pytest.raises(ValueError, match="fps"):
        write_animation(tmp_path / "a.gif", [picture(0)], fps)


@pytest.mark.parametrize("name", ["a.gif", "a.mp4", "a.png"])
def test_a_failure_leaves_the_file_that_was_there(name, tmp_path):
    def broken():
        yield picture(0)
        yield picture(1)
        raise RuntimeError("the episode broke")

    (tmp_path / name).write_bytes(b"earlier")
    with pytest.raises(RuntimeError, match="the episode broke"):
        write_animation(tmp_path / name, broken(), 10.0)
    with pytest.raises(ValueError, match="no pictures"):
        write_animation(tmp_path / name, [], 10.0)
    assert (tmp_path / name).read_bytes() == b"earlier"
    # ffmpeg has been waited for, so nothing appears later
    assert list(tmp_path.iterdir()) == [tmp_path / name]


def test_the_file_is_as_readable_as_any_new_one(tmp_path):
    (tmp_path / "plain").touch()
    write_animation(tmp_path / "a.png", [picture(0)], 10.0)
    modes = [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("plain", "a.png")]
    assert modes[0] == modes[1]


@pytest.mark.parametrize(("name", "module"), [("a.gif", "PIL"), ("a.mp4", "imageio"), ("a.png", "imageio")])
def test_a_missing_package_says_what_to_install(name, module, monkeypatch, tmp_path):
    for known in [module, *(m for m in sys.modules if m.startswith(f"{module}."))]:
        monkeypatch.setitem(sys.modules, known, None)
    with pytest.raises(ImportError, match=r"pip install '\.\[render\]' in a clone"):
        write_animation(tmp_path / name, [picture(0)], 10.0)
    assert not list(tmp_path.iterdir())
