"""One massless, springy, actuated leg."""

from collections.abc import Mapping
from math import isclose, pi, radians, remainder
from types import MappingProxyType
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from legspring.checks import shown
from legspring.model._base import Frozen, Label, Number, Positive, require_number
from legspring.model.formula import Formula, is_constant

_NOBODY: Mapping[str, str] = MappingProxyType({})


def _half_turn(angle: float) -> float:
    if abs(angle) > pi:
        raise ValueError("must be between -pi and pi rad (angle_deg takes degrees)")
    return angle


def _close(one: float, other: float) -> bool:
    return isclose(one, other, rel_tol=1e-12, abs_tol=1e-12)


class Leg(Frozen):
    """A leg, eqs (2.1)-(2.2) and the placement of its foot.

    Along the leg acts the force k (abs(r) - l) + c d abs(r)/dt, from hip to foot where it is positive: a
    spring, whose force-free length l may be actuated, and beside all of it a damper. A foot is always put
    down at the leg's force-free length and angle; a damper's force begins at once.

    See :ref:`model-legs`.

    Parameters
    ----------
    name : str
        Name of the leg, such as "FL".
    pair : str
        Label of the pair that it belongs to, such as "F".
    hip : tuple of float
        Place of the hip in the body (dx, dy), to the right and forward of the centre of mass (m).
    length : float
        Force-free length l0 (m).
    stiffness : float
        Stiffness k (N/m).
    angle : float
        Touch-down angle beta (rad), + counter-clockwise from straight ahead, between -pi and pi;
        ``angle_deg`` (deg) is accepted in its place.
    actuation : float
        Amplitude abs(ldev) of the force-free length (m), less than the length.
    phase : float, optional
        Phase phi (rad) of the force-free length at touch-down; without it, gaits have the phases at which
        the animal runs at its desired speed.
    function : {"push", "pull"}
        What the leg does unless a family says otherwise; it gives ldev its sign.
    offset : float
        Time of the first touch-down, in units of the step's duration t_des, from 0 to below 2:
        0 for the left tripod, 1 for the right one. A leg that does not go by the clock is put down at the
        start if this is 0.
    touchdown : {"clock", "ground", "lift-off"}
        When it touches down: every two step durations; or when its foot, held at the leg's length and
        angle, comes down to the ground, the line y = const through the foot that is put down at the start
        (the animal is then seen from the side); or when another leg lifts off.
    follows : str, optional
        Name of that other leg.
    stance : float, optional
        Time from touch-down to lift-off, in step durations; by default a leg lifts off when its force is
        zero.
    damping : float
        Damping c (N s/m).
    length_law : str, optional
        Force-free length l (m) as a formula in t (step durations since touch-down), l0, ldev (m) and phi
        (rad), by default that of eq. (2.2), ``l0 - ldev*sin(pi*t + phi)``.

    Raises
    ------
    ModelError
        If a value is not valid.
    """

    name: Label
    pair: Label
    hip: tuple[Number, Number] = (0.0, 0.0)
    length: Positive
    stiffness: Positive
    angle: Annotated[Number, AfterValidator(_half_turn)]
    actuation: Annotated[Number, Field(ge=0)]
    phase: Number | None = None
    function: Literal["push", "pull"] = "push"
    offset: Annotated[Number, Field(ge=0, lt=2)]
    touchdown: Literal["clock", "ground", "lift-off"] = "clock"
    follows: Label | None = None
    stance: Positive | None = None
    damping: Annotated[Number, Field(ge=0)] = 0.0
    length_law: Formula | None = None

    @model_validator(mode="before")
    @classmethod
    def _degrees_to_radians(cls, fields: Any) -> Any:
        if not isinstance(fields, dict) or "angle_deg" not in fields:
            return fields
        if "angle" in fields:
            raise ValueError("angle and angle_deg are both given; give one")
        degrees = fields["angle_deg"]
        try:
            angle = radians(require_number(degrees))
        except (ValueError, OverflowError) as error:
            raise ValueError(f"angle_deg = {shown(degrees)}: {error}") from None
        return {name: value for name, value in fields.items() if name != "angle_deg"} | {"angle": angle}

    @model_validator(mode="after")
    def _actuation_below_length(self) -> Self:
        if self.actuation >= self.length:
            raise ValueError(f"actuation = {self.actuation}: must be less than the length, {self.length} m")
        return self

    @model_validator(mode="after")
    def _follows_another(self) -> Self:
        if (self.touchdown == "lift-off") != (self.follows is not None):
            raise ValueError("touchdown = 'lift-off' and follows (the name of another leg) must be given together")
        if self.follows == self.name:
            raise ValueError(f"follows = {self.follows!r}: must be another leg")
        return self

    @property
    def ldev(self) -> float:
        """Signed amplitude ldev of eq. (2.2) (m): negative in a leg that pushes."""
        return -self.actuation if self.function == "push" else self.actuation

    @property
    def plain(self) -> bool:
        """Whether it is a leg of the thesis: on the sinusoid, without a damper, up when its force is zero."""
        return self.length_law is None and self.stance is None and self.damping == 0.0

    @property
    def passive(self) -> bool:
        """Whether it does no work: a spring of constant length, up when its force is zero, without a damper."""
        return self.timeless and self.damping == 0.0

    @property
    def timeless(self) -> bool:
        """Whether its force does not depend on the time since its touch-down, nor its lift-off."""
        constant = self.actuation == 0.0 if self.length_law is None else is_constant(self.length_law)
        return constant and self.stance is None

    def mirrored(
        self, name: str, partners: Mapping[str, str] = _NOBODY, *, alike: bool = False, later: float = 1.0
    ) -> "Leg":
        """Return the leg's mirror image: on the body's other side, one step later.

        Parameters
        ----------
        name : str
            Name of the image.
        partners : mapping of str to str
            Names of the images of other legs, for one that follows them.
        alike : bool
            Whether it is seen from the side, where the two legs of a pair are alike.
        later : float
            How much later the image is put down, in step durations.

        Returns
        -------
        Leg
            The image; mirrored twice, a leg is itself again.
        """
        (dx, dy), angle = self.hip, self.angle
        if not alike:
            # 0.0 - x where -x would do, so that no zero turns into -0.0.
            dx, angle = 0.0 - dx, 0.0 - angle
        image = {"hip": (dx, dy), "angle": angle, "offset": (self.offset + later) % 2.0}
        follows = None if self.follows is None else ({name: self.name} | dict(partners)).get(self.follows, self.follows)
        return self.model_copy(update={"name": name, "follows": follows, **image})

    def is_mirror_image_of(self, other: "Leg", partners: Mapping[str, str] = _NOBODY, *, alike: bool = False) -> bool:
        """Tell whether two legs are mirror images, one step apart, up to rounding.

        Parameters
        ----------
        other : Leg
            The leg to compare with.
        partners : mapping of str to str
            Names of the images of the legs.
        alike : bool
            Whether they are seen from the side, where images are alike.

        Returns
        -------
        bool
            Whether this leg is `other` mirrored; names do not matter.
        """
        image = other.mirrored(self.name, partners, alike=alike)
        return (
            self._manner() == image._manner()
            and all(map(_close, self._geometry(), image._geometry()))
            and _close(remainder(self.offset - image.offset, 2.0), 0.0)  # offsets wrap around at 2
        )

    def _geometry(self) -> tuple[float, ...]:
        return (*self.hip, self.length, self.stiffness, self.angle, self.actuation, self.damping)

    def _manner(self) -> tuple[object, ...]:
        return (self.pair, self.phase, self.function, self.touchdown, self.follows, self.stance, self.length_law)
