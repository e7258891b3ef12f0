"""One size for each effect of physics.fmu at which it shows, as parameters of the FMU."""

SHOWING: dict[str, dict[str, float]] = {
    "coulomb_friction": {"level": 0.3},
    "stribeck_friction": {"level": 0.2, "breakaway": 0.5, "velocity": 0.4},
    "presliding_friction": {"level": 0.3, "deflection": 1e-3},
    "asymmetric_friction": {"level_positive": 0.3, "level_negative": 0.2},
    "load_dependent_friction": {"level": 0.1, "coefficient": 0.2},
    "position_dependent_friction": {"level": 0.2, "sine": 0.1, "cosine": 0.05, "wavenumber": 3.0},
    "viscous_friction": {"coefficient": 0.1},
    "quadratic_drag": {"coefficient": 0.1},
    "backlash": {"gap": 0.01, "load_inertia": 1e-3, "stiffness": 50.0, "damping": 0.01},
    "torsional_compliance": {"stiffness": 50.0, "damping": 0.01, "load_inertia": 1e-3},
    "hysteresis": {"level": 0.3, "deflection": 0.05},
    "cogging_torque": {"wavenumber_1": 7.0, "sine_1": 0.1, "wavenumber_4": 28.0, "cosine_4": 0.1},
    "torque_ripple": {"wavenumber_1": 7.0, "sine_1": 0.1, "wavenumber_2": 14.0, "cosine_2": 0.1},
    "gravity_torque": {"sine": 0.2, "cosine": 0.3},
    "elastic_return": {"stiffness": 0.5, "preload": 0.1},
    "constant_torque_offset": {"level": 0.2},
    "periodic_disturbance": {"frequency": 30.0, "sine": 0.1, "cosine": 0.2},
    "pulse_disturbance": {"start": 0.002, "duration": 0.01, "level": 0.3},
    "load_inertia": {"inertia": 1e-3},
    "actuator_saturation": {"limit": 0.5},
    "actuator_dead_zone": {"width": 0.2},
    "actuator_rate_limit": {"rate": 5.0},
    "actuator_lag": {"time": 5e-3},
    "actuator_gain_loss": {"loss": 0.1},
    "transport_delay": {"delay": 1.7e-3},
    "thermal_derating": {"loss": 0.3, "time": 0.01, "scale": 0.5},
    "supply_voltage_limit": {"limit": 0.8, "slope": 0.3},
    "magnetic_saturation": {"coefficient": 0.4},
    "sensor_eccentricity": {"sine": 0.01, "cosine": 0.02, "wavenumber": 2.0},
    "sensor_lag": {"time": 3e-3},
    "sensor_offset": {"level": 0.1},
    "sensor_scale": {"share": 0.01},
}

# What an effect keeps at size zero.
SHAPES: dict[str, tuple[str, ...]] = {
    "stribeck_friction": ("velocity",),
    "presliding_friction": ("deflection",),
    "position_dependent_friction": ("wavenumber",),
    "backlash": ("gap", "stiffness", "damping"),
    "torsional_compliance": ("stiffness", "damping"),
    "hysteresis": ("deflection",),
    "cogging_torque": ("wavenumber_1", "wavenumber_4"),
    "torque_ripple": ("wavenumber_1", "wavenumber_2"),
    "periodic_disturbance": ("frequency",),
    "pulse_disturbance": ("start", "duration"),
    "thermal_derating": ("time", "scale"),
    "supply_voltage_limit": ("slope",),
    "sensor_eccentricity": ("wavenumber",),
}


def shape(effect: str) -> dict[str, float]:
    """Parameters that an effect keeps at size zero, as `FmuInstance.start` takes them."""
    return {f"{effect}.{name}": SHOWING[effect][name] for name in SHAPES.get(effect, ())}


def parameters(effect: str) -> dict[str, float]:
    """Parameters of an effect at a size that shows, as `FmuInstance.start` takes them."""
    return {f"{effect}.{name}": value for name, value in SHOWING[effect].items()}


def port_of(effect: str) -> str:
    """Output of physics.fmu that the effect acts on."""
    if effect.startswith("sensor_"):
        return "sensor"
    commands = ("actuator_", "transport_", "thermal_", "supply_", "magnetic_")
    return "command" if effect.startswith(commands) else "torque"
