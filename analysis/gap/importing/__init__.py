"""``gapscope import``: logs of any readable format become a log set; every guess is shown.

>>> plan = make_plan(path, wanted)          # guesses, with how sure and why
>>> plan = plan.state("q", "carriage:pos", "mm")
>>> carry_out(plan, [path], name=..., system=...).save(folder)
"""

from .guess import SURE, Guess
from .plan import Plan, description, make_plan
from .write import FORMATS, Imported, carry_out

__all__ = ["FORMATS", "SURE", "Guess", "Imported", "Plan", "carry_out", "description", "make_plan"]
