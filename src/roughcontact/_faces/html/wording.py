"""Advice of warnings in words that suit all who read a report, whatever they solve with."""

from __future__ import annotations

# What advice says for scripts and the command line, by what a report says instead.
_ADVICE = {
    ": surface.detrend('plane'), on the command line --detrend plane": "",
    "or boundary='free'": "or a free boundary",
    " (ElasticPerfectlyPlastic, on the command line --hardness)": "",
    "5 µm is 5e-6, 210 GPa is 210e9;": "5 µm is 5e-6 m, 210 GPa is 210e9 Pa;",
    "give unit= (on the command line --unit)": "state their unit",
    "keep them with non_measured='keep'": "keep them non-measured",
    " (rc.beyond_resolution gives the range of areas)": "",
}


def name_advice(text: str) -> str:
    """Return a warning without phrases of Python and options of the command line."""
    for phrase, words in _ADVICE.items():
        text = text.replace(phrase, words)
    return text
