"""The body: a point mass, or a rigid body that may yaw."""

from typing import Literal, Self

from pydantic import model_validator

from legspring.model._base import Frozen, Positive


class Body(Frozen):
    """A planar body, eqs (2.3)-(2.6).

    See :ref:`model-body`.

    Parameters
    ----------
    mass : float
        Mass m (kg).
    inertia : float, optional
        Moment of inertia I about the centre of mass (kg m^2); a body that is free to yaw needs one.
    yaw : {"held", "free"}
        Whether the heading of the body is held at 0, as in the thesis's results, or moves.

    Raises
    ------
    ModelError
        If a value is not valid, or yaw is free and there is no inertia.
    """

    mass: Positive
    inertia: Positive | None = None
    yaw: Literal["held", "free"] = "held"

    @model_validator(mode="after")
    def _free_yaw_has_inertia(self) -> Self:
        if self.yaw == "free" and self.inertia is None:
            raise ValueError("yaw = 'free' needs an inertia (kg m^2)")
        return self
