"""A gamepad as an input of a servo: the sticks give the velocity of the tool while a button is held.

The buttons are named as on an Xbox pad; other pads have them in the same places.

- LB, held: the robot follows; released, it stops (a dead man's button).
- Left stick: up moves along x, left along y. Right stick: up moves along z, left turns about z.
- RB, held in addition: the left stick turns, sideways about x and up about y, and does not move.
- Cross, up and down: changes the speed factor by a tenth.

The axes belong to the given frame. A stick at its end gives 1, which `ServoOptions.scaling` and `turning`
convert to m/s and rad/s; `dead_zone` is a share of the stick's range.
"""

import os
from typing import TYPE_CHECKING

import numpy as np

from trajopt.driving.servo_command import Twist
from trajopt.driving.servo_input import Order
from trajopt.values.errors import MissingExtra, ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD

if TYPE_CHECKING:
    from pygame._sdl2.controller import Controller

FULL = 32767.0
"""Value of SDL for a stick at its end."""
NOTCH = 0.1
"""Change of the speed factor by the cross."""
SLOWEST = 0.1
"""Least speed factor of the cross."""
RELEASED = "the button was let go"


class Gamepad:
    """A gamepad found by pygame.

    pygame and its SDL have one state per process: it is initialised with the first gamepad, without a window
    unless the program has one, and remains after `close`.
    """

    @checked
    def __init__(self, number: int = 0, *, frame: str = WORLD) -> None:
        """Open it.

        Args:
            number: Index of the gamepad.
            frame: Frame of the axes: "world", or the tool.

        Raises:
            MissingExtra: If pygame-ce is not installed.
            ProblemError: If it does not exist.
        """
        # Without a window there is no focus, without which SDL ignores pads.
        os.environ.setdefault("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1")
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        try:
            import pygame
            from pygame._sdl2 import controller
        except ImportError as error:
            raise MissingExtra("pygame-ce", "gamepad") from error
        if not pygame.display.get_init():
            os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
            pygame.display.init()
        controller.init()
        pads = [index for index in range(controller.get_count()) if controller.is_controller(index)]
        if not 0 <= number < len(pads):
            have = f"SDL finds {len(pads)}, counted from 0" if pads else "SDL finds none"
            raise ProblemError(f"gamepad number {number} does not exist: {have}")
        self._pygame = pygame
        self._pad: Controller = controller.Controller(pads[number])
        self._frame, self._speed, self._cross = frame, 1.0, 0
        self._done = False

    @property
    def name(self) -> str:
        """Name of the gamepad."""
        return self._pad.name

    @checked
    def read(self, since: float) -> Order | None:
        """Return the order of the sticks."""
        pygame = self._pygame
        pygame.event.pump()
        if not self._pad.attached():
            self._done = True
            return Order(released="the gamepad is disconnected")
        speed = self._faster()
        if not self._held(pygame.CONTROLLER_BUTTON_LEFTSHOULDER):
            return Order(speed=speed, released=RELEASED)
        left, ahead = (
            -self._axis(each) for each in (pygame.CONTROLLER_AXIS_LEFTX, pygame.CONTROLLER_AXIS_LEFTY)
        )
        about, up = (
            -self._axis(each) for each in (pygame.CONTROLLER_AXIS_RIGHTX, pygame.CONTROLLER_AXIS_RIGHTY)
        )
        if self._held(pygame.CONTROLLER_BUTTON_RIGHTSHOULDER):
            # Right turns clockwise as seen from behind, as a hand turns a knob: about x.
            linear, angular = (0.0, 0.0, up), (-left, ahead, about)
        else:
            linear, angular = (ahead, left, up), (0.0, 0.0, about)
        return Order(command=Twist(np.array(linear), np.array(angular), self._frame), speed=speed)

    @property
    def done(self) -> bool:
        """Whether it is disconnected."""
        return self._done

    def close(self) -> None:
        """Close the gamepad."""
        self._pad.quit()

    def _faster(self) -> float | None:
        """Return the speed factor if the cross has just changed it."""
        pygame = self._pygame
        cross = self._held(pygame.CONTROLLER_BUTTON_DPAD_UP) - self._held(pygame.CONTROLLER_BUTTON_DPAD_DOWN)
        pressed, self._cross = cross if cross != self._cross else 0, cross
        if not pressed:
            return None
        self._speed = round(min(max(self._speed + NOTCH * pressed, SLOWEST), 1.0), 3)
        return self._speed

    def _held(self, button: int) -> bool:
        return self._pad.get_button(button)

    def _axis(self, axis: int) -> float:
        """Return the position of a stick, from -1 to 1."""
        return max(self._pad.get_axis(axis) / FULL, -1.0)
