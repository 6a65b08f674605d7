"""A gamepad as an input of a servo: the sticks give the velocity of the tool, while a button is held.

The buttons are those of an Xbox pad; of others, those in the same places.

- LB, held: the robot follows. Let go, it stops: a dead man's button.
- Left stick: up goes along x, left along y. Right stick: up goes along z, left turns about z.
- RB, held too: the left stick turns, sideways about x and up about y, and does not move.
- Cross, up and down: faster and slower, by a tenth of the whole speed each time.

Axes are those of the frame that it is given. A stick at its end says 1: `ServoOptions.scaling` and `turning`
make m/s and rad/s of that, and `dead_zone` is a part of a stick's way.
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
"""What SDL says of a stick at its end."""
NOTCH = 0.1
"""So much of the whole speed the cross changes at a time."""
SLOWEST = 0.1
"""The part of the whole speed below which the cross does not go."""
LET_GO = "the button was let go"


class Gamepad:
    """A gamepad that pygame finds.

    pygame and its SDL have one state for the whole process: it is begun with the first gamepad, without a
    window unless the program has one, and goes on after `close`.
    """

    @checked
    def __init__(self, number: int = 0, *, frame: str = WORLD) -> None:
        """Open it.

        Args:
            number: Which one, where there are several.
            frame: Frame whose axes the sticks mean: "world", or the tool's own.

        Raises:
            MissingExtra: If pygame-ce is not installed.
            ProblemError: If there is no such gamepad.
        """
        # Without a window nobody gives the focus to, and a pad would be silent without it.
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
            have = f"there are {len(pads)}" if pads else "there is none"
            raise ProblemError(f"no gamepad number {number}: {have} that SDL knows")
        self._pygame = pygame
        self._pad: Controller = controller.Controller(pads[number])
        self._frame, self._speed, self._cross = frame, 1.0, 0
        self._done = False

    @property
    def name(self) -> str:
        """What it calls itself."""
        return self._pad.name

    @checked
    def read(self, since: float) -> Order | None:
        """Return what the sticks say now."""
        pygame = self._pygame
        pygame.event.pump()
        if not self._pad.attached():
            self._done = True
            return Order(released="the gamepad is gone")
        speed = self._faster()
        if not self._held(pygame.CONTROLLER_BUTTON_LEFTSHOULDER):
            return Order(speed=speed, released=LET_GO)
        left, ahead = (
            -self._axis(each) for each in (pygame.CONTROLLER_AXIS_LEFTX, pygame.CONTROLLER_AXIS_LEFTY)
        )
        about, up = (
            -self._axis(each) for each in (pygame.CONTROLLER_AXIS_RIGHTX, pygame.CONTROLLER_AXIS_RIGHTY)
        )
        if self._held(pygame.CONTROLLER_BUTTON_RIGHTSHOULDER):
            # To the right turns clockwise as seen from behind, as a hand on a knob would: about x.
            linear, angular = (0.0, 0.0, up), (-left, ahead, about)
        else:
            linear, angular = (ahead, left, up), (0.0, 0.0, about)
        return Order(command=Twist(np.array(linear), np.array(angular), self._frame), speed=speed)

    @property
    def done(self) -> bool:
        """Whether it is gone."""
        return self._done

    def close(self) -> None:
        """Let go of it."""
        self._pad.quit()

    def _faster(self) -> float | None:
        """Return the speed where the cross has just changed it."""
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
        """Return how far a stick is, from -1 to 1."""
        return max(self._pad.get_axis(axis) / FULL, -1.0)
