"""How fast an animal means to run on a slope, and how long its steps take at that speed."""

from functools import cache
from math import degrees, inf, isclose, radians
from statistics import linear_regression
from typing import Self

from pydantic import model_validator

from legspring.model._base import Frozen, ModelError, Number, Positive

# A slope that went from degrees to radians and back may leave the domain by rounding alone.
_ROUNDING_DEG = 1e-9


class SpeedLaw(Frozen):
    """Desired speed v_des: a straight line in the slope.

    See :ref:`model-speed-law`.

    Parameters
    ----------
    level : float
        Speed on level ground (m/s).
    vertical : float
        Speed straight up a wall, at 90 deg (m/s).
    domain_deg : tuple of float
        Least and greatest slope for which the law holds (deg), at most from -90 to 90.

    Raises
    ------
    ModelError
        If a value is not valid or the speed is not positive all over the domain.

    Examples
    --------
    >>> SpeedLaw(level=0.35, vertical=0.20)(0.0)
    0.35
    """

    level: Positive
    vertical: Number
    domain_deg: tuple[Number, Number] = (-90.0, 90.0)

    @model_validator(mode="after")
    def _positive_over_a_domain(self) -> Self:
        low, high = self.domain_deg
        if not -90.0 <= low <= high <= 90.0:
            raise ValueError(f"domain_deg = {self.domain_deg}: should rise, within -90 to 90 deg")
        for slope_deg in self.domain_deg:
            if (speed := self._speed(slope_deg)) <= 0:
                raise ValueError(f"speed at {slope_deg:g} deg = {speed:g} m/s: must be greater than 0")
        return self

    def __call__(self, slope: float) -> float:
        """Evaluate the law.

        Parameters
        ----------
        slope : float
            Slope sigma (rad), uphill positive.

        Returns
        -------
        float
            Desired speed v_des (m/s).

        Raises
        ------
        ModelError
            If the slope is outside the law's domain.
        """
        slope_deg = degrees(slope)
        low, high = self.domain_deg
        if not low - _ROUNDING_DEG <= slope_deg <= high + _ROUNDING_DEG:
            valid = f"{low:g} deg" if low == high else f"between {low:g} and {high:g} deg"
            raise ModelError(f"slope = {slope_deg:g} deg: must be {valid}")
        return self._speed(slope_deg)

    @property
    def rate(self) -> float:
        """Derivative of the speed by the slope (m/s per rad)."""
        return (self.vertical - self.level) / radians(90.0)

    def _speed(self, slope_deg: float) -> float:
        return self.level + slope_deg / 90.0 * (self.vertical - self.level)


class StepLaw(Frozen):
    """Step duration t_des against speed: half of a stride, t_des = 1/(2 f).

    The stride frequency f is the least-squares straight line through measured points. Where
    animals run faster by longer strides and not by quicker ones, f is constant. Instead of
    points, one duration for all speeds can be given.

    See :ref:`model-step-law`.

    Parameters
    ----------
    points : tuple of tuple of float, shape (n, 2)
        Measured speeds (m/s) and stride frequencies (Hz); two different speeds at least.
    constant_above : float, optional
        Speed from which the frequency is constant (m/s).
    duration : float, optional
        Step duration at every speed (s), in place of points.

    Raises
    ------
    ModelError
        If a value is not valid, or not just one of points and duration is given.

    Examples
    --------
    >>> StepLaw(points=((0.1, 5.0), (0.3, 10.0)), constant_above=0.3)(0.5)
    0.05
    >>> StepLaw(duration=0.04)(0.5)
    0.04
    """

    points: tuple[tuple[Positive, Positive], ...] = ()
    constant_above: Positive | None = None
    duration: Positive | None = None

    @model_validator(mode="after")
    def _points_or_duration(self) -> Self:
        if bool(self.points) == (self.duration is not None):
            raise ValueError("needs points (speed m/s, stride frequency Hz) or a duration (s), and not both")
        if self.points and len({speed for speed, _ in self.points}) < 2:
            raise ValueError("points must have at least two different speeds (m/s)")
        if self.duration is not None and self.constant_above is not None:
            raise ValueError("constant_above goes with points; a duration is constant anyway")
        return self

    def __call__(self, speed: float) -> float:
        """Evaluate the law.

        Parameters
        ----------
        speed : float
            Desired speed v_des (m/s).

        Returns
        -------
        float
            Step duration t_des (s).

        Raises
        ------
        ModelError
            If the line gives no positive frequency at this speed.
        """
        if self.duration is not None:
            return self.duration
        gradient, intercept = self._line
        if self.constant_above is not None:
            speed = min(speed, self.constant_above)
        frequency = intercept + gradient * speed
        if not frequency > 0:
            raise ModelError(f"stride frequency at {speed:g} m/s = {frequency:g} Hz: must be greater than 0")
        return 1.0 / (2.0 * frequency)

    def rate(self, speed: float, ahead: float = 1.0) -> float:
        """Return the derivative of the duration by the speed (s per m/s).

        Parameters
        ----------
        speed : float
            Desired speed v_des (m/s).
        ahead : float
            Which derivative is meant at a kink: that towards greater speeds (> 0) or smaller ones.
        """
        if self.duration is not None:
            return 0.0
        above = speed > (inf if self.constant_above is None else self.constant_above)
        if ahead > 0.0 if self.has_kink(speed) else above:
            return 0.0
        gradient, _ = self._line
        return -2.0 * gradient * self(speed) ** 2

    def has_kink(self, speed: float) -> bool:
        """Tell whether the frequency begins to be constant at a speed (m/s)."""
        return self.constant_above is not None and isclose(speed, self.constant_above, rel_tol=1e-9)

    @property
    def _line(self) -> tuple[float, float]:
        return _line_through(self.points)


@cache
def _line_through(points: tuple[tuple[float, float], ...]) -> tuple[float, float]:
    speeds, frequencies = zip(*points, strict=True)
    gradient, intercept = linear_regression(speeds, frequencies)
    return gradient, intercept
