"""What plug-ins brought, checked before it is used."""

from skiros_py.catalogue.catalogue import Catalogue, choose_planners
from skiros_py.catalogue.fitting import fitting
from skiros_py.catalogue.kinds import KINDS, Kind
from skiros_py.catalogue.loading import load_catalogue
from skiros_py.catalogue.survey import Surveyed, survey

__all__ = ["KINDS", "Catalogue", "Kind", "Surveyed", "choose_planners", "fitting", "load_catalogue", "survey"]
