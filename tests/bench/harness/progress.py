"""A bar on a terminal, a line now and then elsewhere. On stderr."""
import shutil
import sys
import time


class Progress:
    def __init__(self, title, total, stream=sys.stderr):
        self.title, self.total, self.stream = title, total, stream
        self.done = self.measured = 0
        self.start = self.told = time.monotonic()

    def step(self, text, measured=True):
        """One run more; `measured` unless it was there from an earlier session."""
        self.done += 1
        self.measured += measured
        if not measured and self.done < self.total:
            return
        if self.stream.isatty():
            self._draw(text)
        elif time.monotonic() - self.told > 30 or self.done == self.total:
            self.told = time.monotonic()
            print(f"{self._count()}  {text}", file=self.stream, flush=True)

    def end(self):
        if self.stream.isatty() and self.total:
            print(file=self.stream)

    def _count(self):
        elapsed = time.monotonic() - self.start
        left = elapsed / self.measured * (self.total - self.done) if self.measured else 0
        return f"{self.title} {self.done}/{self.total}  {_clock(elapsed)}, {_clock(left)} left"

    def _draw(self, text):
        filled = 24 * self.done // max(1, self.total)
        line = f"[{'#' * filled}{'-' * (24 - filled)}] {self._count()}  {text}"
        print("\r\033[K" + line[: shutil.get_terminal_size().columns - 1], end="", file=self.stream, flush=True)


def _clock(seconds):
    minutes, seconds = divmod(int(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{seconds:02}"
