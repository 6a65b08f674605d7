"""From a problem to a program, and back to a path."""

from trajopt.transcription.knots import KnotsNlp as KnotsNlp
from trajopt.transcription.knots import fixed_goal as fixed_goal
from trajopt.transcription.knots import goal_centre as goal_centre
from trajopt.transcription.knots import transcribe as transcribe
from trajopt.transcription.knots import transcribe_covered as transcribe_covered
