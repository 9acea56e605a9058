"""Contacts come to rest, slide, stick and let go."""

from __future__ import annotations

from collections.abc import Collection, Iterable

import numpy as np

from ..gaps.resting import RestingContact
from ..rest.settle import LIFTED
from ..tree.pressed import STICKS
from ..zeros.closing import GRAZED
from .drift import lay_down, take_out_drift
from .present import Present

__all__ = ["come_to_rest", "heed_stop", "keep_up", "settle"]

# Slip below this share of the velocities counts as zero.
ENDED = 1e-6
# Slip [m/s] that stops sooner than time can tell has stopped.
SETTLED_SLIP = 1e-8


def come_to_rest(now: Present, candidates: Iterable[int], low: Collection[int] = ()) -> None:
    """After an impact: what of the candidates (gaps) stays, and how.

    What parts no faster than the capture speed stays: its next approach would be slower still, and
    captured. Were it not so, contacts that lift each other in turn would do so without end.

    Args:
        now: the motion.
        candidates: gaps that have been struck.
        low: those that stay however fast they open.
    """
    gaps = now.gaps
    if gaps is None:
        if now.resting.acts:
            settle(now, fresh=True)
        return
    slow = max(now.slow, now.settings.capture_speed)
    before = {c.gap: c for c in now.resting.contacts}
    stays: list[RestingContact] = []
    rates = gaps.measure(now.q, now.v)[1].tolist() if gaps.all_rated else None
    for i in candidates:
        opening = now.closing(i) if rates is None else rates[i]
        if i in low or opening <= max(slow, gaps.items[i].rest_speed):
            entry, friction = int(gaps.entries[i]), gaps.items[i].friction
            stays.append(before.get(i) or RestingContact(i, entry, friction, now.t))
    kept = {c.gap for c in stays}
    now.rests += [now.rest(c, now.t) for c in before.values() if c.gap not in kept]
    now.resting.contacts = stays
    now.rebase()
    gaps.hold(stays, now.q)
    gaps.let_go_of_rising(stays, now.q, now.v, slow, [c.gap for c in stays if now.chatters(c.gap)])
    if stays and now.settle(fresh=True, lay=True) is None:
        lay_down(now)
        settle(now, fresh=True)
    elif not stays and now.resting.acts:
        settle(now, fresh=True)


def settle(now: Present, *, fresh: bool = False) -> bool:
    """Look at the resting contacts: which are loaded, lift or slide from here on.

    Drift is taken out on the way.

    Args:
        now: the motion.
        fresh: after an impact.

    Returns:
        Whether anything has changed.
    """
    settled = now.settle(fresh=fresh, lay=False)
    if settled is not None:
        return settled
    resting = now.resting
    if resting.joints is not None:
        resting.joints.heed(now.v)
    if fresh and now.gaps is not None:
        resting.begin(now.gaps.velocities(resting.contacts, now.q, now.v))
        if resting.rolling is not None:
            turning = resting.rolling.turning(now.gaps, resting.contacts, now.q, now.v)
            resting.rolling.begin(resting.contacts, turning)
    now.acceleration()
    changed = _release(now)
    if changed:
        now.acceleration()
    changed |= resting.update_slides(fresh=fresh)
    take_out_drift(now, _bound(now))
    if resting.joints is not None:
        resting.joints.heed(now.v)
    if resting.acts:
        now.acceleration()
        # Once more: what was found to slide may change the loads of the others.
        changed |= resting.update_slides(fresh=False)
    return changed


def keep_up(now: Present) -> bool:
    """At the end of a step: look at what rests, take out drift of what holds.

    Returns:
        Whether what rests does something else from here on.
    """
    if now.resting.acts:
        return settle(now)
    if now.held is not None:
        take_out_drift(now, [])
    return False


def heed_stop(now: Present) -> None:
    """A slip has stopped, or turned."""
    gaps = now.gaps
    if gaps is None:
        return
    slip = gaps.velocities(now.resting.contacts, now.q, now.v)
    fastest = float(np.abs(now.v).max())
    now.resting.heed_stop(slip, ENDED * max(1.0, fastest), SETTLED_SLIP)
    if now.resting.may_tear:
        now.left_to_tear(now.t, now.q, now.v, tear=True)
    contacts, rolling = now.resting.contacts, now.resting.rolling
    if rolling is not None:
        turning = rolling.turning(gaps, contacts, now.q, now.v)
        rolling.heed_stop(contacts, turning, fastest)


def _release(now: Present) -> bool:
    """Let go of contacts that have lifted; whether there was one."""
    resting, gaps = now.resting, now.gaps
    if gaps is None or not resting.contacts:
        return False
    loaded, speeds = resting.loaded(), resting.slip[2::3]
    parted = resting.lets_go()
    lifted = ~loaded & ((speeds > LIFTED) | parted)
    torn: list[int] = []
    stays: list[RestingContact] = []
    changed = False
    i = 0
    for contact in resting.contacts:
        gone, own = lifted[i : i + contact.count], parted[i : i + contact.count]
        i += contact.count
        if gone.all():
            torn += [contact.gap] if own.any() else []
            now.rests.append(now.rest(contact, now.t))
            gaps.let_go(contact)
        else:
            stays.append(contact)
            changed |= bool(gone.any()) and gaps.let_go(contact, gone)
    if len(stays) < len(resting.contacts):
        resting.contacts = stays
        now.rebase()
        for gap in torn:
            # It has no speed yet: rounding alone would close it again.
            now.base[gap] -= max(GRAZED, gaps.rounding(gap, float(abs(now.base[gap]))))
        changed = True
    return changed


def _bound(now: Present) -> list[tuple[int, int]]:
    """Rows of resting points that keep still: (point, row), the normal first."""
    resting = now.resting
    friction, loaded = resting.friction(), resting.loaded()
    found = []
    for i, does in enumerate(resting.slips()[:, 2].tolist()):
        if not loaded[i]:
            continue
        found.append((i, 2))
        if does == STICKS and friction[i]:
            found += [(i, 0), (i, 1)]
    return found
