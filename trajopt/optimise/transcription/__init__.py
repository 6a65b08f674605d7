"""From a problem to a program, and back to a path."""

from trajopt.optimise.transcription.knots import KnotsNlp as KnotsNlp
from trajopt.optimise.transcription.knots import fixed_goal as fixed_goal
from trajopt.optimise.transcription.knots import goal_centre as goal_centre
from trajopt.optimise.transcription.knots import transcribe as transcribe
from trajopt.optimise.transcription.knots import transcribe_covered as transcribe_covered
