"""Hypotheses: the nominal structure with the forms of some effects added."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .effects import Form
from .machine import Array, Machine, Parameter


@dataclass(frozen=True, kw_only=True)
class Hypothesis:
    """Forms that act together; ``dropped`` are (form, parameter) names held at zero."""

    forms: tuple[Form, ...] = ()
    dropped: frozenset[tuple[str, str]] = field(default_factory=frozenset)

    @property
    def ids(self) -> tuple[str, ...]:
        """Effect ids in the order in which they were added."""
        return tuple(form.effect for form in self.forms)

    @property
    def contained(self) -> frozenset[str]:
        """Effect ids, with those that its forms contain: Stribeck friction contains dry friction."""
        return frozenset(self.ids).union(*(form.contains for form in self.forms))

    @property
    def label(self) -> str:
        """Words for a table."""
        if not self.forms:
            return "retuned nominal"
        return " + ".join(f"{form.effect} ({form.name})" for form in self.forms)

    def with_form(self, form: Form) -> "Hypothesis":
        """This hypothesis and one more form."""
        return Hypothesis(forms=(*self.forms, form), dropped=self.dropped)

    def without(self, effect: str) -> "Hypothesis":
        """This hypothesis less one effect."""
        return Hypothesis(
            forms=tuple(form for form in self.forms if form.effect != effect), dropped=self.dropped
        )

    def drop(self, key: tuple[str, str]) -> "Hypothesis":
        """This hypothesis with one removable parameter held at zero."""
        return Hypothesis(forms=self.forms, dropped=self.dropped | {key})

    def free(self, machine: Machine) -> list[tuple[str, Parameter]]:
        """Free parameters as (effect id or "", parameter); own parameters first."""
        replaced = {name for form in self.forms for name in form.replaces}
        replaced |= {
            form.takes[p.name]
            for form in self.forms
            for p in self.kept(form)
            if p.name in form.takes
        }
        own = [("", p) for p in machine.own if p.name not in replaced and p.upper > p.lower]
        return own + [(form.effect, p) for form in self.forms for p in self.kept(form)]

    def kept(self, form: Form) -> list[Parameter]:
        """Parameters of a form that are not dropped."""
        return [p for p in form.parameters if (form.effect, p.name) not in self.dropped]

    @property
    def rough(self) -> bool:
        """Whether a form has impacts, which derivatives do not see through."""
        return any(form.step > 0.0 for form in self.forms)

    @property
    def size(self) -> int:
        """Number of parameters beyond the nominal structure."""
        return sum(len(self.kept(form)) for form in self.forms)

    def plant(
        self, machine: Machine, values: Mapping[tuple[str, str], float], time: float = 0.0
    ) -> Any:
        """The plant at the values, by (effect id or "", parameter name).

        ``time`` is how long the machine has been running [s].
        """
        own = machine.nominal()
        own.update({name: value for (effect, name), value in values.items() if effect == ""})
        plant = machine.build(own)
        plant.time = time
        # Forms that split the machine in two act last, on everything the others have changed.
        for form in sorted(self.forms, key=lambda f: f.effect.startswith("transmission.")):
            form.apply(
                plant,
                {
                    p.name: values.get((form.effect, p.name), 0.0)
                    for p in form.parameters
                    if (form.effect, p.name) not in self.dropped
                },
            )
        return plant.finished()


@dataclass(frozen=True, kw_only=True)
class Fit:
    """A hypothesis at its best parameters on the fit runs."""

    hypothesis: Hypothesis
    keys: tuple[tuple[str, str], ...]  # (effect id or "", parameter name)
    units: tuple[str, ...]
    values: Array  # in the parameters' units
    deviation: Array  # standard deviation of each value; NaN with impacts, which have none
    at_bound: Any  # (p,) bool
    losses: Array  # held-out squared residual per block, sums to the held-out loss
    samples: Array  # residuals per block
    rms: float  # residual on the fit runs [position unit]
    held_out_rms: float  # residual on held-out fit runs [position unit]
    importance: Array  # (p,) relative rise of the fit loss without the parameter, linearised
    converged: bool
    # All residuals of the fit runs in one vector, and their derivatives (residuals, p) by the
    # parameters in units of their scales; empty where fits do not build on each other.
    residual: Array = field(default_factory=lambda: np.zeros(0))
    jacobian: Array = field(default_factory=lambda: np.zeros((0, 0)))
    finished: bool = True  # whether the search ended by itself
    searched: bool = True  # False where a linear step showed that a search does not pay

    def by_key(self) -> dict[tuple[str, str], float]:
        """Values by key."""
        return dict(zip(self.keys, (float(v) for v in self.values)))

    def agreement(self, retuned: "Fit") -> float | None:
        """Correlation of what the effects change in the prediction with what the retuned model lacks.

        1 where all they change is missing, 0 where nothing is; None where residuals are not kept.
        """
        if self.residual.size == 0 or self.residual.size != retuned.residual.size:
            return None
        lacking, change = retuned.residual, retuned.residual - self.residual
        # Sums, not BLAS, whose last bits depend on how many threads a process gives it.
        size = float(np.sqrt(np.sum(change**2) * np.sum(lacking**2)))
        return float(np.sum(change * lacking)) / size if size > 0.0 else 0.0

    def called_by_values(self) -> "Fit":
        """This fit with each form that its values make one of another effect called by that effect."""
        known, found = self.by_key(), self
        for form in self.hypothesis.forms:
            values = {p.name: known.get((form.effect, p.name), 0.0) for p in form.parameters}
            other = form.amounts_to(values)
            if other is not None and other.effect not in found.hypothesis.ids:
                found = found._with_names_of(form, other)
        return found

    def _with_names_of(self, form: Form, other: Form) -> "Fit":
        names = {
            (form.effect, mine.name): (other.effect, its.name)
            for mine, its in zip(form.parameters, other.parameters, strict=True)
        }
        hypothesis = Hypothesis(
            forms=tuple(other if f is form else f for f in self.hypothesis.forms),
            dropped=frozenset(names.get(key, key) for key in self.hypothesis.dropped),
        )
        keys = tuple(names.get(key, key) for key in self.keys)
        return replace(self, hypothesis=hypothesis, keys=keys)

    @property
    def score(self) -> float:
        """Log of the held-out rms plus a price per parameter; smaller is better."""
        return float(0.5 * np.log(self.losses.sum() / self.samples.sum())) + price(self.hypothesis)


PARAMETER_PRICE = 0.005  # a parameter must lower the held-out residual by this share
EFFECT_PRICE = 0.01  # an effect, on top of its parameters
FURTHER_PRICE = 0.1  # every effect beside the first one, on top of that


def price(hypothesis: Hypothesis) -> float:
    """What parsimony asks of a hypothesis, as a fall of the log residual, before it may win."""
    further = FURTHER_PRICE * max(len(hypothesis.forms) - 1, 0)
    return sum(price_of(hypothesis, effect) for effect in hypothesis.ids) + further


def price_of(hypothesis: Hypothesis, effect: str) -> float:
    """What parsimony asks of one effect of a hypothesis and its parameters."""
    (form,) = (form for form in hypothesis.forms if form.effect == effect)
    return EFFECT_PRICE + form.price + PARAMETER_PRICE * len(hypothesis.kept(form))
