"""What a benchmark found: sentences, tables, numbers and pictures, written as Markdown, JSON and PNG."""

from __future__ import annotations

import dataclasses
import io
import os
import platform
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vr_envs.evaluation.files import write_bytes, write_json
from vr_envs.evaluation.report import versions
from vr_envs.evaluation.table import markdown

if TYPE_CHECKING:
    from collections.abc import Collection

    from matplotlib.figure import Figure


@dataclasses.dataclass(frozen=True)
class Table:
    """A titled table of texts; columns numbered in `left` are aligned to the left. `note` stands under it.

    `detail`: it goes to NAME.md, not to the terminal.
    """

    title: str
    head: list[str]
    rows: list[list[str]]
    left: Collection[int] = (0,)
    note: str = ""
    detail: bool = False

    def markdown(self) -> str:
        """As Markdown, which also reads well as plain text."""
        note = f"\n\n{self.note}" if self.note else ""
        return f"### {self.title}\n\n{markdown(self.head, self.rows, self.left)}{note}"


def processor() -> str:
    """The processor's name, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def machine() -> dict[str, str]:
    """Processor, cores, system and versions, on which every number here depends."""
    return {"processor": f"{processor()}, {os.cpu_count()} cores", "system": platform.platform(), **versions()}


@dataclasses.dataclass
class Report:
    """What one benchmark found.

    `sentences`: what the tables say, in words; `numbers`: everything, for programs; `figures`: name -> picture;
    `failed`: something is wrong with what was measured, and the command's exit code says so.
    """

    name: str
    title: str
    sentences: list[str] = dataclasses.field(default_factory=list)
    tables: list[Table] = dataclasses.field(default_factory=list)
    numbers: dict[str, Any] = dataclasses.field(default_factory=dict)
    figures: dict[str, Figure] = dataclasses.field(default_factory=dict)
    failed: bool = False

    def text(self, detail: bool = True) -> str:
        """Sentences and tables, as Markdown; without tables of detail for a terminal."""
        lines = [f"## {self.title}", ", ".join(f"{key} {value}" for key, value in machine().items())]
        lines += ["\n".join(f"- {sentence}" for sentence in self.sentences)] if self.sentences else []
        lines += [table.markdown() for table in self.tables if detail or not table.detail]
        return "\n\n".join(lines) + "\n"

    def write(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write NAME.json, NAME.md and NAME-PICTURE.png, each all or nothing; returns their paths.

        Raises:
            OSError: the folder cannot be made or written.
        """
        target = Path(folder)
        target.mkdir(parents=True, exist_ok=True)
        data = {"name": self.name, "machine": machine(), "sentences": self.sentences, "numbers": self.numbers}
        paths = [target / f"{self.name}.json", target / f"{self.name}.md"]
        write_json(paths[0], data)
        pictures = [f"![{name}]({self.name}-{name}.png)" for name in self.figures]
        write_bytes(paths[1], "\n\n".join([self.text().rstrip(), *pictures, ""]).encode())
        for name, figure in self.figures.items():
            buffer = io.BytesIO()
            figure.savefig(buffer, format="png", dpi=150)
            paths.append(target / f"{self.name}-{name}.png")
            write_bytes(paths[-1], buffer.getvalue())
        return paths
