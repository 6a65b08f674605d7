"""The checks of the judge, one for each kind of requirement; every module here registers its own."""

from trajopt.problem.requirements.requirement import import_modules

import_modules(__name__)
