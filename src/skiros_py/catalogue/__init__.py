"""What plug-ins brought, checked before it is used."""

from skiros_py.catalogue.catalogue import Catalogue
from skiros_py.catalogue.fitting import fitting
from skiros_py.catalogue.kinds import KINDS, Kind
from skiros_py.catalogue.loading import load_catalogue
from skiros_py.catalogue.survey import Surveyed, survey

__all__ = ["KINDS", "Catalogue", "Kind", "Surveyed", "fitting", "load_catalogue", "survey"]
