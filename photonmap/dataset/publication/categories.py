"""Semantic categories of objects: numbers that are the same in all sets, and other sets' labels."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

FIRST_OWN = 1001
"""Number of the first kind of objects that is not in the table, such as those of users' scenes."""
OTHER = "other"
"""The supercategory of those."""

_NYU40 = {
    "wall": 1, "floor": 2, "cabinet": 3, "bed": 4, "chair": 5, "sofa": 6, "table": 7, "door": 8,
    "window": 9, "picture": 11, "counter": 12, "desk": 14, "shelves": 15, "curtain": 16,
    "pillow": 18, "mirror": 19, "floor mat": 20, "clothes": 21, "ceiling": 22, "books": 23,
    "towel": 27, "box": 29, "whiteboard": 30, "toilet": 33, "sink": 34, "lamp": 35, "bathtub": 36,
    "otherstructure": 38, "otherfurniture": 39, "otherprop": 40,
}  # fmt: skip
"""Labels of NYU Depth V2 in 40 classes (Gupta et al. 2013), as in ScanNet and Hypersim."""
_COCO = {
    "bench": 15, "umbrella": 28, "sports ball": 37, "bottle": 44, "cup": 47, "bowl": 51,
    "chair": 62, "couch": 63, "potted plant": 64, "bed": 65, "dining table": 67, "toilet": 70,
    "sink": 81, "book": 84, "clock": 85, "vase": 86,
}  # fmt: skip
"""Categories of COCO 2017 that are found here."""

# Supercategory: kinds, each with its label in NYU40 and, after a slash, in COCO. Kinds are numbered
# in this order: new ones go to the end.
_TABLE = """
structure: walls=wall, floor=floor, ceiling=ceiling, door=door, window=window,
 skirting=otherstructure, backdrop=otherstructure, ground=floor, eaves=otherstructure
lamp: pendant lamp=lamp, ceiling lamp=lamp, ceiling spot=lamp, floor lamp=lamp, table lamp=lamp,
 wall lantern=lamp, street lamp=lamp, bollard=lamp, key light=lamp, side light=lamp, top light=lamp,
 low light=lamp
seat: chair=chair/chair, armchair=chair/chair, sofa=sofa/couch, sofa bench=sofa/couch,
 stool=chair/chair, bar stool=chair/chair, bench=chair/bench
table: table=table/dining table, desk=desk, counter=counter, garden table=table/dining table
storage: cabinet=cabinet, shelf=shelves, wall shelf=shelves, crate=box, basket=box, bin=otherprop,
 toolbox=box, tool board=otherfurniture, coat rack=otherfurniture, umbrella stand=otherfurniture
bedding: bed=bed/bed, cushion=pillow
textile: curtain=curtain, rug=floor mat, towel=towel, shoes=clothes
bathroom: bathtub=bathtub, basin=sink/sink, toilet=toilet/toilet, tap=otherprop,
 towel rail=otherprop, soap=otherprop, paper roll=otherprop
wall object: picture=picture, mirror=mirror, clock=otherprop/clock, blackboard=whiteboard
vessel: vase=otherprop/vase, jug=otherprop, bowl=otherprop/bowl, cup=otherprop/cup,
 bottle=otherprop/bottle, plate=otherprop, tin=otherprop
thing: book=books/book, ball=otherprop/sports ball, block=otherprop, block stack=otherprop,
 ring tower=otherprop, castle=otherprop, globe=otherprop, timber=otherprop
plant: plant=otherprop/potted plant, tree=otherprop, shrub=otherprop, planter=otherprop
sculpture: plinth=otherfurniture, pebble=otherprop, knot=otherprop, ribbon=otherprop,
 superquadric=otherprop, boulder=otherprop
outdoors: parasol=otherprop/umbrella
"""


@dataclass(frozen=True)
class Category:
    """A kind of objects.

    Parameters
    ----------
    number : the same in every set, if the kind is known
    name : of the kind, in the singular where there may be several: "chair"
    group : to which it belongs, COCO's supercategory: "seat"
    nyu40 : label in the 40 classes of NYU Depth V2; "" where none is known
    coco : category of COCO 2017; "" where there is none
    """

    number: int
    name: str
    group: str = OTHER
    nyu40: str = ""
    coco: str = ""

    def describe(self) -> dict[str, object]:
        """Return it as an item of "categories" in COCO's JSON, with the labels of other sets."""
        return {
            "id": self.number,
            "name": self.name,
            "supercategory": self.group,
            "nyu40": {"id": _NYU40[self.nyu40], "name": self.nyu40} if self.nyu40 else None,
            "coco": {"id": _COCO[self.coco], "name": self.coco} if self.coco else None,
        }


def _read_table() -> dict[str, Category]:
    """Return the known categories by their names."""
    known: dict[str, Category] = {}
    for line in _TABLE.replace("\n ", " ").strip().splitlines():
        group, kinds = line.split(": ")
        for kind in kinds.split(", "):
            name, labels = kind.strip().split("=")
            nyu40, _, coco = labels.partition("/")
            known[name] = Category(len(known) + 1, name, group, nyu40, coco)
    return known


CATEGORIES = _read_table()
"""All kinds of objects in generated scenes, by name."""


def kind_of(name: str) -> str:
    """Return the kind of an object: "vase" of "vase 2"."""
    return re.sub(r" \d+$", "", name)


def categories_of(objects: Iterable[str]) -> dict[str, Category]:
    """Return the categories of objects by kind; kinds that are not known are numbered by name."""
    kinds = {kind_of(name) for name in objects}
    own = sorted(kinds - {*CATEGORIES})
    unknown = {kind: Category(FIRST_OWN + place, kind) for place, kind in enumerate(own)}
    known = {kind: each for kind, each in CATEGORIES.items() if kind in kinds}
    return known | unknown
