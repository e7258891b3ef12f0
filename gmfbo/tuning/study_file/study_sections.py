"""Validated sections of a study file."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    model_validator,
)

from gmfbo.errors import did_you_mean
from gmfbo.objective.cost import PAPER_WEIGHTS
from gmfbo.objective.margins import MARGINS
from gmfbo.objective.metrics import METRICS, SETTLING_BAND
from gmfbo.objective.tracking import COMMAND_METRICS, TRACKING_METRICS
from gmfbo.space import Gain
from gmfbo.tuning.study_file.drift_section import DriftSection
from gmfbo.tuning.study_file.reference_section import ReferenceSection
from gmfbo.tuning.study_file.safety_section import SafetySection

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Number = Annotated[float, Field(allow_inf_nan=False)]
UnitText = Annotated[str, Field(pattern=r"^[^\s<>&\"]([^<>&\"\n]{0,18}[^\s<>&\"])?$")]


def _number_or_seed(value: object) -> float | Literal["seed"]:
    if value == "seed":
        return "seed"
    if isinstance(value, int | float) and math.isfinite(value):
        return float(value)
    raise ValueError(f'expected a number or "seed", got {value!r}')


def _as_range(value: object) -> object:
    """Expand the short forms [low, high] and a number into a table."""
    if isinstance(value, list) and len(value) == 2:
        return {"low": value[0], "high": value[1]}
    if isinstance(value, int | float):
        return {"low": value, "high": value}
    if isinstance(value, dict) and "values" in value:
        return {**value, **_ends_of(value)}
    if isinstance(value, dict | GainRange):
        return value
    raise ValueError(f"expected [low, high], a number or a table, got {value!r}")


def _ends_of(value: dict[str, Any]) -> dict[str, float]:
    """Bounds of a gain that may take single values only."""
    values = value["values"]
    if "low" in value or "high" in value or value.get("integer"):
        raise ValueError("expected either values or low and high, got both")
    numbers = isinstance(values, list) and all(isinstance(one, int | float) for one in values)
    if not numbers or len(set(values)) < 2:
        raise ValueError(f"values: expected a list of at least two numbers, got {values!r}")
    return {"low": min(values), "high": max(values)}


def _as_references(value: object) -> object:
    """Expand a single [reference] into a list of [[reference]]."""
    return [value] if isinstance(value, dict | ReferenceSection) else value


def _as_normalisation(value: object) -> object:
    return {"points": value} if isinstance(value, int) else value


def _as_words(value: object) -> object:
    """Require a command as a list, since shells split a text differently."""
    if isinstance(value, list) and value and all(isinstance(word, str) for word in value):
        return value
    raise ValueError(f'expected a list of words such as ["python", "bench.py"], got {value!r}')


Parameters = dict[str, Annotated[float | Literal["seed"], PlainValidator(_number_or_seed)]]

DEFAULT_METHOD = "gmfbo_estimated"
"""Method that was run on all plants of `tests/benchmarks/plants`, with fewest real runs there."""

KNOWN_METRICS = (*METRICS, *TRACKING_METRICS, *COMMAND_METRICS)
"""Metrics that need no function of the user."""

# Separates the draw of hidden physics from all other draws of the same seed.
_HIDDEN_STREAM = 0x41D


class Section(BaseModel):
    """Part of a study file; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class PlantChange(Section):
    """A lasting change of the plant after its n-th run, initial ones included."""

    after_runs: int = Field(ge=1)
    parameters: Parameters


class HiddenPhysics(Section):
    """Physics of the plant that its twin lacks, drawn from the study's seed."""

    count: tuple[int, int] = (1, 1)
    groups: dict[str, dict[str, tuple[int | float, int | float]]]

    @model_validator(mode="after")
    def _drawable(self) -> Self:
        low, high = self.count
        if not 0 <= low <= high <= len(self.groups):
            raise ValueError(
                f"count: expected [least, most] of the {len(self.groups)} groups, "
                f"got [{low}, {high}]"
            )
        for group, ranges in self.groups.items():
            for name, (least, most) in ranges.items():
                if not (0 < least <= most < math.inf):
                    raise ValueError(
                        f"groups.{group} '{name}': expected [low, high] with 0 < low <= high, "
                        f"got [{least:g}, {most:g}]"
                    )
        return self

    def drawn(self, seed: int) -> dict[str, float]:
        """Draw parameters of a few groups, log-uniform in their ranges; integers stay integers."""
        rng = np.random.default_rng([seed, _HIDDEN_STREAM])
        count = int(rng.integers(self.count[0], self.count[1] + 1))
        chosen = rng.choice(len(self.groups), size=count, replace=False)
        values: dict[str, float] = {}
        for group in sorted(chosen):
            for name, (low, high) in list(self.groups.values())[group].items():
                value = float(np.exp(rng.uniform(np.log(low), np.log(high))))
                whole = isinstance(low, int) and isinstance(high, int)
                values[name] = float(round(value)) if whole else value
        return values


class PlantSection(Section):
    """IS1, the real axis: an FMU, a program, recordings, or a user who asks and tells."""

    twin: str | None = None
    command: Annotated[list[str], BeforeValidator(_as_words)] | None = None
    function: str | None = None  # FILE.py:FUNCTION of the user
    recorded: str | None = None
    ask_tell: bool = False
    time_limit: Positive = 600.0  # [s] of one run of the command
    retries: int = Field(0, ge=0)
    parameters: Parameters = {}
    hidden: HiddenPhysics | None = None
    change: PlantChange | None = None
    noise: dict[str, NotNegative] = {}  # standard deviation by signal [its unit]

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        kinds = (self.twin, self.command, self.function, self.recorded, self.ask_tell or None)
        if sum(kind is not None for kind in kinds) != 1:
            raise ValueError(
                'expected exactly one of twin = FILE, command = ["program", ...], '
                'function = "FILE.py:FUNCTION", recorded = FOLDER and ask_tell = true'
            )
        if self.twin is None and (self.parameters or self.hidden or self.change):
            raise ValueError("parameters, hidden and change need a twin that plays the plant")
        if self.twin is None and self.noise:
            raise ValueError("noise needs a twin that plays the plant; a real one has its own")
        if self.command is None and self.model_fields_set & {"time_limit", "retries"}:
            raise ValueError("time_limit and retries need a command")
        return self


class TwinSection(Section):
    """IS2, the digital twin."""

    twin: str
    parameters: Parameters = {}


class GainRange(Section):
    """Range of one gain [unit of the FMU parameter]; equal ends fix it."""

    low: Number
    high: Number
    scale: Literal["linear", "log"] = "linear"
    integer: bool = False
    values: tuple[Number, ...] = ()
    now: Number | None = None  # in force today: the first real run

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.low > self.high:
            raise ValueError(f"expected low <= high, got [{self.low:g}, {self.high:g}]")
        if self.scale == "log" and self.low <= 0.0:
            raise ValueError(f"a log scale needs a positive lower bound, got {self.low:g}")
        if self.now is not None and not self.low <= self.now <= self.high:
            raise ValueError(
                f"now: expected within [{self.low:g}, {self.high:g}], got {self.now:g}; widen the "
                "range"
            )
        return self

    def gain(self, name: str) -> Gain | float:
        """The gain of this range, or its only value.

        Parameters
        ----------
        name : str
            FMU parameter.
        """
        low, high = self.low, self.high
        if self.integer and math.ceil(low) <= math.floor(high):
            low, high = float(math.ceil(low)), float(math.floor(high))
        if low == high:
            return low
        values = tuple(sorted(set(self.values)))
        return Gain(name, low, high, self.scale, self.integer, values)


class Normalisation(Section):
    """Constants of the cost: from the first `points` runs of IS2, or known ones."""

    points: int | None = Field(None, ge=2)
    mean: dict[str, Number] = {}
    std: dict[str, Positive] = {}  # [unit of the metric]

    @model_validator(mode="after")
    def _points_or_constants(self) -> Self:
        if (self.points is None) != bool(self.mean and self.std):
            raise ValueError("expected a number of points, or both mean and std")
        return self


class ObjectiveSection(Section):
    """Weighted sum of normalised metrics, of steps and a user's own, to be minimised."""

    signal: str = "position"
    weights: dict[str, NotNegative] = Field(default_factory=lambda: dict(PAPER_WEIGHTS))
    normalise: Annotated[Normalisation, BeforeValidator(_as_normalisation)] = Normalisation(
        points=10
    )
    metrics: str | None = None  # FILE.py:FUNCTION of the user
    units: dict[str, UnitText] = {}  # of the user's own metrics
    band: Annotated[float, Field(gt=0.0, lt=1.0)] = SETTLING_BAND  # share of the step
    filter: NotNegative = 0.0  # [s] of the low-pass that the response is smoothed by
    command: str | None = None  # signal; without it the twin file's state of that name
    as_published: bool = False  # a failed run has a price; runs are not ranked

    @model_validator(mode="after")
    def _known_metrics(self) -> Self:
        constants = self.normalise
        for name in (*self.weights, *constants.mean, *constants.std):
            self.check_metric(name)
        for name in self.weights if constants.points is None else ():
            if name not in constants.mean or name not in constants.std:
                raise ValueError(f"normalise: expected mean and std of '{name}'")
        if not any(self.weights.values()):
            raise ValueError("weights: expected at least one above zero")
        return self

    def check_metric(self, name: str) -> None:
        """Raise for a name that is no metric of ours and none of the user's function."""
        if name not in KNOWN_METRICS and self.metrics is None:
            raise ValueError(
                f"no metric '{name}'"
                + did_you_mean(name, KNOWN_METRICS)
                + ' (one of your own needs [objective] metrics = "FILE.py:FUNCTION")'
            )


class BudgetSection(Section):
    """Initial runs, and when to stop: after `iterations` queries or `is1_runs` real runs."""

    initial_is1: int = Field(2, ge=1)
    initial_is2: int = Field(10, ge=2)
    iterations: int | None = Field(None, ge=0)
    is1_runs: int | None = Field(None, ge=1)
    is3_per_run: int = Field(4, ge=0)
    is2_runs: int | None = Field(None, ge=2)  # of the twin, in all
    is2_seconds: Positive = 1800.0  # [s] of twin runs: half an hour, as long as a bench waits

    @property
    def most_queries(self) -> int:
        """Most queries of both sources after the initial ones, so that twin queries end too."""
        if self.iterations is not None:
            return self.iterations
        return 20 if self.is1_runs is None else max(100, 5 * self.is1_runs)

    def queries_left(self, queries: int, real_runs: int) -> int:
        """Fewest queries left in the budget; `real_runs` count initial ones, `queries` do not."""
        left = self.most_queries - queries
        if self.is1_runs is not None:
            left = min(left, self.is1_runs - real_runs)
        return max(left, 0)


class CompareSection(Section):
    """What a comparison of methods is judged by, where the plant is no FMU."""

    truth: str | None = None  # table of gains and noise-free metrics


class StudyFile(Section):
    """A validated study file; paths in it are relative to its folder."""

    name: str = Field(min_length=1, pattern=r"^[^/\\]+$")
    seed: int = Field(0, ge=0)
    method: str = DEFAULT_METHOD
    out: str | None = None
    earlier: str | None = None  # real runs to take over: a study, a folder of recordings, a table
    is1: PlantSection
    is2: TwinSection
    gains: dict[str, Annotated[GainRange, BeforeValidator(_as_range)]] = {}
    references: Annotated[
        tuple[ReferenceSection, ...],
        BeforeValidator(_as_references),
        Field(alias="reference", min_length=1),
    ] = (ReferenceSection(),)
    objective: ObjectiveSection = ObjectiveSection()
    constraints: dict[str, Number] = {}
    safety: SafetySection = SafetySection()
    drift: DriftSection = DriftSection()
    budget: BudgetSection = BudgetSection()
    compare: CompareSection = CompareSection()

    @model_validator(mode="after")
    def _normalised_by_initial_runs(self) -> Self:
        points = self.objective.normalise.points
        if points is not None and points > self.budget.initial_is2:
            raise ValueError(
                f"[objective] normalise: expected at most initial_is2 = "
                f"{self.budget.initial_is2}, got {points}: the constants come from these runs"
            )
        return self

    @model_validator(mode="after")
    def _known_limits(self) -> Self:
        for name in self.constraints:
            if name in MARGINS:
                continue
            try:
                self.objective.check_metric(name)
            except ValueError as error:
                raise ValueError(f"[constraints]: {error}") from None
        return self

    @model_validator(mode="after")
    def _units_of_own_metrics(self) -> Self:
        for name in self.objective.units:
            if name in KNOWN_METRICS or name in MARGINS:
                raise ValueError(f"[objective] units: the unit of '{name}' is known; leave it out")
            if name not in self.own_metrics:
                raise ValueError(
                    f"[objective] units: no metric '{name}' of your own has a weight or a limit"
                    + did_you_mean(name, self.own_metrics)
                    + " (a weight of 0 shows it alone)"
                )
        return self

    @property
    def reference(self) -> ReferenceSection:
        """The first reference; most studies have one."""
        return self.references[0]

    @property
    def own_metrics(self) -> frozenset[str]:
        """Names that the user's function must return."""
        return frozenset({*self.objective.weights, *self.constraints} - {*KNOWN_METRICS, *MARGINS})

    @property
    def folder_name(self) -> str:
        """Folder of the study, relative to the file."""
        return self.out or f"{self.name}.study"


def stated(file: StudyFile) -> dict[str, Any]:
    """Values stated in a study file, as TOML can hold them, without defaults."""
    return file.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
