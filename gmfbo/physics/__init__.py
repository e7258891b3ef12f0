"""Physics that a digital twin may lack: its law, its size, and its words.

An `Effect` acts at a port of the twin; its equations are in `physics.fmu`, all else is here::

    effect = CATALOGUE["coulomb_friction"]
    effect.not_excited(excitation)         # None, or why these recordings cannot show it
    effect.signal(states, parameters)      # port signal on a measured trajectory, without feedback
    effect.feature(states)                 # the same for unit size at its typical shape
    for start in effect.starts(excitation):            # fitted parameters, off zero and bounds
        effect.variables(start, excitation)            # {"coulomb_friction.level": ..., fixed ones}
    effect.bounds(excitation), effect.scales(excitation)
    effect.size(start, excitation) >= effect.floor(excitation)      # else it is never claimed
    effect.acts(states, parameters), effect.region(parameters, units)
    effect.statement(parameters, units, units.place)

`signal` is None for effects that carry motion of their own (backlash, compliance): simulate them.
`feature` is None as well where no shape is typical (lines over position or time are searched for).
`Units.resolve(parameter.unit)` writes a unit for a twin. A friction law's bristle deflection and a
gap's contact are fixed parameters that follow from the excitation, never fitted ones. Between
processes, pass names: an effect holds functions and does not pickle.
"""

from gmfbo.physics.catalogue import CATALOGUE, add_effect
from gmfbo.physics.effect import Effect, EffectParameter, Units, Values
from gmfbo.physics.excitation import Excitation
from gmfbo.physics.states import States

__all__ = [
    "CATALOGUE",
    "Effect",
    "EffectParameter",
    "Excitation",
    "States",
    "Units",
    "Values",
    "add_effect",
]
