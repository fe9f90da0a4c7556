"""What to mind of a run: each warning leads to the place on the page that shows it, and to what it means."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ncf_fenicsx.report.curves import ERRORS, PENETRATION, PIVOTS, STEP_SIZES, anchor, curves
from ncf_fenicsx.report.error_bars import FORCE, VF
from ncf_fenicsx.report.numbers import unbalanced
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.sentence import short

LARGE_ERROR = 0.1
"""Estimated error of the field of Vf, over its change, from which on it is a warning."""
DEEP = 0.02
"""Penetration over the travel of the tool, or between layers over their thickness, from which on it is a warning."""
VISCOUS = 0.01
"""Share of the tools' work that viscosity has taken from which on it is a warning."""
UNBALANCED = 1e-4
"""What is left of the balance of forces, over the largest of them, from which on it is a warning."""
CAUTIONS, VIEW, SCENE, STEPS = "about-cautions", "view-of-the-stack", "file-scene", anchor(STEP_SIZES)
"""Anchors of a page: the explanation of cautions, the view, the scene with all defaults, the size of the steps."""
ALWAYS = {VIEW, SCENE}
SHOWN_BY = (
    ("negative pivots", anchor(PIVOTS)),
    ("viscous_share", anchor(ERRORS)),
    ("never touched", anchor(FORCE)),
    ("never meet", anchor(FORCE)),
    ("data", anchor(VF)),
    ("elements", VIEW),
    ("from one node to the next", VIEW),
    (".path", VIEW),
    (".position", VIEW),
    ("", SCENE),
)
"""Signs in the words of cautions, and the anchor of what shows them; all others are about values of the scene."""


@dataclass(frozen=True)
class Warned:
    """A warning.

    Attributes:
        words: what to mind.
        about: anchor of what explains it.
        place: anchor of the curve or the section that shows it.
    """

    words: str
    about: str
    place: str


def warnings(results: Results) -> list[Warned]:
    """What to mind, each with the anchor of its explanation; the cautions of the run among it."""
    if not results.rows:
        return []
    found = _of_ending(results) + _of_contact(results) + _of_errors(results)
    drawn = {curve["id"] for curve in curves(results)}
    cautions = [Warned(words, CAUTIONS, _place(words, drawn)) for words in results.record.get("cautions", [])]
    return found + cautions


def _place(caution: str, drawn: set[str]) -> str:
    """Anchor of what shows a caution of a run: the first that its words tell of, and that the page has."""
    told = (place for sign, place in SHOWN_BY if sign in caution)
    return next((place for place in told if place in drawn or place in ALWAYS), CAUTIONS)


def _of_ending(results: Results) -> list[Warned]:
    if not results.record:
        return [Warned("The run has not ended: the page shows what is written so far.", "about-ending", STEPS)]
    if results.record["ending"] != "done":
        return [Warned(f"The run stopped early: {results.record['reason']}.", "about-ending", STEPS)]
    return []


def _of_contact(results: Results) -> list[Warned]:
    history, found = results.history, []
    for name, moved in zip(
        results.tool_columns("penetration_max"), results.tool_columns("tool_displacement"), strict=False
    ):
        deep, travel = float(history[name].max()), float(np.abs(history[moved]).max())
        if deep > DEEP * travel > 0:
            words = f"{name}: the fabric penetrates a tool by {short(1e3 * deep)} mm, {100 * deep / travel:.2g} % of "
            found.append(Warned(f"{words}how far it moves.", "about-penetration", anchor(PENETRATION)))
    return found + _between_layers(results)


def _between_layers(results: Results) -> list[Warned]:
    """Faces of layers that penetrate each other, or the mould, by more than a share of a layer."""
    thickness, found = results.scene.stack.thickness, []
    columns = [*results.interface_columns("interface_penetration_max"), "mould_penetration_max"]
    for name in (column for column in columns if column in results.history):
        deep = float(np.nanmax(results.history[name]))
        if deep > DEEP * thickness:
            words = f"{name}: faces penetrate each other by {short(1e3 * deep)} mm, {100 * deep / thickness:.2g} % of "
            found.append(Warned(f"{words}a layer.", "about-penetration", anchor(PENETRATION)))
    return found


def _of_errors(results: Results) -> list[Warned]:
    history, found = results.history, []
    if "vf_error" in history and history["vf_error"][-1] > LARGE_ERROR:
        words = f"The mesh is coarse: the field of Vf is off by an estimated {100 * history['vf_error'][-1]:.2g} % of "
        found.append(Warned(f"{words}its change.", "about-error", anchor(ERRORS)))
    if history.get("viscous_share", np.zeros(1)).max() > VISCOUS:
        share = 100 * history["viscous_share"].max()
        words = f"Stabilising viscosity has taken {share:.2g} % of the tools' work."
        found.append(Warned(words, "about-viscosity", anchor(ERRORS)))
    left, scale = unbalanced(results).max(), np.abs(history["support_force"]).max()
    if left > UNBALANCED * scale > 0:
        words = f"Forces balance only to {short(left)} N of {short(scale)} N."
        found.append(Warned(words, "about-balance", anchor(FORCE)))
    if history.get("negative_pivots", np.zeros(1)).max() > 0 and not results.record:
        when = history["time"][int(np.argmax(history["negative_pivots"] > 0))]
        found.append(Warned(f"Stability is lost at {short(when)} s.", "about-stability", anchor(PIVOTS)))
    return found


EXPLAINED = {
    "about-ending": (
        "A run that stopped early",
        "All that the page shows was accepted and is on the disk. The reason says which limit was met. "
        "A run goes on with ncf-fenicsx run --restart FOLDER.",
    ),
    "about-penetration": (
        "Penetration",
        "A penalty lets faces penetrate a little. The force is then too low, for the tool has pressed less deep than "
        "it moved. Raise the penalty, or take another way to enforce contact.",
    ),
    "about-error": (
        "Estimated error of the mesh",
        "vf_error is a root mean square over the stack, relative to how much Vf has changed; no band around a curve. "
        "More elements along x and y take vf_error_in_plane away, more through the layers the rest; "
        "one element through each is the paper's model. It says nothing of errors of the laws.",
    ),
    "about-viscosity": (
        "Stabilising viscosity",
        "Where steps fail again and again a viscosity helps the stack over. What it takes of the work of the tools "
        "is missing elsewhere: forces are wrong by about that share.",
    ),
    "about-balance": (
        "Balance of forces",
        "What supports carry is the weight and the force of the tools. In an explicit run inertia is missing "
        "there, and in a stabilised one the viscosity.",
    ),
    "about-stability": (
        "Loss of stability",
        "From the first negative pivot on the stack may wrinkle in more than one way; the answer depends on the branch "
        "that was taken. The transverse shear modulus decides when that happens.",
    ),
    "about-cautions": (
        "Cautions of the run",
        "The program has found these in the scene or while it ran: values far from usual ones, a mesh that is coarse "
        "for its tool, a law beyond its data, a loss of stability (negative pivots).",
    ),
}
"""Titles and texts of what warnings point to, by anchor."""
