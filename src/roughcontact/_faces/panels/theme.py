"""The look of figures: colours that the colour-blind tell apart, in light and dark."""

from __future__ import annotations

from typing import Any

import attrs

from roughcontact._base.checks import flag
from roughcontact.errors import MissingPackage
from roughcontact.errors.door import guarded

# Numbers between these are written without powers on logarithmic axes.
_PLAIN_NUMBER_RANGE = (0.99e-4, 1.01e4)


def require_matplotlib() -> None:
    """Raise `MissingPackage` without matplotlib."""
    try:
        import matplotlib  # noqa: F401 - whether it is there
    except ImportError:
        raise MissingPackage("Drawing needs matplotlib: pip install 'roughcontact[plot]'.") from None


@attrs.frozen
class Theme:
    """Colours of a figure.

    Attributes
    ----------
    ink, paper
        Text and lines; the background.
    open, unknown
        Cells without contact; non-measured points.
    edge, limit
        Edge of the contact; saturated cells.
    body, counterbody
        The two bodies in a cut.
    lines
        Colours of curves, in order: the palette of Okabe and Ito, https://jfly.uni-koeln.de/color, in an order in which
        neighbours differ in lightness too.
    is_dark
        Whether the background is dark.
    """

    ink: str
    paper: str
    open: str
    unknown: str
    edge: str
    limit: str
    body: str
    counterbody: str
    lines: tuple[str, ...]
    is_dark: bool = False


LIGHT = Theme(
    ink="#1a1a1a",
    paper="#ffffff",
    open="#ebebeb",
    unknown="#9a9a9a",
    edge="#000000",
    limit="#d55e00",
    body="#8fb8d8",
    counterbody="#c9c9c9",
    lines=("#0072b2", "#e69f00", "#000000", "#56b4e9", "#009e73"),
)
DARK = Theme(
    ink="#e6e6e6",
    paper="#14171c",
    open="#2b3038",
    unknown="#7d828a",
    edge="#ffffff",
    limit="#ff8c42",
    body="#2f6690",
    counterbody="#5b616b",
    lines=("#56b4e9", "#f0e442", "#ffffff", "#009e73", "#e69f00"),
    is_dark=True,
)


def parameters(dark: bool) -> dict[str, Any]:
    """Return the parameters of matplotlib, `matplotlib.rcParams`, that differ from its defaults."""
    from matplotlib.rcsetup import cycler

    theme = DARK if dark else LIGHT
    inked = ("axes.edgecolor", "axes.labelcolor", "axes.titlecolor", "text.color", "xtick.color", "ytick.color")
    papered = ("axes.facecolor", "figure.facecolor", "savefig.facecolor", "legend.facecolor")
    return {
        **dict.fromkeys(inked, theme.ink),
        **dict.fromkeys(papered, theme.paper),
        "axes.formatter.limits": (-4, 5),
        "axes.formatter.use_mathtext": True,
        "axes.linewidth": 0.7,
        "axes.prop_cycle": cycler(color=theme.lines),
        "axes.titlesize": 9,
        "figure.constrained_layout.h_pad": 0.06,
        "figure.constrained_layout.wspace": 0.06,
        "figure.titlesize": 10,
        "font.size": 9,
        "grid.color": theme.ink,
        "grid.alpha": 0.18,
        "grid.linewidth": 0.5,
        "hatch.color": theme.ink,
        "legend.edgecolor": theme.ink,
        "legend.fontsize": 8,
        "legend.framealpha": 0.85,
        "legend.frameon": False,
        "lines.linewidth": 1.5,
        "lines.markersize": 4,
        "patch.edgecolor": theme.ink,
        "xtick.labelsize": 8,
        # Minor ticks are shorter than major ones, and their labels stand on one line with these.
        "xtick.minor.pad": 5.0,
        "ytick.minor.pad": 5.0,
        "ytick.labelsize": 8,
    }


@guarded
def style(dark: bool = False) -> Any:
    """Return a context in which matplotlib draws as the panels do; its end restores the parameters.

    Parameters
    ----------
    dark
        Whether the background is dark.

    Raises
    ------
    MissingPackage
        If matplotlib, of the extra ``plot``, is not installed.

    Examples
    --------
    >>> with rc.style():  # doctest: +SKIP
    ...     figure, axes = plt.subplots()
    """
    require_matplotlib()
    from matplotlib import pyplot

    # Loads the backend: in notebooks it sets parameters of its own, which the end of the context would take back.
    pyplot.draw_if_interactive()  # type: ignore[no-untyped-call]
    return apply_theme(dark)


def apply_theme(dark: bool = False) -> Any:
    """Return the context of `style` for figures that pyplot does not hold."""
    from matplotlib import style as styles

    return styles.context(["default", parameters(flag(dark, "dark="))])


def theme_of(axes: Any) -> Theme:
    """Return the theme that suits the background of the figure that axes are on."""
    from matplotlib.colors import to_rgba

    red, green, blue, alpha = to_rgba(axes.get_figure(root=True).get_facecolor())
    return DARK if alpha * (0.299 * red + 0.587 * green + 0.114 * blue) + 1.0 - alpha < 0.5 else LIGHT


def plain_logarithms() -> Any:
    """Return a formatter of logarithmic axes that writes 0.1, 1, 10 instead of powers."""
    from matplotlib.ticker import LogFormatterSciNotation

    class PlainLogarithms(LogFormatterSciNotation):
        def __call__(self, x: float, pos: int | None = None) -> str:
            text = str(super().__call__(x, pos))
            return f"{x:g}" if text and _PLAIN_NUMBER_RANGE[0] < x < _PLAIN_NUMBER_RANGE[1] else text

    return PlainLogarithms(minor_thresholds=(1.2, 0.5))
