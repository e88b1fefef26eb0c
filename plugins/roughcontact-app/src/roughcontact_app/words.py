"""Sentences of the library on the page: controls in the place of arguments."""

from __future__ import annotations

from roughcontact.errors import Argument, InputError, Sentence

# What the page calls the controls of arguments.
_CONTROLS = {
    "adhesion": "'Adhesion'",
    "approach": "an approach",
    "boundary": "'Beyond the border of the domain'",
    "force": "a force",
    "friction": "'Coefficient of friction'",
    "laws": "'Laws by which the surfaces change'",
    "non_measured": "'Non-measured points'",
    "pressure": "a mean pressure",
    "rows": "'Rows of the file'",
    "size": "both sides of the map",
    "sliding": "'Sliding distances'",
    "time": "'Times'",
    "unit": "'Unit of the heights'",
}
# What the page says below the name of a part that may be chosen, to somebody who has never met it.
_HELP = {
    "response": {
        "conductance": "How well heat or current passes through the spots in contact.",
        "first-yield": "The load at which a body begins to yield below its surface, if it is pressed on.",
        "flags": "Sharp edges, creases and rough heights, for which the numbers depend on the grid.",
        "imprint": "Depth, pile-up and volume of the imprint in a surface that has flowed.",
        "judgement": "What the uncertainties are found from, and why.",
        "leakage": "How much liquid a pressure drives through the gap, from one side to the other.",
        "noise": "How much of the heights is noise of the measurement.",
        "own-yield": "The load at which a body of the material 'plastic' begins to yield, if it is new.",
        "partial-slip": "Where the contact slips and where it sticks when it is pushed sideways.",
        "perimeter": "The length of the edges of all spots in contact.",
        "phases": "The same contact on half of its cells, twice: how far the numbers depend on the grid.",
        "plastic-zone": "How deep and how large the zone is that has flowed.",
        "pull-off": "The force that parts surfaces that attract each other.",
        "residual-stress": "The stress that stays in a body that has flowed.",
        "stability": "How close surfaces that attract each other are to a sudden jump: at 0 they jump.",
        "stiffness": "How much force another step of approach takes.",
        "stress": "The stress below the surface, with its maximum and the depth of that.",
        "tangential-stiffness": "How much force a small push sideways takes, before anything slips.",
        "total-stress": "The stress in a body that has flowed, by the load and by what stays.",
    },
    "law": {
        "archard": "Wear in proportion to the pressure and to how far the surfaces slide.",
        "oxidation": "Steel grows an oxide where air comes to it, and the gap narrows.",
    },
    "material": {
        "foam": "An open-cell foam, by the density of its cells: soft at first, then they collapse.",
        "plastic": "A metal that flows below its surface where the stress reaches its yield stress.",
        "transversely-isotropic": "Not as stiff downwards as along the surface: wood, a hexagonal crystal.",
        "linear-hardening": "The yield stress grows in proportion to the plastic strain.",
        "ludwik-hardening": "The yield stress grows by a power of the plastic strain.",
        "swift-hardening": "The yield stress is a power of the plastic strain and one from before.",
        "tabulated-hardening": "The yield stress as a test gave it: strains and stresses, with straight lines between.",
        "voce-hardening": "The yield stress grows up to a limit.",
        "residual-stress": "A stress from peening, grinding or hardening, which varies with the depth.",
    },
}
# Those whose values the page writes as a script does.
_WITH_VALUES = ("boundary", "non_measured", "rows")


def in_words_of_page(told: str | Exception) -> str:
    """Return a sentence of the library with the controls of the page."""
    return Sentence(told.marked if isinstance(told, InputError) else str(told)).spell(_spell_control)


def _spell_control(one: Argument) -> str:
    values = one.values if one.name in _WITH_VALUES else ()
    return " ".join(map(str, (_CONTROLS[one.name], *values))) if one.name in _CONTROLS else ""


def end_sentence(text: str) -> str:
    """Return a text with a capital letter and a full stop."""
    return f"{text[0].upper()}{text[1:].rstrip('.')}."


def explain(kind: str, name: str, summary: str) -> str:
    """Return what the page says of a part of a kind; its own summary of one that the page does not know."""
    return _HELP[kind].get(name) or summary[:1].lower() + summary[1:]
