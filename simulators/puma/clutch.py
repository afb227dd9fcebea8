"""Bricks that hold together once they are pressed onto each other. Ours, a model of toy bricks; no maker's data.

The studs of each brick and of the plate are one flat box for collisions. A brick that is pressed onto it at a place of
the studs, within the tolerances of `[clutch]`, goes through it; with its underside down it is held by a weld, which
moves it exactly to its place within 0.1 s and ends when the force in it is too large. A brick elsewhere lies on the
studs' tops.
"""

from dataclasses import dataclass
from enum import IntEnum

import mujoco
import numpy as np
from numpy.typing import NDArray

from robots.kit.description import load
from simulators.puma.cell import DRIVER, Bearer, Floats, bearers, bricks

STUDS = 4  # bit of the first bearer's studs in the masks of collisions
LOOK_EVERY = 5  # steps between two looks
GLIDE = 10  # looks within which a brick reaches its exact place
SETTLED = 2 * GLIDE  # looks after which the force in a weld is that of what pulls
DOWN_M = 0.0004  # lower than this a brick's underside is on the top of what it goes onto
ROOM_M = 0.001  # above the studs, before they are in its way again
NEAR_M = 0.008  # pairs with a larger gap, or so far inside each other, are none
TEARING = 2  # looks in turn at which the force is too large
SOFT = (0.006, 1.0), (0.99, 0.999, 0.001, 0.5, 2.0)  # solref and solimp of welds and contacts


class State(IntEnum):
    """Of a brick above a bearer: the studs are in its way, it goes onto or off them, it is held."""

    FREE, BETWEEN, HELD = range(3)


@dataclass
class Pair:
    """A brick and what bears it; numbers of bearers and of the weld."""

    upper: int
    lower: int
    weld: int
    state: State = State.FREE
    torn: int = 0
    seat: Floats | None = None  # position and quaternion of the exact place, in the bearer's frame
    looks: int = 0


@dataclass(frozen=True)
class Off:
    """Where a brick is from the nearest place of the studs."""

    seat: Floats  # position and quaternion of the place, in the bearer's frame
    gap: float  # m from the bearer's top to the brick's underside
    fits: bool
    above: bool  # some of the bearer is beneath it


def add_welds(spec: mujoco.MjSpec) -> None:
    """Add a weld for each brick on each bearer, which is off."""
    for lower in bearers():
        for name in bricks():
            if name == lower.name:
                continue
            weld = spec.add_equality(name=f"{name} on {lower.name}", type=mujoco.mjtEq.mjEQ_WELD, active=False)
            weld.objtype, weld.name1, weld.name2 = mujoco.mjtObj.mjOBJ_BODY, lower.name, name
            weld.data[:11] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
            weld.solref, weld.solimp = SOFT


def masks(number: int | None) -> int:
    """Return the bits of all studs but those of a bearer, against which a body collides."""
    return sum(1 << (STUDS + n) for n in range(len(bearers())) if n != number)


class Clutch:
    """Looks after all pairs of a brick and its bearer; call `step` after each step of the plant."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data, self._steps = model, data, 0
        self._bearers, self._settings = bearers(), load(DRIVER)["clutch"]
        names = [one.name for one in self._bearers]
        self._bodies = np.array([model.body(name).id for name in names])
        self._trees = model.body_treeid[self._bodies[: len(bricks())]]
        self._solid = [model.geom(name).id for name in names]
        self._studs = [model.geom(f"studs of {name}").id for name in names]
        self._pairs = [
            Pair(upper, lower, model.equality(f"{names[upper]} on {names[lower]}").id)
            for lower in range(len(names))
            for upper in range(len(bricks()))
            if upper != lower
        ]
        self._upper = np.array([pair.upper for pair in self._pairs])
        self._lower = np.array([pair.lower for pair in self._pairs])
        half = np.array([one.half for one in self._bearers])
        self._heights = half[self._upper, 2] + half[self._lower, 2]  # between two middles
        self._reach = half[self._upper, :2].max(axis=1)[:, None] + half[self._lower, :2]
        self.resume()

    def resume(self) -> None:
        """Hold what lies exactly where it would be held: after a restart nothing else tells."""
        for pair, off in self._offs():
            if off.fits and abs(off.gap) < DOWN_M:
                self._hold(pair, off.seat)
                pair.looks = SETTLED

    def let_go(self, name: str) -> None:
        """Part a brick from everything, because it is taken away."""
        for pair in self._pairs:
            if name in (self._bearers[pair.upper].name, self._bearers[pair.lower].name):
                self._part(pair, State.FREE)

    def held(self) -> set[tuple[str, str]]:
        """Return pairs (upper, lower) of names that hold together."""
        return {
            (self._bearers[p.upper].name, self._bearers[p.lower].name) for p in self._pairs if p.state is State.HELD
        }

    def step(self) -> None:
        """Count one step; look at each fifth, unless all bricks rest."""
        self._steps += 1
        if self._steps % LOOK_EVERY or not self._data.tree_awake[self._trees].any():
            return
        held = [pair for pair in self._pairs if pair.state is State.HELD]
        for pair in held:
            self._glide(pair)
        self._tear([pair for pair in held if pair.looks > SETTLED])
        offs = self._offs()
        pressed = self._pressed() if offs else {}
        for pair, off in offs:
            if pair.state is State.BETWEEN:
                if off.gap > self._settings["stud_m"] + ROOM_M or not off.above:
                    self._part(pair, State.FREE)
                elif off.fits and off.gap < DOWN_M and pressed.get(self._solids(pair), 0.0) > self._settings["hold_n"]:
                    self._hold(pair, off.seat)
            elif off.fits and pressed.get(self._stud_pair(pair), 0.0) > self._settings["press_n"]:
                self._part(pair, State.BETWEEN)

    def _solids(self, pair: Pair) -> tuple[int, int]:
        a, b = self._solid[pair.upper], self._solid[pair.lower]
        return min(a, b), max(a, b)

    def _stud_pair(self, pair: Pair) -> tuple[int, int]:
        a, b = self._solid[pair.upper], self._studs[pair.lower]
        return min(a, b), max(a, b)

    def _pressed(self) -> dict[tuple[int, int], float]:
        """Return the normal force (N) between shapes that touch."""
        data, found = self._data, dict[tuple[int, int], float]()
        if not data.ncon:
            return found
        rows = data.contact.efc_address
        forces = np.where(rows >= 0, data.efc_force[np.maximum(rows, 0)], 0.0) if data.nefc else np.zeros(data.ncon)
        for (a, b), force in zip(np.sort(data.contact.geom, axis=1).tolist(), forces.tolist(), strict=True):
            found[a, b] = found.get((a, b), 0.0) + force
        return found

    def _offs(self) -> list[tuple[Pair, Off]]:
        """Return the pairs that do not hold whose brick is just above its bearer, or was."""
        at, turned = self._data.xpos[self._bodies], self._data.xmat[self._bodies].reshape(-1, 3, 3)
        below = turned[self._lower].transpose(0, 2, 1)
        place = (below @ (at[self._upper] - at[self._lower])[:, :, None])[:, :, 0]
        turn = below @ turned[self._upper]
        gap = place[:, 2] - self._heights
        near = (gap > -NEAR_M) & (gap < NEAR_M) & (np.abs(place[:, :2]) < self._reach).all(axis=1)
        return [
            (pair, self._off(self._bearers[pair.upper], self._bearers[pair.lower], place[n], turn[n]))
            for n, pair in enumerate(self._pairs)
            if pair.state is State.BETWEEN or (near[n] and pair.state is State.FREE)
        ]

    def _off(self, upper: Bearer, lower: Bearer, place: Floats, turn: Floats) -> Off:
        pitch, within = load(DRIVER)["plate"]["pitch_m"], np.radians(self._settings["within_deg"])
        yaw = float(np.arctan2(turn[1, 0], turn[0, 0]))
        quarters = round(yaw / (np.pi / 2))
        level = pitch * np.round(place[:2] / pitch)
        half = upper.half[:2] if quarters % 2 == 0 else upper.half[1::-1]
        beneath = (np.abs(lower.studs - level) < half).all(axis=1).any()
        height = lower.half[2] + upper.half[2]
        gap = float(place[2]) - height
        fits = (
            bool(beneath)
            and float(np.hypot(*(place[:2] - level))) <= self._settings["within_m"]
            and abs(yaw - quarters * np.pi / 2) <= within
            and turn[2, 2] >= np.cos(within)
            and -0.001 < gap < self._settings["stud_m"] + ROOM_M
        )
        angle = quarters * np.pi / 4
        seat = np.array([*level, height, np.cos(angle), 0.0, 0.0, np.sin(angle)])
        above = bool((np.abs(place[:2]) < np.add(lower.half[:2], max(upper.half))).all())
        return Off(seat, gap, bool(fits), above)

    def _hold(self, pair: Pair, seat: Floats) -> None:
        """Weld the brick where it is now; `_glide` moves it to its exact place."""
        pair.state, pair.seat, pair.looks, pair.torn = State.HELD, seat, 0, 0
        here = self._model.eq_data[pair.weld, 3:10]
        body = [self._bodies[pair.lower], self._bodies[pair.upper]]
        back, turn = np.zeros(4), np.zeros(4)
        mujoco.mju_negQuat(back, self._data.xquat[body[0]])
        mujoco.mju_mulQuat(turn, back, self._data.xquat[body[1]])
        place = np.zeros(3)
        mujoco.mju_rotVecQuat(place, self._data.xpos[body[1]] - self._data.xpos[body[0]], back)
        if turn @ seat[3:] < 0:
            turn = -turn
        here[:3], here[3:] = place, turn
        self._let_through(pair, passes=True)
        self._data.eq_active[pair.weld] = 1

    def _glide(self, pair: Pair) -> None:
        """Lead the weld from where the brick went on to the exact place."""
        if pair.looks < GLIDE and pair.seat is not None:
            here = self._model.eq_data[pair.weld, 3:10]
            here += (pair.seat - here) / (GLIDE - pair.looks)
            here[3:] /= np.linalg.norm(here[3:])
        pair.looks += 1

    def _tear(self, pairs: list[Pair]) -> None:
        """Part the pair whose force is the most too large, if it has been so for some time: one relieves the others."""
        shares = {}
        for pair in pairs:
            pull, bend = self._load(pair)
            share = max(pull / self._settings["pull_n"], bend / self._settings["peel_nm"])
            pair.torn = pair.torn + 1 if share > 1.0 else 0
            if pair.torn >= TEARING:
                shares[pair.weld] = share, pair
        if shares:
            self._part(max(shares.values(), key=lambda one: one[0])[1], State.BETWEEN)
            for pair in pairs:
                pair.torn = 0

    def _load(self, pair: Pair) -> tuple[float, float]:
        """Return the force (N) that pulls a pair apart and the torque (N m) that bends it off."""
        data = self._data
        force = data.efc_force[: data.ne][data.efc_id[: data.ne] == pair.weld]  # equalities come first
        if len(force) != 6:  # both of them sleep
            return 0.0, 0.0
        up: NDArray[np.float64] = data.xmat[self._bodies[pair.lower]].reshape(3, 3)[:, 2]
        return float(force[:3] @ up), float(np.linalg.norm(force[3:])) / 2

    def _part(self, pair: Pair, state: State) -> None:
        pair.state, pair.seat, pair.torn = state, None, 0
        self._data.eq_active[pair.weld] = 0
        self._let_through(pair, passes=state is not State.FREE)

    def _let_through(self, pair: Pair, passes: bool) -> None:
        """Let the bearer's studs go into the brick, or not."""
        bit, shape = 1 << (STUDS + pair.lower), self._solid[pair.upper]
        kept = int(self._model.geom_conaffinity[shape])
        self._model.geom_conaffinity[shape] = kept & ~bit if passes else kept | bit
