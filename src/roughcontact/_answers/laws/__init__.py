"""Laws of an interface: properties of its contact over the load, in a form that other programs read."""

from roughcontact._answers.laws.columns import LawColumn as LawColumn
from roughcontact._answers.laws.columns import PowerFit as PowerFit
from roughcontact._answers.laws.film import FilmLaw as FilmLaw
from roughcontact._answers.laws.film import film_law as film_law
from roughcontact._answers.laws.film_fits import FilmFit as FilmFit
from roughcontact._answers.laws.film_plan import FilmPlan as FilmPlan
from roughcontact._answers.laws.film_plan import plan_film as plan_film
from roughcontact._answers.laws.film_plan import space_separations as space_separations
from roughcontact._answers.laws.law import MAX_LOAD_RATIO as MAX_LOAD_RATIO
from roughcontact._answers.laws.law import InterfaceLaw as InterfaceLaw
from roughcontact._answers.laws.law import interface_law as interface_law
