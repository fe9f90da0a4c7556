"""Scenes of the runs whose pages are tested."""

TITLE = 'A "roller" <b>für</b> </script> Jürgen & Söhne'
STACK = {"layers": 2, "size": ["12 mm", "6 mm"], "divisions": [4, 2], "grading": [0.0, 0.0]}
STITCHED = {"kind": "stitched", "yarn_stiffness": "0.01 N", "slip_share": 0.0}


def down(depth):
    """A path straight down."""
    return [{"travel": ["0 mm", "0 mm", f"-{depth}"], "speed": "1 mm/min"}]


ROLLER = {"width": "infinite", "path": down("0.1 mm")}
BALL = {"kind": "sphere", "radius": "2 mm", "position": ["8 mm", "0 mm"], "path": down("0.1 mm")}
FOOT = {"kind": "presser_foot", "size": ["8 mm", "8 mm"], "path": down("0.1 mm")}


def case(**tables):
    """A scene as a table: two layers under a roller, without a picture; other tables replace these."""
    usual = {"stack": STACK, "interface": STITCHED, "tool": ROLLER, "output": {"picture": False}}
    return usual | tables


WHOLE = case(
    title=TITLE,
    stack=STACK | {"divisions": [6, 2]},
    tool={"width": "infinite", "path": down("0.2 mm")},
    output={"permeability": {}},
)
"""With all that a page can show."""
