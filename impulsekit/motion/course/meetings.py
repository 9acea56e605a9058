"""Points that meet planes in compiled code: what that knows of a motion, and what it tells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...impact.singular import has_uneven_masses
from ...laws.struck import Together
from ...scene import Contact, Scene
from ...scene.contacts import adheres, turns
from ...scene.friction import is_plain, static_friction
from ...scene.law import RESTITUTIONS
from ..gaps.resting import RestingContact
from ..travel.journey import Ledger
from ..travel.meet import Hold, Rules
from ..travel.strike import Blow
from .present import Present

__all__ = [
    "Met",
    "hold_of",
    "ledger_of",
    "met_in",
    "rest_as",
    "rules_of",
    "strikes_plainly",
]

# So many contacts that cease to rest are noted, besides two by gap.
MOST_OVER = 64


@dataclass(frozen=True, eq=False)
class Met:
    """An impact that compiled code has solved.

    Attributes:
        t: [s]. q: (nq,). v: (nv,) before, dv: (nv,) Δv.
        part: (m,) which gaps took part.
        soft: whether without restitution.
        blow: what the points did.
    """

    t: float
    q: np.ndarray
    v: np.ndarray
    dv: np.ndarray
    part: np.ndarray
    soft: bool
    blow: Blow

    @property
    def found(self) -> Together:
        """What the points did."""
        blow, count = self.blow, int(np.count_nonzero(self.part))
        code, residual, off, fastest = blow.numbers.tolist()
        points, works = blow.points[:, : 3 * count].copy(), blow.works[:, :count].copy()
        return Together(int(code), residual, off, fastest, 0, False, self.dv, points, works)


def strikes_plainly(scene: Scene) -> bool:
    """Whether points that meet planes are known to compiled code: slip at the end, none held."""
    return (
        scene.law.slip == "end"
        and scene.law.restitution in ("newton", "poisson")
        and not scene.held
        and not has_uneven_masses(scene.robot.model)
        and not any(getattr(entry, "tangential_restitution", 0.0) for entry in scene.contacts)
        and not any(map(adheres, scene.contacts))
    )


def rules_of(now: Present, *, changes: bool) -> Rules:
    """How the gaps of a motion meet.

    Args:
        now: the motion. changes: whether velocities that jump change what acts.
    """
    scene, gaps = now.scene, now.gaps
    items = [] if gaps is None else gaps.items
    plain = np.zeros(len(items), dtype=bool)
    coefficients = np.zeros((3, len(items)))
    known = not changes and strikes_plainly(scene) and gaps is not None and not gaps.has_conditions
    for i, item in enumerate(items):
        entry = scene.contacts[item.entry]
        if not (known and isinstance(entry, Contact)):
            continue
        if isinstance(entry.restitution, float) and is_plain(entry.friction) and not turns(entry):
            plain[i] = True
            coefficients[:2, i] = static_friction(entry.friction), entry.restitution
    friction = np.array([item.friction for item in items], dtype=float)
    word = RESTITUTIONS.index(scene.law.restitution)
    at_once = scene.law.order == "simultaneous"
    capture = float(now.settings.capture_speed)
    return Rules(plain, coefficients, friction, word, at_once, capture)


def ledger_of(now: Present, impacts: int, steps: int) -> Ledger:
    """Room for so many impacts and steps."""
    m, nq, nv = len(now.base), len(now.q), len(now.v)
    return Ledger(
        np.zeros(2, dtype=np.int64),
        np.zeros(impacts),
        np.zeros((impacts, nq)),
        np.zeros((impacts, nv)),
        np.zeros((impacts, nv)),
        np.zeros((impacts, m), dtype=bool),
        np.zeros(impacts, dtype=bool),
        np.zeros((impacts, 4)),
        np.zeros((impacts, 3, 3 * m)),
        np.zeros((impacts, 3, m)),
        np.zeros((nv, nv)),
        np.zeros(steps, dtype=np.int64),
        np.zeros((steps, m), dtype=np.int64),
        np.zeros((steps, m)),
    )


def hold_of(now: Present) -> Hold:
    """What rests now."""
    m, contacts = len(now.base), now.resting.contacts
    n = len(contacts)
    hold = Hold(
        np.array([n]),
        np.zeros(m, dtype=np.int64),
        np.zeros(m),
        np.zeros((m, 3)),
        now.base.copy(),
        np.zeros((MOST_OVER + 2 * m, 3)),
        np.zeros(1, dtype=np.int64),
    )
    if n:
        hold.gaps[:n] = [contact.gap for contact in contacts]
        hold.since[:n] = [contact.since for contact in contacts]
    return hold


def rest_as(now: Present, hold: Hold) -> None:
    """Let rest what ``hold`` has, which impacts have changed."""
    gaps = now.gaps
    if gaps is None:
        return
    for gap, start, end in hold.over[: hold.many[0]].tolist():
        own = RestingContact(int(gap), int(gaps.entries[int(gap)]), 0.0, start)
        now.rests.append(now.rest(own, end))
    n = int(hold.number[0])
    now.resting.contacts = [
        RestingContact(i, int(gaps.entries[i]), gaps.items[i].friction, since)
        for i, since in zip(hold.gaps[:n].tolist(), hold.since[:n].tolist(), strict=True)
    ]
    now.base = hold.base


def met_in(ledger: Ledger) -> list[Met]:
    """The impacts of a ledger, copied."""
    count = int(ledger.counts[0])
    if not count:
        return []
    own = ledger.q, ledger.v, ledger.dv, ledger.part, ledger.numbers, ledger.points, ledger.works
    q, v, dv, part, *more = (array[:count].copy() for array in own)
    numbers, points, works = more
    seen = zip(ledger.times[:count].tolist(), ledger.soft[:count].tolist(), strict=True)
    return [
        Met(t, q[i], v[i], dv[i], part[i], soft, Blow(dv[i], numbers[i], points[i], works[i], dv))
        for i, (t, soft) in enumerate(seen)
    ]
