"""The contributions of plug-ins, checked before they are used."""

from skiros_py.catalogue.catalogue import Catalogue
from skiros_py.catalogue.loading import KINDS, Kind, Surveyed, fitting, load_catalogue, survey

__all__ = ["KINDS", "Catalogue", "Kind", "Surveyed", "fitting", "load_catalogue", "survey"]
