"""The figures of RatSLAM. Sources: docs/explanation/ratslam.md."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class ViewSettings:
    """View templates: the part of a picture that is compared, and how."""

    width: int = 60  # columns of a template
    height: int = 20  # rows of a template
    top: int = 0  # rows of the picture from here
    bottom: int = 150  # to here, this one excluded
    shift: int = 4  # columns by which two views may be shifted to each other
    match: float = 0.03  # mean absolute difference, 1 = black to white, up to which two views are the same
    young: int = 10  # the newest templates inject nothing
    dark: float = 4.0  # mean grey level of the template below which the picture counts as black
    flat: float = 1.0  # standard deviation of the grey levels below which there is nothing to recognise


@dataclass(frozen=True)
class CellSettings:
    """The attractor network of pose cells."""

    across: int = 15  # cells in x, and as many in y
    around: int = 36  # cells in the heading
    cell_m: float = 0.015
    excite_width: int = 7
    excite_sd: float = 1.0  # "variance 1" of the sources is the standard deviation of their formula
    inhibit_width: int = 5
    inhibit_sd: float = 2.0
    inhibit_all: float = 0.00002
    inject: float = 0.1
    restore: float = 0.05
    tired: float = 1.0  # what each further picture of the same view adds to the decay of its injection


@dataclass(frozen=True)
class MapSettings:
    """The experience map."""

    new_beyond: float = 2.0  # distance in cells beyond which a place is another experience
    loops: int = 20  # of relaxation, after each change of the experience
    correction: float = 0.5
    still_s: float = 10.0  # of a rest, the most that counts in the duration of a link
    sure_m: float = 0.2  # a place that disagrees with the map by more than this,
    sure_rad: float = 0.3  # or by more than this, is another place that looks alike
    drift: float = 0.05  # added to both for each metre of the way between (m/m, rad/m), beside the odometry's bend
    wrong_after: int = 5  # successive sightings of such places that agree, after which the map counts as wrong
    wrong_m: float = 0.05  # and the robot has to have driven so far between them
    carried_m: float = 0.8  # where they disagree with the map by more than this,
    carried_rad: float = 0.6  # or by more than this, the robot was carried, and no link is made
    carried_after: int = 12  # sightings, after which that is believed
    most: int = 10_000  # experiences, and templates
    square_m: float = 0.05  # pruning keeps one experience for each square of this side
    headings: int = 24  # and each of so many headings
    stale_after: int = 20_000  # arrivals elsewhere (an hour of driving), after which one yields to a newer one
    forgotten_after: int = 5000  # arrivals (15 minutes of driving), after which one that was never met again is removed
    same_m: float = 1.0  # the longest way over links between two experiences that are pruned to one
    prune_each: int = 200  # new experiences between two prunings


@dataclass(frozen=True)
class Settings:
    """All figures.

    `pruning`: keep the map small for days; without it the caller clears the map now and then. `calibrate`: learn the
    error of the odometry in turns.
    """

    views: ViewSettings = field(default_factory=ViewSettings)
    cells: CellSettings = field(default_factory=CellSettings)
    map: MapSettings = field(default_factory=MapSettings)
    pruning: bool = False
    calibrate: bool = True
