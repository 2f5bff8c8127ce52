"""What all parts of the reader of a scene share, and the files that it may open."""

from __future__ import annotations

import os.path
from dataclasses import dataclass, field
from pathlib import Path

from photonmap.io.readers.decoding import Losses, note_loss
from photonmap.io.readers.gltf_parts.nodes import unused_name
from photonmap.io.readers.mitsuba_parts.nodes import Node
from photonmap.io.readers.mitsuba_parts.xml import Element
from photonmap.io.readers.registry import MissingTextures
from photonmap.runtime.named_files import is_below, outside
from photonmap.runtime.wording import shown


@dataclass
class Files:
    """Finds files by the names that a scene gives them.

    Parameters
    ----------
    scene : the file of the scene, in whose folder files are looked for
    allowed : the folder outside of which nothing is opened
    folders : further ones, in which `<path>` has files looked up
    """

    scene: Path
    allowed: Path
    folders: list[Path] = field(default_factory=list)

    def find(self, element: Element, name: str) -> Path:
        """Return a file beside the one that names it, beside the scene, or in a further folder.

        Raises
        ------
        InputError : it lies outside of the scene's folder, or does not exist
        """
        places = (element.path.parent, *self.folders, self.scene.parent)
        found = [self.inside(element, place, name) for place in places]
        for path in found:
            try:
                if path.is_file():
                    return path
            except ValueError:  # a null character
                break
        raise element.error(f"file {shown(name)} does not exist; correct its name")

    def inside(self, element: Element, folder: Path, name: str) -> Path:
        """Return what a name, perhaps with Windows' separators, means in a folder."""
        path = Path(os.path.normpath(folder / name.replace("\\", "/")))
        if not is_below(path, self.allowed):
            raise element.error(f"{shown(name)} {outside(self.allowed)}")
        return path


@dataclass
class Context:
    """What all parts of the reader of a scene share.

    Parameters
    ----------
    files : finds the files that it names
    missing_textures : what becomes of an image that cannot be read
    losses : takes what is not simulated
    names : those in use, of meshes, and of materials, lights and cameras
    """

    files: Files
    missing_textures: MissingTextures
    losses: Losses
    names: dict[str, set[str]] = field(default_factory=dict)

    def lose(self, what: str, node: Node) -> None:
        """Note what is not simulated of a node."""
        note_loss(self.losses, what, node.label(self.files.scene))

    def lose_unread(self, node: Node) -> None:
        """Note the parameters that nothing asked for."""
        for name in node.unread():
            self.lose(f"{node.tag} parameter {name}", node)

    def name(self, kind: str, node: Node) -> str:
        """Return a name that no other of this kind has: the id, or else the type."""
        used = self.names.setdefault(kind, set())
        return unused_name(node.id or node.type or node.tag, len(used) + 1, used)
