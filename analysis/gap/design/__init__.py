"""The next experiment: the motion inside the machine's limits that best separates two hypotheses.

from gapscope.analysis.gap.design import Limits, design_experiment
design = design_experiment(diagnose("logs"))
design.save(Path("design"))
"""

from .experiment import Design, design_experiment
from .limits import Limits, limits_of
from .pair import Pair, top_two

__all__ = ["Design", "Limits", "Pair", "design_experiment", "limits_of", "top_two"]
