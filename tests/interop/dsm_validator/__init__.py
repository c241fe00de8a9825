"""Checks `.dsm` files of every kind by what docs/format/dsm-1.md says of them, and by nothing else: no part of this
package was made from another reader. Numbers in round brackets are sections of that document."""

from .fault import BeyondLimits, Fault, Limits
from .validator import check, verdict

__all__ = ["BeyondLimits", "Fault", "Limits", "check", "verdict"]
