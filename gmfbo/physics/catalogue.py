"""Catalogue of the effects; to add one, import it here and list it.

Effects outside of gmfbo are added by `add_effect`, or by the entry point of a package.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib.metadata import entry_points

from gmfbo.errors import InputError
from gmfbo.physics.effect import Effect
from gmfbo.physics.effects.actuator_dead_zone import actuator_dead_zone
from gmfbo.physics.effects.actuator_gain_loss import actuator_gain_loss
from gmfbo.physics.effects.actuator_lag import actuator_lag
from gmfbo.physics.effects.actuator_rate_limit import actuator_rate_limit
from gmfbo.physics.effects.actuator_saturation import actuator_saturation
from gmfbo.physics.effects.asymmetric_friction import asymmetric_friction
from gmfbo.physics.effects.backlash import backlash
from gmfbo.physics.effects.cogging_torque import cogging_torque
from gmfbo.physics.effects.constant_torque_offset import constant_torque_offset
from gmfbo.physics.effects.coulomb_friction import coulomb_friction
from gmfbo.physics.effects.elastic_return import elastic_return
from gmfbo.physics.effects.gravity_torque import gravity_torque
from gmfbo.physics.effects.hysteresis import hysteresis
from gmfbo.physics.effects.load_dependent_friction import load_dependent_friction
from gmfbo.physics.effects.load_inertia import load_inertia
from gmfbo.physics.effects.magnetic_saturation import magnetic_saturation
from gmfbo.physics.effects.periodic_disturbance import periodic_disturbance
from gmfbo.physics.effects.position_dependent_friction import position_dependent_friction
from gmfbo.physics.effects.presliding_friction import presliding_friction
from gmfbo.physics.effects.pulse_disturbance import pulse_disturbance
from gmfbo.physics.effects.quadratic_drag import quadratic_drag
from gmfbo.physics.effects.sensor_eccentricity import sensor_eccentricity
from gmfbo.physics.effects.sensor_lag import sensor_lag
from gmfbo.physics.effects.sensor_offset import sensor_offset
from gmfbo.physics.effects.sensor_scale import sensor_scale
from gmfbo.physics.effects.stribeck_friction import stribeck_friction
from gmfbo.physics.effects.supply_voltage_limit import supply_voltage_limit
from gmfbo.physics.effects.thermal_derating import thermal_derating
from gmfbo.physics.effects.torque_ripple import torque_ripple
from gmfbo.physics.effects.torsional_compliance import torsional_compliance
from gmfbo.physics.effects.transport_delay import transport_delay
from gmfbo.physics.effects.viscous_friction import viscous_friction

# The order of reports; the first wins among effects that explain equally well.
_EFFECTS = (
    coulomb_friction,
    stribeck_friction,
    presliding_friction,
    asymmetric_friction,
    load_dependent_friction,
    position_dependent_friction,
    viscous_friction,
    quadratic_drag,
    backlash,
    torsional_compliance,
    hysteresis,
    cogging_torque,
    torque_ripple,
    gravity_torque,
    elastic_return,
    constant_torque_offset,
    actuator_saturation,
    actuator_dead_zone,
    actuator_rate_limit,
    actuator_lag,
    actuator_gain_loss,
    transport_delay,
    thermal_derating,
    supply_voltage_limit,
    magnetic_saturation,
    sensor_eccentricity,
    sensor_lag,
    sensor_offset,
    sensor_scale,
    periodic_disturbance,
    pulse_disturbance,
    load_inertia,
)

_PORTS = ("torque", "command", "sensor")


class _Catalogue(Mapping[str, Effect]):
    """Effects by name; effects of installed packages are loaded at the first look-up."""

    def __init__(self) -> None:
        self._own = {effect.name: effect for effect in _EFFECTS}
        self._added: dict[str, Effect] = {}
        self._loaded = False

    def add(self, effect: Effect) -> None:
        known = self._own.get(effect.name, self._added.get(effect.name, effect))
        if known is not effect:
            raise InputError(
                f"effect '{effect.name}': expected a name that is free, got that of another "
                "effect; give yours another name"
            )
        if effect.port not in _PORTS:
            raise InputError(
                f"effect '{effect.name}': expected a port of {', '.join(_PORTS)}, got "
                f"'{effect.port}'"
            )
        self._added[effect.name] = effect

    @property
    def added(self) -> tuple[Effect, ...]:
        """Effects that are not part of gmfbo."""
        return tuple(effect for name, effect in self._all().items() if name not in self._own)

    def _all(self) -> dict[str, Effect]:
        if not self._loaded:
            self._loaded = True  # set first, since a loaded package may look up an effect itself
            try:
                for effect in _installed_effects():
                    self.add(effect)
            except InputError:
                self._loaded = False  # so that each later look-up reports the error again
                raise
        return {**self._own, **self._added}

    def __getitem__(self, name: str) -> Effect:
        return self._all()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all())

    def __len__(self) -> int:
        return len(self._all())


def _installed_effects() -> Iterator[Effect]:
    for entry in entry_points(group="gmfbo.effects"):
        try:
            effect = entry.load()
        except Exception as error:
            reason = f"{type(error).__name__}: {error}".splitlines()[0]
            raise InputError(
                f"effect '{entry.name}': cannot load {entry.value} ({reason}); "
                "repair or uninstall the package that adds it"
            ) from error
        if not isinstance(effect, Effect):
            raise InputError(
                f"effect '{entry.name}': expected {entry.value} to be a gmfbo.physics.Effect, got "
                f"{type(effect).__name__}"
            )
        yield effect


CATALOGUE = _Catalogue()
"""All effects by name: gmfbo's in the order above, then added ones."""


def add_effect(effect: Effect) -> None:
    """Add an effect that is not part of gmfbo to every diagnosis of this process.

    Its law is C code in a `physics.fmu` of your own, made by
    `fmu_build.own_effect.build_physics` and named by the environment variable `GMFBO_PHYSICS`.
    Adding the same effect again does nothing.

    Parameters
    ----------
    effect : Effect
        Its bounds, its smallest claimed size, and its words.

    Raises
    ------
    InputError
        Another effect has this name, or it names no port.
    """
    CATALOGUE.add(effect)
