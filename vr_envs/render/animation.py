"""Pictures in files: an animation (.gif, .mp4) or the last picture (.png)."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import closing
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from vr_envs.render.extras import extra
from vr_envs.render.style import INKS, PAPER, mix

SUFFIXES = (".gif", ".mp4", ".png")
THINNED = 8  # shades of an ink in a film's palette


def write_animation(path: str | os.PathLike[str], frames: Iterable[np.ndarray], fps: float) -> None:
    """Write pictures to a file, whole or not at all: a file that is there stays as it is if anything fails.

    Args:
        path: the name ends in .gif (endless loop), .mp4 (H.264) or .png (the last picture alone).
        frames: pictures (height, width, 3) uint8, all of one size, taken one by one; an .mp4 needs even sizes.
        fps: pictures per second, positive. A .gif keeps time in hundredths of a second, and at most 50 a second.

    Raises:
        ValueError: another extension, no pictures, or an `fps` that is not positive.
        ImportError: imageio is missing; it says what to install.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in SUFFIXES:
        raise ValueError(f"{target} is not a name for a picture; it must end in one of {', '.join(SUFFIXES)}")
    if not 0.0 < fps < float("inf"):
        raise ValueError(f"fps = {fps!r} is not allowed; give a number above 0")
    write = {".gif": _write_gif, ".mp4": _write_mp4, ".png": _write_png}[suffix]
    # a failure to import must not leave even an empty file behind
    module = extra("PIL.Image") if suffix == ".gif" else extra("imageio.v2")
    handle, temporary = tempfile.mkstemp(suffix=suffix, prefix=f".{target.stem}-", dir=target.parent)
    os.close(handle)
    try:
        pictures = iter(frames)
        first = next(pictures, None)
        if first is None:
            raise ValueError("there are no pictures to write")
        write(module, temporary, chain([first], pictures), fps)
        # mkstemp makes a private file; this one gets the permissions of any new file
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(temporary, 0o666 & ~umask)
        os.replace(temporary, target)
    except BaseException:
        os.unlink(temporary)
        raise


def _palette(image: Any, first: np.ndarray) -> Any:
    """256 colours for a whole film: the first picture's own, then every ink of these pictures thinned on paper.

    One palette for all keeps what does not move the same from picture to picture, which halves the file.
    """
    inks = [c for ink in INKS for k in range(1, THINNED + 1) for c in mix(PAPER, ink, k / THINNED)]
    own = image.fromarray(first).quantize(256 - len(inks) // 3).getpalette()
    palette = image.new("P", (1, 1))
    palette.putpalette(own + inks)
    return palette


def _write_gif(image: Any, path: str, frames: Iterator[np.ndarray], fps: float) -> None:
    """Each picture is reduced to the palette as it comes, so a long film takes a third of the memory."""
    first = next(frames)
    palette = _palette(image, first)
    pictures = (
        image.fromarray(frame).quantize(palette=palette, dither=image.Dither.NONE) for frame in chain([first], frames)
    )
    duration = 10 * max(2, round(100.0 / fps))
    next(pictures).save(path, save_all=True, append_images=pictures, duration=duration, loop=0)


def _write_mp4(imageio: Any, path: str, frames: Iterator[np.ndarray], fps: float) -> None:
    # the writer's own context does not wait for ffmpeg after a failure, which then writes to a file that is gone
    with closing(imageio.get_writer(path, fps=fps, macro_block_size=2)) as film:
        for frame in frames:
            film.append_data(frame)


def _write_png(imageio: Any, path: str, frames: Iterator[np.ndarray], fps: float) -> None:
    last = next(frames)
    for frame in frames:
        last = frame
    imageio.imwrite(path, last)
