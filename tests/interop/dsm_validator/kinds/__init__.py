"""The kinds of maps (the table of section 13)."""

from .attenuation import Attenuation
from .deep import Deep
from .fragments import Fragments
from .layers import Layers
from .media import Media
from .mtsm import Mtsm
from .prefiltered import Prefiltered
from .views import Views

# By name and version of the payload.
KINDS = {
    ("attenuation", 1): Attenuation,
    ("deep", 1): Deep,
    ("fragments", 1): Fragments,
    ("fragments", 2): Media,
    ("layers", 1): Layers,
    ("mtsm", 1): Mtsm,
    ("prefiltered", 1): Prefiltered,
    ("views", 1): Views,
}
