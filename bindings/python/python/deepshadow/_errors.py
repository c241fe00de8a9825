"""The exceptions of the package."""

from __future__ import annotations


class DeepshadowError(Exception):
    """An error of this package; all others are kinds of it.

    ``file`` is the file that it is about and ``place`` the place in it, such as "tile
    (0, 0) of level 0 at byte 4096"; None where there is none.
    """

    file: str | None
    place: str | None

    def __init__(self, message: str, file: str | None = None, place: str | None = None) -> None:
        super().__init__(message)
        self.file = file
        self.place = place

    def __reduce__(self) -> tuple[type[DeepshadowError], tuple[str, str | None, str | None]]:
        return type(self), (str(self), self.file, self.place)


class FileError(DeepshadowError):
    """A map or an image is not what it should be, or cannot be read or written."""


class SceneError(DeepshadowError):
    """A scene or a file of one is not sound."""


class QueryError(DeepshadowError):
    """A map cannot answer what it is asked."""


class SettingError(DeepshadowError, ValueError):
    """An argument is not what it can be."""


class HitSourceError(DeepshadowError):
    """A hit source failed, but not by an exception of its own."""


class Cancelled(DeepshadowError):
    """A progress function ended the work; no file was changed."""
