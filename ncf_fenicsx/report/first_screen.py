"""HTML of the first screen: sentence, ending, numbers as a table, warnings with links to what explains them."""

from __future__ import annotations

from ncf_fenicsx.report.markup import element, text
from ncf_fenicsx.report.numbers import Figure, ending, figures
from ncf_fenicsx.report.reading import Results
from ncf_fenicsx.report.sentence import sentence
from ncf_fenicsx.report.warnings import EXPLAINED, Warned, warnings


def screen(results: Results) -> str:
    """The section at the top of a page."""
    done = results.record.get("ending") == "done"
    inner = element("p", text(sentence(results)), class_="sentence")
    inner += element("p", text(ending(results)), class_="ending" if done else "ending not-done")
    found = figures(results)
    if found:
        body = "".join(_row(figure) for figure in found)
        head = "<thead><tr><th scope=col>Number</th><th scope=col>Value</th><th scope=col>How sure</th></tr></thead>"
        inner += f'<table class="figures"><caption>The numbers that matter</caption>{head}<tbody>{body}</tbody></table>'
    minded = warnings(results)
    if minded:
        inner += element("h2", "To mind") + element("ul", "".join(map(_warning, minded)), class_="warnings")
    return element("section", inner, aria_label="Overview")


def _warning(one: Warned) -> str:
    """A warning that leads to what shows it, with a link to what it means."""
    shown = element("a", text(one.words), href=f"#{one.place}")
    about = "" if one.place == one.about else " " + element("a", "What it means", href=f"#{one.about}", class_="about")
    return element("li", shown + about)


def _row(figure: Figure) -> str:
    value = element("td", text(figure.value), data_column=figure.column, data_row=figure.row, class_="value")
    return element("tr", element("th", text(figure.name), scope="row") + value + element("td", text(figure.error)))


def explanations() -> str:
    """What the warnings point to."""
    items = "".join(
        element("dt", text(title), id=about) + element("dd", text(words)) for about, (title, words) in EXPLAINED.items()
    )
    inner = element("h2", "How far to believe a run") + element("dl", items)
    return element("section", inner, aria_label="Explanations", class_="screen-only")
