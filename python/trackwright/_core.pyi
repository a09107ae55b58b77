"""The types of the compiled part; `help()` has the words."""

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Protocol, Union

import numpy as np
import numpy.typing as npt

__version__: str

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Records = np.recarray[Any, np.dtype[np.void]]
Path = Union[str, os.PathLike[str]]
Figures = dict[str, Any]
Body = Literal["tool", "crf"]
Outside = Literal["clamp", "extrapolate", "reject"]
MapKind = Literal["distortion", "correction"]
FitMethod = Literal["per-direction", "joint"]
SensorKind = Literal["5dof", "6dof"]
Weights = Literal["area", "gnomonic"]
Loss = Literal["huber", "squares"]
VolumeName = Literal["cube", "dome", "tabletop", "compact"]
Scatter = Literal["first-order", "monte-carlo"]
Determination = Literal["full", "poor", "free-axis", "free-rotation"]
ModelName = Literal["bernstein", "kriging", "harmonic"]
# Of "x" to "rz" (min, max, step); "pivot": "origin", "tip", {"body": (x, y, z)} or {"reference": …}.
Motion = dict[str, Any]
Requirement = dict[str, float]
# A name, or conductivity in S/m and relative permeability.
Material = Union[str, tuple[float, float]]

class DataFrame(Protocol):
    """Anything with the DataFrame interchange protocol."""

    def __dataframe__(self, nan_as_null: bool = ..., allow_copy: bool = ...) -> Any: ...

Memory = Union[npt.NDArray[Any], Mapping[str, npt.ArrayLike], DataFrame]
Table = Union[Path, Memory]

class TrackwrightError(ValueError): ...
class TrackwrightWarning(UserWarning): ...

class Readings:
    """Poses as the tracker would report them; those that were left out are not a number."""

    @property
    def positions(self) -> Floats: ...
    @property
    def quaternions(self) -> Floats: ...
    @property
    def outside(self) -> Flags: ...

class Corrected(Found):
    """Readings that were corrected; those without an answer are not a number."""

    @property
    def positions(self) -> Floats: ...
    @property
    def quaternions(self) -> Floats: ...
    @property
    def outside(self) -> Flags: ...
    @property
    def converged(self) -> Flags: ...
    @property
    def ambiguous(self) -> Flags: ...

class Environment:
    @staticmethod
    def load(path: Path) -> Environment: ...
    @staticmethod
    def fit(
        table: Table,
        *,
        order: int | None = None,
        directions: int | None = None,
        ridge: float | None = None,
        method: FitMethod = "per-direction",
        map: MapKind = "distortion",
        sensors: SensorKind = "5dof",
        weights: Weights = "area",
        lag: float = 0.0,
        sensor_offset: float = 0.0,
        rcond: float = 1e-10,
        model: ModelName | None = None,
        symmetric: bool = False,
        generator: str | None = None,
        degree: int | None = None,
        loss: Loss = "huber",
        holdout: Table | None = None,
        hold_out: str | None = None,
        volume: VolumeName | None = None,
        support: bool = True,
        jitter_position_mm: float | None = None,
        jitter_angle_deg: float | None = None,
        jitter_growth_mm: float | None = None,
        registration_mm: float | None = None,
        registration_deg: float | None = None,
        bounds: npt.ArrayLike | None = None,
        name: str | None = None,
        as_is: bool = False,
    ) -> Environment: ...
    @staticmethod
    def select(
        table: Table,
        *,
        models: Sequence[str] | None = None,
        orders: Sequence[int] | None = None,
        directions: Sequence[int] | None = None,
        ridges: Sequence[float] | None = None,
        folds: int = 5,
        group: str | None = None,
        hold_out: str | None = None,
        seed: int = 1,
        method: FitMethod = "per-direction",
        map: MapKind = "distortion",
        sensors: SensorKind = "5dof",
        weights: Weights = "area",
        lag: float = 0.0,
        sensor_offset: float = 0.0,
        rcond: float = 1e-10,
        generator: str | Sequence[str] | None = None,
        degree: int | None = None,
        loss: Loss = "huber",
        volume: VolumeName | None = None,
        support: bool = True,
        jitter_position_mm: float | None = None,
        jitter_angle_deg: float | None = None,
        jitter_growth_mm: float | None = None,
        registration_mm: float | None = None,
        registration_deg: float | None = None,
        name: str | None = None,
        as_is: bool = False,
    ) -> Environment: ...
    def save(self, path: Path, *, overwrite: bool = False) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def map(self) -> MapKind: ...
    @property
    def model(self) -> str: ...
    @property
    def bounds(self) -> Floats: ...
    @property
    def figures(self) -> Figures | None: ...
    def distort(
        self,
        positions: npt.ArrayLike,
        quaternions: npt.ArrayLike,
        *,
        outside: Outside = "clamp",
        as_is: bool = False,
    ) -> Readings: ...
    def distort_6dof(
        self,
        positions: npt.ArrayLike,
        quaternions: npt.ArrayLike,
        *,
        as_is: bool = False,
    ) -> Readings: ...
    def compensate(
        self,
        positions: npt.ArrayLike,
        quaternions: npt.ArrayLike,
        *,
        outside: Outside = "clamp",
        method: Literal["auto", "inverse", "shortcut"] = "auto",
        as_is: bool = False,
    ) -> Corrected: ...
    def validity(
        self,
        positions: npt.ArrayLike,
        quaternions: npt.ArrayLike,
        *,
        outside: Outside = "clamp",
        as_is: bool = False,
    ) -> Records: ...

class Sensor:
    def __init__(
        self,
        name: str,
        position: npt.ArrayLike,
        *,
        axis: npt.ArrayLike | None = None,
        rotation: npt.ArrayLike | None = None,
        marker: bool = False,
        coil: tuple[float, float] | None = None,
    ) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def degrees_of_freedom(self) -> int: ...
    @property
    def position(self) -> Floats: ...
    @property
    def axis(self) -> Floats | None: ...
    @property
    def rotation(self) -> Floats | None: ...
    @property
    def coil(self) -> tuple[float, float] | None: ...
    def __eq__(self, other: object) -> bool: ...

class Design:
    @staticmethod
    def load(path: Path) -> Design: ...
    @staticmethod
    def builtin(name: str) -> Design: ...
    @staticmethod
    def builtin_names() -> list[str]: ...
    def save(self, path: Path) -> list[os.PathLike[str]]: ...
    def to_ron(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def environment(self) -> Environment: ...
    @property
    def has_crf(self) -> bool: ...
    def sensors(self, body: Body = "tool") -> list[Sensor]: ...
    def tip(self, body: Body = "tool") -> Floats | None: ...
    @property
    def crf_from_tool(self) -> Floats: ...
    @property
    def tracker_from_crf(self) -> Floats | None: ...
    @property
    def requirement(self) -> Requirement | None: ...
    @property
    def motion(self) -> Motion | None: ...
    def with_name(self, name: str) -> Design: ...
    def with_sensor(
        self,
        name: str,
        position: npt.ArrayLike | None = None,
        *,
        axis: npt.ArrayLike | None = None,
        rotation: npt.ArrayLike | None = None,
        marker: bool = False,
        coil: tuple[float, float] | None = None,
        new_name: str | None = None,
        body: Body = "tool",
    ) -> Design: ...
    def without_sensor(self, name: str, *, body: Body = "tool") -> Design: ...
    def with_tip(self, position: npt.ArrayLike | None, *, body: Body = "tool") -> Design: ...
    def with_tool_pose(self, crf_from_tool: npt.ArrayLike) -> Design: ...
    def with_crf_pose(self, tracker_from_crf: npt.ArrayLike) -> Design: ...
    def with_motion(
        self, motion: Motion | None, *, body: Body = "tool"
    ) -> Design: ...
    def with_requirement(
        self, requirement: Requirement | None, *, body: Body = "tool"
    ) -> Design: ...
    def with_target(self, name: str, position: npt.ArrayLike) -> Design: ...
    def without_target(self, name: str) -> Design: ...
    def with_orientation_weight(self, weight_mm: float | None) -> Design: ...
    def with_environment(self, path: Path) -> Design: ...
    def numbers(self) -> dict[str, tuple[float, str]]: ...

class Simulation(Found):
    @property
    def trials(self) -> Records: ...

def simulate(
    design: Design,
    mode: Literal["single", "motion", "input"] = "single",
    *,
    environment: Environment | None = None,
    poses: Table | None = None,
    outside: Outside = "clamp",
    expected: bool = True,
    support: bool = False,
    uncertainty: Scatter | Sequence[Scatter] | None = None,
    samples: int | None = None,
    seed: int | None = None,
    jitter_position_mm: float | None = None,
    jitter_angle_deg: float | None = None,
    jitter_growth_mm: float | None = None,
    as_is: bool = False,
) -> Simulation: ...
def simulate_crf(
    design: Design,
    mode: Literal["single", "motion"] = "single",
    *,
    environment: Environment | None = None,
    outside: Outside = "clamp",
) -> list[Simulation]: ...

class Places(Found):
    """What a search came to; `design` is as it was where nothing better was found."""

    @property
    def design(self) -> Design: ...
    @property
    def is_better(self) -> bool: ...

def optimize(
    design: Design,
    *,
    moves: Sequence[str] | None = None,
    sensors: int | tuple[int, int] | None = None,
    kinds: Sequence[Sequence[float]] | None = None,
    metric: str | None = None,
    environments: Sequence[Environment] | None = None,
    rooms: Literal["worst", "mean"] = "worst",
    generator_bounds: tuple[float, float] | None = None,
    crf_bounds: tuple[float, float] | None = None,
    built_error: tuple[float, float] = (0.2, 0.3),
    seconds: float = 30.0,
    seed: int = 0,
) -> Places: ...
def compare(
    *designs: Design,
    environments: Sequence[Environment] | None = None,
    baseline: int = 0,
    outside: Outside = "clamp",
    least_mm: float = ...,
    least_deg: float = ...,
    seed: int = 0,
) -> Figures: ...

class Sweep:
    """A plan of many designs in many rooms; its rows are numbered from 0."""

    @staticmethod
    def load(path: Path) -> Sweep: ...
    @property
    def rows(self) -> int: ...
    def compute(
        self,
        folder: Path,
        *,
        shard: tuple[int, int] = (1, 1),
        progress: Callable[[float], object] | None = None,
    ) -> Figures: ...

def sweep_status(folder: Path) -> Figures: ...
def merge_sweep(
    folder: Path,
    path: Path,
    *,
    overwrite: bool = False,
    progress: Callable[[float], object] | None = None,
) -> Figures: ...

class SweepTable:
    """The rows of a sweep; a column is read when it is taken: `table["position_rms"]`."""

    @staticmethod
    def load(path: Path) -> SweepTable: ...
    @property
    def rows(self) -> int: ...
    @property
    def columns(self) -> dict[str, str]: ...
    @property
    def parameters(self) -> list[str]: ...
    def __getitem__(self, name: str) -> npt.NDArray[Any]: ...

class FrameFit:
    """A body's frame in the tracker's, and what of its rotation the sensors determine."""

    @property
    def tracker_from_body(self) -> Floats: ...
    @property
    def singular_values_mm2(self) -> Floats: ...
    @property
    def determination(self) -> Determination: ...
    @property
    def free_axis(self) -> Floats | None: ...

def fit_frame(
    sensors: Sequence[Sensor],
    positions: npt.ArrayLike,
    quaternions: npt.ArrayLike | None = None,
    *,
    orientation_weight_mm: float = 100.0,
    near: npt.ArrayLike | None = None,
) -> FrameFit: ...
def point_covariance(
    sensors: Sequence[Sensor],
    point: npt.ArrayLike,
    position_covariance: npt.ArrayLike,
    rotation_covariance: npt.ArrayLike,
    *,
    orientation_weight_mm: float = 100.0,
) -> Floats: ...
def basis_orientations(directions: int) -> Floats: ...
def orientation_weights(
    axes: npt.ArrayLike, directions: int = 14, *, weights: Weights = "area"
) -> Floats: ...
def rotation_vectors(quaternions: npt.ArrayLike) -> Floats: ...

class Generator:
    """The coils of a tracker's field generator."""

    @staticmethod
    def builtin(name: Literal["planar-nine", "anser"]) -> Generator: ...
    @staticmethod
    def load(path: Path) -> Generator: ...
    @property
    def name(self) -> str: ...
    @property
    def coils(self) -> int: ...
    def field(self, positions: npt.ArrayLike) -> Floats: ...

def solid_harmonic_gradients(positions: npt.ArrayLike, degree: int) -> Floats: ...
def sphere_factor(radius_mm: float, material: Material, frequency_hz: float) -> complex: ...
def sphere_field(
    radius_mm: float,
    dipole_at: npt.ArrayLike,
    moment: npt.ArrayLike,
    positions: npt.ArrayLike,
    *,
    material: Material | None = None,
    frequency_hz: float = 0.0,
) -> Floats: ...

class Found:
    """A result: its figures, and as a person reads them (`str`, and HTML in a notebook)."""

    @property
    def figures(self) -> Figures: ...
    def _repr_html_(self) -> str: ...

class Pivot(Found):
    @property
    def tip(self) -> Floats: ...
    @property
    def pivot(self) -> Floats: ...
    @property
    def rms_mm(self) -> float: ...

class Spin(Found):
    @property
    def shaft(self) -> Floats: ...
    @property
    def towards_tip(self) -> bool: ...

class Registration(Found):
    @property
    def target_from_source(self) -> Floats: ...
    @property
    def residuals_mm(self) -> Floats: ...
    def move_points(
        self, points: Table | npt.ArrayLike, *, as_is: bool = False
    ) -> tuple[Floats, Floats]: ...

class HandEye(Found):
    @property
    def tracker_from_reference(self) -> Floats: ...
    @property
    def body_from_sensor(self) -> Floats: ...
    @property
    def covariance(self) -> Floats: ...
    @property
    def errors_mm(self) -> Floats: ...
    @property
    def errors_deg(self) -> Floats: ...

def pivot(
    poses: Table | Sequence[Path] | npt.ArrayLike,
    *,
    tool: str | None = None,
    relative_to: str | None = None,
    min_poses: int = 10,
    min_range_deg: float = 15.0,
    min_turn_deg: float = 2.0,
    max_rms_mm: float = 5.0,
    as_is: bool = False,
) -> Pivot: ...
def spin(
    poses: Table | Sequence[Path] | npt.ArrayLike,
    *,
    tip: npt.ArrayLike | None = None,
    tip_std_error_mm: float = 0.0,
    tool: str | None = None,
    relative_to: str | None = None,
    min_poses: int = 10,
    min_range_deg: float = 15.0,
    min_turn_deg: float = 2.0,
    max_shaft_deg: float = 3.0,
    as_is: bool = False,
) -> Spin: ...
def register(
    source: Table | npt.ArrayLike,
    target: Table | npt.ArrayLike,
    *,
    leave_out_outliers: bool = False,
    fle_mm: float | None = None,
    max_turn_error_deg: float = 10.0,
    as_is: bool = False,
) -> Registration: ...
def hand_eye(
    tracker_from_sensor: npt.ArrayLike,
    reference_from_body: npt.ArrayLike,
    *,
    sensor: Sequence[int] | npt.NDArray[np.integer[Any]] | None = None,
    pose: Sequence[int] | npt.NDArray[np.integer[Any]] | None = None,
    min_poses: int = 10,
    min_turn_deg: float = 2.0,
) -> HandEye: ...

class Recording:
    @staticmethod
    def load(path: Path, *, as_is: bool = False) -> Recording: ...
    @staticmethod
    def from_bytes(bytes: bytes) -> Recording: ...
    @staticmethod
    def of_tools(tools: dict[str, Any]) -> Recording: ...
    def to_bytes(self) -> bytes: ...
    def save(self, path: Path, *, overwrite: bool = False) -> None: ...
    @property
    def tools(self) -> list[str]: ...
    def track(self, tool: str | None = None, *, relative_to: str | None = None) -> Records: ...
    def unusable(self, tool: str | None = None) -> dict[str, int]: ...

class Tool(Found):
    @staticmethod
    def load(path: Path, *, accept_checksum: bool = False) -> Tool: ...
    @staticmethod
    def from_bytes(
        bytes: bytes, extension: str = "rom", *, accept_checksum: bool = False
    ) -> Tool: ...
    def to_bytes(self, extension: Literal["rom", "tool", "ini", "json"] = "rom") -> bytes: ...
    def save(self, path: Path, *, overwrite: bool = False) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def kind(self) -> str | None: ...
    @property
    def sensors(self) -> list[Sensor]: ...
    @property
    def tip(self) -> Floats | None: ...

class IgtlMessage:
    @property
    def kind(self) -> str: ...
    @property
    def device(self) -> str: ...
    @property
    def timestamp_s(self) -> float | None: ...
    @property
    def poses(self) -> dict[str, Floats]: ...
    @property
    def text(self) -> str | None: ...
    @property
    def code(self) -> int | None: ...
    @property
    def problem(self) -> str | None: ...

class IgtlDecoder:
    def __init__(self) -> None: ...
    def feed(self, bytes: bytes) -> list[IgtlMessage]: ...

def encode_transform(
    device: str, pose: npt.ArrayLike, *, timestamp_s: float | None = None
) -> bytes: ...
def encode_tracking(
    device: str,
    names: Sequence[str],
    poses: npt.ArrayLike,
    *,
    timestamp_s: float | None = None,
) -> bytes: ...
def encode_status(
    device: str, text: str = "", *, code: int = 1, timestamp_s: float | None = None
) -> bytes: ...
