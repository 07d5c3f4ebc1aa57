"""Numbers and tables as Markdown."""
import math
import textwrap

NO_FIGURES = "*No figures: the runs that this needs were not made.*"


def seconds(value):
    if value is None or math.isnan(value):
        return "–"
    for factor, unit in ((1, "s"), (1e3, "ms"), (1e6, "µs"), (1e9, "ns")):
        if value * factor >= 1 or unit == "ns":
            return f"{rounded(value * factor)} {unit}"
    return ""


def rounded(value):
    """Three digits."""
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    digits = max(0, 2 - math.floor(math.log10(abs(value))))
    return f"{value:.{digits}f}" if digits < 6 else f"{value:.2e}"


def ratio(value):
    return "–" if math.isnan(value) else rounded(value) + "x"


def percent(value):
    return "–" if math.isnan(value) else f"{100 * value:.3g} %"


def count(value):
    return f"{int(value):,}".replace(",", " ")


def table(header, rows):
    """Columns after the first are numbers, to the right."""
    if not rows:
        return NO_FIGURES
    lines = ["| " + " | ".join(header) + " |", "|---" + "|--:" * (len(header) - 1) + "|"]
    lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines)


def wrapped(figures):
    """Lines as the docs have them: tables may be wider."""
    return "\n".join(line if line.startswith("|") else textwrap.fill(line, 100) for line in figures.split("\n"))


def with_handicap(figures, page=""):
    """Says before figures that show `triangle_set`, our [TLK09], that it has a handicap, which `page` describes."""
    note = f"`triangle_set` has a [handicap]({page}#the-papers-evidence-on-these-pairs).\n\n"
    return (note if "`triangle_set`" in figures else "") + figures
