"""What plug-ins brought, checked before it is used."""

from skiros_py.catalogue.catalogue import Catalogue, choose_planners
from skiros_py.catalogue.loading import KINDS, Kind, Surveyed, fitting, load_catalogue, survey

__all__ = ["KINDS", "Catalogue", "Kind", "Surveyed", "choose_planners", "fitting", "load_catalogue", "survey"]
