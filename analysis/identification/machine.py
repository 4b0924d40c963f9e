"""What identification needs of a machine: its regressor, its limits, what is known before, and an independent plant."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...models.parallel.bodies import PARAMETERS, central, parameters, regressor
from ...models.parallel.chain import Chain
from .polygon import inside

Floats = NDArray[np.float64]
Rigid = Callable[[Floats, Floats, Floats], Floats]


@dataclass(frozen=True, kw_only=True)
class Machine:
    """A machine to identify; n axes, p rigid parameters, then n Coulomb and n viscous friction parameters."""

    name: str
    title: str
    parameters: tuple[str, ...]  # rigid
    rigid: Rigid  # K (..., n, p) at positions, rates, accelerations (..., n)
    prior: Floats  # rigid, as drawn or weighed (p,) [kg, kg m, kg m^2]
    chain: Callable[[Floats], Chain]  # bodies and closures with rigid parameters (p,)
    trusted: tuple[str, ...] = ()  # parameters that are well known before
    tensors: tuple[tuple[int, ...], ...] = ()  # indices of xx yy zz xy xz yz about a centre of mass
    bodies: tuple[tuple[int, ...], ...] = ()  # indices of ten parameters of one body
    unit: str = "m"  # of an axis: m or rad
    lower: Floats  # travel (n,)
    upper: Floats
    polygon: Floats | None = None  # of the joint space, for two axes (vertices, 2)
    speed: Floats  # limits (n,)
    acceleration: Floats
    start: Floats  # of the motions (n,)
    frequency: float  # of the Fourier series [Hz]
    harmonics: int
    budget: int = 6000  # motions that a search tries by default
    at_rest: bool = True  # at the start of a cycle; the source's series leave it free
    period: float  # of sampling [s]
    cutoff: float  # of the filter [Hz]
    resolution: float  # of the encoder at the axis
    coulomb: Floats  # assumed true (n,) [N, N m]
    viscous: Floats  # [N s/m, N m s/rad]
    noise: float  # of a force or torque, standard deviation
    printed: dict[str, Any] = field(default_factory=dict)  # numbers of the source to set beside

    @property
    def axes(self) -> int:
        """Number of actuated coordinates."""
        return int(self.lower.size)

    @property
    def names(self) -> tuple[str, ...]:
        """Rigid parameters, Coulomb friction by axis, viscous friction by axis."""
        friction = [f"{word}{i + 1}" for word in ("Fc", "c") for i in range(self.axes)]
        return (*self.parameters, *friction)

    def full_regressor(self, q: Floats, v: Floats, a: Floats) -> Floats:
        """K (..., n, p + 2n) with friction columns sgn(v) and v of each axis (5.18), (5.20)."""
        axis = np.eye(self.axes)
        friction = [np.sign(v)[..., None] * axis, v[..., None] * axis]
        return np.concatenate([self.rigid(q, v, a), *friction], axis=-1)

    def random_states(self, count: int, seed: int) -> tuple[Floats, Floats, Floats]:
        """Positions inside the joint space, rates and accelerations inside their limits (count, n)."""
        rng = np.random.default_rng(seed)
        q = np.empty((0, self.axes))
        while len(q) < count:
            trial = rng.uniform(self.lower, self.upper, (4 * count, self.axes))
            if self.polygon is not None:
                trial = trial[inside(trial, self.polygon) > 0.0]
            q = np.concatenate([q, trial])
        v, a = (
            rng.uniform(-limit, limit, (count, self.axes))
            for limit in (self.speed, self.acceleration)
        )
        return q[:count], v, a

    def truth(self, seed: int) -> Floats:
        """Planted rigid parameters (p,): 1 % around the prior where trusted, 20 % elsewhere.

        A tensor, or the ten parameters of a body, are scaled as one, so that they stay those of a body.
        """
        rng = np.random.default_rng(seed)
        spread = np.array([0.01 if name in self.trusted else 0.2 for name in self.parameters])
        off = spread * rng.uniform(-1.0, 1.0, self.prior.size)
        for block in (*self.tensors, *self.bodies):
            off[list(block)] = off[block[0]]
        return np.asarray(self.prior * (1.0 + off))


def of_chain(chain: Chain, **limits: Any) -> Machine:
    """A machine known only by its bodies and closures: ten parameters a body, motion from its plant.

    ``limits`` are the fields of ``Machine`` that a chain does not have. Slower than a closed form.
    """
    from ...systems.closed_chain import ClosedChain

    plant = ClosedChain(chain)
    names = tuple(f"{link.name}.{word}" for link in chain.links for word in PARAMETERS)
    prior = np.concatenate([parameters(b.mass, b.centre, b.inertia) for b in chain.links])

    def rigid(q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Floats:
        q, v, a = (np.asarray(part, dtype=float) for part in (q, v, a))
        flat, near, rows = [part.reshape(-1, part.shape[-1]) for part in (q, v, a)], None, []
        for position, rate, acceleration in zip(*flat):
            try:
                near = plant.close(position, near)
            except ValueError:
                near = plant.close(position)
            rows.append(regressor(plant.motion(near, rate), acceleration))
        return np.stack(rows).reshape(*q.shape[:-1], q.shape[-1], -1)

    def with_values(values: Floats) -> Chain:
        links = []
        for link, ten in zip(chain.links, values.reshape(-1, 10)):
            mass, centre, inertia = central(ten)
            links.append(
                replace(
                    link, mass=mass, centre=tuple(centre.tolist()), inertia=tuple(inertia.tolist())
                )
            )
        return replace(chain, links=tuple(links))

    blocks = tuple(tuple(range(10 * k, 10 * k + 10)) for k in range(len(chain.links)))
    return Machine(
        name=chain.name,
        title=limits.pop("title", chain.name),
        parameters=names,
        rigid=rigid,
        prior=prior,
        chain=with_values,
        bodies=blocks,
        **limits,
    )
