"""The effects that gmfbo knows; to add one, import it here and list it."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from gmfbo.physics.effect import Effect
from gmfbo.physics.effects.actuator_saturation import actuator_saturation
from gmfbo.physics.effects.cogging_torque import cogging_torque
from gmfbo.physics.effects.coulomb_friction import coulomb_friction
from gmfbo.physics.effects.stribeck_friction import stribeck_friction
from gmfbo.physics.effects.transport_delay import transport_delay
from gmfbo.physics.effects.viscous_friction import viscous_friction

# The order is that of reports, and decides between effects that explain equally well.
_EFFECTS = (
    coulomb_friction,
    stribeck_friction,
    viscous_friction,
    cogging_torque,
    actuator_saturation,
    transport_delay,
)

CATALOGUE: Mapping[str, Effect] = MappingProxyType({effect.name: effect for effect in _EFFECTS})
