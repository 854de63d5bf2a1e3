"""One massless, springy, actuated leg."""

from math import isclose, pi, radians, remainder
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from legspring.model._base import Frozen, Label, Number, Positive, require_number


def _half_turn(angle: float) -> float:
    if abs(angle) > pi:
        raise ValueError("must be between -pi and pi rad (angle_deg takes degrees)")
    return angle


def _close(one: float, other: float) -> bool:
    return isclose(one, other, rel_tol=1e-12, abs_tol=1e-12)


class Leg(Frozen):
    """A leg, eqs (2.1)-(2.2) and the placement of its foot.

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
    function : {"push", "pull"}
        What the leg does unless a family says otherwise; it gives ldev its sign.
    offset : float
        Time of the first touch-down, in units of the step's duration t_des, from 0 to below 2:
        0 for the left tripod, 1 for the right one.

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
    function: Literal["push", "pull"] = "push"
    offset: Annotated[Number, Field(ge=0, lt=2)]

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
            raise ValueError(f"angle_deg = {degrees!r}: {error}") from None
        return {name: value for name, value in fields.items() if name != "angle_deg"} | {"angle": angle}

    @model_validator(mode="after")
    def _actuation_below_length(self) -> Self:
        if self.actuation >= self.length:
            raise ValueError(f"actuation = {self.actuation}: must be less than the length, {self.length} m")
        return self

    @property
    def ldev(self) -> float:
        """Signed amplitude ldev of eq. (2.2) (m): negative in a leg that pushes."""
        return -self.actuation if self.function == "push" else self.actuation

    def mirrored(self, name: str) -> "Leg":
        """Return the leg's mirror image: on the body's other side, one step later.

        Parameters
        ----------
        name : str
            Name of the image.

        Returns
        -------
        Leg
            The image; mirrored twice, a leg is itself again.
        """
        dx, dy = self.hip
        # 0.0 - x where -x would do, so that no zero turns into -0.0.
        image = {"hip": (0.0 - dx, dy), "angle": 0.0 - self.angle, "offset": (self.offset + 1.0) % 2.0}
        return self.model_copy(update={"name": name, **image})

    def is_mirror_image_of(self, other: "Leg") -> bool:
        """Tell whether two legs are mirror images, up to rounding.

        Parameters
        ----------
        other : Leg
            The leg to compare with.

        Returns
        -------
        bool
            Whether this leg is `other` mirrored; names do not matter.
        """
        image = other.mirrored(self.name)
        return (
            (self.pair, self.function) == (image.pair, image.function)
            and all(map(_close, self._geometry(), image._geometry()))
            and _close(remainder(self.offset - image.offset, 2.0), 0.0)  # offsets wrap around at 2
        )

    def _geometry(self) -> tuple[float, ...]:
        return (*self.hip, self.length, self.stiffness, self.angle, self.actuation)
